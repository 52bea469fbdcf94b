/* external_force.h - an external force on every node: uniform gravity, and the attraction of a point of mass
 * M. With d = x - center:
 *
 *   a   = g - G M d / (d^2 + s^2)^(3/2)            s: softening (Plummer's)
 *   phi = - g . (x - origin) - G M / (d^2 + s^2)^(1/2)
 *
 * The potential is 1/d in 1-D, 2-D and 3-D alike. The force is added to the sums of the pair forces
 * (force.c), before the work of the pairs is summed: no package and no scheme knows of it, and the mean
 * velocity of a kick, from which compatible energies follow, includes it. Its work goes into kinetic energy
 * alone. Kinetic + internal + potential energy is conserved as well as the scheme does it: to second order in
 * dt for leapfrog, without a trend. */
#ifndef KITH_PHYSICS_EXTERNAL_FORCE_H
#define KITH_PHYSICS_EXTERNAL_FORCE_H

#include "lib/core/vec.h"

struct kith_external_force {
  double gravity[NDIM], origin[NDIM];   /* g, and where its potential is 0 */
  double center[NDIM], mass, softening; /* of the point; mass is G M, 0: no point */
};

static inline bool kith_external_force_acts(const struct kith_external_force *external_force) {
  bool acts = external_force->mass > 0;
  for (int a = 0; a < NDIM; ++a) acts = acts || external_force->gravity[a] != 0;
  return acts;
}

/* Per unit mass, at x[NDIM]. At the center of a point without softening it is -infinity, and the
 * acceleration is not a number. */
double kith_external_force_potential(const struct kith_external_force *external_force, const double *x);
/* Adds a to acceleration[n * NDIM] at position[n * NDIM]. */
void kith_external_force_acceleration(const struct kith_external_force *external_force, kith_index n,
                                      const double *position, double *acceleration);

#endif
