/* body.h - a force from outside on every node: uniform gravity, and the pull of a point of mass M. With d = x - center:
 *
 *   a   = g - G M d / (d^2 + s^2)^(3/2)            s: softening (Plummer's)
 *   phi = - g . (x - origin) - G M / (d^2 + s^2)^(1/2)
 *
 * The same law 1/d in 1-D, 2-D and 3-D. It is added where the pair forces of a package are summed (force.c), before the work of
 * the pairs is: so no package and no scheme knows of it, and the mean velocity of a kick, which compatible energies are made from, has
 * it. Its work goes into kinetic energy alone; internal energies follow from pairs only. Kinetic + internal + potential is kept as the
 * scheme keeps it: second order in dt for leapfrog, without a trend, because phi is taken along the path and the work along the kicks. */
#ifndef KITH_PHYSICS_BODY_H
#define KITH_PHYSICS_BODY_H

#include "lib/core/vec.h"

struct kith_body {
  double gravity[NDIM], origin[NDIM];   /* g, and where its potential is 0 */
  double center[NDIM], mass, softening; /* of the point; mass: G M, 0: there is none */
};

static inline bool kith_body_acts(const struct kith_body *body) {
  bool acts = body->mass > 0;
  for (int a = 0; a < NDIM; ++a) acts = acts || body->gravity[a] != 0;
  return acts;
}

/* Per unit mass, at x[NDIM]. At the center of a point without softening it is -infinity, and the pull is not a number. */
double kith_body_potential(const struct kith_body *body, const double *x);
/* Adds a to acceleration[n * NDIM] at position[n * NDIM]. */
void kith_body_pull(const struct kith_body *body, kith_index n, const double *position, double *acceleration);

#endif
