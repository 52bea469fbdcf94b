#include "physics/body.h"

#include <math.h>

double kith_body_potential(const struct kith_body *body, const double *x) {
  double along = 0, d2 = body->softening * body->softening;
  for (int a = 0; a < NDIM; ++a) {
    along += body->gravity[a] * (x[a] - body->origin[a]);
    d2 += (x[a] - body->center[a]) * (x[a] - body->center[a]);
  }
  return body->mass > 0 ? -along - body->mass / sqrt(d2) : -along;
}

void kith_body_pull(const struct kith_body *body, kith_index n, const double *position,
                    double *acceleration) {
  const double s2 = body->softening * body->softening, mass = body->mass;
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < n; ++i) {
    const double *x = position + (size_t)i * NDIM;
    const double d2 = kith_distance2(x, body->center) + s2, pull = mass > 0 ? mass / (d2 * sqrt(d2)) : 0;
    for (int a = 0; a < NDIM; ++a)
      acceleration[(size_t)i * NDIM + a] += body->gravity[a] - pull * (x[a] - body->center[a]);
  }
}
