/* Rebuild policy `entity-change`: the sequence of internal nodes differs from that of the last lists. */
#include <string.h>
#include "lib/connectivity/policies/rebuild.h"

struct entities {
  kith_index n, capacity;
  int n_lists;
  kith_index count[KITH_MAX_LISTS];
  int64_t *id; /* [n] */
};

static kith_status create(struct kith_rebuild *policy) {
  return kith_resize(&policy->self, 0, 1, sizeof(struct entities));
}

static void destroy(struct kith_rebuild *policy) {
  struct entities *saved = policy->self;
  if (saved != NULL) kith_free(&saved->id);
  kith_free(&policy->self);
}

static bool needs_rebuild(const struct kith_rebuild *policy, const struct kith_cover *cover,
                          const struct kith_nodes *nodes) {
  const struct entities *saved = policy->self;
  (void)cover;
  if (saved->n != nodes->n_internal || saved->n_lists != nodes->n_lists) return true;
  for (int l = 0; l < nodes->n_lists; ++l)
    if (saved->count[l] != nodes->lists[l].count) return true;
  return saved->n > 0 && memcmp(saved->id, nodes->id->i64, (size_t)saved->n * sizeof *saved->id) != 0;
}

static kith_status snapshot(struct kith_rebuild *policy, const struct kith_nodes *nodes) {
  struct entities *saved = policy->self;
  const kith_index n = nodes->n_internal;
  if (n > saved->capacity) {
    KITH_TRY(kith_resize(&saved->id, 0, (size_t)n, sizeof *saved->id));
    saved->capacity = n;
  }
  saved->n = n;
  saved->n_lists = nodes->n_lists;
  for (int l = 0; l < nodes->n_lists; ++l) saved->count[l] = nodes->lists[l].count;
  if (n > 0) memcpy(saved->id, nodes->id->i64, (size_t)n * sizeof *saved->id);
  return KITH_OK;
}

const struct kith_rebuild_ops kith_rebuild_entity_change = {
    .name = "entity-change",
    .doc = "nodes were added, deleted or reordered; alone, the run stops when the lists could miss a pair",
    .create = create,
    .destroy = destroy,
    .needs_rebuild = needs_rebuild,
    .snapshot = snapshot};
