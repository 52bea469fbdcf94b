/* rows.h - compressed rows (CSR): entries of row i are node[first[i]] .. node[first[i + 1] - 1].
 *
 * They are built in two passes: kith_rows_reserve; the first counts, the length of row i into first[i + 1];
 * kith_rows_sum makes offsets of the lengths; the second fills in. */
#ifndef KITH_CONNECTIVITY_ROWS_H
#define KITH_CONNECTIVITY_ROWS_H

#include "lib/core/base.h"

enum { KITH_FEW = 1000 }; /* nodes: for fewer, waking threads costs more than they save */

/* Where a part of 0 .. n - 1 begins, cut into equal `parts`. */
static inline kith_index kith_part_start(kith_index n, int part, int parts) {
  return (kith_index)((int64_t)n * part / parts);
}

struct kith_rows {
  kith_index n;
  size_t *first;    /* [n + 1] */
  kith_index *node; /* [first[n]] */
  size_t rows_capacity, entries_capacity;
};

/* Memory for n rows; first[0] = 0. */
kith_status kith_rows_reserve(struct kith_rows *rows, kith_index n);
/* first[i + 1] holds the length of row i: sums them up and reserves memory for the entries. */
kith_status kith_rows_sum(struct kith_rows *rows);
void kith_rows_clear(struct kith_rows *rows);
size_t kith_rows_bytes(const struct kith_rows *rows);
/* The length of the longest row. */
size_t kith_rows_longest(const struct kith_rows *rows);

/* Does sorted row i hold j? */
static inline bool kith_rows_hold(const struct kith_rows *rows, kith_index i, kith_index j) {
  const size_t e = kith_lower_bound(rows->node, rows->first[i], rows->first[i + 1], j);
  return e < rows->first[i + 1] && rows->node[e] == j;
}

/* Entries of n rows in columns, one value of each for each entry. */
struct kith_column {
  void *values;
  size_t size; /* of a value */
};
/* Drops the entries whose first column, an index, is below 0, in place; order is kept. The columns end with
 * {0}. Returns how many entries are left. Parallel over fixed shares of the rows. */
size_t kith_compact(size_t *first, kith_index n, const struct kith_column *column);
void kith_rows_compact(struct kith_rows *rows);

#endif
