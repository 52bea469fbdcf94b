/* p4est.c - the order of the leaves of a p4est forest: a brick of trees, whose depth is the number of times
 * that all counts of cells can be halved.
 *
 * Burstedde, Wilcox and Ghattas, SIAM J. Sci. Comput. 33, 1103 (2011). The library lays out the brick and
 * numbers the leaves, which needs no communicator. The curve is cut as for the other curves. In 1-D the brick
 * is one tree high and each tree has one leaf: the order is that of the cells. */
#include "lib/domain/partition/partition.h"

#ifdef KITH_P4EST
#if NDIM == 3
#include <p4est_to_p8est.h>
#include <p8est_bits.h>
#else
#include <p4est_bits.h>
#endif

static p4est_connectivity_t *new_brick(const int *trees, const struct kith_cells *cells) {
#if NDIM == 3
  const bool *p = cells->periodic;
  return p8est_connectivity_new_brick(trees[0], trees[1], trees[2], p[0], p[1], p[2]);
#else
  return p4est_connectivity_new_brick(trees[0], NDIM == 1 ? 1 : trees[NDIM - 1], cells->periodic[0],
                                      NDIM == 1 ? 0 : cells->periodic[NDIM - 1]);
#endif
}

/* How often the counts of all axes can be halved. */
static int depth_of(const struct kith_cells *cells) {
  int depth = 0;
  for (bool even = NDIM > 1; even; depth += even)
    for (int a = 0; a < NDIM; ++a) even = even && (cells->count[a] >> depth) % 2 == 0;
  return depth;
}

/* The cell of leaf number `leaf` of the tree whose first corner is at `corner`. */
static int64_t cell_of(const struct kith_cells *cells, const double *corner, int depth, uint64_t leaf) {
  p4est_quadrant_t quadrant;
  p4est_quadrant_set_morton(&quadrant, depth, leaf);
  int64_t k[3] = {quadrant.x, quadrant.y, 0};
#if NDIM == 3
  k[2] = quadrant.z;
#endif
  for (int a = 0; a < NDIM; ++a) k[a] = (k[a] >> (P4EST_MAXLEVEL - depth)) + ((int64_t)corner[a] << depth);
  return kith_grid_number(cells->count, k);
}

static kith_status p4est_first(struct kith_partition *partition, int32_t *owner) {
  const struct kith_cells *cells = partition->cells;
  const int depth = depth_of(cells);
  int trees[NDIM];
  for (int a = 0; a < NDIM; ++a) trees[a] = (int)(cells->count[a] >> depth);
  uint64_t *key = NULL, next = 0;
  KITH_TRY(kith_resize(&key, 0, (size_t)cells->n, sizeof *key));
  p4est_connectivity_t *brick = new_brick(trees, cells);
  for (p4est_topidx_t tree = 0; tree < brick->num_trees; ++tree) {
    const double *corner = brick->vertices + 3 * brick->tree_to_vertex[P4EST_CHILDREN * tree];
    for (uint64_t leaf = 0; leaf < UINT64_C(1) << (NDIM * depth); ++leaf)
      key[cell_of(cells, corner, depth, leaf)] = next++;
  }
  p4est_connectivity_destroy(brick);
  const kith_status status = kith_curve_first(partition, key, owner);
  kith_free(&key);
  return status;
}
#endif

const struct kith_partitioner_ops kith_partitioner_p4est = {
    .name = "p4est",
    .doc = "cuts of the leaves of a p4est brick at equal weight",
#ifdef KITH_P4EST
    KITH_CURVE,
    .first = p4est_first,
#else
    .needs = "p4est (Debian: libp4est-dev)",
#endif
};
