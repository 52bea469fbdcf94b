/* exact.h - exact solutions a run is compared with: one family, chosen by name from the scene.
 *
 * A solution gives the state at a place x[NDIM] and a time; radial solutions use r = |x - center|, vortices
 * the distance from the axis through the center along axis 2. Gases are ideal, pressure = (gamma - 1)
 * density energy, unless the member says otherwise. Mathematics, source, limits and parameters stand in the
 * file of each; what follows from the rest of a scene the member derives. `kith list exact` lists them.
 *
 * After create a solution is read-only: any number of threads may ask it. */
#ifndef KITH_VALIDATION_EXACT_EXACT_H
#define KITH_VALIDATION_EXACT_EXACT_H

#include "lib/core/param.h"

/* What every solution yields; energy is per unit mass, without kinetic energy. */
struct kith_exact_state {
  double density, velocity[NDIM], pressure, energy;
};

/* A gas: the first member of the settings of all but riemann, slabs and hugoniot, and of what they create. */
struct kith_exact_gas {
  double gamma, density, pressure, uniform_velocity[NDIM], center[NDIM], period[NDIM];
};

/* What members derive their settings from. Values that are not constant in space are NaN. */
struct kith_exact_scene {
  double lower[NDIM], upper[NDIM], until; /* domain; end of the run */
  struct {
    bool open[2], mirror[2], periodic; /* lower and upper side: nothing, or an immovable mirror */
    double velocity;                   /* of a side that moves, whose other side is open; else 0 */
  } axis[NDIM];
  bool forced; /* by gravity or a point mass */
  int n_regions;
  struct kith_exact_region {
    /* rho c^2 = gamma (P + stiffness): 0 in an ideal gas; NaN if its material has no such law. */
    double gamma, stiffness;
    bool barotropic; /* its pressure takes nothing from its energy */
    double density, pressure, energy, velocity[NDIM];
    double lower[NDIM], upper[NDIM]; /* its box; infinite where the scene gives none */
    bool irregular;                  /* parts of the box are left out, or it stays where it is */
  } region[2];                       /* the first two */
  int n_deposits;
  double deposit_energy, deposit_time, deposit_center[NDIM]; /* of the first one */
};

/* The gas between the outer waves of a Riemann problem. [0]: the left-running wave and the gas left of the
 * contact, [1]: the right ones. A shock has tail = head. A vacuum has the velocity between its two edges. */
struct kith_exact_star {
  double pressure, velocity, density[2];
  double head[2], tail[2]; /* speeds dx/dt of the outer and inner edge of each wave */
  double interface;        /* x[0] of the jump at t = 0: the contact is at interface + velocity t */
};

struct kith_exact_ops {
  const char *name, *doc;
  const struct kith_param *params; /* its own parameters; `settings` below are their values */
  size_t settings_size;
  /* Sets what follows from the scene; what does not follow stays as it is. Members for ideal gases, which are
   * not `not_ideal`, have it and set their gamma, to NaN if a material is no ideal gas. NULL: nothing
   * follows. */
  void (*derive)(void *settings, const struct kith_exact_scene *scene);
  const char *derived_from; /* the scenes from which everything follows, if only from some; NULL: not told */
  /* BAD_INPUT "exact solution NAME: ..." for values that do not fit together; each by itself is in its range.
   * NULL: all do. */
  kith_status (*check)(const void *settings);
  /* Creates *self, one block of memory. NULL: *self is a copy of the settings. */
  kith_status (*create)(void **self, const void *settings);
  /* State at x[NDIM] and time >= 0; time 0 gives the initial state. Cheap (a table look-up or a closed form):
   * called once per node. All values are finite, but of velocities that it does not know, which are NaN; a
   * vacuum has density, pressure and energy 0. */
  void (*state)(const void *self, const double *x, double time, struct kith_exact_state *out);
  /* Radius (or position along axis 0) of the leading shock at `time`: the right-going one of a Riemann
   * problem, else the left-going one; 0 if these states make none. NULL if the member never has one. */
  double (*shock)(const void *self, double time);
  struct kith_exact_star (*star)(const void *self); /* NULL: the member is no Riemann problem */
  bool radial;                                      /* it has a center; else it varies along axis 0 only */
  bool vortex;     /* it turns about an axis through the center, along axis 2 */
  bool transverse; /* its velocity is along axis 1 */
  bool not_ideal;  /* heat is conducted, the gas is viscous, or it is no gas: no solution of Euler's equations
                   * of an ideal gas */
};

#define KITH_EXACT_LIST(X) \
  X(riemann)               \
  X(sedov)                 \
  X(noh)                   \
  X(gresho)                \
  X(yee)                   \
  X(acoustic_wave)         \
  X(entropy_wave)          \
  X(square)                \
  X(two_blasts)            \
  X(shu_osher) X(uniform) X(decaying_wave) X(slabs) X(hugoniot) X(kidder)
#define X(name) extern const struct kith_exact_ops kith_exact_##name;
KITH_EXACT_LIST(X)
#undef X
KITH_FAMILY_FUNCTIONS(kith_exact);

/* Creates a solution, which kith_free frees. BAD_INPUT, with the parameter's name, for wrong settings. */
kith_status kith_exact_create(void **self, const struct kith_exact_ops *ops, const void *settings);
/* What a radial solution is about: the center at time 0, carried with the gas through its periods. Borrowed;
 * NULL for others. */
const struct kith_exact_gas *kith_exact_about(const struct kith_exact_ops *ops, const void *self);

/* Vector to x from the nearest periodic image of the center, which is carried along. */
void kith_exact_offset(const struct kith_exact_gas *about, const double *x, double time, double offset[3]);
/* Where x stands: its distance from the center, or the axis of a vortex; about NULL: x[0]. Here and below ops
 * may be NULL. */
double kith_exact_place(const struct kith_exact_ops *ops, const struct kith_exact_gas *about, const double *x,
                        double time);
/* The component of a velocity at x that the member has: outwards, counterclockwise around the axis of a
 * vortex, both beyond the uniform velocity, along axis 1 if it is transverse, or axis 0 if `about` is NULL.
 * 0 at the center. */
double kith_exact_speed(const struct kith_exact_ops *ops, const struct kith_exact_gas *about, const double *x,
                        double time, const double *velocity);

#endif
