/* integrator.h - the state of the time integration: what a run sets, what a step keeps, how nodes are moved.
 *
 * In this room, from below: ledger, integrator, flow (gas that comes and goes), window (gas that sleeps),
 * lifecycle (that of the connectivity in one function), step (a step in one function), schemes/. */
#ifndef KITH_INTEGRATOR_INTEGRATOR_H
#define KITH_INTEGRATOR_INTEGRATOR_H

#include "boundaries/flow.h"
#include "integrator/ledger.h"
#include "integrator/scheme.h"
#include "lib/comm/sum.h"
#include "lib/connectivity/connectivity.h"
#include "lib/core/profile.h"
#include "lib/domain/decomposition.h"
#include "lib/neighbor/search.h"
#include "physics/package.h"

/* What lists were made from. Coordinates are scalar fields, because a mirror that acts on a node later must
 * not change them. */
struct kith_built {
  struct kith_field *x[NDIM], *search_radius, *support;
};

/* The field of nodes: mass over density of an inflow that changes. */
#define KITH_ZONE_VOLUME "zone_volume"

struct kith_flow_state {
  double density, energy, velocity[NDIM];
};
/* The state at the face of an inflow, beside x. */
typedef kith_status kith_flow_state_at(const void *context, const struct kith_boundary *boundary, int list,
                                       const double *x, double time, struct kith_flow_state *out);

/* What the ranks of a run tell each other after a step. */
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
  const void *settings;                     /* of the scheme: what its params fill; NULL if it has none */
  struct kith_excluder *excluders;          /* may be NULL */
  struct kith_profile *profile;             /* may be NULL */
  struct kith_decomposition *decomposition; /* of the nodes of several ranks; NULL: one process */
  bool canonical;       /* lists are in an order that all numbers of ranks share; nodes number their images */
  double cfl, fixed_dt; /* fixed_dt > 0: of every step that does not land on an output */
  double skin;          /* search radius = (1 + skin) support, and what the step may need (lifecycle.h) */
  bool cull, check;
  int reorder_every; /* lifecycles between checks of the curve order, 0: never */
  bool follows;      /* gas that no signal has reached sleeps (window.h) */
  bool summarizes;   /* `summary` is wanted after each step */
  /* What a caller decides by all ranks after a step: ask (NULL: nothing) writes what this rank wants. */
  void (*ask)(void *context, double wish[KITH_WISHES]);
  void *asker;

  /* The step. */
  double time;
  double until, every; /* where steps have to land next, and how far that is from where they did last */
  double clock;        /* the time of the positions, within a step too: where faces that move are */
  uint64_t step;
  double dt;               /* of the last step */
  enum kith_limit limiter; /* what limited it, and the node that did (-1: none) */
  int64_t limiting_node;
  struct kith_timestep_limit timestep_limit; /* for the next step */
  struct kith_summary summary;               /* after the last step, of all ranks */
  double wish[KITH_WISHES];                  /* the largest of all ranks */
  kith_status pending; /* a failure of this rank between steps: all learn of it when they next agree */
  struct kith_ledger ledger;

  /* The scheme. */
  struct kith_kick kick; /* package.h */
  struct kith_field *energy_base;
  struct kith_field *energy_rate_last; /* unless the scheme has stages */
  int evaluations;                     /* of the rates, per step; with implicit a guess */
  void *self;

  struct {                     /* gas that comes and goes: flow.h */
    kith_flow_state_at *state; /* at the faces of inflows; NULL: they stay as they are. The caller's, with: */
    const void *context;
    int64_t id_stride;
    struct kith_through rate;      /* of what the gas gets from outside, by the last evaluation */
    struct kith_sum got[1 + NDIM]; /* block steps: of this base step so far, on this rank; energy, momentum */
    struct kith_sum lifted;        /* by mirrors at the end of the step, on this rank: kith_flow_mirror */
  } flow;

  /* The lists. */
  enum kith_rebuild_reason due; /* why they must be rebuilt whatever the policies say; none: ask them */
  bool fresh;                   /* just rebuilt: ghosts have their values as long as the generation */
  uint64_t positions;           /* nodes->positions is this one */
  bool holding;            /* inside a step of several stages: no wraps, mirrors, migration, reordering */
  double ahead;            /* how long they must serve, from the present positions; 0: only now */
  struct kith_built built; /* fields are NULL if lists neither outlive a step nor are made again within one */
  bool resuming;           /* they are being rebuilt from `built`, bitwise identical */
  uint64_t since_reorder, count[2]; /* count: nodes of all ranks before and after the last lifecycle */
  struct { /* block steps: what the present tick has to do with, if that is not all; find() finds it */
    bool only;
    kith_status (*find)(struct kith_integrator *integrator);
    kith_index n, *node;
    size_t capacity;
  } near;
  struct kith_field *reached[2]; /* the window: scratch, U8; NULL if it is not followed */
  struct kith_requirements need;
  struct { /* scratch of the lifecycle */
    uint8_t *keep;
    kith_index *renumber;
    size_t keep_capacity, renumber_capacity;
    bool told; /* other ranks know what this one keeps */
  } scratch;
};

/* The nodes that the present step or tick has to do with, k = 0 .. count - 1. */
static inline kith_index kith_near_count(const struct kith_integrator *it) {
  return it->near.only ? it->near.n : it->nodes->n_internal;
}
static inline kith_index kith_near_node(const struct kith_integrator *it, kith_index k) {
  return it->near.only ? it->near.node[k] : k;
}

/* Registers fields. The members that the caller sets must be there. BAD_INPUT if the scheme refuses its
 * settings. */
kith_status kith_integrator_init(struct kith_integrator *integrator);
void kith_integrator_clear(struct kith_integrator *integrator);
size_t kith_integrator_bytes(const struct kith_integrator *integrator);
/* Registers the fields. names (string constants): of the search radius, the support, x, y, z. */
kith_status kith_built_fields(struct kith_built *built, struct kith_nodes *nodes, const char *const names[5],
                              enum kith_role role);
void kith_built_copy(const struct kith_nodes *nodes, const struct kith_built *to,
                     const struct kith_built *from);

/* to = from, of internal nodes. */
void kith_field_copy(const struct kith_nodes *nodes, struct kith_field *to, const struct kith_field *from);
/* v += dt A, and u by equation (1) of package.h; the time kicked so far += dt. */
void kith_kick(struct kith_integrator *integrator, double dt);
/* v += dt A, u += dt rate: a state for packages to evaluate, which the scheme then takes back. The middle of
 * dt is `later` than the evaluation of the rates: where a scheme has one a step, the rate of the energy is
 * extrapolated linearly from that one and the last. With constant rates pressures lag, and sound waves of a
 * few spacings slowly grow. Once per step. */
void kith_predict(struct kith_integrator *integrator, double dt, double later);
/* Supports follow the divergence of the velocity for a time dt: H *= exp(dt div v / d). */
void kith_drift_supports(struct kith_integrator *integrator, double dt);
/* x += dt v, and the supports. */
void kith_drift(struct kith_integrator *integrator, const struct kith_field *velocity, double dt);

#endif
