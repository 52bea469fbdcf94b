/* slope.h - the pass for the gradient of a scalar that is known after the density pass, as the pressure.
 *
 * With the weights w = -g(q) and the matrix of density.h, [sum_j w dx dx]^-1 sum_j w dx (f_j - f_i): exact
 * for linear functions on any nodes. A barrier has the value of i. */
#ifndef KITH_PHYSICS_PASSES_SLOPE_H
#define KITH_PHYSICS_PASSES_SLOPE_H

#include "physics/passes/density.h"
#include "physics/passes/viscosity.h"

/* Fills `slope` (vector) of internal nodes from `value` of all nodes and ghosts. Collective. */
kith_status kith_slope(struct kith_package *package, const struct kith_connectivity *connectivity,
                       const struct kith_field *value, const struct kith_field *matrix,
                       struct kith_field *slope);

/* Returns the heat from j to i by which pressures even out at a face of this area, for packed particles
 * (viscosity.h) with the pressure and its slope at these fields. Between the states at the middle of a pair
 * Roe's solver moves the face with - {P_j - P_i} / (rho_i c_i + rho_j c_j); the work of the mean pressure at
 * it is this heat. {} is what van Leer's limiter leaves of the difference, between 0 and all of it. */
KITH_INLINE double kith_slope_heat(const double *restrict i, const double *restrict j, int pressure,
                                   int slope, double area) {
  const double pi = i[pressure], pj = J(pressure),
               impedances = i[KITH_PACKED_DENSITY] * i[KITH_PACKED_SOUND] +
                            J(KITH_PACKED_DENSITY) * J(KITH_PACKED_SOUND);
  double si = 0, sj = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double d = J(KITH_PACKED_X + a) - i[KITH_PACKED_X + a];
    si += i[slope + a] * d, sj += J(slope + a) * d;
  }
  const double product = si * sj, sum = si + sj, van_leer = product > 0 ? 4 * product / (sum * sum) : 0,
               jump = pj - pi, left = jump - 0.5 * van_leer * sum,
               difference = KITH_MAX(KITH_MIN(left, KITH_MAX(jump, 0.0)), KITH_MIN(jump, 0.0));
  return 0.5 * KITH_MAX(pi + pj, 0.0) * area * difference / KITH_MAX(impedances, 1e-300);
}

#endif
