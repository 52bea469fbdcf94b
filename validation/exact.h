/* exact.h - exact solutions a run is compared with: one family, chosen by name from the scene.
 *
 * A solution gives the state at a place and a time. Space is always given as x[NDIM]; radial solutions use
 * r = |x - center|, vortices the distance from the axis that runs through the center along axis 2. Gases are ideal: pressure = (gamma - 1) density energy. Each member's mathematics, source
 * and limits stand at the top of its file.
 *
 *   riemann        two half spaces, planar along axis 0; either side may have its own gamma or be a vacuum
 *   sedov          point explosion in NDIM dimensions (a plane, a line, a point), gas uniform or with a density that falls as a power of r
 *   noh            cold gas imploding onto a plane, a line or a point
 *   gresho         steady vortex, 2-D and 3-D
 *   yee            another steady vortex, a smooth one
 *   acoustic-wave  travelling wave along axis 0; linear theory: differs from the Euler equations by O(amplitude^2)
 *   entropy-wave   a wave of density alone, carried along axis 0
 *   square         a denser box in gas of the same pressure
 *   two-blasts     two blasts that meet between walls: no exact solution, a reference of our own finite volumes (lagrange.h)
 *   uniform        the same state everywhere and always
 *
 * create() may turn off GSL's error handler for the process (it would abort): errors of GSL come back as
 * status. After create a solution is read-only: any number of threads may ask it. */
#ifndef KITH_VALIDATION_EXACT_H
#define KITH_VALIDATION_EXACT_H

#include "lib/core/base.h"

/* What every solution yields; energy is per unit mass, without kinetic energy. */
struct kith_exact_state {
  double density, velocity[NDIM], pressure, energy;
};

/* All parameters of all members; a member reads those it documents and ignores the rest. */
struct kith_exact_parameters {
  double gamma[2];    /* ratio of specific heats: left and right of a Riemann problem, else [0] */
  double density[2];  /* left and right (0: vacuum); square: inside and outside; else [0]: undisturbed */
  double velocity[2]; /* riemann: along axis 0, left and right; noh: inflow speed in [0] (> 0, inward) */
  double uniform_velocity[NDIM]; /* of the whole: uniform, waves, vortices, square */
  double pressure[2];            /* left and right, else [0]: undisturbed */
  double interface_position;     /* riemann: x[0] of the jump at t = 0 */
  double blast_energy;           /* sedov: total energy on all sides of the center */
  double omega;                  /* sedov: undisturbed density = density[0] r^-omega */
  double center[NDIM];           /* sedov, noh, vortices, square */
  double period[NDIM];           /* vortices, square: of a periodic box, 0: none */
  double side[NDIM];             /* square */
  double end_time;               /* two-blasts: computed until then */
  double amplitude;              /* waves: relative, of the density; yee: strength */
  double wavelength;             /* waves: along axis 0 */
  double origin;                 /* waves: x[0] where the phase is 0 at t = 0 */
};

struct kith_exact_ops {
  const char *name, *doc;
  /* *self owned by the caller, freed by destroy. BAD_INPUT with the parameter's name if out of range. */
  kith_status (*create)(void **self, const struct kith_exact_parameters *parameters);
  void (*destroy)(void **self);
  /* State at x[NDIM] and time >= 0; time 0 gives the initial state. Cheap (a table look-up or a closed form):
   * called once per node. All values are finite; a vacuum has density, pressure and energy 0. */
  void (*state)(const void *self, const double *x, double time, struct kith_exact_state *out);
  /* Radius (or position along axis 0) of the leading shock at `time`: the right-going one of a Riemann
   * problem, else the left-going one; 0 if these states make none. NULL if the member never has one. */
  double (*shock)(const void *self, double time);
  /* View of center[NDIM] of a radial solution; NULL for members that vary along axis 0 only. */
  const double *(*center)(const void *self);
  bool vortex; /* it turns about an axis through the center, along axis 2 */
};

#define KITH_EXACT_LIST(X) \
  X(riemann)               \
  X(sedov) X(noh) X(gresho) X(yee) X(acoustic_wave) X(entropy_wave) X(square) X(two_blasts) X(uniform)
#define X(name) extern const struct kith_exact_ops kith_exact_##name;
KITH_EXACT_LIST(X)
#undef X

/* The member called `name` ('-' and '_' are the same), or NULL. */
const struct kith_exact_ops *kith_exact_find(const char *name);
/* All members, ended by NULL. */
const struct kith_exact_ops *const *kith_exact_all(void);

/* Where x stands on the line that a member varies along: distance from the center, or from the axis of a vortex; center NULL: x[0]. */
double kith_exact_place(const struct kith_exact_ops *ops, const double *center, const double *x);
/* The component of a velocity at x that the member has: outwards, around the axis of a vortex (counterclockwise), or along axis 0.
 * At the center itself 0. */
double kith_exact_speed(const struct kith_exact_ops *ops, const double *center, const double *x,
                        const double *velocity);

#endif
