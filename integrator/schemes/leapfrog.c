/* Scheme leapfrog: kick, drift, kick (velocity Verlet). The force sees velocities and energies that are
 * predicted to the end of the step; one evaluation. */
#include "integrator/step.h"

static void predict(struct kith_integrator *it, double dt) {
  struct kith_hydro *hydro = it->hydro;
  struct kith_field *base = it->kick.velocity_base;
  kith_profile_begin(it->profile, "kick");
  kith_kick(it, 0.5 * dt);
  it->kick.lead = 0.5 * dt;
  kith_field_copy(it->nodes, base, hydro->velocity);
  kith_field_copy(it->nodes, it->energy_base, hydro->energy);
  kith_drift(it, base, dt);
  kith_predict(it, 0.5 * dt, 0.75 * dt);
  kith_profile_end(it->profile);
}

static kith_status advance(struct kith_integrator *it, double *step) {
  const double dt = *step;
  struct kith_hydro *hydro = it->hydro;
  KITH_TRY(kith_integrator_evaluate(it));
  kith_profile_begin(it->profile, "kick");
  kith_field_copy(it->nodes, hydro->velocity, it->kick.velocity_base);
  kith_field_copy(it->nodes, hydro->energy, it->energy_base);
  it->kick.time = 0;
  kith_kick(it, 0.5 * dt);
  kith_profile_end(it->profile);
  return KITH_OK;
}

const struct kith_scheme_ops kith_scheme_leapfrog = {.name = "leapfrog",
                                                     .doc = "kick, drift, kick; one evaluation a step",
                                                     .evaluations = 1,
                                                     .predict = predict,
                                                     .advance = advance};
