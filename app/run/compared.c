/* The nodes of a run that are compared, measured and drawn: all, or a copy of some. */
#include "app/run/compared.h"

#include <stdio.h>
#include <string.h>
#include "app/output/pictures/plot.h"

static kith_status copy_gas(struct kith_compared *compared) {
  struct kith_simulation *m = compared->simulation;
  KITH_TRY(kith_nodes_copy(&compared->gas, m->nodes, false));
  if (m->nodes->flag != NULL)
    KITH_TRY(kith_nodes_delete(compared->gas, kith_nodes_field_named(compared->gas, "flag")->u8));
  KITH_TRY(kith_boundaries_mirror(&m->boundaries, compared->gas));
  return kith_boundaries_wrap(&m->boundaries, compared->gas);
}

kith_status kith_compared_take(struct kith_compared *compared) {
  const struct kith_simulation *m = compared->simulation;
  const bool strays = m->integrator.positions != m->nodes->positions || m->nodes->activity != NULL;
  if (m->nodes->flag == NULL && !(strays && m->integrator.step > 0)) return KITH_OK;
  return kith_ranks_allreduce_status(m->nodes->ranks, copy_gas(compared));
}

void kith_compared_clear(struct kith_compared *compared) {
  kith_nodes_destroy(&compared->gas);
}

/* Fields have their names from kith_hydro_init. */
struct kith_profile_view kith_compared_view(const struct kith_compared *compared) {
  const struct kith_nodes *all = compared->simulation->nodes,
                          *nodes = compared->gas != NULL ? compared->gas : all;
#define VALUES(name) kith_nodes_field_named(nodes, name)->f64
  return (struct kith_profile_view){.n = nodes->n_internal,
                                    .position = VALUES("position"),
                                    .velocity = VALUES("velocity"),
                                    .mass = VALUES("mass"),
                                    .density = VALUES("density"),
                                    .pressure = VALUES("pressure"),
                                    .energy = VALUES("energy"),
                                    .id = nodes->id->i64,
                                    .ranks = all->ranks};
#undef VALUES
}

double kith_compared_measure(const struct kith_compared *compared, enum kith_measure which,
                             const double *start) {
  const struct kith_simulation *m = compared->simulation;
  const struct kith_profile_view view = kith_compared_view(compared);
  struct kith_measured measured = {
      .nodes = &view, .domain = m->scene->domain, .time = m->integrator.time, .start = start};
  memcpy(measured.center, m->hydro.center, sizeof measured.center);
  return kith_measure_take(which, &measured);
}

void kith_compared_draw(const struct kith_compared *compared, const char *directory, const char *frame,
                        const struct kith_norms *norms) {
  const struct kith_simulation *m = compared->simulation;
  const struct kith_scene *scene = m->scene;
  const struct kith_plot plot = {.scene = scene->name,
                                 .frame = frame,
                                 .picture = &scene->output.picture,
                                 .time = m->integrator.time,
                                 .resolution = scene->resolution,
                                 .nodes = kith_compared_view(compared),
                                 .exact = scene->exact.ops,
                                 .solution = scene->exact.solution,
                                 .window = &scene->exact.window,
                                 .norms = norms};
  kith_nodes_free_work(m->nodes);
  if (kith_plot_write(&plot, directory) != KITH_OK && kith_ranks_rank(m->nodes->ranks) == 0)
    fprintf(stderr, "kith: warning: %s\n", kith_failure());
}
