#include "app/pilot.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <time.h>

/* Of the processor where there is one thread: other programs do not count. */
static double seconds_now(void) {
  struct timespec t;
  if (omp_get_max_threads() > 1) return kith_seconds();
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

kith_status kith_times_measure(struct kith_model *model, struct kith_times *out) {
  enum { MOST = 3 };
  struct kith_integrator *it = &model->integrator;
  const bool lasting = kith_rebuilds_lasting(it->rebuilds);
  const double start = seconds_now();
  *out = (struct kith_times){.rates = INFINITY, .lifecycle = lasting ? INFINITY : 0};
  for (double before = start; out->evaluations < MOST && before - start < 0.5; ++out->evaluations) {
    if (lasting) KITH_TRY(kith_lifecycle(it, "plan"));
    const double between = seconds_now();
    KITH_TRY(kith_integrator_rates(it));
    const double now = seconds_now();
    if (lasting) out->lifecycle = fmin(out->lifecycle, between - before);
    out->rates = fmin(out->rates, now - between);
    before = now;
  }
  return KITH_OK;
}

/* ---- pilots ---- */

struct flight {
  struct kith_scene *scene;
  struct kith_model *model;
  double steps, rebuilds, growth;
};

static kith_status take_off(struct flight *f, const struct kith_options *o, double resolution) {
  const char *overrides[KITH_MAX_OVERRIDES + 1];
  char setting[64];
  for (int k = 0; k < o->n_overrides; ++k) overrides[k] = o->overrides[k];
  snprintf(setting, sizeof setting, "resolution=%.10g", resolution);
  overrides[o->n_overrides] = setting;
  KITH_TRY(kith_scene_read(&f->scene, o->subject, o->n_overrides + 1, overrides));
  KITH_TRY(kith_model_create(&f->model, f->scene, NULL, false));
  return kith_model_start(f->model);
}

static kith_status fly(struct flight *f, double until, double limit) {
  struct kith_integrator *it = &f->model->integrator;
  struct kith_times times;
  KITH_TRY(kith_times_measure(f->model, &times));
  const struct kith_ledger before = it->ledger;
  const double start = seconds_now();
  while (it->time < until) {
    KITH_TRY(kith_integrator_step(it, until));
    if (seconds_now() - start > limit) KITH_FAIL(DIVERGED, "a pilot takes longer than %.3g s", limit);
  }
  const double seconds = seconds_now() - start;
  const double evaluations = fmax((double)(it->ledger.evaluations - before.evaluations), 1);
  f->steps = (double)it->step;
  f->rebuilds = times.lifecycle > 0 ? (double)(it->ledger.lifecycles - before.lifecycles) / evaluations : 0;
  f->growth = seconds / evaluations / (times.rates + f->rebuilds * times.lifecycle);
  return KITH_OK;
}

static kith_status one(struct flight *f, const struct kith_options *o, double resolution, double until,
                       double limit) {
  *f = (struct flight){0};
  kith_status status = take_off(f, o, resolution);
  if (status == KITH_OK) status = fly(f, until, limit);
  kith_model_destroy(&f->model);
  kith_scene_destroy(&f->scene);
  return status;
}

/* Whole and even, where that makes little difference: lattices and centers may need it. */
static double rounded(double resolution) {
  return resolution > 10 ? 2 * round(0.5 * resolution) : resolution;
}

kith_status kith_pilot_run(struct kith_pilot *out, const struct kith_options *options, double resolution,
                           double until, double cost, double budget) {
  *out = (struct kith_pilot){0};
  const double part = fmin(pow(budget / cost, 1.0 / (NDIM + 1)), 0.8);
  out->resolution[1] = rounded(part * resolution);
  out->resolution[0] = rounded(0.7 * part * resolution);
  for (int k = 0; k < 2; ++k) {
    struct flight f;
    KITH_TRY(one(&f, options, out->resolution[k], until, 10 * budget));
    out->steps[k] = f.steps, out->rebuilds = f.rebuilds, out->growth = f.growth;
  }
  return KITH_OK;
}

double kith_pilot_steps(const struct kith_pilot *p, double resolution) {
  const double slope = (p->steps[1] - p->steps[0]) / (p->resolution[1] - p->resolution[0]);
  return p->steps[1] + fmax(slope, 0) * (resolution - p->resolution[1]);
}
