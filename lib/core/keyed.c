/* keyed.c - a stable parallel radix sort by key. */
#include "lib/core/keyed.h"

#include <omp.h>
#include <stdlib.h>
#include <string.h>

enum { SHORT = 20, DIGIT = 8, BINS = 1 << DIGIT, TOP_DIGIT = 11, TOP_BINS = 1 << TOP_DIGIT, MAX_CHUNKS = 64 };

kith_status kith_keyed_grow(struct kith_keyed *item[2], size_t *capacity, size_t n) {
  size_t of_scratch = *capacity;
  KITH_TRY(kith_reserve(&item[0], capacity, n, sizeof **item));
  const kith_status status = kith_reserve(&item[1], &of_scratch, n, sizeof **item);
  if (status != KITH_OK) *capacity = 0; /* of both */
  return status;
}

static inline int bit_length(uint64_t v) {
  return v ? 64 - __builtin_clzll(v) : 0;
}

static void insertion_sort(struct kith_keyed *item, size_t n) {
  for (size_t i = 1; i < n; ++i) {
    const struct kith_keyed moving = item[i];
    size_t k = i;
    for (; k > 0 && item[k - 1].key > moving.key; --k) item[k] = item[k - 1];
    item[k] = moving;
  }
}

/* Sorts a[n]; the result is wanted in b if `in_b`, else in a. */
static void sort_bin(struct kith_keyed *a, struct kith_keyed *b, size_t n, bool in_b) {
  uint64_t differing = 0;
  if (n > SHORT)
    for (size_t i = 1; i < n; ++i) differing |= a[i].key ^ a[0].key;
  if (differing == 0) {
    if (n <= SHORT) insertion_sort(a, n);
    if (in_b) memcpy(b, a, n * sizeof *a);
    return;
  }
  const int shift = KITH_MAX(bit_length(differing) - DIGIT, 0);
  uint32_t place[BINS + 1] = {0};
  for (size_t i = 0; i < n; ++i) ++place[(a[i].key >> shift & (BINS - 1)) + 1];
  for (int d = 0; d < BINS; ++d) place[d + 1] += place[d];
  for (size_t i = 0; i < n; ++i) b[place[a[i].key >> shift & (BINS - 1)]++] = a[i];
  /* place[d] is now the end of bin d. */
  for (size_t d = 0, first = 0; d < BINS; first = place[d++])
    if (place[d] > first) sort_bin(b + first, a + first, place[d] - first, !in_b);
}

/* Stable scatter of all items by the digit at `shift`; end[d] becomes the end of bin d. */
static void scatter(const struct kith_keyed *from, struct kith_keyed *to, size_t n, int shift, size_t chunks,
                    uint32_t (*place)[TOP_BINS], uint32_t *end) {
#pragma omp parallel for schedule(static) if (chunks > 1)
  for (size_t c = 0; c < chunks; ++c)
    for (size_t i = n * c / chunks; i < n * (c + 1) / chunks; ++i)
      ++place[c][from[i].key >> shift & (TOP_BINS - 1)];
  uint32_t first = 0;
  for (size_t d = 0; d < TOP_BINS; ++d) {
    for (size_t c = 0; c < chunks; ++c) {
      const uint32_t count = place[c][d];
      place[c][d] = first;
      first += count;
    }
    end[d] = first;
  }
#pragma omp parallel for schedule(static) if (chunks > 1)
  for (size_t c = 0; c < chunks; ++c)
    for (size_t i = n * c / chunks; i < n * (c + 1) / chunks; ++i)
      to[place[c][from[i].key >> shift & (TOP_BINS - 1)]++] = from[i];
}

kith_status kith_keyed_sort(struct kith_keyed *item, struct kith_keyed *scratch, size_t n) {
  if (n < TOP_BINS) {
    sort_bin(item, scratch, n, false);
    return KITH_OK;
  }
  /* The order does not depend on the chunks, so they may follow the threads. */
  const size_t chunks = (size_t)KITH_MIN(omp_get_max_threads(), MAX_CHUNKS);
  uint32_t(*place)[TOP_BINS] = NULL;
  KITH_TRY(kith_resize(&place, 0, chunks + 1, sizeof *place));
  uint32_t *const end = place[chunks];
  uint64_t differing = 0;
#pragma omp parallel for schedule(static) reduction(| : differing)
  for (size_t i = 0; i < n; ++i) differing |= item[i].key ^ item[0].key;
  scatter(item, scratch, n, KITH_MAX(bit_length(differing) - TOP_DIGIT, 0), chunks, place, end);
#pragma omp parallel for schedule(dynamic, 16)
  for (int d = 0; d < TOP_BINS; ++d) {
    const size_t first = d > 0 ? end[d - 1] : 0;
    if (end[d] > first) sort_bin(scratch + first, item + first, end[d] - first, true);
  }
  kith_free(&place);
  return KITH_OK;
}

static int compare_items(const void *a, const void *b) {
  const struct kith_keyed *p = a, *q = b;
  return p->key != q->key ? (p->key > q->key) - (p->key < q->key) : (p->node > q->node) - (p->node < q->node);
}

void kith_keyed_replace(struct kith_keyed *item, kith_index n, struct kith_keyed *in, kith_index m) {
  kith_index stay = 0;
  for (kith_index k = 0; k < n; ++k)
    if (item[k].node >= 0) item[stay++] = item[k];
  qsort(in, (size_t)m, sizeof *in, compare_items);
  for (kith_index to = n, left = m; left > 0;)
    item[--to] = stay > 0 && compare_items(&item[stay - 1], &in[left - 1]) > 0 ? item[--stay] : in[--left];
}
