/* Short runs that measure what one process needs for a scene, and what a rank exchanges with others. */
#include "app/plan/calibration.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include "app/output/output.h"
#include "integrator/lifecycle.h"
#include "integrator/window.h"

/* Processor time if there is one thread, so that other programs do not count; else wall time. */
static double seconds_now(void) {
  struct timespec t;
  if (omp_get_max_threads() > 1) return kith_seconds();
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

kith_status kith_evaluation_measure(struct kith_simulation *simulation, double *seconds) {
  struct kith_integrator *it = &simulation->integrator;
  const double start = seconds_now();
  double before = start;
  *seconds = INFINITY;
  if (it->follows) memset(it->nodes->activity->u8, KITH_ACTIVE, (size_t)it->nodes->n_internal);
  for (int k = 0; k < 3 && before - start < 0.5; ++k) {
    if (kith_rebuilds_lasting(it->rebuilds)) {
      KITH_TRY(kith_lifecycle(it, KITH_BECAUSE_requested));
      KITH_TRY(kith_lifecycle_close(it));
    }
    KITH_TRY(kith_integrator_rates(it));
    const double now = seconds_now();
    *seconds = fmin(*seconds, now - before);
    before = now;
  }
  if (it->follows) kith_window_begin(it);
  return KITH_OK;
}

/* The cost of a run of the same scene at another resolution, which has more steps, and more nodes. */
static double cost_at(const struct kith_calibration *c, double resolution) {
  const double finer = resolution / c->resolution;
  return finer * (c->pairs * kith_pow_dim(finer) + KITH_EVALUATION_PAIRS * c->evaluations);
}

double kith_updates_needed(const struct kith_integrator *it) {
  const double dt = kith_package_timestep_limit(it->package, it->cfl).dt;
  double sum = 0;
#pragma omp parallel for schedule(static) reduction(+ : sum)
  for (kith_index i = 0; i < it->nodes->n_internal; ++i)
    sum += dt / kith_package_limit_of_node(it->package, i, it->cfl).dt;
  return sum / it->nodes->n_internal;
}

struct calibration_run {
  double until, limit;
  struct kith_calibration *out;
};

static kith_status steps_of(struct kith_simulation *m, void *context) {
  const struct calibration_run *run = context;
  struct kith_calibration *out = run->out;
  struct kith_integrator *it = &m->integrator;
  double first;
  KITH_TRY(kith_simulation_start(m));
  KITH_TRY(kith_evaluation_measure(m, &first));
  out->pairs = out->evaluations = 0;
  const bool parts = it->nodes->activity != NULL; /* not all nodes are updated in each step */
  const uint64_t evaluations = it->ledger.evaluations, updates = it->ledger.updates,
                 pairs = m->package.pair_evaluations;
  const double start = seconds_now();
  double needed = 0, aside = 0;
  while (it->time < run->until && cost_at(out, out->resolution) < run->limit) {
    const double before = seconds_now();
    if (!parts) needed += kith_updates_needed(it);
    aside += seconds_now() - before;
    const double next = kith_output_next(m->scene, it->time);
    KITH_TRY(kith_simulation_step(m, kith_output_step_end(m->scene, next, run->until)));
    out->pairs = (double)(m->package.pair_evaluations - pairs);
    out->evaluations = (double)(it->ledger.evaluations - evaluations);
  }
  const double of_node = (double)(it->ledger.updates - updates) / m->nodes->n_internal,
               all = parts ? of_node : out->evaluations;
  out->steps = parts ? of_node : (double)it->step;
  out->reached = it->time;
  out->growth = (seconds_now() - start - aside) / fmax(all, 1) / first;
  out->needed = kith_scheme_has_blocks(it->scheme, it->settings) ? of_node / out->evaluations
                : parts                                          ? NAN
                                                                 : needed / (double)it->step;
  return KITH_OK;
}

kith_status kith_scene_read_with(struct kith_scene **scene, const struct kith_options *o,
                                 const char *setting) {
  const char *overrides[KITH_MAX_OVERRIDES + 1];
  memcpy(overrides, o->overrides, sizeof o->overrides);
  overrides[o->n_overrides] = setting;
  return kith_scene_read(scene, o->subject, o->n_overrides + 1, overrides);
}

kith_status kith_scene_read_at(struct kith_scene **scene, const struct kith_options *o, double resolution) {
  char setting[64];
  snprintf(setting, sizeof setting, "resolution=%.10g", resolution);
  return kith_scene_read_with(scene, o, setting);
}

/* Calls `then` with a simulation of the scene at another resolution. */
static kith_status with_resolution(const struct kith_options *o, double resolution, struct kith_ranks *ranks,
                                   kith_status (*then)(struct kith_simulation *, void *), void *context) {
  struct kith_scene *scene = NULL;
  struct kith_simulation *m = NULL;
  KITH_TRY(kith_scene_read_at(&scene, o, resolution));
  kith_status status = kith_simulation_create(&m, scene, ranks, NULL, false);
  if (status == KITH_OK) status = then(m, context);
  kith_simulation_destroy(&m);
  kith_scene_destroy(&scene);
  return status;
}

/* Whole and even where that makes little difference: lattices and centers may need it. */
static double evened(double resolution) {
  return resolution > 5 ? 2 * round(0.5 * resolution) : resolution;
}

kith_status kith_calibration_run(struct kith_calibration *out, const struct kith_options *options,
                                 const struct kith_calibration *guess, double until, double budget) {
  const double resolution = guess->resolution, cost = cost_at(guess, resolution);
  struct kith_calibration last;
  struct calibration_run run = {until, 3 * budget, out};
  double next = cost <= budget ? resolution : evened(0.5 * resolution * pow(budget / cost, 1.0 / (NDIM + 1)));
  kith_status status = KITH_INTERNAL;
  *out = (struct kith_calibration){0};
  do {
    last = *out;
    *out = *guess;
    out->pairs *= pow(next / resolution, NDIM + 1), out->evaluations *= next / resolution;
    out->resolution = next;
    status = with_resolution(options, next, NULL, steps_of, &run);
    next =
        cost_at(out, resolution) <= budget ? resolution : fmin(evened(4 * out->resolution / 3), resolution);
  } while (next > out->resolution && cost_at(out, next) <= (last.reached >= until ? budget : 3 * budget));
  KITH_TRY(status);
  /* Steps are no multiple of the resolution: those of the start, and of few nodes with block steps, grow less
   * than it, those of a small blast more, which has more room in more nodes, and those of conduction as its
   * square. A line through two runs mostly has too few steps, a power too many. */
  const double ratio = resolution / out->resolution;
  double line = out->steps * ratio, power = line;
  if (last.reached >= until && last.steps > 0) {
    const double more = fmax(out->steps / last.steps, 1), finer = out->resolution / last.resolution;
    line = out->steps * (1 + (1 - 1 / more) / (1 - 1 / finer) * (ratio - 1));
    power = out->steps * pow(ratio, log(more) / log(finer));
  }
  out->expected = sqrt(line * power);
  if (out->reached < until) out->expected = out->steps * ratio * until / out->reached;
  return KITH_OK;
}

/* ---- one rank of many ---- */

static kith_status rehearse(struct kith_simulation *m, void *context) {
  enum { STEPS = 20 }; /* they include a check of the balance */
  struct kith_rehearsal *out = context;
  struct kith_integrator *it = &m->integrator;
  KITH_TRY(kith_simulation_start(m));
  it->summarizes = true;
  const struct kith_halo_traffic before = kith_halo_traffic(m->halo);
  const uint64_t evaluations = it->ledger.evaluations, updates = it->ledger.updates,
                 checks = m->decomposition->balance_checks,
                 calls = kith_ranks_traffic(m->nodes->ranks).collectives;
  while (it->step < STEPS && it->time < m->scene->until) KITH_TRY(kith_simulation_step(m, m->scene->until));
  const struct kith_halo_traffic now = kith_halo_traffic(m->halo);
  const double n = fmax((double)it->step, 1);
  const bool parts = it->nodes->activity != NULL;
  *out = (struct kith_rehearsal){
      .evaluations = parts ? (double)(it->ledger.updates - updates) / m->nodes->n_internal / n
                           : (double)(it->ledger.evaluations - evaluations) / n,
      .collectives = (double)(kith_ranks_traffic(m->nodes->ranks).collectives - calls) / n,
      .balance_checks = (double)(m->decomposition->balance_checks - checks) / n};
#define X(name, doc) out->name = (double)(now.name - before.name) / n;
  KITH_HALO_TRAFFIC_LIST(X)
#undef X
  return KITH_OK;
}

kith_status kith_rehearsal_run(struct kith_rehearsal *out, const struct kith_options *options,
                               double resolution) {
  struct kith_ranks *ranks = NULL;
  kith_status status = kith_ranks_rehearse(&ranks);
  if (status == KITH_OK) status = with_resolution(options, resolution, ranks, rehearse, out);
  kith_ranks_destroy(&ranks);
  return status;
}
