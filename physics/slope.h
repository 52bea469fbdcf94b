/* slope.h - slopes between two nodes, limited: what a pair function extrapolates with. No loops: who calls these vectorizes. */
#ifndef KITH_PHYSICS_SLOPE_H
#define KITH_PHYSICS_SLOPE_H

#include "lib/core/vec.h"

/* Van Leer's limiter of two slopes, 4 r / (1 + r)^2 with r their ratio: 0 if they differ in sign, 1 if they are equal. */
KITH_INLINE double kith_slope_limiter(double slope_i, double slope_j) {
  const double product = slope_i * slope_j, sum = slope_i + slope_j;
  return product > 0 ? 4 * product / (sum * sum) : 0;
}

/* g . x of a vector g, its members `stride` apart; y, z: anything if there are none. */
KITH_INLINE double kith_slope_vector(const double *restrict g, int stride, double x, double y, double z) {
  return NDIM == 1   ? g[0] * x
         : NDIM == 2 ? g[0] * x + g[stride] * y
                     : g[0] * x + g[stride] * y + g[2 * stride] * z;
}

/* x.G.x of a symmetric G given by its upper triangle. */
KITH_INLINE double kith_slope_symmetric(const double *restrict g, int stride, double x, double y, double z) {
  return NDIM == 1   ? g[0] * x * x
         : NDIM == 2 ? g[0] * x * x + g[2 * stride] * y * y + 2 * (g[stride] * x * y)
                     : g[0] * x * x + g[3 * stride] * y * y + g[5 * stride] * z * z +
                           2 * (g[stride] * x * y + g[2 * stride] * x * z + g[4 * stride] * y * z);
}

/* The jump v_ij . x_ij = vx between velocities extrapolated to the middle of the pair, by the slopes x_ij.G.x_ij; never more than the
 * whole jump. spacings: the distance in mean node spacings; closer pairs than 1 see more of the jump, below 4/5 all of it. */
KITH_INLINE double kith_slope_jump(double vx, double slope_i, double slope_j, double spacings) {
  const double closer = 5 * KITH_MIN(spacings - 1, 0.0);
  const double phi = kith_slope_limiter(slope_i, slope_j) * KITH_MAX(1 - closer * closer, 0.0);
  return KITH_MAX(vx - 0.5 * phi * (slope_i + slope_j), vx);
}

#endif
