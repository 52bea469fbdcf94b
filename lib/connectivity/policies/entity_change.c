/* Rebuild policy `entity-change`: the sequence of internal nodes differs from that of the last lists. */
#include <string.h>
#include "lib/connectivity/policies/rebuild.h"

struct entities {
  kith_index n, count[KITH_MAX_LISTS];
  int64_t *id; /* [n] */
  size_t capacity;
};

static bool needs_rebuild(const struct kith_rebuild *policy, const struct kith_nodes *nodes) {
  const struct entities *before = policy->self;
  for (int l = 0; l < nodes->n_lists; ++l)
    if (before->count[l] != nodes->lists[l].count) return true;
  return before->n != nodes->n_internal ||
         (before->n > 0 && memcmp(before->id, nodes->id->i64, (size_t)before->n * sizeof *before->id) != 0);
}

static kith_status snapshot(struct kith_rebuild *policy, const struct kith_nodes *nodes) {
  const size_t n = (size_t)nodes->n_internal;
  if (policy->self == NULL) KITH_TRY(kith_resize(&policy->self, 0, 1, sizeof(struct entities)));
  struct entities *now = policy->self;
  KITH_TRY(kith_reserve(&now->id, &now->capacity, n, sizeof *now->id));
  now->n = nodes->n_internal;
  for (int l = 0; l < nodes->n_lists; ++l) now->count[l] = nodes->lists[l].count;
  if (n > 0) memcpy(now->id, nodes->id->i64, n * sizeof *now->id);
  return KITH_OK;
}

static void destroy(struct kith_rebuild *policy) {
  KITH_FREE(&((struct entities *)policy->self)->id, &policy->self);
}

const struct kith_rebuild_ops kith_rebuild_entity_change = {
    .name = "entity-change",
    .doc = "nodes were added, deleted or reordered; alone, the run stops when the lists could miss a pair",
    .needs_rebuild = needs_rebuild,
    .snapshot = snapshot,
    .destroy = destroy};
