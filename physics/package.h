/* package.h - packages: the connectivity that a package requires, and how rates follow from the state.
 *
 * A run has a list of packages. The first is a hydro package (family kith_package): it computes supports,
 * density, pressure and the rates. The packages after it (family kith_added) add forces and heats of pairs to
 * these rates, in the order of the list, or couple the pairs: then forces and heats of pairs of all packages
 * are multiplied by f_couple. What follows about pairs holds for all packages together.
 *
 * A hydro package is a short sequence of passes (volume and density -> gradients -> pair force); between
 * passes it refreshes ghosts. The first pass (density.h) and the last (force.h: pair forces in both
 * traversals, energy) are shared by all hydro packages: each adds the passes between, and one function of a
 * pair. Added packages have the last pass only. A package is one file with its parameter table and one word
 * in a list below; tests/unit/physics/conformance_package.c or conformance_added.c covers it. A hydro package
 * reads position, velocity, energy, mass, support and fills support, density, pressure, sound speed,
 * acceleration and the rates.
 *
 * Energy, for every package. A pair with the force f_ij on i heats its ends by q_ij + q_ji = f_ij . (p_j -
 * p_i), where p are the velocities with which it is evaluated. Let a be the acceleration by pairs, A that by
 * all forces, w the velocity at the start of the kick, and t the time kicked so far. Then the next part dt of
 * the kick is
 *     v += dt A,   u += dt (rate + correction + (t + dt / 2) slope),   m_i rate_i = sum_j q_ij.       (1)
 * thermal:     correction and slope are zero.
 * compatible:  slope = -a . a, correction = -a . (w + s g - p), with s from the start of the kick to the
 *              evaluation and g the external force (A - a) at the last evaluation, which counts as if it had
 *              acted before the pairs. Since sum_i m_i rate_i = - sum_i m_i a_i . p_i, the sum of all is
 *              minus what pairs add to the kinetic energy, to round-off, whatever f and p are. Owen (2014,
 *              Int. J. Numer. Meth. Fluids 75, 749) has p = w + (t + dt / 2) A, which costs a second
 *              evaluation of the pairs. Schemes predict p = w + s A by the last rates: then correction and
 *              slope differ by the change of a alone, and gas that moves or falls as a whole sees neither. */
#ifndef KITH_PHYSICS_PACKAGE_H
#define KITH_PHYSICS_PACKAGE_H

#include "lib/connectivity/connectivity.h"
#include "lib/core/param.h"
#include "lib/core/profile.h"
#include "physics/block_steps.h"
#include "physics/hydro.h"
#include "physics/kernel.h"

/* Hydro packages, of which a run has one, and those added to it. */
#define KITH_PACKAGE_LIST(X) X(sph) X(crk) X(mfm) X(magma2) X(remix)
#define KITH_ADDED_PACKAGE_LIST(X) X(conduction) X(viscosity) X(coupling)

struct kith_package;

/* The largest Courant number with which explicit schemes let diffusion decay (diffusion.h). */
#define KITH_DIFFUSION_STABLE 0.7

/* Reasons for the length of a step: by the state (package.c), by added packages, by the integrator, by a
 * scheme. */
#define KITH_LIMIT_LIST(X) \
  X(nothing)               \
  X(courant)               \
  X(acceleration)          \
  X(compression)           \
  X(displacement)          \
  X(cooling) KITH_ADDED_PACKAGE_LIST(X) X(fixed) X(accuracy) X(growth) X(end) X(convergence)
enum kith_limit {
#define X(name) KITH_LIMIT_##name,
  KITH_LIMIT_LIST(X)
#undef X
};
const char *kith_limit_name(enum kith_limit limit);

/* The longest step that is allowed. Of several limits the shortest holds, and ties go to the lowest id. */
struct kith_timestep_limit {
  double dt;
  int64_t node; /* global id, -1: no node */
  enum kith_limit reason;
};
enum { KITH_LIMIT_WORDS = sizeof(struct kith_timestep_limit) / 8 }; /* in messages between ranks */

/* The present kick of velocities: set by the scheme, read by packages. */
struct kith_kick {
  struct kith_field *velocity_base;      /* velocities at the start of the kick; filled before evaluate */
  double time;                           /* time kicked since then */
  double lead;                           /* time from the start of the kick to the evaluation */
  double evaluation_dt;                  /* time from one evaluation to the next; 0 at the start */
  const struct kith_block_steps *blocks; /* for block time steps; NULL: one step for all nodes */
};

/* What a package can and cannot do with its settings, for checks of a scene. */
struct kith_package_traits {
  bool recomputes;        /* it computes values of ghosts with rows itself, by one pass before the forces */
  bool swings;            /* light nodes beside heavy ones swing faster than sound tells (sph.c) */
  bool elastic;           /* a lattice resists shear: sums over few neighbors depend on where they are */
  bool viscous;           /* an added package that resists shear */
  const char *history;    /* what depends on earlier evaluations: no step can be repeated; NULL: nothing */
  const char *all_rows;   /* what needs the rows of all nodes at once, so no block steps; NULL: nothing */
  const char *uncoupled;  /* why porosity and damage would not act, and what to take; NULL: they do */
  const char *no_between; /* parameter that leaves no intersections of supports; NULL: none does */
  const char *cheaper;    /* a cheaper setting and its trade-off, for `kith plan`; NULL: none */
};

struct kith_package_ops {
  const char *name, *doc;
  const struct kith_param *params; /* its own parameters, NULL: none */
  size_t settings_size;
  size_t self_size; /* of its private state, package->self, which is zeroed before create */
  /* Registers fields, checks parameters. NULL: nothing. */
  kith_status (*create)(struct kith_package *package);
  /* Frees what the private state owns. NULL: nothing. */
  void (*destroy)(struct kith_package *package);
  /* Returns what it requires of the connectivity. NULL: rows, and rows of ghosts if these are recomputed. */
  struct kith_requirements (*requirements)(const struct kith_package *package);
  /* Computes rates from the state; an added package adds them to those of the packages before. Where nodes
   * have an activity, it leaves the fields of those that are not active alone. NULL: it has none. OUTGROWN:
   * a support has to grow beyond the search radius of its node; such supports are set to what to try next,
   * and the caller rebuilds the connectivity and calls again. DIVERGED: a support does not converge; it is
   * NaN. */
  kith_status (*evaluate)(struct kith_package *package, struct kith_connectivity *connectivity,
                          const struct kith_kick *kick);
  size_t (*bytes)(const struct kith_package *package);        /* owned by the private state; NULL: 0 */
  struct kith_package_traits (*traits)(const void *settings); /* NULL: all zero */
  /* Defaults of a hydro package, chosen by the measurements in app/manual/methods.md. */
  double spacings;   /* node spacings in 2 sigma; 0: those of kith_kernel_neighbors */
  double cfl;        /* Courant number */
  double stable_cfl; /* the largest with which noise in gas at rest dies out; 0: it does at 1.4 cfl, too */
  /* Fills f_couple (connectivity.h), by which every force and heat of a pair is multiplied, from pairs and
   * intersections that were just built, before culling. Only a package without `evaluate` has it. */
  kith_status (*couple)(struct kith_package *package, struct kith_connectivity *connectivity);
  /* Of an added package: the longest time step at Courant number 1 that node i allows. NULL: any. */
  double (*longest_step)(const struct kith_package *package, kith_index i);
};

enum kith_traversal { KITH_TRAVERSE_PAIRS, KITH_TRAVERSE_GATHER };

struct kith_package {
  /* Set by the caller. */
  struct kith_package *next; /* next of the list, borrowed; NULL: this is the last one */
  const struct kith_package_ops *ops;
  struct kith_hydro *hydro; /* borrowed */
  enum kith_kernel kernel;
  double neighbors; /* ball H^d n */
  bool compatible;
  const void *settings; /* of the package, as its params declare them; borrowed */
  enum kith_traversal traversal;
  /* Values of remote ghosts are recomputed from their rows between passes, instead of exchanged: needs ranks
   * and the trait. */
  bool recompute;
  double added_cfl; /* the largest Courant number that multiplies limits of added packages; 0: any */
  struct kith_profile *profile;     /* borrowed, may be NULL */
  const struct kith_field *barrier; /* U8, 1: the node is a wall (force.h); NULL: there is none */

  /* Set by kith_package_init and the passes. */
  enum kith_limit limit; /* by which an added package shortens a step; of a hydro package `nothing` */
  double self_weight;    /* weight of a node in its own sums: kith_kernel_self_weight */
  struct kith_field *energy_correction;   /* if the energy is compatible */
  struct kith_field *pair_acceleration;   /* is hydro->acceleration unless there is an external force */
  struct kith_field *velocity_divergence; /* div v; supports are predicted by it */
  struct kith_field *signal;              /* signal speed of the Courant condition */
  uint64_t pair_evaluations; /* counted over the run; the first package counts for the whole list */
  uint64_t support_iterations, fallbacks; /* Newton steps beyond the first; gradients without an inverse */
  void *self;                             /* private state of the member */

  /* Scratch of the passes. */
  struct kith_border {
    uint8_t *chunk; /* is there a remote ghost in the rows of a chunk? (sweep.h) */
    size_t capacity;
    const kith_index *rows; /* the rows that `chunk` is of, and the generation of ghosts */
    uint64_t ghosts;
  } border;
  uint8_t *needed; /* [n_ghost]: is the ghost recomputed? (density.h) */
  size_t needed_capacity;
};

#define X(name) extern const struct kith_package_ops kith_package_##name;
KITH_PACKAGE_LIST(X)
KITH_ADDED_PACKAGE_LIST(X)
#undef X
KITH_FAMILY_FUNCTIONS(kith_package);
KITH_FAMILY_FUNCTIONS_OF(kith_added, kith_package_ops);
#define X(name) +1
enum { KITH_ADDED_PACKAGES = KITH_ADDED_PACKAGE_LIST(X) }; /* a run has each at most once */
#undef X

/* Returns the traits of a package with these settings. */
struct kith_package_traits kith_package_traits(const struct kith_package_ops *ops, const void *settings);

/* Registers the shared fields and calls ops->create, after the caller has set its members. */
kith_status kith_package_init(struct kith_package *package);
void kith_package_clear(struct kith_package *package);

/* Returns what its connectivity has to provide. */
struct kith_requirements kith_package_requirements(const struct kith_package *package);
/* Starts to refresh ghost values of these fields, as profile stage `refresh`: those of remote ghosts arrive
 * during the next sweep, or when the next exchange starts. Collective. */
void kith_package_start_refresh(struct kith_package *package, int n, struct kith_field *const *fields);

/* Computes the rates by all packages from this one on: see `evaluate` of the ops. */
kith_status kith_package_evaluate(struct kith_package *package, struct kith_connectivity *connectivity,
                                  const struct kith_kick *kick);

/* Returns the time step that node i alone allows: see kith_package_limit_of_rank. */
struct kith_timestep_limit kith_package_limit_of_node(const struct kith_package *package, kith_index i,
                                                      double cfl);
/* Return the time step that the present state and rates allow, on this rank or (collective) on all ranks: the
 * least of the Courant condition with h = 2 sigma and the signal speed, acceleration, compression,
 * displacement, loss of energy, and the limits of the packages after this one. */
struct kith_timestep_limit kith_package_limit_of_rank(const struct kith_package *package, double cfl);
struct kith_timestep_limit kith_package_timestep_limit(const struct kith_package *package, double cfl);

/* Returns the memory besides fields of nodes and of pairs, of all packages from this one on. */
size_t kith_package_bytes(const struct kith_package *package);

#endif
