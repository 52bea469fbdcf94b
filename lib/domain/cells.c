/* The grid of cells: coordinates, faces, neighbors. */
#include "lib/domain/cells.h"

static const double NEARLY = 1e-9; /* L / edge may round to just below a whole number */

/* Counts for this edge; returns their product (no integer yet: it may be huge). */
static double count_for(struct kith_cells *cells, double edge) {
  double n = 1;
  for (int a = 0; a < NDIM; ++a) {
    const double fits = floor((cells->upper[a] - cells->lower[a]) / edge + NEARLY);
    const double count = KITH_MIN(KITH_MAX(fits, 1), 1e18);
    cells->count[a] = (int64_t)count;
    n *= count;
  }
  return n;
}

kith_status kith_cells_init(struct kith_cells *cells, const double *lower, const double *upper,
                            const bool *periodic, double least_edge, int64_t most_cells) {
  struct kith_cells made = {.n = 1};
  if (!(least_edge > 0) || most_cells < 1 || most_cells > INT32_MAX)
    KITH_FAIL(BAD_INPUT, "%lld cells of an edge of %g", (long long)most_cells, least_edge);
  for (int a = 0; a < NDIM; ++a) {
    if (!(lower[a] < upper[a] && isfinite(upper[a] - lower[a])))
      KITH_FAIL(BAD_INPUT, "cells from %g to %g on axis %d: lower must be less than upper, and both finite",
                lower[a], upper[a], a);
    made.lower[a] = lower[a], made.upper[a] = upper[a];
    made.periodic[a] = periodic[a];
  }
  for (double edge = least_edge, n; (n = count_for(&made, edge)) > (double)most_cells;)
    edge *= KITH_MAX(pow(n / (double)most_cells, 1.0 / NDIM), 1.01);
  for (int a = 0; a < NDIM; ++a) {
    made.edge[a] = (upper[a] - lower[a]) / (double)made.count[a];
    made.n *= made.count[a];
  }
  *cells = made;
  return KITH_OK;
}

double kith_cells_face(const struct kith_cells *cells, int axis, int64_t k) {
  return k == cells->count[axis] ? cells->upper[axis] : cells->lower[axis] + (double)k * cells->edge[axis];
}

/* Rounding may put x one cell off: the faces have the last word. */
static int64_t cell_on_axis(const struct kith_cells *cells, int a, double x) {
  const double lower = cells->lower[a], length = cells->upper[a] - lower;
  if (cells->periodic[a] && !(x >= lower && x < cells->upper[a])) x -= length * floor((x - lower) / length);
  const double s = (x - lower) / cells->edge[a], last = (double)(cells->count[a] - 1);
  int64_t k = s > 0 ? (int64_t)(s < last ? s : last) : 0;
  while (k > 0 && x < kith_cells_face(cells, a, k)) --k;
  while (k + 1 < cells->count[a] && x >= kith_cells_face(cells, a, k + 1)) ++k;
  return k;
}

int64_t kith_cells_of(const struct kith_cells *cells, const double *x) {
  int64_t k[NDIM];
  for (int a = 0; a < NDIM; ++a) {
    if (!isfinite(x[a])) return -1;
    k[a] = cell_on_axis(cells, a, x[a]);
  }
  return kith_grid_number(cells->count, k);
}

int64_t kith_cells_beside(const struct kith_cells *cells, int64_t c, int axis, int side) {
  const int64_t m = cells->count[axis];
  int64_t k[NDIM];
  kith_grid_place(cells->count, c, k);
  k[axis] += side;
  if (k[axis] < 0 || k[axis] >= m) {
    if (!cells->periodic[axis]) return -1;
    k[axis] = (k[axis] + m) % m;
  }
  return kith_grid_number(cells->count, k);
}

/* Offset number `code` in base 3, one digit an axis: the middle code is the cell itself, and its mirror image
 * about the middle is the opposite offset. False: there is no cell. */
static bool image_at(const struct kith_cells *cells, const int64_t *k, int code,
                     struct kith_cell_image *image) {
  int64_t there[NDIM];
  for (int a = 0; a < NDIM; ++a, code /= 3) {
    there[a] = k[a] + code % 3 - 1;
    image->shift[a] = there[a] < 0 ? -1 : there[a] >= cells->count[a];
    if (image->shift[a] != 0 && !cells->periodic[a]) return false;
    there[a] -= image->shift[a] * cells->count[a];
  }
  image->cell = kith_grid_number(cells->count, there);
  return true;
}

int kith_cells_neighbors(const struct kith_cells *cells, int64_t c, struct kith_cell_image *image,
                         int *n_forward) {
  const int half = KITH_CELL_NEIGHBORS / 2;
  int64_t k[NDIM];
  kith_grid_place(cells->count, c, k);
  int n = 0;
  for (int d = 1; d <= half; ++d) n += image_at(cells, k, half + d, &image[n]);
  if (n_forward != NULL) *n_forward = n;
  for (int d = 1; d <= half; ++d) n += image_at(cells, k, half - d, &image[n]);
  return n;
}
