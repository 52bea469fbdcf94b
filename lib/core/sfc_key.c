/* Keys of positions, and the order of space-filling-curve keys, with ties broken by a second number. */
#include "lib/core/sfc_key.h"

void kith_sfc_keys(const double *x, kith_index n, const double *lower, const double *upper, uint64_t *key) {
  double inverse_cell[NDIM];
  for (int a = 0; a < NDIM; ++a)
    inverse_cell[a] =
        upper[a] > lower[a] ? (double)(UINT64_C(1) << KITH_SFC_KEY_BITS) / (upper[a] - lower[a]) : 0;
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < n; ++i)
    key[i] = kith_sfc_key_of_position(x + (size_t)i * NDIM, lower, inverse_cell);
}

static inline bool in_order(const uint64_t *key, const int64_t *tie, size_t a, size_t b) {
  return key[a] < key[b] || (key[a] == key[b] && (tie == NULL || tie[a] <= tie[b]));
}

/* Orders each run of equal keys by tie; `spare` has room for it. */
static kith_status sort_ties(size_t n, const int64_t *tie, struct kith_keyed *item,
                             struct kith_keyed *spare) {
  for (size_t first = 0, end; first < n; first = end) {
    for (end = first + 1; end < n && item[end].key == item[first].key;) ++end;
    if (end - first == 1) continue;
    /* Ties are ordered as signed numbers: the flipped sign bit puts the negative ones first. */
    for (size_t i = first; i < end; ++i) item[i].key = (uint64_t)tie[item[i].node] ^ (UINT64_C(1) << 63);
    KITH_TRY(kith_keyed_sort(item + first, spare, end - first));
  }
  return KITH_OK;
}

kith_status kith_sfc_key_sort(size_t n, const uint64_t *key, const int64_t *tie, struct kith_keyed *scratch,
                              kith_index *order) {
  if (n > INT32_MAX) KITH_FAIL(UNSUPPORTED, "cannot sort %zu keys: more than an index counts", n);
  size_t ordered = 1;
  while (ordered < n && in_order(key, tie, ordered - 1, ordered)) ++ordered;
  if (ordered >= n) {
    for (size_t i = 0; i < n; ++i) order[i] = (kith_index)i;
    return KITH_OK;
  }
  struct kith_keyed *item = scratch, *spare = scratch + n;
#pragma omp parallel for schedule(static) if (n > KITH_FEW_COPIES)
  for (size_t i = 0; i < n; ++i) item[i] = (struct kith_keyed){key[i], (kith_index)i};
  KITH_TRY(kith_keyed_sort(item, spare, n));
  if (tie != NULL) KITH_TRY(sort_ties(n, tie, item, spare));
#pragma omp parallel for schedule(static) if (n > KITH_FEW_COPIES)
  for (size_t i = 0; i < n; ++i) order[i] = item[i].node;
  return KITH_OK;
}
