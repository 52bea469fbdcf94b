/* cell_box.h - for tests: the box that a cell covers. */
#ifndef KITH_TEST_DOMAIN_CELL_BOX_H
#define KITH_TEST_DOMAIN_CELL_BOX_H

#include "lib/domain/cells.h"

static inline struct kith_box cell_box(const struct kith_cells *cells, int64_t c) {
  int64_t k[NDIM];
  struct kith_box box;
  kith_grid_place(cells->count, c, k);
  for (int a = 0; a < NDIM; ++a) {
    box.lower[a] = kith_cells_face(cells, a, k[a]);
    box.upper[a] = kith_cells_face(cells, a, k[a] + 1);
  }
  return box;
}

#endif
