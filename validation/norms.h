/* norms.h - the distance between nodes and an exact solution, in a window.
 *
 *   l1 = sum_i V_i |q_i - q(x_i)| / sum_i V_i,   l2 = sqrt(sum V d^2 / sum V),   linf = max |d|,
 *
 * with V = mass / density of the node, over the nodes inside the window. For vectors d is the length of the
 * difference. Sums are taken in fixed blocks in node order, so they do not depend on the number of threads. */
#ifndef KITH_VALIDATION_NORMS_H
#define KITH_VALIDATION_NORMS_H

#include "validation/exact.h"

enum kith_window_kind { KITH_WINDOW_ALL, KITH_WINDOW_SLAB, KITH_WINDOW_BALL }; /* slab: |x[0] - center[0]| */

struct kith_window {
  enum kith_window_kind kind;
  double center[NDIM], inner, outer; /* inner <= distance <= outer */
};

struct kith_norm {
  double l1, l2, linf;
};

struct kith_norms {
  struct kith_norm density, velocity, pressure, energy;
  kith_index nodes;    /* nodes inside the window */
  double blip;         /* max |P - P*| / P* within 0.1 of a contact (riemann only, else 0) */
  double shock_radius; /* measured: see kith_shock_radius; 0 if the solution has no shock */
  double shock_exact;  /* the exact one */
  double density_peak; /* largest mean density over radial bins (sedov, noh) or the largest density */
};

/* Views of node arrays of length n: position[n*NDIM], velocity[n*NDIM], the rest [n]. */
struct kith_profile_view {
  kith_index n;
  const double *position, *velocity, *mass, *density, *pressure, *energy;
};

kith_status kith_norms_measure(struct kith_norms *out, const struct kith_exact_ops *ops, const void *solution,
                               double time, const struct kith_window *window,
                               const struct kith_profile_view *nodes);

#endif
