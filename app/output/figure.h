/* figure.h - panels of curves over two axes, drawn by gnuplot: DIR/NAME.gp, and from it DIR/NAME.png and an
 * interactive DIR/NAME.svg, which says what a point is when the pointer rests on it.
 *
 *   kith_figure_open(&f, DIR, NAME, title, rows, columns);
 *   for each panel: kith_figure_panel, then for each curve kith_figure_series and its points, then
 *     kith_figure_draw;
 *   kith_figure_close(&f); */
#ifndef KITH_APP_OUTPUT_FIGURE_H
#define KITH_APP_OUTPUT_FIGURE_H

#include "app/cli/process.h"
#include "lib/io/atomic_file.h"

enum kith_series_kind {
  KITH_SERIES_CURVE,     /* a line with marks */
  KITH_SERIES_FRONT,     /* a broad grey line, sorted by x */
  KITH_SERIES_REFERENCE, /* hollow marks, no line */
  KITH_SERIES_LEVEL      /* a dashed horizontal line at the y of its one point */
};
enum { KITH_FIGURE_SERIES = 256, KITH_FIGURE_LABEL = 128 };

struct kith_figure {
  char directory[KITH_PATH], name[32];
  struct kith_atomic_file *file;
  int n_series; /* of the panel */
  struct {
    enum kith_series_kind kind;
    char label[KITH_FIGURE_LABEL];
    double level;
    int n; /* points */
  } series[KITH_FIGURE_SERIES];
};

kith_status kith_figure_open(struct kith_figure *figure, const char *directory, const char *name,
                             const char *title, int rows, int columns);
/* names: of x = 0, 1, 2...; NULL: numbers, on a logarithmic axis or not. y is logarithmic. */
void kith_figure_panel(struct kith_figure *figure, const char *title, const char *x_label,
                       const char *y_label, bool logarithmic_x, int n_names, const char *const *names);
void kith_figure_series(struct kith_figure *figure, enum kith_series_kind kind, const char *label);
/* A point of the last series, with what it says; left out where x or y cannot be drawn. */
__attribute__((format(printf, 4, 5))) void kith_figure_point(struct kith_figure *figure, double x, double y,
                                                             const char *format, ...);
void kith_figure_draw(struct kith_figure *figure);
/* Writes the script and runs gnuplot. A figure is no reason to lose a study: what goes wrong with gnuplot is
 * a warning on stderr; BAD_FILE if the script cannot be written. Accepts one that was not opened. */
kith_status kith_figure_close(struct kith_figure *figure);

#endif
