#include "app/svg.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Okabe and Ito's colors, which nearly everybody can tell apart; without the yellow, which is faint on white. */
static const char *const colors[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                     "#56b4e9", "#e69f00", "#000000", "#7a5195"};
static const char grey[] = "#666c75";
enum { COLORS = sizeof colors / sizeof *colors, SHAPES = 6, MOST_TICKS = 64 };
static const double LEFT = 74, RIGHT = 14, TOP = 34, BOTTOM = 50;

struct axis {
  double lower, upper, from, to; /* values; where they are drawn */
  bool logarithmic;
};

const char *kith_svg_color(int style) {
  return colors[style % COLORS];
}

void kith_xml_text(FILE *f, const char *text) {
  for (const char *c = text; *c != '\0'; ++c) {
    const char *escaped = *c == '&'   ? "&amp;"
                          : *c == '<' ? "&lt;"
                          : *c == '>' ? "&gt;"
                          : *c == '"' ? "&quot;"
                                      : NULL;
    if (escaped != NULL)
      fputs(escaped, f);
    else
      fputc((unsigned char)*c < ' ' ? ' ' : *c, f);
  }
}

void kith_svg_open(FILE *f, double width, double height, const char *title) {
  fprintf(
      f,
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" viewBox=\"0 0 %.0f %.0f\" "
      "role=\"img\" font-family=\"DejaVu Sans, Helvetica, Arial, sans-serif\" font-size=\"12\" fill=\"#1f2328\" aria-label=\"",
      width, height, width, height);
  kith_xml_text(f, title);
  fputs("\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n", f);
}

static void put_text(FILE *f, double x, double y, const char *more, const char *text) {
  fprintf(f, "<text x=\"%.1f\" y=\"%.1f\"%s>", x, y, more);
  kith_xml_text(f, text);
  fputs("</text>\n", f);
}

/* --- axes --- */

static double place(const struct axis *a, double value) {
  const double part = a->logarithmic ? log(value / a->lower) / log(a->upper / a->lower)
                                     : (value - a->lower) / (a->upper - a->lower);
  return a->from + part * (a->to - a->from);
}

static bool shown(const struct kith_dot *dot) {
  return !dot->failed && isfinite(dot->x) && isfinite(dot->y);
}

static void choose_range(struct axis *a, double lower, double upper, bool logarithmic) {
  if (!(lower <= upper)) lower = 0.1, upper = 10;
  a->logarithmic = lower > 0 && (logarithmic || upper >= 5 * lower);
  const double span = upper - lower;
  if (a->logarithmic) {
    const double margin = fmax(pow(upper / lower, 0.06), 1.02);
    a->lower = lower / margin, a->upper = upper * margin;
  } else {
    const double margin = span > 0 ? 0.07 * span : fmax(0.1 * fabs(upper), 1e-12);
    a->lower = lower - margin, a->upper = upper + margin;
  }
}

static void choose_axes(const struct kith_panel *p, struct axis *x, struct axis *y) {
  double least[2] = {INFINITY, INFINITY}, most[2] = {-INFINITY, -INFINITY};
  for (int s = 0; s < p->n; ++s)
    for (int k = 0; k < p->series[s].n; ++k) {
      const struct kith_dot *d = &p->series[s].dot[k];
      if (isfinite(d->x)) least[0] = fmin(least[0], d->x), most[0] = fmax(most[0], d->x);
      if (shown(d)) least[1] = fmin(least[1], d->y), most[1] = fmax(most[1], d->y);
    }
  if (p->level > 0) least[1] = fmin(least[1], p->level), most[1] = fmax(most[1], p->level);
  choose_range(x, least[0], most[0], p->logarithmic);
  choose_range(y, least[1], most[1], p->logarithmic);
  if (p->n_names > 0) *x = (struct axis){-0.5, p->n_names - 0.5, 0, 0, false};
}

/* "0.02", "2·10⁻⁶" */
static void tick_text(double value, char text[48]) {
  static const char *const raised[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  const double size = fabs(value);
  if (size == 0 || (size >= 0.9e-3 && size < 0.99e4)) {
    snprintf(text, 48, "%.4g", value);
    return;
  }
  int power = (int)floor(log10(size) + 1e-9);
  const double digits = value / pow(10, power);
  int n = fabs(digits - 1) < 1e-6 ? snprintf(text, 48, "10") : snprintf(text, 48, "%.3g·10", digits);
  if (power < 0) n += snprintf(text + n, (size_t)(48 - n), "⁻");
  power = abs(power);
  if (power >= 10) n += snprintf(text + n, (size_t)(48 - n), "%s", raised[power / 10 % 10]);
  snprintf(text + n, (size_t)(48 - n), "%s", raised[power % 10]);
}

static int log_ticks(const struct axis *a, double ticks[MOST_TICKS]) {
  static const double fine[] = {1, 1.5, 2, 3, 4, 5, 7}, middle[] = {1, 2, 5}, coarse[] = {1};
  const double span = log10(a->upper / a->lower);
  const double *digits = span < 0.9 ? fine : span < 2.6 ? middle : coarse;
  const int count = span < 0.9 ? 7 : span < 2.6 ? 3 : 1, every = span < 9 ? 1 : (int)ceil(span / 7);
  int n = 0;
  for (int e = (int)floor(log10(a->lower)); e <= (int)ceil(log10(a->upper)); ++e)
    for (int d = 0; d < count && n < MOST_TICKS; ++d) {
      const double tick = digits[d] * pow(10, e);
      if (tick >= a->lower && tick <= a->upper && e % every == 0) ticks[n++] = tick;
    }
  return n;
}

static int linear_ticks(const struct axis *a, double ticks[MOST_TICKS]) {
  const double raw = (a->upper - a->lower) / 5, power = pow(10, floor(log10(raw))), part = raw / power;
  const double step = power * (part > 5 ? 10 : part > 2 ? 5 : part > 1 ? 2 : 1);
  int n = 0;
  for (double k = ceil(a->lower / step); k * step <= a->upper && n < MOST_TICKS; k += 1)
    ticks[n++] = k * step + 0.0; /* not -0 */
  return n;
}

static int choose_ticks(const struct axis *a, double ticks[MOST_TICKS]) {
  const int n = a->logarithmic ? log_ticks(a, ticks) : 0;
  return n >= 3 ? n : linear_ticks(a, ticks); /* little room on a logarithmic axis is nearly linear */
}

static void put_x_ticks(FILE *f, const struct kith_panel *p, const struct axis *x, const struct axis *y) {
  double ticks[MOST_TICKS];
  char text[48];
  const int n = p->n_names > 0 ? KITH_MIN(p->n_names, MOST_TICKS) : choose_ticks(x, ticks);
  double last = -INFINITY;
  for (int k = 0; k < n; ++k) {
    const double at = place(x, p->n_names > 0 ? k : ticks[k]);
    fprintf(f, "<path d=\"M%.1f %.1fV%.1f\" stroke=\"#e6e8eb\"/>\n", at, y->from, y->to);
    if (p->n_names > 0) {
      char turn[96];
      snprintf(turn, sizeof turn, " text-anchor=\"end\" font-size=\"10\" transform=\"rotate(-30 %.1f %.1f)\"",
               at, y->from + 14);
      put_text(f, at, y->from + 14, turn, p->names[k]);
      continue;
    }
    tick_text(ticks[k], text);
    if (at - last > 34) put_text(f, at, y->from + 16, " text-anchor=\"middle\"", text), last = at;
  }
}

static void put_y_ticks(FILE *f, const struct axis *x, const struct axis *y) {
  double ticks[MOST_TICKS];
  char text[48];
  const int n = choose_ticks(y, ticks);
  for (int k = 0; k < n; ++k) {
    const double at = place(y, ticks[k]);
    fprintf(f, "<path d=\"M%.1f %.1fH%.1f\" stroke=\"#e6e8eb\"/>\n", x->from, at, x->to);
    tick_text(ticks[k], text);
    put_text(f, x->from - 6, at + 4, " text-anchor=\"end\"", text);
  }
}

/* --- marks --- */

static void put_shape(FILE *f, int shape, double x, double y, double r) {
  switch (shape % SHAPES) {
    case 0:
      fprintf(f, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\"", x, y, r);
      return;
    case 1:
      fprintf(f, "<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"", x - 0.9 * r, y - 0.9 * r,
              1.8 * r, 1.8 * r);
      return;
    case 2:
      fprintf(f, "<path d=\"M%.1f %.1fl%.1f %.1fh%.1fz\"", x, y - 1.2 * r, 1.1 * r, 2 * r, -2.2 * r);
      return;
    case 3:
      fprintf(f, "<path d=\"M%.1f %.1fl%.1f %.1fl%.1f %.1fl%.1f %.1fz\"", x, y - 1.3 * r, 1.3 * r, 1.3 * r,
              -1.3 * r, 1.3 * r, -1.3 * r, -1.3 * r);
      return;
    case 4:
      fprintf(f, "<path d=\"M%.1f %.1fl%.1f %.1fh%.1fz\"", x, y + 1.2 * r, 1.1 * r, -2 * r, -2.2 * r);
      return;
    default:
      fprintf(f, "<path d=\"M%.1f %.1fh%.1fl%.1f %.1fl%.1f %.1fh%.1fl%.1f %.1fz\"", x - 0.6 * r, y - r,
              1.2 * r, 0.6 * r, r, -0.6 * r, r, -1.2 * r, -0.6 * r, -r);
  }
}

static const char *color_of(const struct kith_series *s) {
  return s->hollow ? grey : kith_svg_color(s->style);
}

/* Methods beyond the colors go on with other shapes; a ring shows that a point is on the front. */
static void put_mark(FILE *f, const struct kith_series *s, double x, double y, const struct kith_dot *dot) {
  const int shape = s->style + s->style / COLORS;
  put_shape(f, shape, x, y, 4.5);
  fprintf(f, " fill=\"%s\" stroke=\"%s\" stroke-width=\"%s\">", s->hollow ? "#ffffff" : color_of(s),
          dot != NULL && dot->ring ? "#1f2328" : color_of(s), dot != NULL && dot->ring ? "2" : "1.4");
  if (dot != NULL && dot->title[0] != '\0') {
    fputs("<title>", f);
    kith_xml_text(f, dot->title);
    fputs("</title>", f);
  }
  /* what put_shape opened */
  static const char *const ends[SHAPES] = {"circle", "rect", "path", "path", "path", "path"};
  fprintf(f, "</%s>\n", ends[shape % SHAPES]);
}

static void put_cross(FILE *f, const struct kith_series *s, double x, double y, const struct kith_dot *dot) {
  fprintf(f, "<path d=\"M%.1f %.1fl9 9m0 -9l-9 9\" stroke=\"%s\" stroke-width=\"2.2\" fill=\"none\"><title>",
          x - 4.5, y, color_of(s));
  kith_xml_text(f, dot->title);
  fputs("</title></path>\n", f);
}

static void put_line(FILE *f, const struct kith_series *s, const struct axis *x, const struct axis *y) {
  bool drawing = false;
  fputs("<path d=\"", f);
  for (int k = 0; k < s->n; ++k) {
    if (shown(&s->dot[k]))
      fprintf(f, "%c%.1f %.1f", drawing ? 'L' : 'M', place(x, s->dot[k].x), place(y, s->dot[k].y));
    drawing = shown(&s->dot[k]);
  }
  fprintf(f, "\" fill=\"none\" stroke=\"%s\" stroke-width=\"1.6\"/>\n", color_of(s));
}

/* Through the rings, from the cheapest: the next one is that with the least x beyond. */
static void put_front(FILE *f, const struct kith_panel *p, const struct axis *x, const struct axis *y) {
  double at = -INFINITY;
  bool begun = false;
  for (const struct kith_dot *next = p->series[0].dot; next != NULL;) {
    next = NULL;
    for (int s = 0; s < p->n; ++s)
      for (int k = 0; k < p->series[s].n; ++k) {
        const struct kith_dot *d = &p->series[s].dot[k];
        if (d->ring && shown(d) && d->x > at && (next == NULL || d->x < next->x)) next = d;
      }
    if (next == NULL) break;
    fprintf(f, begun ? "L%.1f %.1f" : "<path class=\"front\" d=\"M%.1f %.1f", place(x, next->x),
            place(y, next->y));
    begun = true, at = next->x;
  }
  if (begun)
    fputs(
        "\" fill=\"none\" stroke=\"#1f2328\" stroke-opacity=\"0.16\" stroke-width=\"9\" stroke-linejoin=\"round\" "
        "stroke-linecap=\"round\"/>\n",
        f);
}

static void put_level(FILE *f, const struct kith_panel *p, const struct axis *x, const struct axis *y) {
  if (!(p->level > 0)) return;
  const double at = place(y, p->level);
  fprintf(f, "<path d=\"M%.1f %.1fH%.1f\" stroke=\"#b3261e\" stroke-dasharray=\"6 4\"/>\n", x->from, at,
          x->to);
  if (p->level_label != NULL)
    put_text(f, x->to - 4, at - 4, " text-anchor=\"end\" font-size=\"11\" fill=\"#b3261e\"", p->level_label);
}

void kith_panel_write(FILE *f, const struct kith_panel *p, double left, double top) {
  struct axis x, y;
  char turn[96];
  choose_axes(p, &x, &y);
  x.from = left + LEFT, x.to = left + KITH_PANEL_WIDTH - RIGHT;
  y.from = top + KITH_PANEL_HEIGHT - BOTTOM - (p->n_names > 0 ? 30 : 0), y.to = top + TOP;
  put_text(f, x.from, top + 20, " font-size=\"14\" font-weight=\"bold\"", p->title);
  put_x_ticks(f, p, &x, &y);
  put_y_ticks(f, &x, &y);
  fprintf(f, "<path d=\"M%.1f %.1fV%.1fH%.1f\" fill=\"none\" stroke=\"#3c424a\"/>\n", x.from, y.to, y.from,
          x.to);
  put_text(f, (x.from + x.to) / 2, top + KITH_PANEL_HEIGHT - 12, " text-anchor=\"middle\"", p->x_label);
  snprintf(turn, sizeof turn, " text-anchor=\"middle\" transform=\"rotate(-90 %.1f %.1f)\"", left + 16,
           (y.from + y.to) / 2);
  put_text(f, left + 16, (y.from + y.to) / 2, turn, p->y_label);
  put_level(f, p, &x, &y);
  if (p->n > 0) put_front(f, p, &x, &y);
  for (int s = 0; s < p->n; ++s)
    if (!p->series[s].hollow && p->n_names == 0) put_line(f, &p->series[s], &x, &y);
  for (int s = 0; s < p->n; ++s)
    for (int k = 0; k < p->series[s].n; ++k) {
      const struct kith_dot *d = &p->series[s].dot[k];
      if (shown(d)) put_mark(f, &p->series[s], place(&x, d->x), place(&y, d->y), d);
      if (d->failed && isfinite(d->x)) put_cross(f, &p->series[s], place(&x, d->x), y.to + 2, d);
    }
}

double kith_legend_write(FILE *f, int n, const struct kith_series *series, double left, double top,
                         double width) {
  double x = left, y = top + 14;
  for (int s = 0; s < n; ++s) {
    const double needs = 30 + 7.6 * (double)strlen(series[s].label);
    if (x > left && x + needs > left + width) x = left, y += 20;
    if (f != NULL) {
      put_mark(f, &series[s], x + 7, y - 4, NULL);
      put_text(f, x + 18, y, "", series[s].label);
    }
    x += needs;
  }
  return y + 8 - top;
}
