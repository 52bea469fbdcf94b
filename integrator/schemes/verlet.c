/* Scheme verlet: drift, kick, drift, and one evaluation in the middle, with velocities and energies that are
 * predicted by the rates of the last middle. The first drift takes the velocity at the start of the step, the
 * second that at its end, so the scheme without viscosity is reversible (position Verlet). */
#include "integrator/flow.h"
#include "integrator/step.h"

static kith_status predict(struct kith_integrator *it, double dt) {
  KITH_TRY(kith_flow_exchange(it));
  kith_predict(it, 0.5 * dt, 0.5 * dt, 0.5 * it->dt + 0.25 * dt);
  return KITH_OK;
}

static kith_status advance(struct kith_integrator *it, double *dt) {
  KITH_TRY(kith_integrator_evaluate(it));
  kith_correct(it, *dt);
  kith_drift(it, 0.5 * *dt);
  return KITH_OK;
}

const struct kith_scheme_ops kith_scheme_verlet = {
    .name = "verlet",
    .doc = "position Verlet: drift, kick, drift; one evaluation a step, in its middle",
    .evaluations = 1,
    .predict = predict,
    .advance = advance};
