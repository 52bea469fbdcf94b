/* partition_world.h - what the tests of maps share: a grid in whole numbers. */
#ifndef KITH_TEST_DOMAIN_PARTITION_WORLD_H
#define KITH_TEST_DOMAIN_PARTITION_WORLD_H

#include "lib/domain/partition/partition.h"
#include "tests/check.h"

/* Cells have edge 1, the box begins at 0; bit a of periodic_axes is axis a. */
static inline struct kith_cells grid(const int *count, int periodic_axes) {
  double lower[NDIM], upper[NDIM];
  bool periodic[NDIM];
  for (int a = 0; a < NDIM; ++a) lower[a] = 0, upper[a] = count[a], periodic[a] = periodic_axes >> a & 1;
  struct kith_cells cells = {0};
  CHECK_OK(kith_cells_init(&cells, lower, upper, periodic, 1, 1 << 20));
  return cells;
}

#endif
