/* Scheme rk2: midpoint. Rates at the start, a half step, rates in the middle, the whole step with them. */
#include "integrator/schemes/midpoint.h"

static void predict(struct kith_integrator *it, double dt) {
  (void)dt;
  kith_field_copy(it->nodes, it->kick.velocity_base, it->hydro->velocity);
  it->kick.time = 0;
}

static kith_status advance(struct kith_integrator *it, double *dt) {
  KITH_TRY(kith_integrator_evaluate(it));
  kith_midpoint_to_middle(it, *dt);
  KITH_TRY(kith_integrator_evaluate(it));
  kith_midpoint_to_end(it, *dt);
  return KITH_OK;
}

const struct kith_scheme_ops kith_scheme_rk2 = {.name = "rk2",
                                                .doc = "midpoint; two evaluations a step",
                                                .evaluations = 2,
                                                .stages = true,
                                                .predict = predict,
                                                .advance = advance};
