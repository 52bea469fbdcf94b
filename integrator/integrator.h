/* integrator.h - the step: lifecycle, time-step control, schemes.
 *
 *   requirements -> is a rebuild due -> ghosts -> neighbors -> connectivity -> cull -> patch -> ready -> scheme
 *
 * kith_lifecycle (lifecycle.c) is the design in one function. A scheme moves the state and asks for rates through
 * kith_integrator_rates, which runs the lifecycle if one is due at the present positions, else only refreshes
 * ghost values. */
#ifndef KITH_INTEGRATOR_INTEGRATOR_H
#define KITH_INTEGRATOR_INTEGRATOR_H

#include "boundaries/boundary.h"
#include "lib/connectivity/connectivity.h"
#include "lib/connectivity/rebuild.h"
#include "lib/core/profile.h"
#include "lib/neighbor/search.h"
#include "physics/package.h"

struct kith_integrator;

struct kith_scheme_ops {
  const char *name, *doc;
  int evaluations; /* of the rates, per step */
  /* Advances all state from time to time + dt. The rates of the present state are there on entry (and after). */
  kith_status (*step)(struct kith_integrator *integrator, double dt);
};

#define KITH_SCHEME_LIST(X) X(leapfrog) X(rk2) X(cheap_rk2)
#define X(name) extern const struct kith_scheme_ops kith_scheme_##name;
KITH_SCHEME_LIST(X)
#undef X
const struct kith_scheme_ops *kith_scheme_find(
    const char *name); /* '-' and '_' are the same; NULL if there is none */
const struct kith_scheme_ops *const *kith_scheme_all(void);

/* What happened, summed over the run (and the last lifecycle, where said); nothing but uint64_t, for checkpoints. created = culled + kept, for each boundary. */
struct kith_ledger {
  uint64_t lifecycles, support_rebuilds, reorders, refreshes;
  uint64_t cut; /* pairs that barriers cut */
  uint64_t because[5];            /* first build, then policies in the order of KITH_REBUILD_LIST */
  uint64_t created, culled, kept; /* ghosts */
  uint64_t candidates, row_entries, pairs;
  struct {
    uint64_t created, culled, kept;
  } boundary[2 * NDIM + 8];
  uint64_t ghosts, last_entries, last_pairs; /* of the last lifecycle */
};

/* Who asks for what, and why: what the connectivity is built from. */
struct kith_demand {
  const char *who, *why;
  struct kith_requirements need;
};
enum { KITH_DEMANDS = 3 };

struct kith_integrator {
  /* Set by the caller. All borrowed. */
  struct kith_nodes *nodes;
  struct kith_hydro *hydro;
  struct kith_package *package;
  struct kith_boundaries *boundaries;
  struct kith_search *search;
  struct kith_connectivity *connectivity;
  struct kith_rebuilds *rebuilds;
  const struct kith_scheme_ops *scheme;
  const struct kith_excluder *excluders; /* may be NULL */
  struct kith_profile *profile;          /* may be NULL */
  double cfl, fixed_dt;                  /* fixed_dt > 0: every step is this long */
  double skin;                           /* reach = (1 + skin) support */
  bool cull, check;
  int reorder_every; /* lifecycles between checks of the curve order, 0: never */

  /* Its own. */
  double time;
  uint64_t step;
  double dt;           /* of the last step */
  const char *limiter; /* what limited it, and the node that did (-1: none) */
  int64_t limiting_node;
  struct kith_vote vote; /* for the next step */
  uint64_t since_reorder;
  struct kith_field *energy_base, *position_base;
  /* What lasting lists were made from; NULL if lists do not last. Coordinates are scalars: a node that is mirrored since then
   * has moved, the place has not. */
  struct kith_field *built[NDIM], *built_reach, *built_support;
  bool resuming; /* the lists of a restarted run are being made again: with built_reach */
  struct kith_requirements need;
  struct kith_ledger ledger;
  uint8_t *keep; /* scratch of the lifecycle */
  kith_index *renumber;
  size_t keep_capacity, renumber_capacity;
};

/* Registers fields. The members that the caller sets must be there. */
kith_status kith_integrator_init(struct kith_integrator *integrator);
void kith_integrator_clear(struct kith_integrator *integrator);

/* First rates: solves the supports from their guesses. Call once before the first step of a new run. */
kith_status kith_integrator_start(struct kith_integrator *integrator);
/* Makes the lists of a restarted run again, bit for bit. Fields, time, step, dt, kicked and vote are restored by the caller. */
kith_status kith_integrator_resume(struct kith_integrator *integrator);
/* One step, not beyond `until`. DIVERGED if the state leaves the physical range or the step collapses. */
kith_status kith_integrator_step(struct kith_integrator *integrator, double until);

/* For schemes. Ghosts, neighbors, connectivity if due, then the package's rates. */
kith_status kith_integrator_rates(struct kith_integrator *integrator);
/* v += dt a. */
void kith_kick_velocity(struct kith_integrator *integrator, double dt);
/* u += dt (rate + (kicked + dt / 2) slope); kicked += dt. */
void kith_kick_energy(struct kith_integrator *integrator, double dt);
/* x += dt v; supports follow the expansion: H *= exp(dt div v / d). */
void kith_drift(struct kith_integrator *integrator, const struct kith_field *velocity, double dt);
void kith_field_copy(const struct kith_nodes *nodes, struct kith_field *to, const struct kith_field *from);

/* lifecycle.c */
void kith_lifecycle_demands(const struct kith_integrator *integrator,
                            struct kith_demand demand[KITH_DEMANDS]);
kith_status kith_lifecycle(struct kith_integrator *integrator, const char *reason);

size_t kith_integrator_bytes(const struct kith_integrator *integrator);

#endif
