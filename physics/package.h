/* package.h - a hydro package: what connectivity it needs, and how rates follow from the state. One family.
 *
 * A package is a short sequence of passes (volume and density -> gradients -> pair force -> work); between passes it
 * refreshes ghosts. It reads position, velocity, energy, mass, support and fills support, density, pressure, sound speed, acceleration and the rates.
 *
 * Energy, for every package: after a kick of velocities from `velocity_base` by dt a, with t already kicked since the base,
 *     u += dt (energy_rate + (t + dt / 2) energy_slope).
 * thermal:     energy_rate is du/dt at the present velocity, energy_slope is zero.
 * compatible:  each pair's work f_ij . (v_j - v_i) is shared between its ends, e_ij + e_ji = 1, with v the mean velocity over the kick:
 *     m_i energy_rate = sum_j e_ij f_ij . (v_j - v_i) of the base, m_i energy_slope = sum_j e_ij f_ij . (a_j - a_i),
 *     so that sum_i (m v^2 / 2 + m u) is kept to round-off, whatever the forces (Owen 2014, J. Num. Meth. Fluids 75, 749). */
#ifndef KITH_PHYSICS_PACKAGE_H
#define KITH_PHYSICS_PACKAGE_H

#include "lib/connectivity/connectivity.h"
#include "lib/core/profile.h"
#include "physics/hydro.h"
#include "physics/kernel.h"

struct kith_package;

/* What limits the time step: the smallest vote wins; ties go to the first in order. */
struct kith_vote {
  double dt;
  int64_t node;       /* global id, -1: no node */
  const char *reason; /* "courant", "acceleration", ... */
};

struct kith_package_ops {
  const char *name, *doc;
  /* Registers fields, checks parameters. Private state in package->self. */
  kith_status (*create)(struct kith_package *package);
  void (*destroy)(struct kith_package *package);
  struct kith_requirements (*requirements)(const struct kith_package *package);
  /* Rates from the state. REACH: a support wants to grow beyond the node's reach; supports are set to what they want at least, and the
   * caller makes new connectivity and calls again. A support that does not converge is NaN, and the density with it. */
  kith_status (*evaluate)(struct kith_package *package, struct kith_connectivity *connectivity);
  struct kith_vote (*vote)(const struct kith_package *package, double cfl);
  /* Private memory, pairwise fields included; pairwise fields alone. */
  size_t (*bytes)(const struct kith_package *package);
  size_t (*pairwise_bytes)(const struct kith_package *package);
};

/* name, word of the scene, doc */
#define KITH_VISCOSITY_LIST(X)                              \
  X(MONAGHAN, monaghan, "on every approaching pair, alike") \
  X(LIMITED, limited,                                       \
    "on the jump that slope-limited gradients leave: little where flow is smooth; the default")
enum kith_viscosity {
#define X(name, word, doc) KITH_VISCOSITY_##name,
  KITH_VISCOSITY_LIST(X)
#undef X
};
enum kith_traversal { KITH_TRAVERSE_PAIRS, KITH_TRAVERSE_GATHER };

struct kith_package {
  const struct kith_package_ops *ops;
  struct kith_hydro *hydro; /* borrowed */
  enum kith_kernel kernel;
  double neighbors;   /* ball H^d n */
  double self_weight; /* of a node in its own sums: kith_kernel_self_weight */
  bool compatible;
  enum kith_viscosity viscosity;
  double alpha, beta;
  enum kith_traversal traversal;
  struct kith_profile *profile; /* borrowed, may be NULL */

  struct kith_field *velocity_base;       /* where kicks start; the scheme fills it before evaluate */
  double kicked;                          /* time kicked since then */
  struct kith_field *energy_slope;        /* NULL unless compatible */
  struct kith_field *expansion;           /* div v: predicts the support */
  uint64_t pair_evaluations;              /* counted over the run */
  uint64_t support_iterations, fallbacks; /* Newton steps beyond the first; gradients without an inverse */
  void *self;
};

#define KITH_PACKAGE_LIST(X) X(sph)
#define X(name) extern const struct kith_package_ops kith_package_##name;
KITH_PACKAGE_LIST(X)
#undef X
const struct kith_package_ops *kith_package_find(const char *name); /* NULL if there is none */
const struct kith_package_ops *const *kith_package_all(void);       /* ended by NULL */

/* Fills ops, kernel... from the caller's members, registers the shared fields and calls ops->create. */
kith_status kith_package_init(struct kith_package *package);
void kith_package_clear(struct kith_package *package);

#endif
