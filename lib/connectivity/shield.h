/* shield.h - shielded coupling: a thin barrier between two nodes cuts their pair.
 *
 * Barrier nodes are marked. A pair of other nodes is cut if some barrier node k of their intersection stands between them: its closest point
 * on the segment from i to j lies strictly between the ends, and nearer than `thickness` times the support of k. Among nodes s apart
 * no segment crosses a layer without one within s / sqrt(2) in 3-D, s / 2 in 2-D; more would cut pairs on one side that come that close.
 * Cut pairs get f_couple = 0 and then go: from rows, pairs, of_row, f_couple and intersection (there also nodes that an end no longer
 * sees). What is left is as if the search had never seen them, so packages need not know. The overlap is left as it is. */
#ifndef KITH_CONNECTIVITY_SHIELD_H
#define KITH_CONNECTIVITY_SHIELD_H

#include "lib/connectivity/connectivity.h"

/* Needs pairs and intersection (else INTERNAL). barrier: U8 field, 1 on barrier nodes, ghosts too. *cut: how many pairs went; may be NULL. */
kith_status kith_connectivity_shield(struct kith_connectivity *connectivity, const struct kith_nodes *nodes,
                                     const struct kith_field *barrier, double thickness, size_t *cut);

/* Drops the pairs whose f_couple is 0. For whoever cuts pairs by another rule. */
kith_status kith_connectivity_decouple(struct kith_connectivity *connectivity);

#endif
