/* kd.c - weighted recursive bisection: the ranks are halved, and the cells in the same proportion of weight.
 *
 * A set of cells is ordered along the longest axis of its bounding box, and cut where the middle of a cell's
 * weight passes the wanted fraction, within a layer if need be. Each cut is off by half a cell at most, and
 * all ranks on its side share that error: no rank exceeds the mean by more than 1.2 of the heaviest cell. */
#include "lib/domain/partition/partition.h"

struct bisection {
  const struct kith_cells *cells;
  const double *weight; /* NULL: equal */
  int32_t *owner;
  kith_index *cell, *sorted; /* [n] cells; a set is a range of them */
  kith_index *place;         /* [longest axis + 1] */
};

static double weight_of(const struct bisection *b, kith_index c) {
  return b->weight == NULL ? 1 : b->weight[c];
}

static int64_t coordinate(const struct kith_cells *cells, int64_t c, int axis) {
  int64_t k[NDIM];
  kith_grid_place(cells->count, c, k);
  return k[axis];
}

/* The longest axis of the bounding box of a set. */
static int longest_axis(const struct bisection *b, kith_index first, kith_index end) {
  int64_t low[NDIM], high[NDIM], k[NDIM];
  kith_grid_place(b->cells->count, b->cell[first], low);
  kith_grid_place(b->cells->count, b->cell[first], high);
  for (kith_index i = first; i < end; ++i) {
    kith_grid_place(b->cells->count, b->cell[i], k);
    for (int a = 0; a < NDIM; ++a) low[a] = KITH_MIN(low[a], k[a]), high[a] = KITH_MAX(high[a], k[a]);
  }
  int longest = 0;
  double length[NDIM];
  for (int a = 0; a < NDIM; ++a) {
    length[a] = (double)(high[a] - low[a] + 1) * b->cells->edge[a];
    if (length[a] > length[longest]) longest = a;
  }
  return longest;
}

/* Stable, by counting: O(cells + layers). */
static void sort_along(const struct bisection *b, kith_index first, kith_index end, int axis) {
  const int64_t layers = b->cells->count[axis];
  for (int64_t k = 0; k <= layers; ++k) b->place[k] = 0;
  for (kith_index i = first; i < end; ++i) ++b->place[coordinate(b->cells, b->cell[i], axis) + 1];
  for (int64_t k = 0; k < layers; ++k) b->place[k + 1] += b->place[k];
  for (kith_index i = first; i < end; ++i)
    b->sorted[b->place[coordinate(b->cells, b->cell[i], axis)]++] = b->cell[i];
  for (kith_index i = first; i < end; ++i) b->cell[i] = b->sorted[i - first];
}

static kith_index cut_at(const struct bisection *b, kith_index first, kith_index end, double fraction) {
  double total = 0, before = 0;
  for (kith_index i = first; i < end; ++i) total += weight_of(b, b->cell[i]);
  for (kith_index i = first; i < end; ++i) {
    const double w = weight_of(b, b->cell[i]);
    if (before + 0.5 * w > fraction * total) return i;
    before += w;
  }
  return end;
}

static void bisect(const struct bisection *b, kith_index first, kith_index end, int rank, int n_ranks) {
  if (n_ranks == 1)
    for (kith_index i = first; i < end; ++i) b->owner[b->cell[i]] = rank;
  if (n_ranks == 1 || first == end) return;
  const int low = n_ranks / 2;
  sort_along(b, first, end, longest_axis(b, first, end));
  const kith_index middle = cut_at(b, first, end, (double)low / n_ranks);
  bisect(b, first, middle, rank, low);
  bisect(b, middle, end, rank + low, n_ranks - low);
}

static kith_status kd_update(struct kith_partition *partition, const double *weight, int32_t *owner) {
  const struct kith_cells *cells = partition->cells;
  struct bisection b = {cells, weight, owner, NULL, NULL, NULL};
  const size_t n = (size_t)cells->n;
  int64_t longest = 0;
  for (int a = 0; a < NDIM; ++a) longest = KITH_MAX(longest, cells->count[a]);
  KITH_TRY(kith_resize(&b.cell, 0, 2 * n + (size_t)longest + 1, sizeof *b.cell));
  b.sorted = b.cell + n;
  b.place = b.sorted + n;
  for (size_t c = 0; c < n; ++c) b.cell[c] = (kith_index)c;
  bisect(&b, 0, (kith_index)n, 0, partition->n_ranks);
  kith_free(&b.cell);
  return KITH_OK;
}

const struct kith_partitioner_ops kith_partitioner_kd = {
    .name = "kd",
    .doc = "weighted recursive bisection",
    .update = kd_update,
};
