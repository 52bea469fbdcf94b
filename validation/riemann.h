/* riemann.h - what a Riemann problem makes of its two states; the solver behind kith_exact_riemann. */
#ifndef KITH_VALIDATION_RIEMANN_H
#define KITH_VALIDATION_RIEMANN_H

#include "validation/exact.h"

/* Between the two outer waves. [0]: the left-running wave and the gas left of the contact, [1]: the right
 * ones. A shock has tail = head. In a vacuum pressure and density are 0 and the velocity is between its two
 * edges. */
struct kith_riemann_star {
  double pressure, velocity, density[2];
  double head[2], tail[2]; /* speeds dx/dt of the outer and inner edge of each wave */
  double interface;        /* x[0] of the jump at t = 0: the contact is at interface + velocity t */
};

/* `self` was created by kith_exact_riemann. */
struct kith_riemann_star kith_riemann_star(const void *self);

#endif
