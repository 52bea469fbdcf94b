/* figure.h - panels of curves over two axes, drawn by gnuplot: DIR/NAME.gp, and from it DIR/NAME.png and
 * DIR/NAME.pdf.
 *
 *   kith_figure_open(&f, DIR, NAME, title, &layout);
 *   for each panel: kith_figure_panel, then a plot command to f.file->stream, or kith_figure_map alone;
 *   kith_figure_legend, then what `plot` takes; kith_figure_close(&f); */
#ifndef KITH_APP_OUTPUT_PICTURES_FIGURE_H
#define KITH_APP_OUTPUT_PICTURES_FIGURE_H

#include <math.h>
#include "app/cli/process.h"
#include "lib/io/atomic_file.h"

struct kith_figure_layout {
  int rows, columns, width, height; /* of a panel, in pixels of the png */
  int legend;                       /* height of the strip below the panels that has the legend */
};

struct kith_figure {
  struct kith_figure_layout layout;
  char directory[KITH_PATH], name[48];
  struct kith_atomic_file *file; /* the script */
  kith_status status;            /* of the pixels of maps, which are files of their own */
  bool png_only;                 /* no pdf: one of many pictures */
  int n_panels;                  /* so far */
};

struct kith_range {
  double lower, upper;
};
#define KITH_NO_RANGE ((struct kith_range){INFINITY, -INFINITY})

/* Values on the pixels of a rectangle, in colors. */
struct kith_figure_map {
  const char *file; /* which the pixels are written to, in the figure's directory */
  const char *title, *labels[2];
  int pixels[2];
  double lower[2], size[2]; /* lower corner of the rectangle; sides of a pixel */
  const float *value;       /* [pixels[1]][pixels[0]]; NaN: none */
  bool has_sign;            /* colors from blue through white to red; else their lightness grows */
  struct kith_range colors; /* NaN: the range of the values */
};

void kith_range_include(struct kith_range *range, double value); /* if it is finite */
/* Widens a range, so that curves keep off the border, and beyond round-off. */
struct kith_range kith_range_with_room(struct kith_range range);
/* Distance of tics: five or so in the range, steps of 1, 2 or 5. */
double kith_range_tics(struct kith_range range);

kith_status kith_figure_open(struct kith_figure *figure, const char *directory, const char *name,
                             const char *title, const struct kith_figure_layout *layout);
/* Begins a panel with linear axes. */
void kith_figure_panel(struct kith_figure *figure, const char *title, const char *x_label,
                       const char *y_label);
/* Adds the panel of a map, and writes its pixels. kith_figure_close tells if they could not be written. */
void kith_figure_map(struct kith_figure *figure, const struct kith_figure_map *map);
/* Begins the legend below the panels: the caller writes what `plot` takes, "NaN with lines title 'run'", and
 * ends the line. */
void kith_figure_legend(struct kith_figure *figure);
/* Writes a text in single quotes; replaces the characters that would be special to gnuplot in these. */
void kith_figure_put_quoted(FILE *f, const char *text);
/* Writes the script and runs gnuplot. A figure is no reason to lose a study: what goes wrong with gnuplot is
 * a warning on stderr. BAD_FILE if the script, or the pixels of a map, could not be written. */
kith_status kith_figure_close(struct kith_figure *figure);

#endif
