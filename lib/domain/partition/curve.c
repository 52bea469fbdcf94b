/* curve.c - partitions that cut a curve through all cells into pieces of equal weight. */
#include "lib/domain/partition/partition.h"

#include "lib/core/sfc_key.h"

/* The rank of a cell is the one of n_ranks equal intervals of the accumulated weight in which the middle of
 * the cell's weight lies, so that no rank exceeds the mean by more than one cell. weight NULL: equal. */
kith_status kith_curve_update(struct kith_partition *partition, const double *weight, int32_t *owner) {
  const struct kith_curve *curve = partition->self;
  const kith_index *order = curve->order;
  double total = 0, before = 0;
  for (int64_t k = 0; k < partition->cells->n; ++k) total += weight == NULL ? 1 : weight[order[k]];
  for (int64_t k = 0; k < partition->cells->n; ++k) {
    const double w = weight == NULL ? 1 : weight[order[k]];
    const double interval = (before + 0.5 * w) / total * partition->n_ranks;
    owner[order[k]] = (int32_t)KITH_MIN(interval, partition->n_ranks - 1);
    before += w;
  }
  return KITH_OK;
}

kith_status kith_curve_first(struct kith_partition *partition, const uint64_t *key, int32_t *owner) {
  struct kith_curve *curve = partition->self;
  const int64_t n = partition->cells->n;
  KITH_TRY(kith_resize(&curve->order, 0, (size_t)n, sizeof *curve->order));
  struct kith_keyed *scratch = NULL;
  KITH_TRY(kith_resize(&scratch, 0, 2 * (size_t)n, sizeof *scratch));
  const kith_status status = kith_sfc_key_sort((size_t)n, key, NULL, scratch, curve->order);
  kith_free(&scratch);
  return status == KITH_OK ? kith_curve_update(partition, NULL, owner) : status;
}

void kith_curve_clear(struct kith_partition *partition) {
  struct kith_curve *curve = partition->self;
  kith_free(&curve->order);
}

kith_status kith_curve_first_by_key(struct kith_partition *partition, int32_t *owner) {
  const struct kith_cells *cells = partition->cells;
  uint64_t *key = NULL;
  KITH_TRY(kith_resize(&key, 0, (size_t)cells->n, sizeof *key));
  for (int64_t c = 0; c < cells->n; ++c) {
    int64_t k[NDIM];
    uint64_t at[NDIM];
    kith_grid_place(cells->count, c, k);
    for (int a = 0; a < NDIM; ++a) at[a] = (uint64_t)k[a];
    key[c] = partition->ops->key_of(at);
  }
  const kith_status status = kith_curve_first(partition, key, owner);
  kith_free(&key);
  return status;
}
