/* partition_world.h - what the tests of maps and shells share: a grid in whole numbers, and lists seen from
 * both sides. */
#ifndef KITH_TEST_DOMAIN_PARTITION_WORLD_H
#define KITH_TEST_DOMAIN_PARTITION_WORLD_H

#include <string.h>

#include "lib/domain/partition/shell.h"
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

/* What p sends to q is, place by place, what q expects of p. */
static inline void check_both_sides(const struct kith_shell *shell, int n_ranks) {
  for (int p = 0; p < n_ranks; ++p)
    for (int k = 0; k < shell[p].n_neighbors; ++k) {
      const struct kith_shell *other = &shell[shell[p].neighbor[k]];
      int back = 0;
      while (back < other->n_neighbors && other->neighbor[back] != p) ++back;
      CHECK(back < other->n_neighbors);
      if (back == other->n_neighbors) continue;
      const int64_t n = shell[p].send_first[k + 1] - shell[p].send_first[k];
      CHECK(n == other->receive_first[back + 1] - other->receive_first[back]);
      CHECK(n > 0 && memcmp(shell[p].send + shell[p].send_first[k],
                            other->receive + other->receive_first[back], (size_t)n * sizeof(int64_t)) == 0);
    }
}

#endif
