/* group.h - targets that are close together, and their candidates. */
#ifndef KITH_CONNECTIVITY_BUILD_GROUP_H
#define KITH_CONNECTIVITY_BUILD_GROUP_H

#include "lib/connectivity/build/builder.h"

/* Fewer targets: a smaller box and fewer tests each; more: candidates are packed less often. The time is flat
 * between 16 and 48. SLOTS: those of the targets, and of idle nodes between them. */
enum { KITH_GROUP_SIZE = 32, KITH_GROUP_SLOTS = 4 * KITH_GROUP_SIZE };

/* Targets, the active nodes of a run of slots: how many, their box, and how far from it neighbors may lie. */
struct kith_group {
  struct kith_run run;
  kith_index targets;
  struct kith_extent extent;
};
struct kith_group kith_group_of(const struct kith_build *build, kith_index first, kith_index count);

/* Joins b to a if it follows in the slots and lies close by, which it does not where the curve jumps: the
 * volume in which candidates may lie must not become much larger. */
bool kith_group_join(struct kith_group *a, const struct kith_group *b);

/* Are the targets ghosts, which have no rows themselves but are entries of the rows of idle nodes? Then only
 * idle nodes are candidates. */
bool kith_group_serves_idle(const struct kith_build *build, const struct kith_group *group);

/* Finds all candidates of the group, for worker->near. Those of each shift start at a new word. self[m]: the
 * position of target m among them, -1 if it is not one of them. */
kith_status kith_group_candidates(struct kith_worker *worker, const struct kith_build *build,
                                  const struct kith_group *group, int *self);

#endif
