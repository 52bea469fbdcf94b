/* integrator.h - the step: lifecycle, time-step control, schemes.
 *
 *   requirements -> is a rebuild due -> ghosts -> neighbors -> connectivity -> cull -> patch -> ready -> scheme
 *
 * kith_lifecycle (lifecycle.c) is the design in one function. A scheme moves the state and asks for rates through
 * kith_integrator_rates, which runs the lifecycle if one is due at the present positions, else only refreshes
 * ghost values.
 *
 * Schemes: our own (schemes.c), ERKStep of SUNDIALS' ARKODE (arkode.c), theta methods by its KINSOL (implicit.c). The last two
 * hold vectors (vector.h) that know nothing of nodes: while they do, nodes are neither reordered nor put back (stages.h). */
#ifndef KITH_INTEGRATOR_INTEGRATOR_H
#define KITH_INTEGRATOR_INTEGRATOR_H

#include "boundaries/boundary.h"
#include "lib/connectivity/connectivity.h"
#include "lib/connectivity/rebuild.h"
#include "lib/core/profile.h"
#include "lib/domain/share.h"
#include "lib/neighbor/search.h"
#include "physics/package.h"

struct kith_integrator;

struct kith_scheme_ops {
  const char *name, *doc;
  int evaluations;          /* of the rates, per step; a first guess where a solver decides */
  const char *incompatible; /* why a compatible energy would not be kept; NULL: it is */
  bool implicit;            /* may be asked for Courant numbers above 1 */
  /* Fields, settings that are checked (BAD_INPUT), private state in integrator->self. NULL: nothing of this. */
  kith_status (*create)(struct kith_integrator *integrator);
  void (*destroy)(struct kith_integrator *integrator);
  /* Advances all state from time to time + *dt. It may take a shorter step: then it sets *dt to what it took, and
   * integrator->limiter to why. The rates of the last evaluation are there on entry (and after): those of the present state,
   * unless the scheme evaluates in the middle. */
  kith_status (*step)(struct kith_integrator *integrator, double *dt);
  size_t (*bytes)(const struct kith_integrator *integrator); /* of the private state; NULL: none */
};

#define KITH_SCHEME_LIST(X) X(leapfrog) X(rk2) X(cheap_rk2) X(verlet) X(rk4) X(arkode) X(implicit)
#define X(name) extern const struct kith_scheme_ops kith_scheme_##name;
KITH_SCHEME_LIST(X)
#undef X
const struct kith_scheme_ops *kith_scheme_find(
    const char *name); /* '-' and '_' are the same; NULL if there is none */
const struct kith_scheme_ops *const *kith_scheme_all(void);

/* Runge-Kutta tables of ARKODE: its constant without ARKODE_, word of the scene. */
#define KITH_TABLE_LIST(X)                          \
  X(HEUN_EULER_2_1_2, heun_euler_2_1_2)             \
  X(BOGACKI_SHAMPINE_4_2_3, bogacki_shampine_4_2_3) \
  X(ARK324L2SA_ERK_4_2_3, ark324l2sa_erk_4_2_3)     \
  X(KNOTH_WOLKE_3_3, knoth_wolke_3_3)               \
  X(ZONNEVELD_5_3_4, zonneveld_5_3_4)               \
  X(ARK436L2SA_ERK_6_3_4, ark436l2sa_erk_6_3_4)     \
  X(ARK437L2SA_ERK_7_3_4, ark437l2sa_erk_7_3_4)     \
  X(SAYFY_ABURUB_6_3_4, sayfy_aburub_6_3_4)         \
  X(CASH_KARP_6_4_5, cash_karp_6_4_5)               \
  X(FEHLBERG_6_4_5, fehlberg_6_4_5)                 \
  X(DORMAND_PRINCE_7_4_5, dormand_prince_7_4_5)     \
  X(ARK548L2SA_ERK_8_4_5, ark548l2sa_erk_8_4_5)     \
  X(ARK548L2SAb_ERK_8_4_5, ark548l2sab_erk_8_4_5)   \
  X(VERNER_8_5_6, verner_8_5_6)                     \
  X(FEHLBERG_13_7_8, fehlberg_13_7_8)
struct kith_table {
  int stages, order, embedded; /* orders; embedded 0: no error estimate */
  int evaluations;             /* of the rates, per step: the first stage has those of the last step's end */
  bool ends;                   /* its last stage is at the end of the step, with the state of the end */
};
/* As the list has it: lower case, '_', without ARKODE_ in front. */
void kith_table_word(const char *name, char *word, size_t size);
/* BAD_INPUT if there is no table of that name, in any of its spellings. */
kith_status kith_table_read(struct kith_table *table, const char *name);

/* A step that the state limits is at most this much longer than the last. */
#define KITH_GROWTH 1.25

/* What happened, summed over the run (and the last lifecycle, where said); nothing but uint64_t, for checkpoints. created = culled + kept, for each boundary. */
struct kith_ledger {
  uint64_t lifecycles, support_rebuilds, reorders, refreshes;
  uint64_t cut;                   /* pairs that barriers cut */
  uint64_t evaluations, rejected; /* of the rates; steps that were tried again with a shorter dt */
  uint64_t because[5];            /* first build, then policies in the order of KITH_REBUILD_LIST */
  uint64_t created, culled, kept; /* ghosts */
  uint64_t candidates, row_entries, pairs;
  struct {
    uint64_t created, culled, kept;
  } boundary[2 * NDIM + 8];
  uint64_t ghosts, last_entries, last_pairs; /* of the last lifecycle */
};

/* Of all ranks: ghosts, lists and pairs are summed (a pair between ranks counts twice), what all do together counts once. Collective. */
struct kith_ledger kith_ledger_of_all(const struct kith_ledger *ledger, struct kith_ranks *ranks);
/* What this rank keeps of the ledger of all, so that their sum is that: sums are kept by rank 0. */
struct kith_ledger kith_ledger_share(const struct kith_ledger *all, const struct kith_ranks *ranks);

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
  struct kith_share *share; /* of the nodes of several ranks (nodes->ranks); NULL: there is one process */
  bool canonical; /* rows and pairs are in an order that all numbers of ranks share; nodes number their images */
  double cfl, fixed_dt; /* fixed_dt > 0: every step is this long */
  double skin;          /* reach = (1 + skin) support */
  bool cull, check;
  int reorder_every; /* lifecycles between checks of the curve order, 0: never */
  struct kith_stepping {
    const char *table; /* of arkode */
    bool adaptive;     /* arkode: dt by the error estimate too; not with fixed_dt */
    double rtol, atol; /* of errors (arkode) or residuals (implicit): see kith_stages_weights */
    double theta;      /* implicit: 1/2 Crank-Nicolson, 1 backward Euler */
  } stepping;

  /* Its own. */
  double time;
  double clock; /* the time of the positions, within a step too: what faces that move go by */
  uint64_t step;
  double dt;           /* of the last step */
  double accurate_dt;  /* what the last error estimate allows for the next step, 0: no opinion */
  const char *limiter; /* what limited it, and the node that did (-1: none) */
  int64_t limiting_node;
  struct kith_vote vote; /* for the next step */
  uint64_t since_reorder;
  struct kith_field *energy_base;
  /* What lasting lists were made from; NULL if lists do not last. Coordinates are scalars: a node that is mirrored since then
   * has moved, the place has not. */
  struct kith_field *built[NDIM], *built_reach, *built_support;
  bool resuming; /* lists are being made again as they were: with built_reach */
  bool holding;  /* there are vectors of the state beside the fields: nodes stay in their places and frames */
  const char *due; /* why the lists must be made anew, whatever the policies say; NULL: ask them */
  void *self;      /* of the scheme */
  int evaluations; /* of the rates, per step; with implicit a guess */
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
/* Supports follow the expansion for a time dt: H *= exp(dt div v / d). */
void kith_drift_supports(struct kith_integrator *integrator, double dt);
/* x += dt v, and the supports. */
void kith_drift(struct kith_integrator *integrator, const struct kith_field *velocity, double dt);
void kith_field_copy(const struct kith_nodes *nodes, struct kith_field *to, const struct kith_field *from);

/* Makes the lists again that `built` tells of. The two fields are used up. */
kith_status kith_integrator_remake(struct kith_integrator *integrator, struct kith_field *vector_scratch,
                                   struct kith_field *scalar_scratch);

/* lifecycle.c */
/* Puts nodes back where boundaries want them, and in order if that is due. Not while vectors are held. */
kith_status kith_lifecycle_settle(struct kith_integrator *integrator);
void kith_lifecycle_demands(const struct kith_integrator *integrator,
                            struct kith_demand demand[KITH_DEMANDS]);
kith_status kith_lifecycle(struct kith_integrator *integrator, const char *reason);

size_t kith_integrator_bytes(const struct kith_integrator *integrator);

#endif
