/* What a chart writes: the page, its panels, its points, and a script for gnuplot. */
#include <math.h>
#include <string.h>
#include "app/chart.h"
#include "app/svg.h"
#include "app/version.h"
#include "lib/io/atomic_file.h"

enum { PANELS = 3, BY_RESOLUTION = 2 };

/* The series of one norm, for each of its panels. */
struct drawing {
  const struct kith_chart *chart;
  int norm, n_codes, n_series;
  struct kith_series series[PANELS][KITH_SUITE_NORMS * 16]; /* methods first, then other codes */
  struct kith_dot *dot;
};
enum { MOST_SERIES = KITH_SUITE_NORMS * 16, MOST_METHODS = 100 };

/* --- points --- */

static void describe(const struct kith_chart *c, int m, int r, int norm, struct kith_dot *dot) {
  const struct kith_point *p = kith_chart_point(c, m, r);
  const double resolution = c->suite->resolution[r];
  if (p->failed) {
    snprintf(dot->title, sizeof dot->title, "%.95s at %.4g failed: %.180s", c->label[m], resolution, p->why);
    return;
  }
  snprintf(dot->title, sizeof dot->title,
           "%.95s at %.4g: %.3g; %.3g CPU-s, %.3g pair evaluations; %.0f nodes, %.0f steps%s", c->label[m],
           resolution, p->value[norm], p->value[0], p->value[2], p->value[3], p->value[4],
           dot->ring ? "; on the front" : "");
}

static kith_status fill_method(struct drawing *d, int m, int panel, const bool *on, struct kith_dot *dot) {
  const struct kith_chart *c = d->chart;
  const int n = c->suite->n_resolutions, norm = c->suite->norm[d->norm];
  for (int r = 0; r < n; ++r) {
    const struct kith_point *p = kith_chart_point(c, m, r);
    dot[r].failed = p->failed;
    dot[r].x = panel == BY_RESOLUTION ? c->suite->resolution[r] : p->value[kith_cost_metrics[panel]];
    dot[r].y = p->value[norm] > 0 ? p->value[norm] : NAN;
    dot[r].ring = panel != BY_RESOLUTION && on[(size_t)m * n + r];
    describe(c, m, r, norm, &dot[r]);
  }
  d->series[panel][m] = (struct kith_series){.label = c->label[m], .style = m, .n = n, .dot = dot};
  return KITH_OK;
}

/* The other codes' points of this norm, one series for each code; they know no pair evaluations. */
static void fill_others(struct drawing *d, struct kith_dot *dot) {
  const struct kith_chart *c = d->chart;
  const char *norm = kith_metrics[c->suite->norm[d->norm]].name;
  for (int k = 0; k < c->others.n; ++k) {
    const struct kith_other *o = &c->others.other[k];
    bool first = strcmp(o->norm, norm) == 0;
    for (int b = 0; b < k; ++b)
      first = first &&
              (strcmp(c->others.other[b].code, o->code) != 0 || strcmp(c->others.other[b].norm, norm) != 0);
    if (!first || d->n_series == MOST_SERIES) continue;
    struct kith_series s = {.label = o->code, .style = d->n_codes++, .hollow = true, .dot = dot};
    for (int b = k; b < c->others.n; ++b) {
      const struct kith_other *p = &c->others.other[b];
      if (strcmp(p->code, o->code) != 0 || strcmp(p->norm, norm) != 0) continue;
      *dot = (struct kith_dot){.x = p->cpu_seconds, .y = p->value};
      snprintf(dot->title, sizeof dot->title, "%.60s %.40s at %.4g: %.3g; %.3g CPU-s on %.90s", p->code,
               p->version, p->resolution, p->value, p->cpu_seconds, p->machine);
      ++dot, ++s.n;
    }
    d->series[0][d->n_series++] = s;
  }
}

static kith_status fill(struct drawing *d, const struct kith_chart *chart, int norm, bool *on) {
  const int shown = KITH_MIN(chart->n_methods, MOST_METHODS), n = chart->suite->n_resolutions;
  struct kith_dot *dot = d->dot;
  d->chart = chart, d->norm = norm, d->n_series = shown, d->n_codes = 0;
  for (int panel = 0; panel < PANELS; ++panel) {
    if (panel < KITH_COSTS) KITH_TRY(kith_chart_front(chart, norm, panel, on));
    for (int m = 0; m < shown; ++m, dot += n) KITH_TRY(fill_method(d, m, panel, on, dot));
  }
  fill_others(d, dot);
  return KITH_OK;
}

/* --- panels --- */

/* The panels of a norm side by side with their legend; returns the height. out NULL: only that. */
static double put_panels(FILE *f, const struct drawing *d, double top) {
  const int metric = d->chart->suite->norm[d->norm];
  const char *const x_labels[PANELS] = {"CPU-seconds", "pair evaluations",
                                        "resolution (nodes per unit length)"};
  const char *const against[PANELS] = {"cost", "work (any machine)", "resolution"};
  const int shown = KITH_MIN(d->chart->n_methods, MOST_METHODS);
  for (int k = 0; k < PANELS && f != NULL; ++k) {
    char title[128];
    snprintf(title, sizeof title, "%s against %s", kith_metrics[metric].name, against[k]);
    const struct kith_panel panel = {.title = title,
                                     .x_label = x_labels[k],
                                     .y_label = kith_metrics[metric].doc,
                                     .n = k == 0 ? d->n_series : shown,
                                     .series = d->series[k],
                                     .logarithmic = true,
                                     .level = d->chart->suite->target[d->norm],
                                     .level_label = "target"};
    kith_panel_write(f, &panel, k * KITH_PANEL_WIDTH, top);
  }
  return KITH_PANEL_HEIGHT +
         kith_legend_write(f, d->n_series, d->series[0], 60, top + KITH_PANEL_HEIGHT,
                           PANELS * KITH_PANEL_WIDTH - 80) +
         10;
}

/* --- the page --- */

static const char style[] =
    "body{font:15px/1.5 'DejaVu Sans',Helvetica,Arial,sans-serif;color:#1f2328;background:#fff;margin:2em auto;max-width:1310px;"
    "padding:0 1em}\n"
    "h1{font-size:1.5em;margin:0}h2{font-size:1.2em;margin:2em 0 .4em;border-bottom:1px solid #d5d9de}h3{font-size:1em}\n"
    "p.act{background:#eef4fb;border-left:4px solid #0072b2;padding:.6em .9em;margin:.6em 0;max-width:70em}\n"
    ".note{color:#4a5058;font-size:.9em}\n"
    "svg{max-width:100%;height:auto}\n"
    "table{border-collapse:collapse;margin:.6em 0;font-size:.9em}\n"
    "th,td{padding:.2em .8em;text-align:right;border-bottom:1px solid #e6e8eb}th{border-bottom:2px solid #8a9099}\n"
    "td:first-child,th:first-child,td.text{text-align:left}tr.failed td{color:#b3261e}\n"
    ".wide{overflow-x:auto}\n";

static void put_head(FILE *f, const struct kith_chart *c) {
  const int all = c->n_methods * c->suite->n_resolutions;
  fputs("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>kith chart: ", f);
  kith_xml_text(f, c->suite->name);
  fprintf(f, "</title>\n<style>\n%s</style></head><body>\n<h1>", style);
  kith_xml_text(f, c->suite->name);
  fputs(": error against cost</h1>\n<p class=\"note\">Scene ", f);
  kith_xml_text(f, c->suite->scene_name);
  fprintf(f, " in %d-D; %d method%s at %d resolution%s, %d run%s", c->suite->dimension, c->n_methods,
          c->n_methods == 1 ? "" : "s", c->suite->n_resolutions, c->suite->n_resolutions == 1 ? "" : "s", all,
          all == 1 ? "" : "s");
  if (c->n_failed > 0)
    fprintf(f, ", %d of which failed (crosses at the upper edge; reasons below)", c->n_failed);
  fprintf(f, ". kith %s, one run at a time on %d thread%s of ", kith_version(), c->threads,
          c->threads == 1 ? "" : "s");
  kith_xml_text(f, c->machine);
  fputs(". Norms are weighted by volume, against the exact solution.</p>\n", f);
}

static kith_status put_front(FILE *f, const struct kith_chart *c, int norm) {
  static const char *const costs[KITH_COSTS] = {"CPU-seconds", "pair evaluations"};
  char text[KITH_CHART_TEXT];
  for (int cost = 0; cost < KITH_COSTS; ++cost) {
    KITH_TRY(kith_chart_front_names(c, norm, cost, text));
    fprintf(f, "<p>On the front in %s (nothing is both cheaper and more accurate): <b>", costs[cost]);
    kith_xml_text(f, text[0] != '\0' ? text : "nobody");
    fputs("</b>.</p>\n", f);
  }
  kith_chart_others_sentence(c, norm, text);
  if (text[0] == '\0') return KITH_OK;
  fputs("<p>", f);
  kith_xml_text(f, text);
  fputs("</p>\n", f);
  return KITH_OK;
}

static kith_status put_norm(FILE *f, const struct kith_chart *c, const struct drawing *d) {
  char text[KITH_CHART_TEXT];
  const struct kith_metric *metric = &kith_metrics[c->suite->norm[d->norm]];
  fprintf(f, "<h2>%s</h2>\n", metric->doc);
  KITH_TRY(kith_chart_sentence(c, d->norm, text));
  fputs("<p class=\"act\">", f);
  kith_xml_text(f, text);
  fputs("</p>\n", f);
  kith_svg_open(f, PANELS * KITH_PANEL_WIDTH, put_panels(NULL, d, 0), metric->doc);
  put_panels(f, d, 0);
  fputs("</svg>\n", f);
  return put_front(f, c, d->norm);
}

static void put_number(FILE *f, const char *format, double value) {
  fputs("<td>", f);
  if (isfinite(value))
    fprintf(f, format, value);
  else
    fputs("&ndash;", f);
  fputs("</td>", f);
}

static void put_orders(FILE *f, const struct kith_chart *c) {
  fputs(
      "<h2>Observed orders of convergence</h2>\n<p class=\"note\">The slope of log error over log resolution through all points, and "
      "between the last two.</p>\n<div class=\"wide\"><table class=\"orders\"><tr><th>method</th>",
      f);
  for (int k = 0; k < c->suite->n_norms; ++k)
    fprintf(f, "<th>%s</th><th>last two</th>", kith_metrics[c->suite->norm[k]].name);
  fputs("</tr>\n", f);
  for (int m = 0; m < c->n_methods; ++m) {
    fputs("<tr><td>", f);
    kith_xml_text(f, c->label[m]);
    fputs("</td>", f);
    for (int k = 0; k < c->suite->n_norms; ++k) {
      double all, last;
      kith_chart_order(c, m, k, &all, &last);
      put_number(f, "%.2f", all);
      put_number(f, "%.2f", last);
    }
    fputs("</tr>\n", f);
  }
  fputs("</table></div>\n", f);
}

static void put_row(FILE *f, const struct kith_chart *c, int m, int r) {
  const struct kith_point *p = kith_chart_point(c, m, r);
  fprintf(f, "<tr%s><td>", p->failed ? " class=\"failed\"" : "");
  kith_xml_text(f, c->label[m]);
  fprintf(f, "</td><td>%.4g</td>", c->suite->resolution[r]);
  if (p->failed) {
    fprintf(f, "<td class=\"text\" colspan=\"%d\">failed: ", 5 + c->suite->n_norms);
    kith_xml_text(f, p->why);
    fputs("</td></tr>\n", f);
    return;
  }
  for (int k = 0; k < c->suite->n_norms; ++k) put_number(f, "%.4g", p->value[c->suite->norm[k]]);
  put_number(f, "%.3g", p->value[0]);
  put_number(f, "%.3g", p->value[2]);
  put_number(f, "%.0f", p->value[3]);
  put_number(f, "%.0f", p->value[4]);
  put_number(f, "%.1e", p->value[kith_metric_find("energy_drift")]);
  fputs("</tr>\n", f);
}

static void put_points(FILE *f, const struct kith_chart *c) {
  fputs(
      "<h2>All points</h2>\n<div class=\"wide\"><table class=\"points\"><tr><th>method</th><th>resolution</th>",
      f);
  for (int k = 0; k < c->suite->n_norms; ++k) fprintf(f, "<th>%s</th>", kith_metrics[c->suite->norm[k]].name);
  fputs("<th>CPU-s</th><th>pair evaluations</th><th>nodes</th><th>steps</th><th>drift of energy</th></tr>\n",
        f);
  for (int m = 0; m < c->n_methods; ++m)
    for (int r = 0; r < c->suite->n_resolutions; ++r) put_row(f, c, m, r);
  fputs("</table></div>\n", f);
}

static void put_others(FILE *f, const struct kith_chart *c) {
  if (c->others.n == 0) return;
  fputs(
      "<h2>Other codes</h2>\n<p class=\"note\">Hollow marks: measured elsewhere, so their CPU-seconds are those of the machine in the "
      "table. They take no part in the front.</p>\n<div class=\"wide\"><table class=\"others\"><tr><th>code</th><th>version</th>"
      "<th>resolution</th><th>norm</th><th>value</th><th>CPU-s</th><th>machine</th></tr>\n",
      f);
  for (int k = 0; k < c->others.n; ++k) {
    const struct kith_other *o = &c->others.other[k];
    fputs("<tr><td>", f), kith_xml_text(f, o->code), fputs("</td><td class=\"text\">", f),
        kith_xml_text(f, o->version);
    fprintf(f, "</td><td>%.4g</td><td class=\"text\">", o->resolution), kith_xml_text(f, o->norm);
    fprintf(f, "</td><td>%.4g</td><td>%.3g</td><td class=\"text\">", o->value, o->cpu_seconds),
        kith_xml_text(f, o->machine);
    fputs("</td></tr>\n", f);
  }
  fputs("</table></div>\n", f);
}

static kith_status put_page(FILE *f, const struct kith_chart *c, struct drawing *d, bool *on) {
  put_head(f, c);
  for (int k = 0; k < c->suite->n_norms; ++k) {
    KITH_TRY(fill(d, c, k, on));
    KITH_TRY(put_norm(f, c, d));
  }
  put_orders(f, c);
  put_points(f, c);
  put_others(f, c);
  fputs("</body></html>\n", f);
  return KITH_OK;
}

static kith_status put_svg(FILE *f, const struct kith_chart *c, struct drawing *d, bool *on) {
  double height = 0;
  for (int k = 0; k < c->suite->n_norms; ++k) {
    KITH_TRY(fill(d, c, k, on));
    height += put_panels(NULL, d, 0);
  }
  kith_svg_open(f, PANELS * KITH_PANEL_WIDTH, height, c->suite->name);
  height = 0;
  for (int k = 0; k < c->suite->n_norms; ++k) {
    KITH_TRY(fill(d, c, k, on));
    height += put_panels(f, d, height);
  }
  fputs("</svg>\n", f);
  return KITH_OK;
}

/* --- points and gnuplot --- */

static kith_status put_csv(FILE *f, const struct kith_chart *c, struct drawing *d, bool *on) {
  (void)d, (void)on;
  fputs("method,resolution,status,why", f);
  for (int k = 0; k < KITH_N_METRICS; ++k) fprintf(f, ",%s", kith_metrics[k].name);
  fputc('\n', f);
  for (int m = 0; m < c->n_methods; ++m)
    for (int r = 0; r < c->suite->n_resolutions; ++r) {
      const struct kith_point *p = kith_chart_point(c, m, r);
      kith_csv_quoted(f, c->label[m]);
      fprintf(f, ",%.9g,%s,", c->suite->resolution[r], p->failed ? "failed" : "ok");
      kith_csv_quoted(f, p->why);
      for (int k = 0; k < KITH_N_METRICS; ++k) fprintf(f, ",%.9g", p->value[k]);
      fputc('\n', f);
    }
  return KITH_OK;
}

/* A word in single quotes, where gnuplot reads nothing into it; double ones it would stop at in a label. */
static void put_quoted(FILE *f, const char *text) {
  fputc('\'', f);
  for (const char *s = text; *s != '\0'; ++s) {
    if (*s == '\'') fputc('\'', f);
    fputc((unsigned char)*s < ' ' ? ' ' : *s == '"' ? '`' : *s, f);
  }
  fputc('\'', f);
}

/* One block of data per method: resolution, cost, work, and every norm. */
static void put_blocks(FILE *f, const struct kith_chart *c) {
  for (int m = 0; m < c->n_methods; ++m) {
    fprintf(f, "$method%d << END\n", m);
    for (int r = 0; r < c->suite->n_resolutions; ++r) {
      const struct kith_point *p = kith_chart_point(c, m, r);
      if (p->failed) continue;
      fprintf(f, "%.9g %.9g %.9g", c->suite->resolution[r], p->value[0], p->value[2]);
      for (int k = 0; k < c->suite->n_norms; ++k) fprintf(f, " %.9g", p->value[c->suite->norm[k]]);
      fputc('\n', f);
    }
    fputs("NaN NaN NaN\nEND\n", f);
  }
}

/* The fronts: cost and error of their points, which gnuplot sorts. */
static kith_status put_fronts(FILE *f, const struct kith_chart *c, bool *on) {
  for (int norm = 0; norm < c->suite->n_norms; ++norm)
    for (int cost = 0; cost < KITH_COSTS; ++cost) {
      KITH_TRY(kith_chart_front(c, norm, cost, on));
      fprintf(f, "$front%d_%d << END\nNaN NaN\n", norm, cost);
      for (int k = 0; k < c->n_methods * c->suite->n_resolutions; ++k)
        if (on[k])
          fprintf(f, "%.9g %.9g\n", c->point[k].value[kith_cost_metrics[cost]],
                  c->point[k].value[c->suite->norm[norm]]);
      fputs("END\n", f);
    }
  return KITH_OK;
}

static void put_plot(FILE *f, const struct kith_chart *c, int norm, int column) {
  static const char *const labels[PANELS] = {"resolution", "CPU-seconds", "pair evaluations"};
  fprintf(f, "set xlabel '%s'\nset ylabel '%s'\nplot ", labels[column - 1],
          kith_metrics[c->suite->norm[norm]].doc);
  if (column > 1)
    fprintf(f, "$front%d_%d using 1:2 smooth unique with lines lw 9 lc rgb '#dddddd' title 'front', \\\n  ",
            norm, column - 2);
  for (int m = 0; m < c->n_methods; ++m) {
    fprintf(f, "%s$method%d using %d:%d with linespoints lw 1.5 pt %d lc rgb '%s' title ",
            m > 0 ? ", \\\n  " : "", m, column, 4 + norm, 4 + m % 9, kith_svg_color(m));
    put_quoted(f, c->label[m]);
  }
  const char *name = kith_metrics[c->suite->norm[norm]].name;
  for (int k = 0; k < c->others.n && column == 2; ++k) {
    const struct kith_other *o = &c->others.other[k];
    if (strcmp(o->norm, name) != 0) continue;
    fprintf(
        f,
        ", \\\n  '+' every ::0::0 using (%.9g):(%.9g) with points pt 6 lc rgb '#666c75' notitle, '+' every ::0::0 using "
        "(%.9g):(%.9g):(",
        o->cpu_seconds, o->value, o->cpu_seconds, o->value);
    put_quoted(f, o->code);
    fputs(") with labels left offset 0.6,0 font ',9' textcolor rgb '#666c75' notitle", f);
  }
  fputc('\n', f);
}

static kith_status put_script(FILE *f, const struct kith_chart *c, struct drawing *d, bool *on) {
  (void)d;
  fprintf(
      f,
      "# gnuplot plot.gp\nset terminal pngcairo noenhanced size 1500,%d font 'Sans,11'\nset output 'chart.png'\n",
      480 * c->suite->n_norms);
  put_blocks(f, c);
  KITH_TRY(put_fronts(f, c, on));
  fputs(
      "set logscale xy\nset format '%g'\nset format x '%.0e'\nset grid lc rgb '#e3e6ea'\nset border 3\nset tics nomirror\n"
      "set key outside bottom center horizontal\nset multiplot layout ",
      f);
  fprintf(f, "%d,3 title ", c->suite->n_norms);
  char title[256];
  snprintf(title, sizeof title, "%s, %d-D: error against cost", c->suite->name, c->suite->dimension);
  put_quoted(f, title);
  fputc('\n', f);
  static const int columns[PANELS] = {2, 3, 1};
  for (int norm = 0; norm < c->suite->n_norms; ++norm)
    for (int k = 0; k < PANELS; ++k) {
      fputs(columns[k] == 1 ? "set format x '%g'\n" : "set format x '%.0e'\n", f);
      put_plot(f, c, norm, columns[k]);
    }
  fputs("unset multiplot\n", f);
  return KITH_OK;
}

/* --- files --- */

typedef kith_status put_file(FILE *, const struct kith_chart *, struct drawing *, bool *);

static kith_status write_file(const struct kith_chart *c, const char *directory, const char *name,
                              put_file *put, struct drawing *d, bool *on) {
  char path[KITH_PATH + 32];
  struct kith_atomic_file *file;
  snprintf(path, sizeof path, "%s/%s", directory, name);
  KITH_TRY(kith_atomic_file_open(&file, path));
  const kith_status status = put(file->stream, c, d, on);
  if (status == KITH_OK) return kith_atomic_file_commit(&file, false);
  kith_atomic_file_abandon(&file);
  return status;
}

static kith_status write_all(const struct kith_chart *c, const char *directory, struct drawing *d, bool *on) {
  KITH_TRY(write_file(c, directory, "chart.csv", put_csv, d, on));
  KITH_TRY(write_file(c, directory, "plot.gp", put_script, d, on));
  KITH_TRY(write_file(c, directory, "chart.svg", put_svg, d, on));
  return write_file(c, directory, "chart.html", put_page, d, on);
}

kith_status kith_chart_write(const struct kith_chart *c, const char *directory) {
  const size_t n = (size_t)c->n_methods * c->suite->n_resolutions;
  struct drawing *d = NULL;
  bool *on = NULL;
  KITH_TRY(kith_resize(&d, 0, 1, sizeof *d));
  kith_status status = kith_resize(&d->dot, 0, PANELS * n + (size_t)c->others.n, sizeof *d->dot);
  if (status == KITH_OK) status = kith_resize(&on, 0, n, sizeof *on);
  if (status == KITH_OK) status = write_all(c, directory, d, on);
  kith_free(&d->dot);
  kith_free(&d);
  kith_free(&on);
  return status;
}
