/* The growth of a mode, by rows of a table, and its picture. */
#include "app/output/growth.h"

#include <inttypes.h>
#include <math.h>
#include "app/output/pictures/figure.h"

enum { SAMPLES = 100 };

/* The first multiple of `every` after `time`, but for rounding: the same whether or not a run was
 * interrupted, and the last one is the end. */
static double next_after(const struct kith_growth *g, double time) {
  return (floor(time / g->every + 1e-6) + 1 - 1e-6) * g->every;
}

kith_status kith_growth_open(struct kith_growth *g, const char *directory, const struct kith_simulation *m,
                             bool restarted) {
  const struct kith_scene *scene = m->scene;
  const struct kith_integrator *it = &m->integrator;
  const bool *wanted = scene->measure.wanted;
  if (!(wanted[KITH_MEASURE_growth] || wanted[KITH_MEASURE_mcnally]) || !(scene->until > 0)) return KITH_OK;
  g->scene = scene;
  g->measure = wanted[KITH_MEASURE_growth] ? KITH_MEASURE_growth : KITH_MEASURE_mcnally;
  g->every = scene->until / SAMPLES;
  g->next = restarted ? next_after(g, it->time) : 0;
  if (kith_ranks_rank(m->nodes->ranks) != 0) return KITH_OK;
  return kith_csv_log_open(&g->log, directory, "growth.csv", "step,time,amplitude",
                           restarted ? &it->step : NULL);
}

bool kith_growth_due(const struct kith_growth *g, double time) {
  return g->scene != NULL && time >= g->next;
}

kith_status kith_growth_add(struct kith_growth *g, uint64_t step, double time, double amplitude) {
  g->next = next_after(g, time), g->sampled = true;
  if (g->log.file == NULL) return KITH_OK;
  fprintf(g->log.file, "%" PRIu64 ",%.9g,%.9g", step, time, amplitude);
  return kith_csv_log_row(&g->log);
}

kith_status kith_growth_draw(struct kith_growth *g, const char *directory, double first) {
  static const struct kith_figure_layout layout = {1, 1, 700, 480, 34};
  const double rate = g->scene->measure.rate;
  struct kith_figure figure;
  char title[256];
  if (g->log.file == NULL || !g->sampled || !(first > 0)) return KITH_OK;
  KITH_TRY(kith_csv_log_close(&g->log)); /* gnuplot reads it now */
  snprintf(title, sizeof title, "%.150s    %d-D,  resolution %.4g", g->scene->name, NDIM,
           g->scene->resolution);
  KITH_TRY(kith_figure_open(&figure, directory, "growth", title, &layout));
  kith_figure_panel(&figure, "amplitude of the mode", "time (code units)", "velocity (code units)");
  fputs(
      "set logscale y\nset datafile separator ','\n"
      "plot 'growth.csv' using 2:3 with points pt 7 ps 0.5 lc rgb '#0072b2'",
      figure.file->stream);
  if (rate > 0)
    fprintf(figure.file->stream, ", %.9g * cosh(%.9g * x) with lines lw 2 lc rgb '#d55e00'", first, rate);
  fputc('\n', figure.file->stream);
  kith_figure_legend(&figure);
  fputs("NaN with points pt 7 ps 0.7 lc rgb '#0072b2' title 'run'", figure.file->stream);
  if (rate > 0)
    fprintf(figure.file->stream, ", NaN with lines lw 2 lc rgb '#d55e00' title 'linear theory, rate %.4g'",
            rate);
  fputc('\n', figure.file->stream);
  return kith_figure_close(&figure);
}
