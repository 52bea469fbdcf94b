#include "app/run.h"

#include <stdio.h>
#include <string.h>
#include "app/model.h"
#include "app/screen.h"

struct run {
  const struct kith_options *options;
  struct kith_scene *scene;
  struct kith_profile *profile;
  struct kith_model *model;
  struct kith_screen screen;
};

static kith_status open_run(struct run *run) {
  const struct kith_options *o = run->options;
  KITH_TRY(kith_scene_read(&run->scene, o->subject, o->n_overrides, o->overrides));
  KITH_TRY(kith_profile_create(&run->profile, 64, o->trace != NULL));
  return kith_model_create(&run->model, run->scene, run->profile, o->check);
}

static kith_status steps(struct run *run) {
  struct kith_integrator *it = &run->model->integrator;
  const double until = run->options->until >= 0 ? run->options->until : run->scene->until;
  KITH_TRY(kith_integrator_start(it));
  kith_screen_init(&run->screen, stderr, run->options->quiet, it->time, until);
  while (it->time < until && (run->options->steps < 0 || it->step < (uint64_t)run->options->steps)) {
    KITH_TRY(kith_integrator_step(it, until));
    kith_screen_step(&run->screen, it, it->time >= until);
  }
  kith_screen_end(&run->screen);
  return KITH_OK;
}

static void compare(struct run *run) {
  const struct kith_scene *scene = run->scene;
  struct kith_nodes *nodes = run->model->nodes;
  const struct kith_hydro *h = &run->model->hydro;
  void *exact;
  struct kith_norms norms;
  if (scene->exact.ops == NULL || scene->exact.ops->create(&exact, &scene->exact.parameters) != KITH_OK) return;
  const struct kith_profile_view view = {nodes->n_internal, nodes->position->f64, h->velocity->f64, h->mass->f64, h->density->f64, h->pressure->f64, h->energy->f64};
  if (kith_norms_measure(&norms, scene->exact.ops, exact, run->model->integrator.time, &scene->exact.window, &view) == KITH_OK)
    printf("L1 rho %.5f v %.5f P %.5f u %.5f blip %.3f shock %.4f exact %.4f peak %.3f\n", norms.density.l1, norms.velocity.l1, norms.pressure.l1, norms.energy.l1, norms.blip, norms.shock_radius, norms.shock_exact, norms.density_peak);
  else printf("%s\n", kith_failure());
  scene->exact.ops->destroy(&exact);
}

enum kith_exit kith_run(const struct kith_options *options) {
  struct run run = {.options = options};
  kith_status status = open_run(&run);
  if (status != KITH_OK) {
    fprintf(stderr, "kith: %s\n", kith_failure());
    return KITH_EXIT_USAGE;
  }
  status = steps(&run);
  if (status != KITH_OK) fprintf(stderr, "kith: %s\n", kith_failure());
  else compare(&run);
  if (options->profile) kith_profile_print(run.profile, stdout, (double)run.model->nodes->n_internal * (double)run.model->integrator.step);
  kith_model_destroy(&run.model);
  kith_profile_destroy(&run.profile);
  kith_scene_destroy(&run.scene);
  return status == KITH_OK ? KITH_EXIT_OK : KITH_EXIT_FAILED;
}
