/* Selecting a partitioner, weights and updates. */
#include "lib/domain/partition/partition.h"

#include <string.h>

#include "lib/core/family.h"

#define X(name) &kith_partitioner_##name,
KITH_FAMILY(kith_partitioner, KITH_PARTITIONER_LIST(X))
#undef X

/* ---- life ---- */

static kith_status start(struct kith_partition *partition, const char *text) {
  int member;
  KITH_TRY(kith_family_choose(kith_partitioner_member, "partitioner", text, strlen(text), &member,
                              &partition->settings));
  const struct kith_partitioner_ops *ops = partition->ops = kith_partitioner_all()[member];
  if (ops->needs != NULL)
    KITH_FAIL(UNSUPPORTED, "partitioner '%s': this kith was built without %s", ops->name, ops->needs);
  KITH_TRY(kith_resize(&partition->owner, 0, (size_t)partition->cells->n, sizeof *partition->owner));
  if (ops->state_size > 0) KITH_TRY(kith_resize(&partition->self, 0, 1, ops->state_size));
  return ops->first != NULL ? ops->first(partition, partition->owner)
                            : ops->update(partition, NULL, partition->owner);
}

kith_status kith_partition_create(struct kith_partition **out, const struct kith_cells *cells, int n_ranks,
                                  const char *text) {
  *out = NULL;
  if (n_ranks < 1) KITH_FAIL(BAD_INPUT, "a partition for %d ranks", n_ranks);
  struct kith_partition *made = NULL;
  KITH_TRY(kith_resize(&made, 0, 1, sizeof *made));
  *made = (struct kith_partition){.cells = cells, .n_ranks = n_ranks, .generation = 1};
  const kith_status status = start(made, text);
  if (status == KITH_OK)
    *out = made;
  else
    kith_partition_destroy(&made);
  return status;
}

void kith_partition_destroy(struct kith_partition **partition) {
  struct kith_partition *p = *partition;
  if (p == NULL) return;
  if (p->self != NULL && p->ops->clear != NULL) p->ops->clear(p);
  KITH_FREE(&p->self, &p->settings, &p->owner);
  kith_free(partition);
}

/* ---- update ---- */

/* Weights with the work of an empty cell added, of mean 1; exactly 1 if all are equal, so that the present
 * map is kept. */
static void effective_weights(const double *weight, int64_t n, double *effective) {
  double largest = 0, sum = 0;
  for (int64_t c = 0; weight != NULL && c < n; ++c) largest = KITH_MAX(largest, weight[c]);
  for (int64_t c = 0; c < n; ++c) sum += effective[c] = largest > 0 ? weight[c] / largest : 1;
  const double mean = sum / (double)n;
  for (int64_t c = 0; c < n; ++c)
    effective[c] = (effective[c] / mean + KITH_EMPTY_CELL) / (1 + KITH_EMPTY_CELL);
}

static kith_status update_into(struct kith_partition *partition, const double *weight, double *effective,
                               int32_t *owner, bool *changed) {
  const int64_t n = partition->cells->n;
  effective_weights(weight, n, effective);
  memcpy(owner, partition->owner, (size_t)n * sizeof *owner);
  KITH_TRY(partition->ops->update(partition, effective, owner));
  *changed = memcmp(owner, partition->owner, (size_t)n * sizeof *owner) != 0;
  if (!*changed) return KITH_OK;
  memcpy(partition->owner, owner, (size_t)n * sizeof *owner);
  ++partition->generation;
  return KITH_OK;
}

kith_status kith_partition_update(struct kith_partition *partition, const double *weight, bool *changed) {
  const int64_t n = partition->cells->n;
  *changed = false;
  for (int64_t c = 0; weight != NULL && c < n; ++c)
    if (!(weight[c] >= 0 && weight[c] < INFINITY))
      KITH_FAIL(BAD_INPUT, "weight of cell %lld is %g: not a finite number of at least 0", (long long)c,
                weight[c]);
  if (partition->ops->update == NULL || partition->n_ranks == 1) return KITH_OK;
  double *effective = NULL;
  int32_t *owner = NULL;
  kith_status status = kith_resize(&effective, 0, (size_t)n, sizeof *effective);
  if (status == KITH_OK) status = kith_resize(&owner, 0, (size_t)n, sizeof *owner);
  if (status == KITH_OK) status = update_into(partition, weight, effective, owner, changed);
  KITH_FREE(&effective, &owner);
  return status;
}

double kith_partition_loads(const struct kith_partition *partition, const int32_t *owner,
                            const double *weight, double *load) {
  double most = 0, sum = 0;
  for (int r = 0; r < partition->n_ranks; ++r) load[r] = 0;
  for (int64_t c = 0; c < partition->cells->n; ++c) load[owner[c]] += weight == NULL ? 1 : weight[c];
  for (int r = 0; r < partition->n_ranks; ++r) most = KITH_MAX(most, load[r]), sum += load[r];
  return sum > 0 ? most * partition->n_ranks / sum : 1;
}

/* ---- restarts ---- */

size_t kith_partition_state(const struct kith_partition *partition, int64_t *word) {
  return partition->ops->state != NULL ? partition->ops->state(partition, word) : 0;
}

kith_status kith_partition_restore(struct kith_partition *partition, const int64_t *word, size_t n) {
  if (n != kith_partition_state(partition, NULL))
    KITH_FAIL(BAD_FILE, "partitioner '%s' has a state of %zu words; the file has %zu", partition->ops->name,
              kith_partition_state(partition, NULL), n);
  return n > 0 ? partition->ops->restore(partition, word) : KITH_OK;
}

kith_status kith_partition_converge(struct kith_partition *partition, const double *weight) {
  enum { MOST_MAPS = 20 };
  bool changed = true;
  for (int k = 0; k < MOST_MAPS && changed; ++k) KITH_TRY(kith_partition_update(partition, weight, &changed));
  return KITH_OK;
}
