/* Radix sort of space-filling-curve keys, with ties broken by a second number. */
#include "lib/core/sfc_key.h"

#include <omp.h>
#include <string.h>

enum { DIGIT = 11, BINS = 1 << DIGIT, MAX_CHUNKS = 64, SHORT_RUN = 32, ITEMS_PER_CHUNK = 8192 };

struct item {
  uint64_t key;
  kith_index number;
};

static inline bool in_order(const uint64_t *key, const int64_t *tie, size_t a, size_t b) {
  return key[a] < key[b] || (key[a] == key[b] && (tie == NULL || tie[a] <= tie[b]));
}

/* A stable sort gives the same order for any number of chunks, so that number may follow the threads. */
static size_t chunks_for(size_t n) {
  const size_t wanted = 1 + n / ITEMS_PER_CHUNK;
  const size_t most = KITH_MIN((size_t)omp_get_max_threads(), (size_t)MAX_CHUNKS);
  return KITH_MIN(wanted, most);
}

/* Turns counts[chunk][digit] into the place of the first item of that digit and chunk. */
static void counts_to_places(size_t chunks, size_t (*counts)[BINS]) {
  size_t place = 0;
  for (size_t d = 0; d < BINS; ++d)
    for (size_t c = 0; c < chunks; ++c) {
      const size_t count = counts[c][d];
      counts[c][d] = place;
      place += count;
    }
}

/* One stable pass on the digit at `shift`: counts, places, scatter. */
static void radix_pass(size_t n, const struct item *restrict from, struct item *restrict to, int shift,
                       size_t chunks, size_t (*counts)[BINS]) {
#pragma omp parallel for schedule(static) if (chunks > 1)
  for (size_t c = 0; c < chunks; ++c) {
    memset(counts[c], 0, sizeof counts[c]);
    for (size_t i = n * c / chunks; i < n * (c + 1) / chunks; ++i)
      ++counts[c][from[i].key >> shift & (BINS - 1)];
  }
  counts_to_places(chunks, counts);
#pragma omp parallel for schedule(static) if (chunks > 1)
  for (size_t c = 0; c < chunks; ++c)
    for (size_t i = n * c / chunks; i < n * (c + 1) / chunks; ++i)
      to[counts[c][from[i].key >> shift & (BINS - 1)]++] = from[i];
}

/* Sorts items by key; equal keys keep their order. The result is in items[0] or items[1]: its place is
 * returned. */
static int radix_sort(size_t n, struct item *const items[2], size_t chunks, size_t (*counts)[BINS]) {
  uint64_t differing = 0;
  for (size_t i = 1; i < n; ++i) differing |= items[0][i].key ^ items[0][0].key;
  int now = 0;
  for (int shift = 0; shift < 64; shift += DIGIT) {
    if ((differing >> shift & (BINS - 1)) == 0) continue;
    radix_pass(n, items[now], items[1 - now], shift, chunks, counts);
    now = 1 - now;
  }
  return now;
}

static void insertion_sort_by_tie(size_t n, const int64_t *tie, struct item *run) {
  for (size_t i = 1; i < n; ++i) {
    const struct item moving = run[i];
    size_t k = i;
    for (; k > 0 && tie[run[k - 1].number] > tie[moving.number]; --k) run[k] = run[k - 1];
    run[k] = moving;
  }
}

/* Orders one run of equal keys by tie; `spare` has room for it. */
static void sort_run(size_t n, const int64_t *tie, struct item *run, struct item *spare,
                     size_t (*counts)[BINS]) {
  if (n <= SHORT_RUN) {
    insertion_sort_by_tie(n, tie, run);
    return;
  }
  /* Ties are ordered as signed numbers: the flipped sign bit puts the negative ones first. */
  for (size_t i = 0; i < n; ++i) run[i].key = (uint64_t)tie[run[i].number] ^ (UINT64_C(1) << 63);
  if (radix_sort(n, (struct item *[2]){run, spare}, 1, counts) == 1) memcpy(run, spare, n * sizeof *run);
}

static void sort_ties(size_t n, const int64_t *tie, struct item *sorted, struct item *spare,
                      size_t (*counts)[BINS]) {
  for (size_t first = 0, end; first < n; first = end) {
    for (end = first + 1; end < n && sorted[end].key == sorted[first].key;) ++end;
    if (end - first > 1) sort_run(end - first, tie, sorted + first, spare, counts);
  }
}

kith_status kith_sfc_key_sort(size_t n, const uint64_t *key, const int64_t *tie, kith_index *order) {
  if (n > INT32_MAX) KITH_FAIL(UNSUPPORTED, "cannot sort %zu keys: more than an index counts", n);
  size_t ordered = 1;
  while (ordered < n && in_order(key, tie, ordered - 1, ordered)) ++ordered;
  if (ordered >= n) {
    for (size_t i = 0; i < n; ++i) order[i] = (kith_index)i;
    return KITH_OK;
  }
  const size_t chunks = chunks_for(n);
  struct item *items[2] = {NULL, NULL};
  size_t(*counts)[BINS] = NULL;
  kith_status status = kith_resize(&items[0], 0, n, sizeof *items[0]);
  if (status == KITH_OK) status = kith_resize(&items[1], 0, n, sizeof *items[1]);
  if (status == KITH_OK) status = kith_resize(&counts, 0, chunks, sizeof *counts);
  if (status == KITH_OK) {
    for (size_t i = 0; i < n; ++i) items[0][i] = (struct item){key[i], (kith_index)i};
    const int now = radix_sort(n, items, chunks, counts);
    if (tie != NULL) sort_ties(n, tie, items[now], items[1 - now], counts);
    for (size_t i = 0; i < n; ++i) order[i] = items[now][i].number;
  }
  kith_free(&items[0]);
  kith_free(&items[1]);
  kith_free(&counts);
  return status;
}
