/* places.h - what ranks tell each other of where their nodes are, and which nodes another rank may need.
 *
 * A place is a bunch of nodes as seen from afar: the box around them and their largest reach R. Node j is near a place if
 *     d(x_j, box) <= f max(R_j, R of the place),
 * so whatever a node of the place may interact with is near it. */
#ifndef KITH_BOUNDARIES_PLACES_H
#define KITH_BOUNDARIES_PLACES_H

#include "lib/domain/cells.h"
#include "lib/nodes/nodes.h"

struct kith_place {
  double reach; /* < 0: it is empty */
  struct kith_box box;
};

/* Place c of the internal nodes with homes[i] == c (I64, small whole numbers). *places: [*n], owned by the caller. */
kith_status kith_places_of_cells(const struct kith_nodes *nodes, const struct kith_field *homes,
                                 struct kith_place **places, size_t *n);
/* Moves those that are not empty to the front; returns how many. */
size_t kith_places_pack(struct kith_place *place, size_t n);
/* The largest reach of `own` and of all places that come within the larger reach of both, as images too on periodic axes. */
double kith_place_widest(const struct kith_place *own, const struct kith_cells *cells,
                         const struct kith_place *all, size_t n);

/* What may be sent: all nodes and images but frozen ones, in bunches of consecutive nodes. Zero, gather, clear. */
struct kith_candidates {
  kith_index n;  /* nodes and ghosts */
  uint8_t *kept; /* [n] 1: not to be sent; then, per rank, 2: sent */
  int bunches;
  uint8_t *hit; /* [bunches] does it hold one that is sent? */
  struct kith_place *bunch, all;
};
kith_status kith_candidates_gather(struct kith_candidates *candidates, const struct kith_nodes *nodes);
void kith_candidates_clear(struct kith_candidates *candidates);

/* Those that are near any of the places there[0 .. n - 1], by list and index: *send [*n_send], owned by the caller; count[list] is raised by
 * how many there are. `there` is reordered. */
kith_status kith_candidates_near(struct kith_candidates *candidates, const struct kith_nodes *nodes,
                                 struct kith_place *there, size_t n, double factor, kith_index **send,
                                 kith_index *n_send, int64_t *count);

#endif
