/* Norms, measures and the picture of a run. */
#include "app/run/comparison.h"

#include <string.h>
#include "app/output/plot.h"
#include "lib/nodes/migrate.h"

kith_status kith_comparison_init(struct kith_comparison *c, const struct kith_scene *scene) {
  *c = (struct kith_comparison){.scene = scene};
  return scene->exact.ops != NULL ? kith_exact_create(&c->exact, scene->exact.ops, scene->exact.settings)
                                  : KITH_OK;
}

void kith_comparison_clear(struct kith_comparison *c) {
  if (c->exact != NULL) kith_exact_destroy(c->scene->exact.ops, &c->exact);
  kith_nodes_destroy(&c->whole);
}

/* Fields have their names from kith_hydro_init. */
static struct kith_profile_view view_of(const struct kith_comparison *c, const struct kith_simulation *m) {
  const struct kith_nodes *nodes = c->whole != NULL ? c->whole : m->nodes;
#define VALUES(name) kith_nodes_field_named(nodes, name)->f64
  return (struct kith_profile_view){nodes->n_internal, VALUES("position"), VALUES("velocity"), VALUES("mass"),
                                    VALUES("density"), VALUES("pressure"), VALUES("energy")};
#undef VALUES
}

static bool measures(const struct kith_scene *scene) {
  bool wanted = false;
  for (int k = 0; k < KITH_N_MEASURES; ++k) wanted = wanted || scene->measure.wanted[k];
  return wanted;
}

/* start: what was measured then; NULL: this is the start. */
static kith_status measure(const struct kith_comparison *c, const struct kith_simulation *m,
                           const struct kith_conservation_baseline *baseline, const double *start,
                           double *value) {
  const struct kith_profile_view view = view_of(c, m);
  struct kith_measured measured = {.nodes = &view,
                                   .domain = c->scene->domain,
                                   .time = m->integrator.time,
                                   .kinetic_start = baseline->totals.kinetic,
                                   .start = start};
  memcpy(measured.center, m->hydro.center, sizeof measured.center);
  for (int k = 0; k < KITH_N_MEASURES; ++k)
    if (c->scene->measure.wanted[k]) KITH_TRY(kith_measure_take((enum kith_measure)k, &measured, &value[k]));
  return KITH_OK;
}

kith_status kith_comparison_start(struct kith_comparison *c, const struct kith_simulation *m,
                                  struct kith_conservation_baseline *baseline) {
  struct kith_ranks *ranks = m->nodes->ranks;
  if (!measures(c->scene)) return KITH_OK;
  if (ranks != NULL) KITH_TRY(kith_nodes_gather(m->nodes, &c->whole));
  const kith_status status =
      kith_ranks_rank(ranks) == 0 ? measure(c, m, baseline, NULL, baseline->measure) : KITH_OK;
  kith_nodes_destroy(&c->whole);
  return kith_ranks_allreduce_status(ranks, status);
}

kith_status kith_comparison_gather(struct kith_comparison *c, const struct kith_simulation *m) {
  const bool needed = c->exact != NULL || c->scene->output.plot || measures(c->scene);
  return m->nodes->ranks != NULL && needed ? kith_nodes_gather(m->nodes, &c->whole) : KITH_OK;
}

kith_status kith_comparison_report(const struct kith_comparison *c, const struct kith_simulation *m,
                                   const struct kith_conservation_baseline *baseline,
                                   struct kith_report *report) {
  const struct kith_profile_view view = view_of(c, m);
  if (c->exact != NULL)
    KITH_TRY(kith_norms_measure(&report->norms, c->scene->exact.ops, c->exact, m->integrator.time,
                                &c->scene->exact.window, &view));
  report->compared = c->exact != NULL;
  return measure(c, m, baseline, baseline->measure, report->measure);
}

void kith_comparison_draw(const struct kith_comparison *c, const struct kith_simulation *m,
                          const struct kith_report *report, const char *directory) {
  if (!c->scene->output.plot) return;
  const struct kith_plot plot = {.scene = c->scene->name,
                                 .time = report->time,
                                 .resolution = c->scene->resolution,
                                 .nodes = view_of(c, m),
                                 .exact = c->exact != NULL ? c->scene->exact.ops : NULL,
                                 .solution = c->exact,
                                 .norms = report->compared ? &report->norms : NULL};
  if (kith_plot_write(&plot, directory) != KITH_OK) fprintf(stderr, "kith: warning: %s\n", kith_failure());
}
