/* coupling.h - shielded coupling: a thin barrier between two nodes cuts their pair.
 *
 * Barrier nodes are marked. A pair of other nodes is cut if some barrier node k of their intersection stands
 * between them: its closest point on the segment from i to j lies strictly between the ends, and nearer than
 * `thickness` times the support of k. Among nodes s apart no segment crosses a layer without one within
 * s / sqrt(2) in 3-D, s / 2 in 2-D; a larger thickness would cut pairs on one side that come that close. Cut
 * pairs get f_couple = 0 and are then removed: from rows, pairs, of_row, f_couple and intersection (there
 * also nodes that an end does not see any more). What is left is as if the search had never found them, so
 * packages need not know. The overlap is left as it is. */
#ifndef KITH_CONNECTIVITY_COUPLING_H
#define KITH_CONNECTIVITY_COUPLING_H

#include "lib/connectivity/connectivity.h"

/* Needs pairs and intersection (else UNSUPPORTED). barrier: U8 field, 1 on barrier nodes, ghosts too. *cut:
 * how many pairs were cut; may be NULL. */
kith_status kith_connectivity_cut_barriers(struct kith_connectivity *connectivity,
                                           const struct kith_nodes *nodes, const struct kith_field *barrier,
                                           double thickness, size_t *cut);

#endif
