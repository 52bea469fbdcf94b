/* Schemes rk2 and cheap-rk2: midpoint. A half step to the middle, then the whole step with the rates there.
 * The half step takes the rates of the start (rk2) or, with one evaluation less, of the last middle
 * (cheap-rk2). */
#include "integrator/flow.h"
#include "integrator/step.h"

/* Goes from the start to the middle by the rates at hand; positions by the velocity of the start. */
static void to_middle(struct kith_integrator *it, double dt) {
  kith_predict(it, 0.5 * dt, 0.5 * dt, 0.5 * it->dt + 0.25 * dt);
}

/* Goes from the start to the end by the rates of the middle; positions by the velocity of the middle.
 * Boundaries may have changed positions in between, so they continue from the middle: half a step of the
 * start's velocity is subtracted. */
static void to_end(struct kith_integrator *it, double dt) {
  kith_drift_supports(it, 0.5 * dt);
  double *restrict x = it->nodes->position->f64;
  const double *restrict v0 = it->kick.velocity_base->f64, *restrict v = it->hydro->velocity->f64;
#pragma omp parallel for simd schedule(static)
  for (size_t k = 0; k < (size_t)it->nodes->n_internal * NDIM; ++k) x[k] += dt * (v[k] - 0.5 * v0[k]);
  kith_correct(it, dt);
}

static kith_status predict(struct kith_integrator *it, double dt) {
  (void)dt;
  KITH_TRY(kith_flow_exchange(it));
  kith_field_copy(it->nodes, it->kick.velocity_base, it->hydro->velocity);
  it->kick.time = it->kick.lead = 0;
  return KITH_OK;
}

static kith_status advance(struct kith_integrator *it, double *dt) {
  KITH_TRY(kith_integrator_evaluate(it));
  to_middle(it, *dt);
  KITH_TRY(kith_integrator_evaluate(it));
  to_end(it, *dt);
  return KITH_OK;
}

const struct kith_scheme_ops kith_scheme_rk2 = {.name = "rk2",
                                                .doc = "midpoint; two evaluations a step",
                                                .evaluations = 2,
                                                .stages = true,
                                                .predict = predict,
                                                .advance = advance};

static kith_status cheap_predict(struct kith_integrator *it, double dt) {
  KITH_TRY(kith_flow_exchange(it));
  to_middle(it, dt);
  return KITH_OK;
}

static kith_status cheap_advance(struct kith_integrator *it, double *dt) {
  KITH_TRY(kith_integrator_evaluate(it));
  to_end(it, *dt);
  return KITH_OK;
}

const struct kith_scheme_ops kith_scheme_cheap_rk2 = {
    .name = "cheap-rk2",
    .doc = "midpoint that starts from the rates of the last middle; one evaluation a step",
    .evaluations = 1,
    .predict = cheap_predict,
    .advance = cheap_advance};
