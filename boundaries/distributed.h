/* distributed.h - ghosts of nodes that other ranks have. Always the last boundary: what is sent are nodes and the
 * images that the boundaries before made of them, so a corner between ranks is nothing special.
 *
 * Who is sent. Every rank tells all others, for each cell of the map in which it has nodes, the box around these nodes and
 * their largest reach R. Node j (or image j) is sent to rank s if, for a cell of s, its distance from the box is
 *     d(x_j, box) <= f max(R_j, R of the cell),
 * so whatever a node of s may interact with is there. Frozen nodes and their images are not sent: every rank has all of them.
 * Ghosts come rank by rank, and list by list, in the order of their nodes.
 *
 * Culling. A rank tells the owners which of its ghosts it keeps; the owners shorten their lists, and keep the images on them.
 *
 * Who owns a pair between ranks: both. Each evaluates it for its own node, and so do all sums over rows; a ghost is
 * never given anything. Pairs are counted on both ranks.
 *
 * Refreshing any set of fields is one message to each neighboring rank, after the images have their values. */
#ifndef KITH_BOUNDARIES_DISTRIBUTED_H
#define KITH_BOUNDARIES_DISTRIBUTED_H

#include "boundaries/boundary.h"
#include "lib/domain/cells.h"

/* Makes an added boundary ready, and the exchange of its nodes, which have ranks. home: I64, the cell of each internal node, small whole numbers
 * of this rank alone. cells: those that are dealt out; periodic axes and the lengths of the box are what matters. Both are borrowed. */
kith_status kith_distributed_init(struct kith_boundary *boundary, struct kith_nodes *nodes,
                                  const struct kith_field *home, const struct kith_cells *cells);

/* For ghosts whose rows are complete: raises the reach of each internal node i to the largest R_j that a node j within max(R_i, R_j) of
 * it may have. Ghosts made with it and with f = 2 then hold all partners of i, and all that lie within R_j of a partner j,
 *     d(x_k, x_i) <= max(R_i, R_j) + R_j <= 2 R'_i.
 * Every own cell is compared with all cells of all ranks. Collective. */
kith_status kith_distributed_widen(struct kith_boundary *boundary, struct kith_nodes *nodes);
#endif
