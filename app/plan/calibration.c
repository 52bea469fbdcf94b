/* Timing of evaluations and short runs with fewer nodes: see calibration.h. */
#include "app/plan/calibration.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include "integrator/lifecycle.h"

/* Processor time where there is one thread: other programs do not count. */
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
  for (int k = 0; k < 3 && before - start < 0.5; ++k) {
    if (kith_rebuilds_lasting(it->rebuilds)) KITH_TRY(kith_lifecycle(it, KITH_BECAUSE_requested));
    KITH_TRY(kith_integrator_rates(it));
    const double now = seconds_now();
    *seconds = fmin(*seconds, now - before);
    before = now;
  }
  return KITH_OK;
}

static kith_status steps_of(struct kith_simulation *m, int k, double until, double limit,
                            struct kith_calibration *out) {
  struct kith_integrator *it = &m->integrator;
  double first;
  KITH_TRY(kith_simulation_start(m));
  KITH_TRY(kith_evaluation_measure(m, &first));
  const uint64_t evaluations = it->ledger.evaluations, lifecycles = it->ledger.lifecycles;
  const double start = seconds_now();
  while (it->time < until) {
    KITH_TRY(kith_integrator_step(it, until));
    if (seconds_now() - start > limit) KITH_FAIL(DIVERGED, "a calibration run exceeds %.3g s", limit);
  }
  out->steps[k] = (double)it->step;
  out->growth = (seconds_now() - start) / fmax((double)(it->ledger.evaluations - evaluations), 1) / first;
  out->lists = (double)(it->ledger.lifecycles - lifecycles) / fmax((double)it->step, 1);
  return KITH_OK;
}

static kith_status run(const struct kith_options *o, int k, double until, double limit,
                       struct kith_calibration *out) {
  const char *overrides[KITH_MAX_OVERRIDES + 1];
  char resolution[64];
  struct kith_scene *scene = NULL;
  struct kith_simulation *m = NULL;
  memcpy(overrides, o->overrides, sizeof o->overrides);
  snprintf(resolution, sizeof resolution, "resolution=%.10g", out->resolution[k]);
  overrides[o->n_overrides] = resolution;
  KITH_TRY(kith_scene_read(&scene, o->subject, o->n_overrides + 1, overrides));
  kith_status status = kith_simulation_create(&m, scene, NULL, false);
  if (status == KITH_OK) status = steps_of(m, k, until, limit, out);
  kith_simulation_destroy(&m);
  kith_scene_destroy(&scene);
  return status;
}

/* Whole and even, where that makes little difference: lattices and centers may need it. */
static double rounded(double resolution) {
  return resolution > 10 ? 2 * round(0.5 * resolution) : resolution;
}

kith_status kith_calibration_run(struct kith_calibration *out, const struct kith_options *options,
                                 double resolution, double until, double cost, double budget) {
  const double part = fmin(pow(budget / cost, 1.0 / (NDIM + 1)), 0.8);
  *out =
      (struct kith_calibration){.resolution = {rounded(0.7 * part * resolution), rounded(part * resolution)}};
  for (int k = 0; k < 2; ++k) KITH_TRY(run(options, k, until, 10 * budget, out));
  return KITH_OK;
}

double kith_calibration_steps(const struct kith_calibration *c, double resolution) {
  const double slope = (c->steps[1] - c->steps[0]) / (c->resolution[1] - c->resolution[0]);
  return c->steps[1] + fmax(slope, 0) * (resolution - c->resolution[1]);
}
