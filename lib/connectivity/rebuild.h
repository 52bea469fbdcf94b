/* rebuild.h - when are ghosts, searches and connectivity made anew: a family of policies, joined by OR.
 *
 *   always         every step
 *   never          only when there is nothing yet
 *   entity-change  nodes were added, deleted or reordered (the sequence of ids and lists differs)
 *   displacement   the lists could miss a pair. They were made with R_i = (1 + skin) H_i at positions x0_i. A pair at distance
 *                  <= max(H_i, H_j) now was within R then if, for every i,
 *                        H_i + |d_i| + max_j |d_j| <= R_i,      d = x - x0 - (common drift) - (wraps),
 *                  so growth of the support counts as displacement and a periodic wrap or a uniform motion does not.
 *                  The maximum goes over all nodes of all ranks (proof in rebuild.c). The common drift is the mean displacement;
 *                  it counts as displacement along axes that ghosts of the snapshot mirror, and if some do not follow a node. Its sum is
 *                  exact (sum.h): all numbers of ranks decide alike.
 *                  R and x0 are those of the snapshot; another number of internal nodes is always due.
 *
 * After every build all policies take a new snapshot, also those that were not asked. */
#ifndef KITH_CONNECTIVITY_REBUILD_H
#define KITH_CONNECTIVITY_REBUILD_H

#include "lib/nodes/nodes.h"

struct kith_rebuild;

struct kith_rebuild_ops {
  const char *name, *doc;
  kith_status (*create)(struct kith_rebuild *policy);
  void (*destroy)(struct kith_rebuild *policy);
  /* Is a rebuild due? Never called before a snapshot. */
  kith_status (*due)(const struct kith_rebuild *policy, const struct kith_nodes *nodes, bool *due);
  /* Remembers what the lists were made from. */
  kith_status (*snapshot)(struct kith_rebuild *policy, const struct kith_nodes *nodes);
};

struct kith_rebuild {
  const struct kith_rebuild_ops *ops;
  double period[NDIM]; /* length of a periodic axis, 0 for the others: wraps are no displacement */
  void *self;
};

#define KITH_REBUILD_LIST(X) X(always) X(never) X(entity_change) X(displacement)
#define X(name) extern const struct kith_rebuild_ops kith_rebuild_##name;
KITH_REBUILD_LIST(X)
#undef X
const struct kith_rebuild_ops *kith_rebuild_find(const char *name); /* '-' and '_' are the same */
const struct kith_rebuild_ops *const *kith_rebuild_all(void);

/* An OR of policies. */
struct kith_rebuilds {
  int n;
  struct kith_rebuild policy[4];
  bool snapshot_taken;
};
/* From words joined by "|": "displacement | entity-change". BAD_INPUT for an unknown word. */
kith_status kith_rebuilds_create(struct kith_rebuilds *out, const char *words, const double *period);
void kith_rebuilds_clear(struct kith_rebuilds *rebuilds);
/* Collective, as all that follows a decision: due on one rank is due on all.
 * *reason: the name of the policy that fired ("first build" if there is no snapshot), NULL if none did. */
kith_status kith_rebuilds_due(const struct kith_rebuilds *rebuilds, const struct kith_nodes *nodes,
                              const char **reason);
kith_status kith_rebuilds_snapshot(struct kith_rebuilds *rebuilds, const struct kith_nodes *nodes);
/* The next due says yes. */
void kith_rebuilds_invalidate(struct kith_rebuilds *rebuilds);
/* Do lists outlive a step under these policies? (false if `always` is among them) */
bool kith_rebuilds_lasting(const struct kith_rebuilds *rebuilds);

#endif
