/* spacetree_cells.h - cells of many levels: what sorting, queries and sweeps of the spacetree search share.
 *
 * Cells of level l are edge / 2^l wide, half as wide as those of level l - 1: each has a parent. A node lives
 * on the finest level whose cells are at least twice its search radius wide, and belongs to the vertex of
 * that level closest to it. So any node of the same level that interacts with it belongs to one of the 2^d
 * vertices of the cell that it is in: these hold the nodes of the cell and of half a cell around it, the
 * local set of the cell. Nodes of coarser levels that interact with it are in the local sets of the ancestors
 * of the cell. All these local sets are the active set of the cell. Nodes of finer levels are in none of
 * them: they find the coarser ones.
 *
 * Cells are half-open, so that a node on a face, an edge or a corner is in one cell. Nodes outside of the
 * frame are in the outermost cells: correct, but slow. */
#ifndef KITH_NEIGHBOR_SPACETREE_CELLS_H
#define KITH_NEIGHBOR_SPACETREE_CELLS_H

#include "lib/core/keyed.h"
#include "lib/core/sfc_key.h"
#include "lib/neighbor/search.h"

enum {
  KITH_SPACETREE_LEVELS = 24,
  /* Bits of the coordinate of a cell of the deepest level; of the Morton code of a vertex; of a level. */
  KITH_CELL_BITS = NDIM == 3   ? 18
                   : NDIM == 2 ? 28
                               : 50,
  KITH_VERTEX_BITS = NDIM * (KITH_CELL_BITS + 1),
  KITH_LEVEL_BITS = 5,
};

/* A vertex that has nodes. Their slots are the runs from its own to that of the next vertex. */
struct kith_vertex {
  uint64_t key;   /* internal or ghost, level, Morton code */
  kith_index run; /* the first one */
};

/* The vertices with nodes of one level, internal ones or ghosts. */
struct kith_layer {
  kith_index vertex, vertices; /* the first one, and how many */
  double radius2;              /* at least the largest squared radius of their nodes */
};

struct kith_spacetree {
  /* The frame stays as it is while nodes are in it and radii suit it. */
  double lower[NDIM], width, edge;
  double per_length[KITH_SPACETREE_LEVELS]; /* cells of a level in a unit of length */
  int deepest;
  /* Sorted: items by key, then by node. contiguous: slots in this order; scattered: slots are nodes. */
  size_t items_capacity, vertices_capacity, runs_capacity, places_capacity;
  struct kith_keyed *item[2]; /* [n]; the second one is scratch */
  struct kith_vertex *vertex; /* [n_vertices + 1] */
  struct kith_run *run;       /* vertex by vertex, ascending; in the layout contiguous one for each vertex */
  kith_index n_vertices;
  struct kith_layer layer[2 * KITH_SPACETREE_LEVELS];
  uint64_t order;    /* generation of the nodes when internal ones were sorted; UINT64_MAX: they are not */
  kith_index *place; /* [n] the item of each node; valid if `placed` */
  bool placed;
};

/* Cells of level l along an axis. */
static inline int64_t kith_spacetree_cells(const struct kith_spacetree *tree, int level) {
  return INT64_C(1) << (KITH_CELL_BITS - tree->deepest + level);
}
static inline int64_t kith_spacetree_clamp(double u, int64_t top) {
  return u > 0 ? (u < (double)top ? (int64_t)u : top) : 0;
}
/* The cell of this level that a coordinate is in. Halved, it is the cell of the next coarser level. */
static inline int64_t kith_spacetree_cell(const struct kith_spacetree *tree, int level, int a, double x) {
  const double u = (x - tree->lower[a]) * tree->per_length[level];
  return kith_spacetree_clamp(u, kith_spacetree_cells(tree, level) - 1);
}
static inline int64_t kith_spacetree_vertex(const struct kith_spacetree *tree, int level, int a, double x) {
  const double u = (x - tree->lower[a]) * tree->per_length[level];
  return kith_spacetree_clamp(u + 0.5, kith_spacetree_cells(tree, level));
}
/* Index of a layer. From the highest bit down a key is: ghost or not, level, Morton code of the vertex. */
static inline int kith_spacetree_layer(uint64_t vertex_key) {
  const int top = (int)(vertex_key >> KITH_VERTEX_BITS);
  return (top >> KITH_LEVEL_BITS) * KITH_SPACETREE_LEVELS + (top & ((1 << KITH_LEVEL_BITS) - 1));
}

/* kith_search_sweep (sweep.c). UNSUPPORTED if a search radius is too large for any cell. */
kith_status kith_spacetree_sweep(const struct kith_search *search, const struct kith_sweep *sweep,
                                 void *context);

#endif
