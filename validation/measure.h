/* measure.h - numbers that characterize a scene without an exact solution, taken from the nodes at the end of
 * a run: chosen by the scene's key `measure`, and found in the report under `measures`.
 *
 *   shear_viscosity    of the mode e = sin(k x) along y, k = 2 pi / L, L the length of the domain along x
 *   vortex_viscosity   of the mode e = (sin k x cos k y, -cos k x sin k y), Taylor and Green's. Viscosity nu
 *                      damps the amplitude a = 2 |sum V v.e| / sum V, the root of the sum of squares over
 *                      the phases 0 and pi / 2 of sines and cosines, as exp(-nu K^2 t), K^2 = k^2 for shear,
 *                      2 k^2 for the vortices. NaN if the flow has no such mode: other wavelengths do not
 *                      count
 *   mcnally            amplitude of a Kelvin-Helmholtz mode of two waves along x in the domain, layers at 1/4
 *                      and 3/4 of it along y (McNally, Lyra and Passy, Astrophys. J. Suppl. 201 (2012) 18,
 *                      in a box of side 1)
 *   growth             rate of a Rayleigh-Taylor mode of one wave along x, at an interface in the middle of
 *                      the domain along y: its amplitude a grows as a(0) cosh(rate t) while it is small, if
 *                      the interface starts flat. NaN if it shrinks, or if the flow had no such mode at the
 *                      start
 *   ripple             amplitude of the same mode, weighted for one that falls as v_y ~ exp(-k |y|) with the
 *                      distance from the interface
 *   spread             of a ring about the center: standard deviation of the radius of the masses, over that
 *                      at the start
 *   separation         least distance of two nodes over the mean of their spacings V^(1/NDIM): 1 on a lattice
 *                      of cubes, some 0.7 in a glass, to 0 where nodes pair. Images do not count
 *   asymmetry          of a problem that is the same with x and y exchanged: largest distance of a node's
 *                      mirror image from the nearest node, in mean spacings; some 1e-13 while all is the
 *                      mirror of itself. NaN in 1-D
 *   transmitted        heat, per area across x, that has passed the middle of the domain along x: internal
 *                      energy beyond it, less that at the start; nodes must not pass it. Half of a node on it
 *                      is beyond
 *   shock_angle        of a shock, straight from the lower corner of the domain, to x, in degrees: densities
 *                      are averaged in sectors of half a degree, between 0.3 and 0.8 of the length of the
 *                      domain along x from the corner; it is where they pass the middle of the largest and
 *                      the least, from x on. NaN in 1-D, and if these differ by less than 5 %
 *
 * V = mass / density. Modes along y are NaN in 1-D. A few sweeps over the nodes of this rank; for separation
 * and asymmetry the nodes of all ranks go around, those of one rank at a time. */
#ifndef KITH_VALIDATION_MEASURE_H
#define KITH_VALIDATION_MEASURE_H

#include "lib/core/vec.h"
#include "validation/norms.h"

#define KITH_MEASURE_LIST(X)                                                                                \
  X(shear_viscosity, "numerical viscosity, from the decay of a shear wave as long as the domain")           \
  X(vortex_viscosity,                                                                                       \
    "numerical viscosity, from the decay of Taylor-Green vortices, one wave along x and y")                 \
  X(mcnally, "amplitude of a Kelvin-Helmholtz mode, as McNally et al. define it")                           \
  X(growth,                                                                                                 \
    "growth rate of a velocity along y that is one wave along x: of an interface in the middle along y, "   \
    "flat at the start")                                                                                    \
  X(ripple, "velocity amplitude of a ripple on the middle plane, for a mode that falls as e^-k|y|")         \
  X(spread, "width of a ring about the center, over its width at the start")                                \
  X(separation, "smallest distance of two nodes, in spacings")                                              \
  X(asymmetry, "largest distance of a mirror image (x and y exchanged) from the nearest node, in spacings") \
  X(transmitted, "heat that has passed the middle of the domain along x")                                   \
  X(shock_angle, "angle between x and an oblique shock from the lower corner of the domain, in degrees")

struct kith_measured {
  const struct kith_profile_view *nodes;
  struct kith_box domain;
  double center[NDIM]; /* of rotation */
  double time;
  const double *start; /* [KITH_N_MEASURES]: what was taken then; NULL: this is the start */
};

enum kith_measure {
#define X(name, doc) KITH_MEASURE_##name,
  KITH_MEASURE_LIST(X)
#undef X
      KITH_N_MEASURES
};
extern const char *const kith_measure_names[KITH_N_MEASURES];

/* Takes a measure; NaN for what cannot be told. Collective: all ranks get what one process gets, bitwise. */
double kith_measure_take(enum kith_measure which, const struct kith_measured *m);

#endif
