/* cart.c - Cartesian blocks that never change, or slabs or pencils: along the first axes only. Cell
 * coordinate k on an axis with d blocks and m cells belongs to block floor(k d / m). */
#include "lib/domain/partition/partition.h"

/* cost: cells of the largest block, cut faces. */
static void cost_of(const struct kith_cells *cells, const int *ranks, double cost[2]) {
  cost[0] = 1, cost[1] = 0;
  for (int a = 0; a < NDIM; ++a) {
    const int cuts = ranks[a] == 1 ? 0 : cells->periodic[a] ? ranks[a] : ranks[a] - 1;
    cost[0] *= ceil((double)cells->count[a] / ranks[a]);
    cost[1] += (double)cuts * (double)cells->n / (double)cells->count[a];
  }
}

/* Better balance is worth more cut faces only beyond this ratio: slabs are often better by one layer. */
static const double ENOUGH = 1.1;

/* Tries all factorizations of `left` over the axes from `axis` on. With least = 0 the smallest largest block
 * is sought; then, with `least` that size, the first mesh with the fewest cut faces among the balanced
 * ones. */
static void try_axes(const struct kith_cells *cells, int axis, int axes, int left, double least, int *ranks,
                     int *best, double *best_cost) {
  if (axis + 1 < axes) {
    for (int d = 1; d <= left; ++d) {
      if (left % d != 0) continue;
      ranks[axis] = d;
      try_axes(cells, axis + 1, axes, left / d, least, ranks, best, best_cost);
    }
    return;
  }
  ranks[axis] = left;
  double cost[2];
  cost_of(cells, ranks, cost);
  const double judged = least == 0 ? cost[0] : cost[1];
  if ((least > 0 && cost[0] > ENOUGH * least) || judged >= *best_cost) return;
  *best_cost = judged;
  for (int a = 0; a < NDIM; ++a) best[a] = ranks[a];
}

void kith_partition_mesh(const struct kith_cells *cells, int n_ranks, int axes, int *ranks) {
  int tried[NDIM];
  double least = INFINITY, faces = INFINITY;
  for (int a = 0; a < NDIM; ++a) tried[a] = 1;
  try_axes(cells, 0, KITH_MIN(axes, NDIM), n_ranks, 0, tried, ranks, &least);
  try_axes(cells, 0, KITH_MIN(axes, NDIM), n_ranks, least, tried, ranks, &faces);
}

struct cart {
  int axes;
};
static const struct kith_param cart_params[] = {
    {"axes", KITH_PARAM_INTEGER, "3", "[1, 3]", "axes that are cut, the first ones: 1 makes slabs, 2 pencils",
     KITH_INTO(struct cart, axes)},
    {0}};

static kith_status cart_first(struct kith_partition *partition, int32_t *owner) {
  const struct kith_cells *cells = partition->cells;
  int ranks[NDIM] = {0};
  kith_partition_mesh(cells, partition->n_ranks, ((const struct cart *)partition->settings)->axes, ranks);
  for (int64_t c = 0; c < cells->n; ++c) {
    int64_t k[NDIM], rank = 0;
    kith_grid_place(cells->count, c, k);
    for (int a = NDIM - 1; a >= 0; --a) rank = rank * ranks[a] + k[a] * ranks[a] / cells->count[a];
    owner[c] = (int32_t)rank;
  }
  return KITH_OK;
}

const struct kith_partitioner_ops kith_partitioner_cart = {
    .name = "cart",
    .doc = "Cartesian blocks of equal size; never changes",
    KITH_SETTINGS(cart_params, cart),
    .first = cart_first,
};
