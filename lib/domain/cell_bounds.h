/* cell_bounds.h - where the nodes of a cell are, as other ranks are told, and which nodes another rank needs.
 *
 * The bounds of a cell are the box around its nodes and their largest search radius R. Node j is near a cell,
 * and is sent to the rank that owns it, if
 *     d(x_j, box) <= f max(R_j, R of the cell),
 * f = 1, or 2 when overlap is required: then whatever a node of the cell may interact with is near it. */
#ifndef KITH_DOMAIN_CELL_BOUNDS_H
#define KITH_DOMAIN_CELL_BOUNDS_H

#include "lib/domain/cells.h"
#include "lib/nodes/nodes.h"

struct kith_cell_bounds {
  double search_radius; /* < 0: it has no nodes */
  struct kith_box box;
};

/* Is a node or image at x near the cell? No tighter than rounding could make it. */
static inline bool kith_cell_bounds_near(const struct kith_cell_bounds *cell, const double *x,
                                         double search_radius, double factor) {
  const double r = factor * KITH_MAX(search_radius, cell->search_radius);
  return cell->search_radius >= 0 && kith_box_distance2(&cell->box, x) <= r * r * (1 + 1e-14);
}

/* Cell c has the internal nodes with home[i] == c, c = 0 .. n - 1. *bounds: [n], owned by the caller. */
kith_status kith_cell_bounds_of_nodes(const struct kith_nodes *nodes, const int64_t *home, size_t n,
                                      struct kith_cell_bounds **bounds);
/* The largest search radius of `own` and of all cells that come within the larger search radius of both, as
 * images too on periodic axes. */
double kith_cell_bounds_widest(const struct kith_cell_bounds *own, const struct kith_cells *cells,
                               const struct kith_cell_bounds *all, size_t n);

/* What may be sent: all nodes and images but frozen ones, in groups of consecutive nodes, which are tested
 * together before their nodes are. Zero, gather, clear. */
struct kith_candidates {
  kith_index n;  /* nodes and ghosts */
  uint8_t *mark; /* [n] 1: not to be sent; during kith_candidates_near, 2: sent */
  int groups;
  uint8_t *hit; /* [groups] does it hold one that is sent? */
  struct kith_cell_bounds *group, all;
};
kith_status kith_candidates_gather(struct kith_candidates *candidates, const struct kith_nodes *nodes);
void kith_candidates_clear(struct kith_candidates *candidates);

/* Those that are near any of cell[0 .. n - 1], by list and index: *send [*n_send], owned by the caller;
 * count[list] is raised by how many there are. `cell` is reordered. */
kith_status kith_candidates_near(struct kith_candidates *candidates, const struct kith_nodes *nodes,
                                 struct kith_cell_bounds *cell, size_t n, double factor, kith_index **send,
                                 kith_index *n_send, int64_t *count);

#endif
