/* rebuild.h - when ghosts, searches and connectivity are rebuilt: a family of policies (`kith list rebuild`),
 * joined by OR. With `displacement` the lists are Verlet lists with a skin (policies/cover.h).
 *
 * The enum of reasons, the ledger and its report are sized by KITH_REBUILD_LIST. Where no policy of an OR
 * promises that the lists hold every significant pair (`never` and `entity-change` do not), the check ends
 * the run with STALE as soon as they may not: a run never continues with lists that miss pairs. */
#ifndef KITH_CONNECTIVITY_POLICIES_REBUILD_H
#define KITH_CONNECTIVITY_POLICIES_REBUILD_H

#include "lib/connectivity/policies/cover.h"
#include "lib/core/param.h"

#ifndef KITH_REBUILD_LIST /* a test adds a member */
#define KITH_REBUILD_LIST(X) X(always) X(never) X(entity_change) X(displacement)
#endif

/* Reasons that are no policy: there are no lists yet; a support outgrew its search radius; nodes or a face
 * moved within a step; the caller requested it; some nodes are active, and only what is near them was
 * updated. */
#define KITH_REBUILD_CAUSE_LIST(X) X(first_build) X(support) X(stage) X(requested) X(selected)

enum kith_rebuild_reason {
  KITH_BECAUSE_none,
#define X(name) KITH_BECAUSE_##name,
  KITH_REBUILD_CAUSE_LIST(X) KITH_REBUILD_LIST(X)
#undef X
      KITH_REBUILD_REASONS
};
/* "none", "first_build", ... */
const char *kith_rebuild_reason_name(enum kith_rebuild_reason reason);
#define X(name) +1
enum { KITH_REBUILD_POLICIES = 0 KITH_REBUILD_LIST(X) };
#undef X

struct kith_rebuild;

struct kith_rebuild_ops {
  const char *name, *doc;
  const struct kith_param *params; /* its own parameters (policy->settings), NULL: none */
  size_t settings_size;
  bool covers;     /* fires before the lists could miss a pair, or after a far drift (cover.h) */
  bool every_step; /* fires whatever happened */
  /* Does the policy fire for a reason of its own? This is the answer of one rank; if one fires, all ranks
   * rebuild. It must be a function of the nodes and of the snapshot alone: a restart takes a new snapshot,
   * and would otherwise rebuild at other steps. Never called before a snapshot. NULL: it has no such
   * reason. */
  bool (*needs_rebuild)(const struct kith_rebuild *policy, const struct kith_nodes *nodes);
  /* Remembers in policy->self what the lists were made from, and forgets it. NULL: nothing to remember. */
  kith_status (*snapshot)(struct kith_rebuild *policy, const struct kith_nodes *nodes);
  void (*destroy)(struct kith_rebuild *policy);
};

struct kith_rebuild {
  const struct kith_rebuild_ops *ops;
  enum kith_rebuild_reason reason; /* for which it fires */
  void *settings;                  /* what its params fill; NULL if it has none */
  void *self;
};

#define X(name) extern const struct kith_rebuild_ops kith_rebuild_##name;
KITH_REBUILD_LIST(X)
#undef X
KITH_FAMILY_FUNCTIONS(kith_rebuild);

/* An OR of policies. */
struct kith_rebuilds {
  int n;
  struct kith_rebuild policy[KITH_REBUILD_POLICIES];
  struct kith_cover cover;
  bool keeps_cover; /* some policy lets lists last, or the caller asks kith_rebuilds_covered */
  bool snapshot_taken;
};
/* From words joined by "|": "displacement | entity-change". Settings of a policy follow a colon:
 * "name:key=value key=value | never". BAD_INPUT for unknown names and keys. period[NDIM]: lengths of periodic
 * axes, 0 for the others; NULL: no axis is periodic. */
kith_status kith_rebuilds_create(struct kith_rebuilds *out, const char *words, const double *period);
void kith_rebuilds_clear(struct kith_rebuilds *rebuilds);
/* The reason for which a rebuild is due whatever happened: first_build if there is no snapshot, that of the
 * first policy if it fires every step, else none. */
enum kith_rebuild_reason kith_rebuilds_certain(const struct kith_rebuilds *rebuilds);
/* Is a rebuild due, and why? *reason: the first policy that fires, first_build if there is no snapshot, none.
 * STALE if none fires, none covers, and the lists may miss a pair. Collective: due on one rank is due on all.
 * `status`: of this rank so far; agreed on. */
kith_status kith_rebuilds_check(struct kith_rebuilds *rebuilds, const struct kith_nodes *nodes,
                                kith_status status, enum kith_rebuild_reason *reason);
/* May the lists be rebuilt within a step, because they may miss pairs? STALE, "WHY, and ...", if no policy
 * fires before they could: whoever chose such policies wants no other lists. id: of the node that is why; -1:
 * of none. Collective where it refuses. */
kith_status kith_rebuilds_allow(const struct kith_rebuilds *rebuilds, const struct kith_nodes *nodes,
                                int64_t id, const char *why);
/* Do the lists hold every significant pair? keeps_cover must be set. Collective; status: as above. */
kith_status kith_rebuilds_covered(struct kith_rebuilds *rebuilds, const struct kith_nodes *nodes,
                                  kith_status status, bool *covered);
/* After a rebuild: all policies take a new snapshot of this rank, also those that were not asked. Then the
 * ranks must agree on the status and on what kith_rebuilds_shared returns. */
kith_status kith_rebuilds_take(struct kith_rebuilds *rebuilds, const struct kith_nodes *nodes);
struct kith_shared kith_rebuilds_shared(struct kith_rebuilds *rebuilds);
/* kith_rebuilds_take, and the agreement of the ranks. Collective. */
kith_status kith_rebuilds_snapshot(struct kith_rebuilds *rebuilds, const struct kith_nodes *nodes);
/* Do lists outlive a step under these policies? */
bool kith_rebuilds_lasting(const struct kith_rebuilds *rebuilds);

#endif
