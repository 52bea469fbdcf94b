/* cells.h - a regular grid of cells over the scene's box: the units that are assigned to ranks.
 *
 * Cell c has coordinates k[NDIM], axis 0 running fastest: c = k0 + count0 (k1 + count1 k2). This linear
 * number is the cell's global id: 64 bits, the same on every rank. Faces belong to the cell above them, the
 * last face of an axis to the last cell or, if it is periodic, to the first one; a position is inside the box
 * of its cell exactly, whatever the rounding.
 *
 * Neighbors share a face, an edge or a corner; across a periodic face they are images. An image of a cell,
 * (cell, shift), is displaced by shift[a] (upper[a] - lower[a]). With 1 or 2 cells on a periodic axis a cell
 * is its own neighbor, or meets another cell more than once, as different images; so no axis needs three
 * cells.
 *
 * The grid is a plain value: it owns no memory and is copied freely. */
#ifndef KITH_DOMAIN_CELLS_H
#define KITH_DOMAIN_CELLS_H

#include "lib/core/vec.h"

enum { KITH_CELL_NEIGHBORS = NDIM == 1 ? 2 : NDIM == 2 ? 8 : 26 };

struct kith_cells {
  double lower[NDIM], upper[NDIM];
  double edge[NDIM]; /* (upper - lower) / count */
  bool periodic[NDIM];
  int64_t count[NDIM], n; /* per axis, at least 1; their product, at most INT32_MAX */
};

struct kith_cell_image {
  int64_t cell;
  int shift[NDIM]; /* -1, 0, 1 lengths of the box */
};

/* As many cells per axis as edges of at least `least_edge` fit (within 1e-9 of a cell), at least one: a box
 * may be thinner than that. If that makes more than `most_cells`, larger edges are used. BAD_INPUT: a box
 * that is empty or not finite; least_edge not positive (infinite: one cell); most_cells outside of 1 ..
 * INT32_MAX. */
kith_status kith_cells_init(struct kith_cells *cells, const double *lower, const double *upper,
                            const bool *periodic, double least_edge, int64_t most_cells);

/* The length of a periodic axis, 0 of others. */
static inline double kith_cells_period(const struct kith_cells *cells, int axis) {
  return cells->periodic[axis] ? cells->upper[axis] - cells->lower[axis] : 0;
}
/* The gap between two intervals of an axis, or between one and the nearest image of the other if the axis has
 * a period (0: none). below, above: how far one lies below and above the other; negative: they overlap. */
static inline double kith_gap(double below, double above, double period) {
  const double gap = KITH_MAX(KITH_MAX(below, above), 0.0);
  return period > 0 ? KITH_MIN(gap, KITH_MAX(period + KITH_MIN(below, above), 0.0)) : gap;
}

/* The cell of a position; a position outside of the box is wrapped on periodic axes and clamped on others. -1
 * for a position that is not finite. */
int64_t kith_cells_of(const struct kith_cells *cells, const double *x);

/* The lower face of cell k of an axis; k = count: the upper face of the box. */
double kith_cells_face(const struct kith_cells *cells, int axis, int64_t k);

/* Item `number` of a grid of count[NDIM] items has place k; axis 0 runs fastest. */
static inline void kith_grid_place(const int64_t *count, int64_t number, int64_t *k) {
  for (int a = 0; a < NDIM; ++a) {
    k[a] = number % count[a];
    number /= count[a];
  }
}
static inline int64_t kith_grid_number(const int64_t *count, const int64_t *k) {
  int64_t number = 0;
  for (int a = NDIM - 1; a >= 0; --a) number = number * count[a] + k[a];
  return number;
}

/* The cell across the face of c on side -1 or 1 of an axis (c itself if it is the only one on a periodic
 * axis); -1: none. */
int64_t kith_cells_beside(const struct kith_cells *cells, int64_t c, int axis, int side);

/* All neighbors of c except itself: their number is returned; `image` has space for KITH_CELL_NEIGHBORS. The
 * first *n_forward (may be NULL) are its forward half: the offsets whose last non-zero component is positive,
 * in the order +x, three of +y, nine of +z. A loop over the forward halves of all cells visits every
 * unordered pair of cell images, up to shifts of both, exactly once, without pairs of a cell with itself
 * unshifted. */
int kith_cells_neighbors(const struct kith_cells *cells, int64_t c, struct kith_cell_image *image,
                         int *n_forward);

#endif
