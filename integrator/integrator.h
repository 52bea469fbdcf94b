/* integrator.h - the state of the time integration: settings of a run, what a step keeps, kicks and drifts.
 *
 * Files of this folder, lowest level first: ledger, levels (of block steps), scheme (what a scheme has to
 * define), integrator, flow (inflow and outflow), window (gas that is not evaluated yet), lifecycle (of the
 * connectivity), step (one time step), block_lengths and block_steps (each node with a step of its own),
 * schemes/. */
#ifndef KITH_INTEGRATOR_INTEGRATOR_H
#define KITH_INTEGRATOR_INTEGRATOR_H

#include <math.h>
#include "boundaries/flow.h"
#include "integrator/ledger.h"
#include "integrator/levels.h"
#include "integrator/scheme.h"
#include "lib/comm/sum.h"
#include "lib/connectivity/connectivity.h"
#include "lib/core/profile.h"
#include "lib/domain/decomposition.h"
#include "lib/neighbor/search.h"
#include "physics/package.h"

/* What the neighbor lists were made from. Coordinates are scalar fields, because a mirror that acts on a node
 * later must not change them. */
struct kith_built {
  struct kith_field *x[NDIM], *search_radius, *support;
};

/* Name of a node field: mass over density in the zone of an inflow whose state changes. */
#define KITH_ZONE_VOLUME "zone_volume"

struct kith_flow_state {
  double density, energy, velocity[NDIM];
};
/* Computes the state at the face of an inflow beside position x. */
typedef kith_status kith_flow_state_at(const void *context, const struct kith_boundary *boundary, int list,
                                       const double *x, double time, struct kith_flow_state *out);

/* Sums over all ranks after a step. */
struct kith_summary {
  struct kith_totals totals;
  uint64_t nodes, ghosts, row_entries, migrated;
};
enum { KITH_WISHES = 2 };

struct kith_integrator {
  /* Set by the caller. All borrowed. */
  struct kith_nodes *nodes;
  struct kith_hydro *hydro;
  struct kith_package *package; /* the first of the list: the hydro package */
  struct kith_boundaries *boundaries;
  struct kith_search *search;
  struct kith_connectivity *connectivity;
  struct kith_rebuilds *rebuilds;
  const struct kith_scheme_ops *scheme;
  const void *settings;                     /* of the scheme, filled from its params; NULL if it has none */
  struct kith_excluder *excluders;          /* may be NULL */
  struct kith_profile *profile;             /* may be NULL */
  struct kith_decomposition *decomposition; /* of nodes over ranks; NULL: one process */
  bool canonical;       /* row order does not depend on the number of ranks; nodes number their images */
  double cfl, fixed_dt; /* fixed_dt > 0: length of every step that does not land on an output */
  double skin;          /* search radius = (1 + skin) support + margin for the step (lifecycle.h) */
  bool cull, check;
  int reorder_every; /* lifecycles between checks of the curve order, 0: never */
  bool follows;      /* gas that no signal has reached is not evaluated (window.h) */
  bool summarizes;   /* fill `summary` after each step */
  /* Wishes of the caller, of which the maximum over all ranks is taken after each step. `ask` writes those of
   * this rank; NULL: none. */
  void (*ask)(void *context, double wish[KITH_WISHES]);
  void *asker;

  /* The step. */
  double time;
  double until, every; /* time at which a step has to land next, and its distance from the last such time */
  double clock;        /* time of the positions, also within a step: sets the place of moving faces */
  uint64_t step;
  double dt;               /* of the last step */
  enum kith_limit limiter; /* what limited dt, and the node that did (-1: none) */
  int64_t limiting_node;
  struct kith_timestep_limit timestep_limit; /* for the next step */
  struct kith_summary summary;               /* of all ranks, after the last step */
  double wish[KITH_WISHES];                  /* the largest of all ranks */
  kith_status pending; /* failure of this rank between steps; ranks agree on it at the next opportunity */
  struct kith_ledger ledger;
  struct kith_levels levels; /* block time steps */

  /* The scheme. */
  struct kith_kick kick; /* package.h */
  struct kith_field *energy_base;
  struct kith_field *energy_rate_last; /* NULL if the scheme has stages or block time steps */
  int evaluations;                     /* of the rates, per step; a guess for scheme implicit */
  double planned;                      /* with block time steps: length of the next base step */
  double accurate_dt; /* next step that the last error estimate of the scheme allows; 0: no estimate */
  void *self;

  struct {                     /* inflow and outflow: flow.h */
    kith_flow_state_at *state; /* set by the caller: state at the faces of inflows; NULL: constant */
    const void *context;
    int64_t id_stride;             /* set by the caller: number of nodes at the start (flow.h) */
    struct kith_through rate;      /* what the gas gets from outside per time, by the last evaluation */
    struct kith_sum got[1 + NDIM]; /* block steps: energy, momentum in this base step so far, on this rank */
    struct kith_sum lifted; /* energy from mirrors at the end of the step, on this rank: kith_flow_mirror */
  } flow;

  /* The lists. */
  enum kith_rebuild_reason due; /* why they must be rebuilt at once; none: the policies decide */
  bool fresh;         /* just rebuilt: ghost values are valid while nodes->positions equals `positions` */
  uint64_t positions; /* nodes->positions at the last rebuild */
  bool holding;       /* inside of a step: no wraps, no migration; reordering only with block steps */
  double ahead;       /* time from now on that lists must cover; 0: now only */
  struct kith_built built; /* fields are NULL if lists neither outlive a step nor are remade within one */
  bool resuming;           /* lists are being rebuilt from `built`, bitwise identical */
  uint64_t since_reorder, count[2]; /* count: nodes of all ranks before and after the last lifecycle */
  struct {     /* block steps: the nodes that the present tick concerns; find() finds them */
    bool only; /* false: all nodes */
    kith_status (*find)(struct kith_integrator *integrator);
    kith_index n, *node;
    size_t capacity;
  } near;
  struct kith_field *reached[2]; /* scratch of the window, U8; NULL if it is not followed */
  struct kith_requirements need;
  struct { /* scratch of the lifecycle */
    uint8_t *keep;
    kith_index *renumber;
    size_t keep_capacity, renumber_capacity;
    bool told; /* other ranks have been told what this one keeps */
  } scratch;
};

/* The nodes that the present step or tick concerns, k = 0 .. count - 1. */
static inline kith_index kith_near_count(const struct kith_integrator *it) {
  return it->near.only ? it->near.n : it->nodes->n_internal;
}
static inline kith_index kith_near_node(const struct kith_integrator *it, kith_index k) {
  return it->near.only ? it->near.node[k] : k;
}

/* Registers fields, from the members that the caller has set. BAD_INPUT if the scheme refuses its
 * settings. */
kith_status kith_integrator_init(struct kith_integrator *integrator);
void kith_integrator_clear(struct kith_integrator *integrator);
size_t kith_integrator_bytes(const struct kith_integrator *integrator);
/* Registers the fields of `built`. names (string constants): of the search radius, the support, x, y, z. */
kith_status kith_built_fields(struct kith_built *built, struct kith_nodes *nodes, const char *const names[5],
                              enum kith_role role);
void kith_built_copy(const struct kith_nodes *nodes, const struct kith_built *to,
                     const struct kith_built *from);

/* Copies a field of internal nodes. */
void kith_field_copy(const struct kith_nodes *nodes, struct kith_field *to, const struct kith_field *from);
/* Kicks: v += dt A, u by (1) of package.h, kick.time += dt. Here, in kith_predict and kith_correct nodes that
 * sleep (window.h) are skipped: their rates are 0, and the velocities and energies that were stored for them
 * at the start are still the present ones. */
void kith_kick(struct kith_integrator *integrator, double dt);
/* Returns the factor by which a support grows in a time dt: exp(dt div v / d), the exponent within 0.2. */
static inline double kith_support_growth(double dt, double velocity_divergence) {
  const double growth = dt * velocity_divergence / NDIM;
  return growth != 0 ? exp(KITH_MAX(KITH_MIN(growth, 0.2), -0.2)) : 1; /* 0 for sleeping nodes */
}
/* Changes supports by the divergence of the velocity during dt. */
void kith_drift_supports(struct kith_integrator *integrator, double dt);
/* Drifts positions, x += dt v, and supports. */
void kith_drift(struct kith_integrator *integrator, double dt);
/* Stores velocities and energies, drifts by the time `drift`, and predicts the state that packages evaluate,
 * v += dt A, u += dt rate. `later` is the time from the last evaluation to the middle of dt: in schemes with
 * one evaluation per step the energy rate at that time is extrapolated linearly from the last two. With the
 * last rate alone pressures would lag, and sound waves of a few spacings would slowly grow. Call once per
 * step. */
void kith_predict(struct kith_integrator *integrator, double drift, double dt, double later);
/* Takes the prediction of velocities and energies back, and kicks them by the new rates. */
void kith_correct(struct kith_integrator *integrator, double dt);

#endif
