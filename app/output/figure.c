/* figure.c - writes a script for gnuplot and has it drawn. */
#include "app/output/figure.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

/* Okabe and Ito's colors, which most people tell apart, and the marks of gnuplot that are filled. */
static const char *const colors[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                     "#e69f00", "#56b4e9", "#000000", "#8a6d00"};
enum { N_COLORS = sizeof colors / sizeof *colors };
static const int marks[] = {7, 5, 9, 11, 13, 15, 4, 8};

/* In quotes, without what gnuplot's svg does not escape. */
static void put_quoted(FILE *f, char quote, const char *text) {
  static const char bad[] = "\"'<>&\\", good[] = "``()+/";
  fputc(quote, f);
  for (const char *s = text; *s != '\0'; ++s) {
    const char *replaced = strchr(bad, *s);
    fputc((unsigned char)*s < ' ' ? ' ' : replaced != NULL ? good[replaced - bad] : *s, f);
  }
  fputc(quote, f);
}

kith_status kith_figure_open(struct kith_figure *g, const char *directory, const char *name,
                             const char *title, int rows, int columns) {
  char path[KITH_PATH + 40];
  *g = (struct kith_figure){0};
  snprintf(g->directory, sizeof g->directory, "%s", directory);
  snprintf(g->name, sizeof g->name, "%s", name);
  snprintf(path, sizeof path, "%s/%s.gp", directory, name);
  KITH_TRY(kith_atomic_file_open(&g->file, path));
  FILE *f = g->file->stream;
  fprintf(f,
          "# gnuplot %s.gp draws %s.png, then itself once more as %s.svg\n"
          "if (!exists('picture')) picture = 'png'\n"
          "if (picture eq 'png') set terminal pngcairo noenhanced size %d,%d font 'Sans,11'\n"
          "if (picture eq 'svg') set terminal svg mouse standalone noenhanced size %d,%d font 'Sans,11' "
          "background '#ffffff'\n"
          "set output '%s.'.picture\nset grid lc rgb '#e3e6ea'\nset border 3\nset tics nomirror\n"
          "set key outside bottom center horizontal samplen 2 width -3 font 'Sans,8'\n"
          "set multiplot layout %d,%d title ",
          name, name, name, 500 * columns, 480 * rows, 500 * columns, 480 * rows, name, rows, columns);
  put_quoted(f, '\'', title);
  fputc('\n', f);
  return KITH_OK;
}

void kith_figure_panel(struct kith_figure *g, const char *title, const char *x_label, const char *y_label,
                       bool logarithmic_x, int n_names, const char *const *names) {
  FILE *f = g->file->stream;
  const char *const words[] = {title, x_label, y_label}, *const what[] = {"title", "xlabel", "ylabel"};
  g->n_series = 0;
  for (int k = 0; k < 3; ++k) {
    fprintf(f, "set %s ", what[k]);
    put_quoted(f, '\'', words[k]);
    fputc('\n', f);
  }
  fprintf(f,
          "unset logscale\nset logscale %s\nset format '%%g'\nset xtics autofreq norotate\nset autoscale\n",
          logarithmic_x ? "xy" : "y");
  for (int k = 0; k < n_names; ++k) {
    fputs(k == 0 ? "set xtics rotate by -40 (" : ", ", f);
    put_quoted(f, '\'', names[k]);
    fprintf(f, " %d%s", k, k == n_names - 1 ? ")\n" : "");
  }
}

void kith_figure_series(struct kith_figure *g, enum kith_series_kind kind, const char *label) {
  if (g->n_series > 0) fputs("END\n", g->file->stream);
  if (g->n_series == KITH_FIGURE_SERIES) --g->n_series; /* more cannot be told apart */
  fprintf(g->file->stream, "$series%d << END\n", g->n_series);
  g->series[g->n_series].n = 0;
  g->series[g->n_series].kind = kind;
  snprintf(g->series[g->n_series++].label, KITH_FIGURE_LABEL, "%s", label);
}

void kith_figure_point(struct kith_figure *g, double x, double y, const char *format, ...) {
  char text[400];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  if (!(isfinite(x) && isfinite(y) && y > 0)) return;
  fprintf(g->file->stream, "%.9g %.9g ", x, y);
  put_quoted(g->file->stream, '"', text);
  fputc('\n', g->file->stream);
  g->series[g->n_series - 1].level = y;
  ++g->series[g->n_series - 1].n;
}

/* Its line, its marks, which say what they are, and its entry in the legend. gnuplot 5.4 breaks on labels of
 * an empty series. */
static void put_marks(FILE *f, int series, int n, bool line, int mark, const char *color) {
  if (n > 0 && line) fprintf(f, ", $series%d using 1:2 with lines lw 1.5 lc rgb '%s' notitle", series, color);
  if (n > 0)
    fprintf(f, ", $series%d using 1:2:3 with labels hypertext point pt %d lc rgb '%s' notitle", series, mark,
            color);
  fprintf(f, ", \\\n  NaN with %spoints pt %d lc rgb '%s'", line ? "lines" : "", mark, color);
}

void kith_figure_draw(struct kith_figure *g) {
  FILE *f = g->file->stream;
  int n_curves = 0, n_points = 0;
  if (g->n_series > 0) fputs("END\n", f);
  for (int k = 0; k < g->n_series; ++k) n_points += g->series[k].n;
  if (n_points == 0)
    fputs("set xrange [1:10]\nset yrange [1:10]\n", f); /* gnuplot stops at nothing to draw */
  fputs("plot NaN notitle", f);
  for (int k = 0; k < g->n_series; ++k) {
    const int n = g->series[k].n, style = n_curves % N_COLORS;
    switch (g->series[k].kind) {
      case KITH_SERIES_CURVE:
        put_marks(f, k, n, true, marks[style], colors[style]);
        ++n_curves;
        break;
      case KITH_SERIES_REFERENCE:
        put_marks(f, k, n, false, 4 + 2 * (k % 5), "#666c75");
        break;
      case KITH_SERIES_FRONT:
        if (n == 0) continue;
        fprintf(f, ", $series%d using 1:2 smooth unique with lines lw 9 lc rgb '#dddddd'", k);
        break;
      case KITH_SERIES_LEVEL:
        fprintf(f, ", %.9g with lines dt 2 lc rgb '#666c75'", g->series[k].level);
    }
    fputs(" title ", f);
    put_quoted(f, '\'', g->series[k].label);
  }
  fputc('\n', f);
}

kith_status kith_figure_close(struct kith_figure *g) {
  if (g->file == NULL) return KITH_OK;
  fprintf(g->file->stream,
          "unset multiplot\nunset output\nif (picture eq 'png') picture = 'svg'; load '%s.gp'\n", g->name);
  KITH_TRY(kith_atomic_file_commit(&g->file, false));
  if (kith_gnuplot_run(g->directory, g->name) != KITH_OK)
    fprintf(stderr, "kith: warning: %s\n", kith_failure());
  return KITH_OK;
}
