/* rows.h - compressed rows (CSR), and how the rows of neighbors are built.
 *
 * Entries of row i are node[first[i]] .. node[first[i + 1] - 1]. The rows of neighbors are built in two
 * passes over the groups of the search, parallel over groups: the first tests distances and counts, the
 * second fills in. The result does not depend on the number of threads, nor on which search was used. */
#ifndef KITH_CONNECTIVITY_ROWS_H
#define KITH_CONNECTIVITY_ROWS_H

#include "lib/connectivity/packed.h"

struct kith_rows {
  kith_index n;
  size_t *first;    /* [n + 1] */
  kith_index *node; /* [first[n]] */
  size_t rows_capacity, entries_capacity;
};

kith_status kith_rows_reserve(struct kith_rows *rows, kith_index n);
/* first[i + 1] holds the length of row i: sums them up and reserves memory for the entries. */
kith_status kith_rows_sum(struct kith_rows *rows);
void kith_rows_clear(struct kith_rows *rows);
size_t kith_rows_bytes(const struct kith_rows *rows);
/* The length of the longest row. */
size_t kith_rows_longest(const struct kith_rows *rows);
/* Drops the entries below 0, in place; order is kept. Parallel over shares of the rows. */
void kith_rows_compact(struct kith_rows *rows);

/* Loops that move rows in place work on fixed shares of the rows, one after the other or at once. */
enum { KITH_SHARES = 64 };
static inline kith_index kith_share_start(kith_index n, int share) {
  return (kith_index)((int64_t)n * share / KITH_SHARES);
}

/* Position of the first entry of a sorted row that is >= j. No branches: they could not be predicted. */
static inline size_t kith_lower_bound(const kith_index *node, size_t from, size_t to, kith_index j) {
  if (from == to) return from;
  const kith_index *at = node + from;
  for (size_t n = to - from; n > 1; n -= n / 2) at += at[n / 2 - 1] < j ? n / 2 : 0;
  return (size_t)(at - node) + (*at < j);
}
/* Does sorted row i hold j? */
static inline bool kith_rows_hold(const struct kith_rows *rows, kith_index i, kith_index j) {
  const size_t e = kith_lower_bound(rows->node, rows->first[i], rows->first[i + 1], j);
  return e < rows->first[i + 1] && rows->node[e] == j;
}

/* What the first pass leaves for the second, kept from build to build. Chunks are fixed shares of the groups:
 * their contents do not depend on which thread filled them. */
enum { KITH_ROW_CHUNKS = 256 };
struct kith_row_chunks {
  struct kith_words {
    size_t n, capacity;
    uint64_t *word;
  } chunk[KITH_ROW_CHUNKS];
};

/* Rows of significant neighbors, ascending: of internal nodes (rows->n = n_internal), of `ghosts` too if
 * wanted. *candidates: how many distances were tested. */
kith_status kith_rows_build(struct kith_rows *rows, const struct kith_build *build, bool ghosts,
                            struct kith_row_chunks *chunks, size_t *candidates);

#endif
