/* norms.h - the distance between nodes and an exact solution, in a window.
 *
 *   l1 = sum_i V_i |q_i - q(x_i)| / sum_i V_i,   l2 = sqrt(sum V d^2 / sum V),   linf = max |d|,
 *
 * with V = mass / density of the node, over the nodes inside the window. For vectors d is the length of the
 * difference; `speed` takes only the component that the solution has (exact.h: along x, outwards, around).
 * A vortex is mostly quoted by the L1 of its speed, "mean |v - v_phi|". Sums are exact: they
 * depend neither on threads nor on ranks. Components of the velocity that the solution does not know do not
 * count.
 *
 * The energy of a Sedov blast has no L1 norm in 3-D (it diverges at the center): compare its pressure. */
#ifndef KITH_VALIDATION_NORMS_H
#define KITH_VALIDATION_NORMS_H

#include <math.h>
#include "validation/exact/exact.h"

/* Lower and upper bound, both inside: of x[0], and of the distance from the center of the solution (or the
 * origin), or from the axis of a vortex. */
struct kith_window {
  double x[2], r[2];
};
#define KITH_WINDOW_ALL ((struct kith_window){{-INFINITY, INFINITY}, {0, INFINITY}})
/* Is x in the window of a solution about this (kith_exact_about)? */
bool kith_window_has(const struct kith_window *window, const struct kith_exact_ops *ops,
                     const struct kith_exact_gas *about, const double *x, double time);

struct kith_norm {
  double l1, l2, linf;
};

struct kith_norms {
  struct kith_norm density, velocity, pressure, energy, speed;
  uint64_t nodes; /* of all ranks in the window; with none, the norms are NaN, and nothing else is measured */
  /* max |(P - P*) / P*| of nodes no farther from the contact than half of the way to the wave on their side,
   * so that neither counts: Riemann problems with a star pressure only, else 0 */
  double contact_pressure_error;
  double shock_radius; /* measured, see below; 0 if the solution has no shock or the nodes show none */
  double shock_exact;  /* the exact one; 0 if there is none */
  int shock_side; /* of a Riemann problem, which may have two: 1 the right-going one, -1 the left-going one */
  double shock_swept; /* the same by the mass that was overrun, see below; 0 for solutions without a center */
  bool shock_outside; /* the exact shock is outside of the window: the norms do not see it */
  /* How far the measured shock is ahead of the exact one, in spacings of the undisturbed gas, (mean mass /
   * exact density ahead)^(1/NDIM) of the nodes that also give the width of the bins: what is smeared by the
   * same number of nodes at any resolution has the same offset; 0 if none is measured. */
  double shock_offset;
  /* Radial solutions: largest mean density over radial bins that are a hundredth of the largest distance of a
   * node in the window wide, or one spacing at the shock if that is larger; else the largest of a node. */
  double density_peak;
  double speed_peak; /* radial solutions: largest |mean speed| over the same bins, else 0 */
  bool vortex;       /* speed is azimuthal */
  bool carried;      /* the vortex has a uniform velocity */
};

/* Views of the node arrays of this rank, of length n: position[n*NDIM], velocity[n*NDIM], the rest [n]. */
struct kith_profile_view {
  kith_index n;
  const double *position, *velocity, *mass, *density, *pressure, *energy;
  const int64_t *id;        /* NULL: 0 .. n - 1 */
  struct kith_ranks *ranks; /* the ranks that have the other nodes; NULL: there are none */
};

/* Measures the norms. Collective: all ranks get the same, to the last bit what one process gets, since sums
 * are exact, and those of bins are of whole multiples of 2^-62 of the largest that is possible. Cost: one
 * state() per node, on all threads, and a few sweeps over the nodes of this rank. DIVERGED, with the node and
 * the value, if a value is not finite or a density or mass not positive; *out is then unchanged.
 *
 * The measured shock. Nodes are binned by distance from the center (or along axis 0), bins one mean node
 * spacing wide: (mean V)^(1/NDIM) of the nodes within four mean spacings of the exact shock. A bin's speed is
 * sum V u / sum V along the outward direction, its place sum V r / sum V. From outside inwards (outside is
 * where the exact density is lower), the shock is where the bins' speed first rises through
 *
 *   (ahead + min(peak, behind)) / 2,   ahead, behind: exact speeds at the two sides of the exact shock,
 *                                      peak: largest speed of a bin,
 *
 * by linear interpolation. Speed, not density: behind a blast a smeared density crosses half its peak far
 * outside. A Sedov blast smeared by a Gaussian is found outside of its place: by 0.1 % of R for sigma = 0.015
 * R, 0.7 % for 0.045 R, 2.7 % for 0.1 R. Choose a window that ends before other waves begin.
 *
 * A front of finite width has half of its speed ahead of the place of one without width: the gas up to there
 * is denser than it was, so its mass is that of a smaller ball. shock_swept is the radius of this ball, the
 * window times (mass inside shock_radius / mass of the window)^(1/NDIM): the place by the gas that was
 * overrun, without any density of a node. The window must be a ball, and gas of one density at its edge. */
kith_status kith_norms_measure(struct kith_norms *out, const struct kith_exact_ops *ops, const void *solution,
                               double time, const struct kith_window *window,
                               const struct kith_profile_view *nodes);

/* How far nodes at the start are from the solution at time 0, in the window: the largest of
 *
 *   sum_i V_i |q_i - q(x_i)| / sum_i V_i (|q_i| + |q(x_i)|)
 *
 * for q the density, the velocity (|.| is its length) and the energy, whose lower sum has the square of the
 * speed, too: cold flows may have any small energy. Without the energy if there is a blast: that of the
 * solution is in a point.
 * *name: which q it is; not set if none differs. Collective. */
double kith_norms_mismatch(const char **name, const struct kith_exact_ops *ops, const void *solution,
                           bool blast, const struct kith_window *window,
                           const struct kith_profile_view *nodes);

#endif
