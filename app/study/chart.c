/* chart.c - error against cost: `kith chart SUITE`, and `kith chart list`.
 *
 * Runs every method of a suite (study.h) at every resolution, one run at a time so that they do not share
 * caches and memory, with one thread unless --threads says otherwise. A run that fails is a point with a
 * reason. DIR: -o, or out/chart/NAME.
 *
 *   DIR/chart.md    for each norm a table: observed orders, the cost at a given error, who is on the Pareto
 *                   front, which points of other codes lie above it; the runs that failed. Also on stdout
 *   DIR/chart.png   errors against CPU-seconds, against pair evaluations (the same on any machine) and
 *                   against resolution, by gnuplot from DIR/chart.gp; and chart.pdf
 *   DIR/points.csv  all points
 *
 * Exit code: 0; 1 if a run failed or the results cannot be written; 2 if the suite or the command line is
 * wrong, or the directory cannot be written to. */
#include "app/cli/options.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "app/output/pictures/figure.h"
#include "app/study/study.h"
#include "lib/core/version.h"

enum { COSTS = 2, POINTS = KITH_SUITE_METHODS * KITH_SUITE_VALUES };
static const int cost_column[COSTS] = {KITH_CPU_SECONDS, KITH_PAIR_EVALUATIONS};

/* All points of one measure: [m * n_values + v]; NaN: failed. */
struct cloud {
  const struct kith_suite *suite;
  int n, measure;
  double target; /* that of the suite; else the largest error at the finest resolution */
  double resolution[POINTS], error[POINTS], cost[COSTS][POINTS];
  bool on[COSTS][POINTS]; /* on the Pareto front */
};

static void fill(struct cloud *c, const struct kith_study *s, int measure) {
  const int n_values = s->suite->n_values;
  const double given = s->suite->target[measure];
  c->suite = s->suite, c->measure = measure, c->n = s->suite->n_methods * n_values, c->target = given;
  for (int k = 0; k < c->n; ++k) {
    c->resolution[k] = s->suite->job[k].x;
    c->error[k] = s->suite->point[k].value[KITH_MEASURES + measure];
    for (int a = 0; a < COSTS; ++a) c->cost[a][k] = s->suite->point[k].value[cost_column[a]];
    if (!(given > 0) && (k + 1) % n_values == 0) c->target = fmax(c->target, c->error[k]);
  }
  for (int a = 0; a < COSTS; ++a) kith_pareto_front(c->n, c->cost[a], c->error, c->on[a]);
}

/* What method m costs at the target. */
struct offer {
  int m;
  struct kith_cost_at_error at[COSTS];
};

static int by_cost(const void *a, const void *b) {
  const double x = ((const struct offer *)a)->at[0].cost, y = ((const struct offer *)b)->at[0].cost;
  return isnan(x) != isnan(y) ? isnan(x) - isnan(y) : (x > y) - (x < y);
}

static void put_number(FILE *f, const char *format, double value) {
  if (isfinite(value))
    fprintf(f, format, value);
  else
    fputs(" - |", f);
}

static void put_method(FILE *f, const struct cloud *c, const struct offer *offer) {
  const int n = c->suite->n_values, first = offer->m * n, last = first + n - 2;
  fprintf(f, "| %s |", c->suite->job[first].label);
  put_number(f, " %.2f |", kith_order(n, c->resolution + first, c->error + first));
  put_number(f, " %.2f |", n > 1 ? kith_order(2, c->resolution + last, c->error + last) : NAN);
  for (int a = 0; a < COSTS; ++a) put_number(f, " %.3g |", offer->at[a].cost);
  put_number(f, offer->at[0].between ? " %.3g |" : " %.3g (coarsest) |", offer->at[0].resolution);
  for (int a = 0; a < COSTS; ++a) {
    for (int k = first; k < first + n; ++k)
      if (c->on[a][k]) fprintf(f, " %s", c->suite->job[k].value);
    fputs(" |", f);
  }
  fputc('\n', f);
}

/* Writes a line for each method, the cheapest at the target first. */
static void put_methods(FILE *f, const struct cloud *c) {
  struct offer offer[KITH_SUITE_METHODS];
  const int n = c->suite->n_values, n_methods = c->suite->n_methods;
  for (int m = 0; m < n_methods; ++m) {
    offer[m].m = m;
    for (int a = 0; a < COSTS; ++a)
      offer[m].at[a] =
          kith_cost_at_error_of(n, c->resolution + m * n, c->cost[a] + m * n, c->error + m * n, c->target);
  }
  qsort(offer, (size_t)n_methods, sizeof *offer, by_cost);
  for (int m = 0; m < n_methods; ++m) put_method(f, c, &offer[m]);
}

/* Writes a line for each point of another code. It is above the front if a point of ours has at most its cost
 * and at most its error. */
static void put_codes(FILE *f, const struct cloud *c) {
  int n = 0;
  for (int j = 0; j < c->suite->n_codes; ++j) {
    const struct kith_reference_code *code = &c->suite->code[j];
    const double error = code->norm[c->measure];
    bool above = false;
    if (isnan(error)) continue;
    for (int k = 0; k < c->n; ++k) above |= c->cost[0][k] <= code->cpu_seconds && c->error[k] <= error;
    if (n++ == 0)
      fputs(
          "\nOther codes, measured elsewhere:\n\n| code | version | resolution | error | CPU-s | machine | "
          "above the front |\n|---|---|---|---|---|---|---|\n",
          f);
    fprintf(f, "| %s | %s | %.4g | %.4g | %.3g | %s | %s |\n", code->name, code->version, code->resolution,
            error, code->cpu_seconds, code->machine, above ? "yes" : "no");
  }
}

static void put_text(FILE *f, const struct kith_study *study, bool to_file) {
  const struct kith_suite *s = study->suite;
  struct cloud c;
  char picture[KITH_PATH + 16];
  fprintf(f,
          "# %s: error against cost\n\nScene %s in %d-D, %d methods at %d resolutions. kith %s, one run at a "
          "time on %d thread%s. Norms are weighted by volume, against the exact solution. Costs are those at "
          "one error, and so is the resolution, between two runs. On the front are runs, by resolution, for "
          "which no other is both cheaper and more accurate.\n",
          s->name, s->scene, s->dimension, s->n_methods, s->n_values, kith_version(), s->job->threads,
          s->job->threads == 1 ? "" : "s");
  for (int measure = 0; measure < s->n_measures; ++measure) {
    fill(&c, study, measure);
    fprintf(
        f,
        "\n## %s\n\n| method | order | of the last two | CPU-s at error %.3g | pair evaluations | resolution "
        "| on the front in CPU-s | in pair evaluations |\n|---|---|---|---|---|---|---|---|\n",
        s->measure[measure], c.target);
    put_methods(f, &c);
    put_codes(f, &c);
  }
  if (study->n_failed > 0) fputs("\n## Failed runs\n\n", f);
  for (int k = 0; k < s->n_methods * s->n_values; ++k)
    if (s->point[k].failed) fprintf(f, "- %s at %s: %s\n", s->job[k].label, s->job[k].value, s->point[k].why);
  snprintf(picture, sizeof picture, "%s/chart.png", study->directory);
  if (to_file && access(picture, R_OK) == 0) fputs("\n![error against cost](chart.png)\n", f);
}

/* Does another code begin with this point? */
static bool begins_code(const struct kith_suite *s, int k) {
  return k == 0 || strcmp(s->code[k].name, s->code[k - 1].name) != 0;
}

static void begin_series(FILE *f, int n) {
  fprintf(f, "%s$series%d << END\n", n > 0 ? "END\n" : "", n);
}

/* Writes a point of a series; returns false, and writes nothing, if it cannot be drawn. */
static bool put_point(FILE *f, double x, double y) {
  if (!(isfinite(x) && isfinite(y) && y > 0)) return false;
  fprintf(f, "%.9g %.9g\n", x, y);
  return true;
}

/* Writes how a series is drawn, for the plot command of its panel or for the legend. The style has the number
 * of a color or symbol. */
static void put_style(FILE *f, bool legend, int n, const char *label, const char *style, int number) {
  if (legend)
    fputs(n > 0 ? ", NaN " : "NaN ", f);
  else
    fprintf(f, ", $series%d ", n);
  fprintf(f, style, number);
  if (!legend) return;
  fputs(" title ", f);
  kith_figure_put_quoted(f, label);
}

/* Writes how all series of a panel are drawn. */
static void put_styles(FILE *f, const struct cloud *c, int a, bool legend) {
  const struct kith_suite *s = c->suite;
  const char *front = "smooth unique with lines lw 9 lc rgb '#dddddd'";
  int n = 0;
  if (a < COSTS) put_style(f, legend, n++, "Pareto front", legend ? strstr(front, "with") : front, 0);
  for (int m = 0; m < s->n_methods; ++m)
    put_style(f, legend, n++, s->job[m * s->n_values].label, "with linespoints lw 1.5 lt %d", m + 1);
  for (int k = 0; k < s->n_codes && a == 0; ++k)
    if (begins_code(s, k))
      put_style(f, legend, n++, s->code[k].name, "with points pt %d lc rgb '#666c75'", k + 1);
  fputc('\n', f);
}

/* Draws a panel: the front, each method, each other code, and a dashed line at the target. a: against this
 * cost; COSTS: against resolution. */
static void draw_panel(struct kith_figure *g, const struct cloud *c, int a) {
  static const char *const labels[] = {"CPU-seconds", "pair evaluations",
                                       "resolution (nodes per unit length)"};
  const struct kith_suite *s = c->suite;
  const double *x = a < COSTS ? c->cost[a] : c->resolution;
  FILE *f = g->file->stream;
  int n = 0, n_points = 0;
  kith_figure_panel(g, s->measure[c->measure], labels[a], "error");
  if (a < COSTS) begin_series(f, n++);
  for (int k = 0; k < c->n && a < COSTS; ++k)
    if (c->on[a][k]) n_points += put_point(f, x[k], c->error[k]);
  for (int k = 0; k < c->n; ++k) {
    if (k % s->n_values == 0) begin_series(f, n++);
    n_points += put_point(f, x[k], c->error[k]);
  }
  for (int k = 0; k < s->n_codes && a == 0; ++k) {
    if (begins_code(s, k)) begin_series(f, n++);
    n_points += put_point(f, s->code[k].cpu_seconds, s->code[k].norm[c->measure]);
  }
  fputs("END\nset logscale xy\n", f);
  if (n_points == 0) fputs("set xrange [1:10]\nset yrange [1:10]\n", f); /* else gnuplot would stop */
  fprintf(f, "plot %.9g with lines dt 2 lc rgb '#666c75'", c->target);
  put_styles(f, c, a, false);
}

static kith_status draw(const struct kith_study *s) {
  struct kith_figure g;
  struct cloud c;
  const struct kith_figure_layout layout = {.rows = s->suite->n_measures,
                                            .columns = COSTS + 1,
                                            .width = 500,
                                            .height = 420,
                                            .legend = 30 + 4 * (s->suite->n_methods + s->suite->n_codes)};
  char title[200];
  snprintf(title, sizeof title, "%s, %d-D: error against cost; dashed: the error at which costs are compared",
           s->suite->name, s->suite->dimension);
  KITH_TRY(kith_figure_open(&g, s->directory, "chart", title, &layout));
  for (int measure = 0; measure < s->suite->n_measures; ++measure) {
    fill(&c, s, measure);
    for (int a = 0; a <= COSTS; ++a) draw_panel(&g, &c, a);
  }
  kith_figure_legend(&g);
  put_styles(g.file->stream, &c, 0, true);
  return kith_figure_close(&g);
}

/* Reads the suite, and has `kith plan` check every method at its coarsest resolution. */
static kith_status read_suite(struct kith_study *s) {
  const struct kith_options *o = s->options;
  KITH_TRY(kith_suite_read(s, o->subject));
  snprintf(s->directory, sizeof s->directory, "%s%.700s", o->directory != NULL ? "" : "out/chart/",
           o->directory != NULL ? o->directory : s->suite->name);
  for (int m = 0; m < s->suite->n_methods; ++m)
    KITH_TRY(kith_job_check(&s->programs, &s->suite->job[m * s->suite->n_values], s->suite->file, "method"));
  return KITH_OK;
}

static enum kith_exit verdict(const struct kith_study *s) {
  return s->n_failed == 0 ? KITH_EXIT_OK : KITH_EXIT_FAILED;
}

enum kith_exit kith_chart(const struct kith_options *options) {
  static const struct kith_study_verb verb = {.name = "chart",
                                              .list = kith_suite_list,
                                              .read = read_suite,
                                              .draw = draw,
                                              .put = put_text,
                                              .verdict = verdict};
  return kith_study_run(&verb, options);
}
