/* pairs.h - the flattened pair list of some rows: each interaction once.
 *
 * Pairs (i, j) with i < j, in lexicographic order: the upper part (j > i) of every row, row by row. So a pair
 * with a ghost starts at the internal node. In canonical order (connectivity.h) other rules hold. */
#ifndef KITH_CONNECTIVITY_PAIRS_H
#define KITH_CONNECTIVITY_PAIRS_H

#include "lib/connectivity/rows.h"

struct kith_pairs {
  size_t n, capacity;
  kith_index starts;     /* passes over pairs visit those that start at nodes 0 .. starts - 1: internal nodes;
                      * canonical pairs: ghosts too */
  kith_index (*node)[2]; /* [n] (i, j), which starts at i; i < j unless canonical */
  size_t *first;         /* [rows or starts + 1] pairs that start at i: first[i] .. first[i + 1] - 1 */
  uint32_t *of_row;      /* [entries of the rows] the pair of each entry */
  double *f_couple;      /* [n] or NULL: 1 for all. A factor; 0 cuts the pair */
  size_t first_capacity, of_row_capacity;
  /* Memory of f_couple, and scratch. */
  double *factors;
  uint32_t *cursor; /* [rows] */
  size_t factors_capacity, cursor_capacity;
};

/* Pairs and of_row of sorted rows, which may lack the rows of ghosts. */
kith_status kith_pairs_build(struct kith_pairs *pairs, const struct kith_rows *rows, kith_index starts);
/* Memory of `first` and of_row; then, when n is known, of the pairs. */
kith_status kith_pairs_reserve(struct kith_pairs *pairs, kith_index rows, size_t entries);
kith_status kith_pairs_reserve_nodes(struct kith_pairs *pairs);
/* of_row from rows and `first`, and nothing else. */
kith_status kith_pairs_of_row(struct kith_pairs *pairs, const struct kith_rows *rows);
/* Makes f_couple (all 1) if it is NULL. */
kith_status kith_pairs_couple(struct kith_pairs *pairs);
/* Drops the pairs whose first node is below 0, in place, with their factors and the offsets of `common`: rows
 * of pairs, already without entries where the pair is dropped; may be NULL. `n`: rows. Parallel. */
void kith_pairs_compact(struct kith_pairs *pairs, kith_index n, struct kith_rows *common);
void kith_pairs_clear(struct kith_pairs *pairs);
size_t kith_pairs_bytes(const struct kith_pairs *pairs);

#endif
