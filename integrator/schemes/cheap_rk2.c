/* Scheme cheap-rk2: midpoint with one evaluation. The half step is made with the rates of the last middle. */
#include "integrator/schemes/midpoint.h"

static kith_status advance(struct kith_integrator *it, double *dt) {
  KITH_TRY(kith_integrator_evaluate(it));
  kith_midpoint_to_end(it, *dt);
  return KITH_OK;
}

const struct kith_scheme_ops kith_scheme_cheap_rk2 = {
    .name = "cheap-rk2",
    .doc = "midpoint that starts from the rates of the last middle; one evaluation a step",
    .evaluations = 1,
    .predict = kith_midpoint_to_middle,
    .advance = advance};
