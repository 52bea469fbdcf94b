/* The two halves of a midpoint step. */
#include "integrator/schemes/midpoint.h"

void kith_midpoint_to_middle(struct kith_integrator *it, double dt) {
  kith_field_copy(it->nodes, it->kick.velocity_base, it->hydro->velocity);
  kith_field_copy(it->nodes, it->energy_base, it->hydro->energy);
  kith_drift(it, it->hydro->velocity, 0.5 * dt);
  kith_kick_energy(it, 0.5 * dt);
  kith_kick_velocity(it, 0.5 * dt);
}

void kith_midpoint_to_end(struct kith_integrator *it, double dt) {
  kith_drift_supports(it, 0.5 * dt);
  double *restrict x = it->nodes->position->f64;
  const double *restrict v0 = it->kick.velocity_base->f64, *restrict v = it->hydro->velocity->f64;
#pragma omp parallel for simd schedule(static)
  for (kith_index k = 0; k < it->nodes->n_internal * NDIM; ++k) x[k] += dt * (v[k] - 0.5 * v0[k]);
  kith_field_copy(it->nodes, it->hydro->velocity, it->kick.velocity_base);
  kith_field_copy(it->nodes, it->hydro->energy, it->energy_base);
  it->kick.time = 0;
  kith_kick_energy(it, dt);
  kith_kick_velocity(it, dt);
}
