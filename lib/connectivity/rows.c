/* rows.c - compressed rows: memory, offsets, and dropping entries in place. */
#include "lib/connectivity/rows.h"

#include <string.h>

kith_status kith_rows_reserve(struct kith_rows *rows, kith_index n) {
  KITH_TRY(kith_reserve(&rows->first, &rows->rows_capacity, (size_t)n + 1, sizeof *rows->first));
  rows->first[0] = 0;
  rows->n = n;
  return KITH_OK;
}

kith_status kith_rows_sum(struct kith_rows *rows, int zero) {
  for (kith_index i = 0; i < rows->n; ++i) rows->first[i + 1] += rows->first[i];
  KITH_TRY(kith_reserve(&rows->node, &rows->entries_capacity, rows->first[rows->n], sizeof *rows->node));
  rows->zero = KITH_MAX(zero, 0);
  if (zero >= 0)
    return kith_reserve(&rows->shift, &rows->shifts_capacity, rows->first[rows->n], sizeof *rows->shift);
  kith_free(&rows->shift);
  rows->shifts_capacity = 0;
  return KITH_OK;
}

void kith_entries_sort(kith_index *node, uint16_t *shift, size_t n) {
  for (size_t k = 1; k < n; ++k) {
    const kith_index moved = node[k];
    const uint16_t by = shift != NULL ? shift[k] : 0;
    size_t to = k;
    for (; to > 0 && (node[to - 1] > moved || (node[to - 1] == moved && shift != NULL && shift[to - 1] > by));
         --to) {
      node[to] = node[to - 1];
      if (shift != NULL) shift[to] = shift[to - 1];
    }
    node[to] = moved;
    if (shift != NULL) shift[to] = by;
  }
}

/* Where the ascending sequence that begins at `from` ends. */
static size_t ascent(const uint64_t *key, size_t from, size_t n) {
  size_t k = from + 1;
  while (k < n && key[k] >= key[k - 1]) ++k;
  return KITH_MIN(k, n);
}

static void merge(const uint64_t *a, const uint64_t *a_end, const uint64_t *b, const uint64_t *b_end,
                  uint64_t *out) {
  while (a < a_end && b < b_end) {
    const bool first = *a < *b;
    *out++ = first ? *a : *b;
    a += first, b += !first;
  }
  if (a < a_end) memcpy(out, a, (size_t)(a_end - a) * sizeof *out);
  if (b < b_end) memcpy(out, b, (size_t)(b_end - b) * sizeof *out);
}

/* A natural merge sort: in each round two ascending sequences that follow one another become one. */
uint64_t *kith_keys_sort(uint64_t *key, uint64_t *spare, size_t n) {
  while (ascent(key, 0, n) < n) {
    for (size_t from = 0; from < n;) {
      const size_t middle = ascent(key, from, n);
      const size_t to = middle < n ? ascent(key, middle, n) : n;
      merge(key + from, key + middle, key + middle, key + to, spare + from);
      from = to;
    }
    uint64_t *swap = key;
    key = spare, spare = swap;
  }
  return key;
}

void kith_rows_clear(struct kith_rows *rows) {
  KITH_FREE(&rows->first, &rows->node, &rows->shift, &rows->wanted);
  *rows = (struct kith_rows){0};
}

size_t kith_rows_bytes(const struct kith_rows *rows) {
  return rows->rows_capacity * sizeof *rows->first + rows->entries_capacity * sizeof *rows->node +
         rows->shifts_capacity * sizeof *rows->shift + (rows->wanted != NULL ? rows->wanted_bytes : 0);
}

size_t kith_rows_longest(const struct kith_rows *rows) {
  size_t longest = 0;
#pragma omp parallel for schedule(static) reduction(max : longest)
  for (kith_index from = 0; from < rows->n; from += KITH_STRETCH) {
    const kith_index stop = kith_rows_stretch_end(rows, from);
    for (kith_index i = from; i < stop; ++i) longest = KITH_MAX(longest, rows->first[i + 1] - rows->first[i]);
  }
  return longest;
}

/* --- compaction --- */

enum { SHARES = 64 };

static void move(const struct kith_column *column, size_t from, size_t to, size_t count) {
  for (const struct kith_column *c = column; from != to && c->values != NULL; ++c)
    memmove((char *)c->values + to * c->size, (char *)c->values + from * c->size, count * c->size);
}

/* Compacts rows begin .. end - 1, of which the first begins at entry `from`, in place, by moving runs of
 * entries that are kept. Returns where they end. */
static size_t compact_share(size_t *first, kith_index begin, kith_index end, size_t from,
                            const struct kith_column *column) {
  const kith_index *index = column[0].values;
  const size_t stride = column[0].size / sizeof *index;
  size_t kept = from, e = from;
  for (kith_index i = begin; i < end; ++i) {
    while (e < first[i + 1]) {
      const size_t run = e;
      while (e < first[i + 1] && index[e * stride] >= 0) ++e;
      move(column, run, kept, e - run);
      kept += e - run;
      while (e < first[i + 1] && index[e * stride] < 0) ++e;
    }
    first[i + 1] = kept;
  }
  return kept;
}

/* Each share is compacted where it is; then the shares are moved together. */
size_t kith_compact(size_t *first, kith_index n, const struct kith_column *column) {
  size_t start[SHARES], length[SHARES], gap[SHARES], to = 0;
  if (n == 0) return 0;
  for (int s = 0; s < SHARES; ++s) start[s] = first[kith_part_start(n, s, SHARES)];
#pragma omp parallel for schedule(dynamic, 1) if (n > KITH_FEW)
  for (int s = 0; s < SHARES; ++s)
    length[s] = compact_share(first, kith_part_start(n, s, SHARES), kith_part_start(n, s + 1, SHARES),
                              start[s], column) -
                start[s];
  for (int s = 0; s < SHARES; ++s, to += length[s - 1]) {
    gap[s] = start[s] - to;
    move(column, start[s], to, length[s]);
  }
#pragma omp parallel for schedule(static) if (n > KITH_FEW)
  for (int s = 0; s < SHARES; ++s)
    for (kith_index i = kith_part_start(n, s, SHARES); i < kith_part_start(n, s + 1, SHARES); ++i)
      first[i + 1] -= gap[s];
  return to;
}

void kith_rows_compact(struct kith_rows *rows) {
  kith_free(&rows->wanted);
  const struct kith_column columns[] = {
      {rows->node, sizeof *rows->node}, {rows->shift, sizeof *rows->shift}, {0}};
  kith_compact(rows->first, rows->n, columns);
}
