/* pairs.h - the flattened pair list of some rows: each interaction once; and its pairwise fields.
 *
 * Pairs (i, j) with i < j, in lexicographic order: the upper part (j > i) of every row, row by row. So a pair
 * with a ghost starts at the internal node. Of two images of i that are neighbors of i, at opposite shifts,
 * the one with the higher shift is in the upper part. In canonical order (connectivity.h) other rules hold.
 *
 * A pairwise field is named values of the pairs of one list, which owns it. Whoever fills it prepares it for
 * the present pairs; a build and a patch number the pairs anew, and the values are stale from then on. */
#ifndef KITH_CONNECTIVITY_PAIRS_H
#define KITH_CONNECTIVITY_PAIRS_H

#include "lib/connectivity/rows.h"

struct kith_pairwise_spec {
  const char *name; /* unique in its list; borrowed: a string constant */
  int components;
  bool lasts; /* patches carry the values over: they must be finite */
  const char *doc;
};

struct kith_pairwise {
  struct kith_pairwise_spec spec;
  size_t capacity;
  uint64_t generation; /* of the pairs that the values belong to */
  double *value;       /* [pairs][components] */
};

enum { KITH_MAX_PAIRWISE = 16 };
struct kith_pairwise_fields {
  int n;
  struct kith_pairwise field[KITH_MAX_PAIRWISE]; /* in the order in which they were first prepared */
};

struct kith_pairs {
  size_t n, capacity;
  /* Passes over pairs visit those that start at nodes 0 .. starts - 1: internal nodes; of canonical pairs
   * ghosts too. */
  kith_index starts;
  kith_index (*node)[2]; /* [n] (i, j), which starts at i; i < j unless canonical */
  uint16_t *shift;     /* [n] j is this image of its node, as seen from i (rows.h); NULL: none is displaced */
  size_t *first;       /* [rows or starts + 1] pairs that start at i: first[i] .. first[i + 1] - 1 */
  uint32_t *of_row;    /* [entries of the rows] the pair of each entry */
  uint64_t generation; /* counts builds and patches */
  struct kith_pairwise_fields *fields; /* NULL before the first build. Copies of the list share them */
  uint32_t *cursor;                    /* [rows]; scratch */
  size_t shifts_capacity, first_capacity, of_row_capacity, cursor_capacity;
};

/* Pairs and of_row of sorted rows, which may lack the rows of ghosts. */
kith_status kith_pairs_build(struct kith_pairs *pairs, const struct kith_rows *rows, kith_index starts);
/* Memory of `first` and of_row; then, when n is known, of the pairs. */
kith_status kith_pairs_reserve(struct kith_pairs *pairs, kith_index rows, size_t entries);
kith_status kith_pairs_reserve_nodes(struct kith_pairs *pairs, bool shifts);
/* of_row from rows and `first`, and nothing else. */
kith_status kith_pairs_of_row(struct kith_pairs *pairs, const struct kith_rows *rows);
/* Drops the pairs whose first node is below 0, in place, with their lasting fields and the offsets of
 * `common`: rows of pairs, already without entries where the pair is dropped; may be NULL. `n`: rows.
 * Parallel. */
void kith_pairs_compact(struct kith_pairs *pairs, kith_index n, struct kith_rows *common);
/* The next generation, to which the lasting fields belong too. */
void kith_pairs_carry(struct kith_pairs *pairs);
void kith_pairs_clear(struct kith_pairs *pairs);
/* Memory besides pairwise fields. */
size_t kith_pairs_bytes(const struct kith_pairs *pairs);

/* The field of this name, registered at the first call, with room for the present pairs, to which its values
 * belong from here on; they are not cleared. Memory is reused. *out is a view: the list owns it. UNSUPPORTED
 * if there never were pairs, INTERNAL if the name is taken with another specification. */
kith_status kith_pairwise_prepare(const struct kith_pairs *pairs, const struct kith_pairwise_spec *spec,
                                  struct kith_pairwise **out);
/* The field called `name`, or NULL. View. */
struct kith_pairwise *kith_pairwise_named(const struct kith_pairs *pairs, const char *name);
/* STALE unless it was prepared for the present pairs. To be asked once in each pass that reads the field. */
kith_status kith_pairwise_fresh(const struct kith_pairs *pairs, const struct kith_pairwise *field);
/* Memory of all of them. */
size_t kith_pairwise_bytes(const struct kith_pairs *pairs);

#endif
