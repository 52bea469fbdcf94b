/* ghost_candidates.h - which nodes and images of this rank may interact with the nodes of cells of others
 * (halo.h). */
#ifndef KITH_DOMAIN_GHOST_CANDIDATES_H
#define KITH_DOMAIN_GHOST_CANDIDATES_H

#include "lib/domain/cells.h"
#include "lib/nodes/nodes.h"

/* What neighbors are told of the nodes of a cell: the box around them, and their largest search radius. */
struct kith_bounds {
  double search_radius; /* < 0: it has no nodes */
  struct kith_box box;
};
static const struct kith_bounds kith_nowhere = {.search_radius = -1};

/* The largest search radius of `own` and of all cells that come within the larger search radius of both, as
 * images too on periodic axes. */
double kith_bounds_widest(const struct kith_bounds *own, const struct kith_cells *cells,
                          const struct kith_bounds *all, size_t n);

/* What may be sent: all nodes and images but frozen ones, in groups of consecutive nodes, which are tested
 * together before their nodes are. */
struct kith_candidates {
  kith_index n;  /* nodes and ghosts */
  uint8_t *mark; /* [n] 1: not to be sent; while one cell after the other is asked, 2: sent */
  int groups;
  uint8_t *hit; /* [groups] does it hold one that is sent? */
  struct kith_bounds *group, all;
  const double *period; /* [NDIM] of axes whose images are shifts, else 0 */
};
/* Cleared by the caller, also after a failure. */
kith_status kith_candidates_gather(struct kith_candidates *candidates, const struct kith_nodes *nodes);
void kith_candidates_clear(struct kith_candidates *candidates);
/* Cell c has the internal nodes with home[i] == c, c = 0 .. n - 1. *bounds: [n], owned by the caller. The
 * candidates that were gathered from these nodes save most of the work; NULL: there are none. */
kith_status kith_bounds_find(const struct kith_candidates *candidates, const struct kith_nodes *nodes,
                             const int64_t *home, size_t n, struct kith_bounds **bounds);
/* *send [*n_send], owned by the caller: the candidates near any of cell[0 .. n - 1], sorted by list and
 * index; count[list], 0 on entry: how many of each list. `cell` is reordered. */
kith_status kith_candidates_near(struct kith_candidates *candidates, const struct kith_nodes *nodes,
                                 struct kith_bounds *cell, size_t n, double factor, kith_index **send,
                                 kith_index *n_send, int64_t *count);

#endif
