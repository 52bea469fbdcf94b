/* partition_world.h - for tests of partitions: a grid of unit cells, and partitions that must succeed. */
#ifndef KITH_TEST_DOMAIN_PARTITION_WORLD_H
#define KITH_TEST_DOMAIN_PARTITION_WORLD_H

#include <stdlib.h>

#include "lib/domain/partition/partition.h"
#include "tests/check.h"

/* Cells have edge 1 and the box begins at 0; bit a of periodic_axes makes axis a periodic. */
static inline struct kith_cells grid(const int *count, int periodic_axes) {
  double lower[NDIM], upper[NDIM];
  bool periodic[NDIM];
  for (int a = 0; a < NDIM; ++a) lower[a] = 0, upper[a] = count[a], periodic[a] = periodic_axes >> a & 1;
  struct kith_cells cells = {0};
  CHECK_OK(kith_cells_init(&cells, lower, upper, periodic, 1, 1 << 20));
  return cells;
}

/* Ends the program if the partition cannot be made. */
static inline struct kith_partition *partition_of(const struct kith_cells *cells, int n_ranks,
                                                  const char *text) {
  struct kith_partition *partition = NULL;
  CHECK_OK(kith_partition_create(&partition, cells, n_ranks, text));
  if (partition == NULL) exit(1);
  return partition;
}

#endif
