/* package.h - a hydro package: what connectivity it needs, and how rates follow from the state. One family.
 *
 * A package is a short sequence of passes (volume and density -> gradients -> pair force -> work); between passes it
 * refreshes ghosts. The first pass (density.h) and the last (force.h: pair forces in both traversals, compatible energy) are the
 * same for all: a package adds what lies between, and one function of a pair. It reads position, velocity, energy, mass, support and fills support, density, pressure, sound speed, acceleration and the rates.
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
  size_t (*bytes)(const struct kith_package *package); /* private memory; NULL: none */
  bool dear; /* a pair costs more than memory: by default it is evaluated once and kept */
};

/* name, word of the scene, doc */
#define KITH_VISCOSITY_LIST(X)                                                                  \
  X(NONE, none, "none: for flows without shocks")                                               \
  X(MONAGHAN, monaghan, "on every approaching pair, alike")                                     \
  X(LIMITED, limited,                                                                           \
    "on the jump that slope-limited gradients leave: little where flow is smooth; the default") \
  X(CULLEN_DEHNEN, cullen_dehnen,                                                               \
    "on every approaching pair, by a coefficient that rises ahead of a shock and decays behind it")
enum kith_viscosity {
#define X(name, word, doc) KITH_VISCOSITY_##name,
  KITH_VISCOSITY_LIST(X)
#undef X
};
/* Balsara's factor: |div v| / (|div v| + |curl v| + 1e-4 c / h), the mean of both ends; and its square. */
#define KITH_BALSARA_LIST(X)                                                   \
  X(NONE, none, "the same in shear and in shocks; the default")                \
  X(FACTOR, balsara, "less viscosity where flow turns more than it converges") \
  X(SQUARED, squared, "the square of the factor: sharper")
enum kith_balsara {
#define X(name, word, doc) KITH_BALSARA_##name,
  KITH_BALSARA_LIST(X)
#undef X
};
/* Faces between nodes, package mfm. */
#define KITH_FACES_LIST(X)                                                                \
  X(ONE_POINT, one_point, "from the gradients at both nodes (Hopkins 2015); the default") \
  X(INTEGRATED, integrated,                                                               \
    "summed over the nodes that two supports share, for all that overlap: dearer, closer to closed")
enum kith_faces {
#define X(name, word, doc) KITH_FACES_##name,
  KITH_FACES_LIST(X)
#undef X
};
enum kith_traversal { KITH_TRAVERSE_PAIRS, KITH_TRAVERSE_GATHER };

struct kith_package {
  /* Set by the caller. */
  const struct kith_package_ops *ops;
  struct kith_hydro *hydro; /* borrowed */
  enum kith_kernel kernel;
  double neighbors; /* ball H^d n */
  bool compatible;
  enum kith_viscosity viscosity;
  enum kith_balsara balsara;
  double alpha, beta, conduction;
  enum kith_faces faces;
  bool closed; /* faces corrected so that those of each node sum to zero */
  enum kith_traversal traversal;
  bool
      recompute; /* between passes values of remote ghosts are computed from their rows, not exchanged: needs ranks, package sph */
  struct kith_profile *profile; /* borrowed, may be NULL */
  const struct kith_field
      *barrier; /* U8, 1: a node that is a wall to whoever looks at it; NULL: there is none */

  /* Kept by the scheme. */
  struct kith_field *velocity_base; /* where kicks start; filled before evaluate */
  double kicked;                    /* time kicked since then */
  double interval;                  /* time from one evaluation to the next; 0 at the start */

  /* Its own. */
  double self_weight;              /* of a node in its own sums: kith_kernel_self_weight */
  struct kith_field *energy_slope; /* NULL unless compatible */
  struct kith_field *expansion;    /* div v: predicts the support */
  struct kith_field *signal;       /* signal speed of the Courant condition */
  uint8_t *border;                 /* chunks beside other ranks: sweep.c */
  size_t border_capacity;
  const kith_index *border_of; /* the rows that it is of, and the generation of ghosts that they are of */
  uint64_t border_ghosts;
  uint8_t *needed; /* ghosts whose values are computed: density.c */
  size_t needed_capacity;
  double *record;                         /* what pairs read of nodes: force.h */
  size_t record_capacity;                 /* doubles */
  struct kith_pairwise pair;              /* what pairs gave, traversal `pairs` */
  uint64_t pair_evaluations;              /* counted over the run */
  uint64_t support_iterations, fallbacks; /* Newton steps beyond the first; gradients without an inverse */
  void *self;
};

#define KITH_PACKAGE_LIST(X) X(sph) X(crk) X(mfm)
#define X(name) extern const struct kith_package_ops kith_package_##name;
KITH_PACKAGE_LIST(X)
#undef X
const struct kith_package_ops *kith_package_find(const char *name); /* NULL if there is none */
const struct kith_package_ops *const *kith_package_all(void);       /* ended by NULL */

/* Fills ops, kernel... from the caller's members, registers the shared fields and calls ops->create. */
kith_status kith_package_init(struct kith_package *package);
void kith_package_clear(struct kith_package *package);

/* Ghost values of these fields, as stage `refresh`: the next sweep (sweep.h), or whoever posts next, awaits those of remote ghosts.
 * Collective. */
void kith_package_post(struct kith_package *package, int n, struct kith_field *const *fields);
/* The same, and awaits them. */
void kith_package_refresh(struct kith_package *package, int n, struct kith_field *const *fields);

/* The time step that the present state and rates allow: Courant condition with h = 2 sigma and the signal speed, acceleration,
 * compression, loss of energy; of all ranks. Collective. */
struct kith_vote kith_package_vote(const struct kith_package *package, double cfl);

/* Memory besides the fields, pairwise fields included; and those alone. */
size_t kith_package_bytes(const struct kith_package *package);
size_t kith_package_pairwise_bytes(const struct kith_package *package);

#endif
