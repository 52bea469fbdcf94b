/* Schemes: how the state is advanced. Each ends with the rates of its last evaluation. */
#include "integrator/integrator.h"
#include "lib/core/family.h"

/* Kick, drift, kick. The force sees velocities and energies that are predicted to the end of the step; one evaluation. */
static kith_status leapfrog_step(struct kith_integrator *it, double dt) {
  struct kith_hydro *hydro = it->hydro;
  struct kith_field *base = it->package->velocity_base;
  kith_profile_begin(it->profile, "kick");
  kith_kick_energy(it, 0.5 * dt);
  kith_kick_velocity(it, 0.5 * dt);
  kith_field_copy(it->nodes, base, hydro->velocity);
  kith_field_copy(it->nodes, it->energy_base, hydro->energy);
  kith_drift(it, base, dt);
  kith_kick_energy(it, 0.5 * dt);
  kith_kick_velocity(it, 0.5 * dt);
  kith_profile_end(it->profile);
  KITH_TRY(kith_integrator_rates(it));
  kith_profile_begin(it->profile, "kick");
  kith_field_copy(it->nodes, hydro->velocity, base);
  kith_field_copy(it->nodes, hydro->energy, it->energy_base);
  it->package->kicked = 0;
  kith_kick_energy(it, 0.5 * dt);
  kith_kick_velocity(it, 0.5 * dt);
  kith_profile_end(it->profile);
  return KITH_OK;
}

/* From the state at the start, by the rates at hand: half a step to the middle, positions with the velocity of the start. */
static void to_middle(struct kith_integrator *it, double dt) {
  kith_field_copy(it->nodes, it->package->velocity_base, it->hydro->velocity);
  kith_field_copy(it->nodes, it->energy_base, it->hydro->energy);
  kith_field_copy(it->nodes, it->position_base, it->nodes->position);
  kith_drift(it, it->hydro->velocity, 0.5 * dt);
  kith_kick_energy(it, 0.5 * dt);
  kith_kick_velocity(it, 0.5 * dt);
}

/* From the state at the start, by the rates of the middle: the whole step, positions with the velocity of the middle. */
static void to_end(struct kith_integrator *it, double dt) {
  kith_drift(it, it->hydro->velocity, 0.5 * dt); /* supports follow; positions are set next */
  double *restrict x = it->nodes->position->f64;
  const double *restrict x0 = it->position_base->f64, *restrict v = it->hydro->velocity->f64;
#pragma omp parallel for simd schedule(static)
  for (kith_index k = 0; k < it->nodes->n_internal * NDIM; ++k) x[k] = x0[k] + dt * v[k];
  kith_field_copy(it->nodes, it->hydro->velocity, it->package->velocity_base);
  kith_field_copy(it->nodes, it->hydro->energy, it->energy_base);
  it->package->kicked = 0;
  kith_kick_energy(it, dt);
  kith_kick_velocity(it, dt);
}

/* Midpoint: rates at the start, a half step, rates in the middle, the whole step with them. */
static kith_status rk2_step(struct kith_integrator *it, double dt) {
  kith_field_copy(it->nodes, it->package->velocity_base, it->hydro->velocity);
  it->package->kicked = 0;
  KITH_TRY(kith_integrator_rates(it));
  to_middle(it, dt);
  KITH_TRY(kith_integrator_rates(it));
  to_end(it, dt);
  return KITH_OK;
}

/* Midpoint with one evaluation: the half step is made with the rates of the last middle. */
static kith_status cheap_rk2_step(struct kith_integrator *it, double dt) {
  to_middle(it, dt);
  KITH_TRY(kith_integrator_rates(it));
  to_end(it, dt);
  return KITH_OK;
}

const struct kith_scheme_ops kith_scheme_leapfrog = {"leapfrog", "kick, drift, kick; one evaluation a step",
                                                     1, leapfrog_step};
const struct kith_scheme_ops kith_scheme_rk2 = {"rk2", "midpoint; two evaluations a step", 2, rk2_step};
const struct kith_scheme_ops kith_scheme_cheap_rk2 = {
    "cheap-rk2", "midpoint that starts from the rates of the last middle; one evaluation a step", 1,
    cheap_rk2_step};

#define X(name) &kith_scheme_##name,
KITH_FAMILY(kith_scheme, KITH_SCHEME_LIST(X))
#undef X
