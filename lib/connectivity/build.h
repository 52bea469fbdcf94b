/* build.h - builders of lists.
 *
 * Rows of neighbors are built in two passes over the groups of the search, parallel over groups: the first
 * tests distances and counts, the second fills in. The result depends neither on the number of threads nor on
 * which search was used.
 *
 * Overlap row i holds the neighbors of i, and every j for which there is a node k (internal or ghost, also i
 * or j) with |x_i - x_k| <= R_i and |x_j - x_k| <= R_j. Symmetric, self excluded, ascending. Complete if
 * ghosts reach twice as far as for neighbors (boundary.h, factor 2).
 *
 * The intersection of a pair is the common neighbors of its nodes, and both; optionally only those whose
 * closest point on the segment from i to j lies strictly between the ends. One row a pair, ascending. */
#ifndef KITH_CONNECTIVITY_BUILD_H
#define KITH_CONNECTIVITY_BUILD_H

#include "lib/connectivity/build/builder.h"
#include "lib/connectivity/pairs.h"

/* Rows of neighbors, ascending unless `unsorted`: of the targets, or if build->row is NULL of internal nodes
 * (rows->n = n_internal), of ghosts too if targets->ghosts; ghosts have none while nodes are idle.
 * *candidates: how many distances were tested. */
kith_status kith_rows_build(struct kith_rows *rows, const struct kith_build *build, size_t *candidates);
/* Overlap rows of the first `n` nodes. Needs the rows of ghosts. (overlap.c) */
kith_status kith_overlap_build(struct kith_rows *overlap, const struct kith_rows *rows, kith_index n,
                               const struct kith_build *build);
/* UNSUPPORTED beyond 2^31 pairs. (intersection.c) */
kith_status kith_intersection_build(struct kith_rows *intersection, const struct kith_rows *rows,
                                    const struct kith_pairs *pairs, bool on_segment,
                                    const struct kith_build *build);

#endif
