/* overlap.h - overlap rows: all nodes whose support shares a node with that of i.
 *
 * Row i holds the neighbors of i, and every j for which there is a node k (internal or ghost, also i or j)
 * with |x_i - x_k| <= R_i and |x_j - x_k| <= R_j. Symmetric, self excluded, ascending. Complete if ghosts
 * reach twice as far as for neighbors (boundary.h, factor 2). */
#ifndef KITH_CONNECTIVITY_OVERLAP_H
#define KITH_CONNECTIVITY_OVERLAP_H

#include "lib/connectivity/rows.h"

/* Scratch memory, kept from build to build: for each node the set of nodes whose support holds it, as
 * non-empty 64-bit words of a bitmap over the nodes. */
struct kith_overlap_spans {
  size_t *first;    /* [rows + 1] */
  kith_index *word; /* number of the word */
  uint64_t *bits;
  size_t first_capacity, word_capacity, bits_capacity;
};

/* Overlap rows of the first `n` nodes. Needs the rows of ghosts. */
kith_status kith_overlap_build(struct kith_rows *overlap, const struct kith_rows *rows, kith_index n,
                               const struct kith_build *build, struct kith_overlap_spans *spans);
void kith_overlap_spans_clear(struct kith_overlap_spans *spans);
size_t kith_overlap_spans_bytes(const struct kith_overlap_spans *spans);

#endif
