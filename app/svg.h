/* svg.h - a panel of points over two axes, as SVG: dark on white, no scripts, nothing from outside; every point says what it is when the
 * pointer rests on it (a plain <title>). */
#ifndef KITH_APP_SVG_H
#define KITH_APP_SVG_H

#include <stdio.h>
#include "lib/core/base.h"

enum { KITH_PANEL_WIDTH = 430, KITH_PANEL_HEIGHT = 360, KITH_DOT_TITLE = 320 };

struct kith_dot {
  double x, y;
  bool ring;   /* on the front */
  bool failed; /* a cross at the upper edge; y does not count */
  char title[KITH_DOT_TITLE];
};
/* Color and shape go by `style`. */
struct kith_series {
  const char *label;
  int style, n;
  bool hollow;          /* of others: no line, not filled, grey */
  struct kith_dot *dot; /* borrowed, in the order of the line */
};
struct kith_panel {
  const char *title, *x_label, *y_label;
  int n;
  const struct kith_series *series;
  int n_names; /* names for x = 0, 1, 2, ...; 0: numbers */
  const char *const *names;
  bool logarithmic; /* both axes, however little they span; else those that span a factor of 5 or more */
  double level;     /* a dashed line at this y; 0: none */
  const char *level_label;
};

/* The panel at (left, top) of an <svg> that is open. A front is drawn through the rings. Axes with values of 0 or below are linear. */
void kith_panel_write(FILE *out, const struct kith_panel *panel, double left, double top);
/* The legend of the series, from left to right within `width`; returns its height. out NULL: only the height. */
double kith_legend_write(FILE *out, int n, const struct kith_series *series, double left, double top,
                         double width);
/* <svg ...> with a white ground; close it with </svg>. */
void kith_svg_open(FILE *out, double width, double height, const char *title);
/* "#0072b2": the color of a style. */
const char *kith_svg_color(int style);
/* Text for XML: &, <, > and quotes escaped; control characters become blanks. */
void kith_xml_text(FILE *out, const char *text);

#endif
