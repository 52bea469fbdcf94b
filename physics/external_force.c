/* External forces: acceleration and potential. */
#include "physics/external_force.h"

#include <math.h>

double kith_external_force_potential(const struct kith_external_force *external_force, const double *x) {
  double along = 0, d2 = external_force->softening * external_force->softening;
  for (int a = 0; a < NDIM; ++a) {
    along += external_force->gravity[a] * (x[a] - external_force->origin[a]);
    d2 += (x[a] - external_force->center[a]) * (x[a] - external_force->center[a]);
  }
  return external_force->mass > 0 ? -along - external_force->mass / sqrt(d2) : -along;
}

void kith_external_force_acceleration(const struct kith_external_force *external_force, kith_index n,
                                      const double *position, double *acceleration) {
  const double s2 = external_force->softening * external_force->softening, mass = external_force->mass;
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < n; ++i) {
    const double *x = position + (size_t)i * NDIM;
    const double d2 = kith_distance2(x, external_force->center) + s2,
                 attraction = mass > 0 ? mass / (d2 * sqrt(d2)) : 0;
    for (int a = 0; a < NDIM; ++a)
      acceleration[(size_t)i * NDIM + a] +=
          external_force->gravity[a] - attraction * (x[a] - external_force->center[a]);
  }
}
