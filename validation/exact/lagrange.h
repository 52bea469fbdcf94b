/* lagrange.h - our own solver of Euler's equations in one dimension, for problems that have no exact
 * solution. Finite volumes in the coordinate m of mass, so that contacts stay what they are at the start,
 * faces between cells:
 *
 *   dv/dt = du/dm,   du/dt = -dp/dm,   de/dt = -d(pu)/dm,   v = 1 / density, e = energy + u^2 / 2
 *
 * B. van Leer, Towards the ultimate conservative difference scheme V, J. Comput. Phys. 32 (1979) 101, made
 * simple: slopes of v, u, p limited to the least of twice both one-sided ones and the central one; states of
 * the faces predicted for the middle of the step along them; at each face a Riemann problem between two
 * gases, by Newton-like iterations in which both waves are jumps. Second order where the flow is smooth,
 * first at shocks. Mass, momentum (but for walls) and energy are conserved to round-off. */
#ifndef KITH_VALIDATION_EXACT_LAGRANGE_H
#define KITH_VALIDATION_EXACT_LAGRANGE_H

#include "lib/core/base.h"

#include <math.h>

/* A cell and its lower face. */
struct kith_cell {
  double face, mass; /* place of the face; mass of the cell */
  double volume, velocity, energy,
      pressure; /* volume and energy per unit mass; energy: with the kinetic one */
  double slope_v, slope_u, slope_p, impedance; /* of a step; private, and so is the state of the face */
  double face_u, face_p;
};

struct kith_lagrange {
  double gamma, time;
  int n;                   /* cells */
  struct kith_cell cell[]; /* [n + 1]: the last one is the upper face of the one before */
};

/* Gas at rest or moving, the same from `from` to the next one's `from`. */
struct kith_slab {
  double from, density, velocity, pressure;
};

/* Cells of about the same mass, whole ones in each slab, the last of which ends at `end`. Walls at both
 * ends. One block of memory, freed by kith_free. */
kith_status kith_lagrange_create(struct kith_lagrange **out, double gamma, int n_slabs,
                                 const struct kith_slab *slab, double end, int cells);
/* On to `time`. DIVERGED if a volume or a pressure is not positive. About 50 ns per cell and step; the number
 * of steps is that of cells that a sound wave would cross, times 2.5. */
kith_status kith_lagrange_run(struct kith_lagrange *flow, double time);

/* The limited slope of b, per cell, between its neighbors a and c. */
static inline double kith_lagrange_slope(double a, double b, double c) {
  const double left = b - a, right = c - b, center = 0.5 * (c - a);
  const double least = KITH_MIN(2 * fabs(left), 2 * fabs(right));
  return left * right <= 0 ? 0 : copysign(KITH_MIN(least, fabs(center)), center);
}

#endif
