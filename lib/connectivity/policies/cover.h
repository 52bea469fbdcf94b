/* cover.h - do the neighbor lists still hold every pair that is significant now?
 *
 * The lists were made with search radii R_i at positions x0_i: they hold every pair with |x0_ij| <= max(R_i,
 * R_j), for all images of the nodes. With d = x - x0 - c up to whole periods, c any vector common to all
 * nodes, a pair that is significant now, |x_ij| <= max(H_i, H_j) = H_i say, had
 *     |x0_ij| <= |x_ij| + |d_i - d_j| <= H_i + |d_i| + max_k |d_k|,
 * so no pair is missing if, for every i,
 *     H_i + |d_i| + max_k |d_k| <= R_i.                                                              (1)
 * The maximum goes over all nodes of all ranks: a maximum over neighbors would miss a fast node that comes
 * from outside the rows. Growth of a support counts as displacement; a periodic wrap or a uniform motion does
 * not.
 *
 * c is the mean displacement. A mirror image moves by S d, as far as d itself, but by S c where all nodes
 * move by c: so c is 0 along axes that some image mirrors, and along all of them if there are ghosts that do
 * not follow a node. Its sum is exact (sum.h), so that all numbers of threads and ranks decide alike. Nodes
 * are put back into a periodic box only when lists are rebuilt: due if c is beyond half its length, though
 * the lists hold.
 *
 * Rounding: positions and distance tests are good to a few units in the last place of |x| and H. A node that
 * has moved at all counts as moved by that much more; where nothing moved, the tests are repeated on the same
 * numbers.
 *
 * Lists that must serve a whole step are asked beforehand: with `ahead` > 0 positions and supports are first
 * drifted by that time.
 *
 * Memory: NDIM + 1 numbers for each internal node. Time: two passes over the nodes. */
#ifndef KITH_CONNECTIVITY_POLICIES_COVER_H
#define KITH_CONNECTIVITY_POLICIES_COVER_H

#include "lib/nodes/nodes.h"

struct kith_cover {
  /* Set by the caller. */
  double period[NDIM];                                     /* length of a periodic axis, 0 for the others */
  double ahead;                                            /* time; 0: the present positions */
  const struct kith_field *velocity, *velocity_divergence; /* borrowed; for `ahead` */

  kith_index n;
  double still[NDIM]; /* 0: a common drift along this axis is no displacement; of this rank, then of all */
  double reference[NDIM]; /* displacement of one node, when it was last measured; in checkpoints */
  double measured[4];     /* the last time, as maxima over the nodes, then over all ranks (cover.c) */
  double *position, *search_radius; /* [n][NDIM], [n]: one after the other */
  size_t capacity;
};

/* Remembers the internal nodes of this rank, with which the lists were just made. Afterwards the ranks must
 * take the maximum of `still` over all of them. */
kith_status kith_cover_snapshot(struct kith_cover *cover, const struct kith_nodes *nodes);
/* Finds the maxima of equation (1) over the nodes of this rank. Collective, for the mean displacement is that
 * of all nodes. */
void kith_cover_measure(struct kith_cover *cover, const struct kith_nodes *nodes);
/* What the ranks must agree on after that, before they ask what follows. */
struct kith_shared kith_cover_shared(struct kith_cover *cover);
/* Does equation (1) hold? It does not if the number of internal nodes has changed on any rank. */
bool kith_cover_holds(const struct kith_cover *cover);
/* Has a common drift taken the nodes half a periodic length away? */
bool kith_cover_far(const struct kith_cover *cover);
void kith_cover_clear(struct kith_cover *cover);

/* The mean of a vector over the internal nodes of all ranks, 0 if there are none: exact (sum.h), the same
 * for all numbers of threads and ranks. vector(context, i, x) writes that of node i. Collective. */
void kith_mean_vector(const struct kith_nodes *nodes,
                      void (*vector)(const void *context, kith_index i, double *x), const void *context,
                      double mean[NDIM]);

#endif
