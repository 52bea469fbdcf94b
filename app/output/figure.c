/* figure.c - writes a script for gnuplot and has it drawn. */
#include "app/output/figure.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>

/* In single quotes nothing is special to gnuplot but these. */
static void put_quoted(FILE *f, const char *text) {
  fputc('\'', f);
  for (const char *s = text; *s != '\0'; ++s) fputc((unsigned char)*s < ' ' ? ' ' : *s == '\'' ? '`' : *s, f);
  fputc('\'', f);
}

kith_status kith_figure_open(struct kith_figure *g, const char *directory, const char *name,
                             const char *title, int rows, int columns, const int panel[2]) {
  char path[KITH_PATH + 40];
  *g = (struct kith_figure){0};
  snprintf(g->directory, sizeof g->directory, "%s", directory);
  snprintf(g->name, sizeof g->name, "%s", name);
  snprintf(path, sizeof path, "%s/%s.gp", directory, name);
  KITH_TRY(kith_atomic_file_open(&g->file, path));
  FILE *f = g->file->stream;
  const int width = panel[0] * columns, height = panel[1] * rows + 40;
  fprintf(f,
          "# gnuplot %s.gp draws %s.png, then %s.pdf\n"
          "if (!exists('pdf')) pdf = 0\n"
          "if (pdf) set terminal pdfcairo noenhanced size %.2f,%.2f font 'Sans,12'; set output '%s.pdf'\n"
          "if (!pdf) set terminal pngcairo noenhanced size %d,%d font 'Sans,12'; set output '%s.png'\n"
          "set colorsequence podo\nset grid lt 1 lw 0.5 lc rgb '#dde1e6'\nset border 3 lc rgb '#30343a'\n"
          "set tics nomirror\nset key outside top center horizontal samplen 2 font 'Sans,11'\n"
          "set multiplot layout %d,%d title ",
          name, name, name, width / 80.0, height / 80.0, name, width, height, name, rows, columns);
  put_quoted(f, title);
  fputs(" font 'Sans,13'", f);
  fputc('\n', f);
  return KITH_OK;
}

void kith_figure_panel(struct kith_figure *g, const char *title, const char *x_label, const char *y_label,
                       bool logarithmic_x) {
  FILE *f = g->file->stream;
  const char *const words[] = {title, x_label, y_label}, *const what[] = {"title", "xlabel", "ylabel"};
  g->n_series = g->n_points = 0;
  for (int k = 0; k < 3; ++k) {
    fprintf(f, "set %s ", what[k]);
    put_quoted(f, words[k]);
    fputc('\n', f);
  }
  fprintf(f, "unset logscale\nset logscale %s\nset format '%%g'\nset autoscale\n",
          logarithmic_x ? "xy" : "y");
}

void kith_figure_series(struct kith_figure *g, const char *label, const char *style, ...) {
  va_list arguments;
  if (g->n_series == 0) g->plot = open_memstream(&g->plot_text, &g->plot_size);
  if (g->n_series > 0) fputs("END\n", g->file->stream);
  fprintf(g->file->stream, "$series%d << END\n", g->n_series);
  if (g->plot == NULL) return; /* no memory: no picture */
  fprintf(g->plot, ", $series%d ", g->n_series++);
  va_start(arguments, style);
  vfprintf(g->plot, style, arguments);
  va_end(arguments);
  fputs(" title ", g->plot);
  put_quoted(g->plot, label);
}

void kith_figure_point(struct kith_figure *g, double x, double y) {
  if (!(isfinite(x) && isfinite(y) && y > 0)) return;
  fprintf(g->file->stream, "%.9g %.9g\n", x, y);
  ++g->n_points;
}

void kith_figure_draw(struct kith_figure *g, double level, const char *label) {
  FILE *f = g->file->stream;
  fputs("END\n", f);
  if (g->n_points == 0)
    fputs("set xrange [1:10]\nset yrange [1:10]\n", f); /* gnuplot stops at nothing to draw */
  if (g->plot != NULL && fclose(g->plot) == 0)
    fprintf(f, "plot %.9g with lines dt 2 lc rgb '#666c75' title '%s'%s\n", level, label, g->plot_text);
  free(g->plot_text);
  g->plot_text = NULL;
}

kith_status kith_figure_close(struct kith_figure *g) {
  fputs("unset multiplot\nset output\n", g->file->stream);
  if (!g->png_only) fprintf(g->file->stream, "if (!pdf) pdf = 1; load '%s.gp'\n", g->name);
  KITH_TRY(kith_atomic_file_commit(&g->file, false));
  if (kith_gnuplot_run(g->directory, g->name) != KITH_OK)
    fprintf(stderr, "kith: warning: %s\n", kith_failure());
  return KITH_OK;
}
