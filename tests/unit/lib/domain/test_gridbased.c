/* test_gridbased.c - the mesh of partitioner gridbased, for 1 to 64 ranks: corners of one color share no
 * rank, and the shapes of ranks fill the box exactly once, after any update. Oracle: definitions in exact
 * integers. The member is compiled into this test, since its mesh is private. */
#include "lib/domain/partition/gridbased.c"

#include <stdlib.h>

#include "tests/unit/lib/domain/partition_world.h"

enum { MOST_RANKS = 64, MOST_CELLS = 2048, UPDATES = 3 };

/* Corners belong to a common rank if they are at most one apart along every axis; then their colors must
 * differ. */
static void check_colors(const struct mesh *mesh) {
  bool covered[SHAPE_CORNERS] = {false};
  for (int64_t c = 0; c < mesh->n_corners; ++c) {
    int64_t i[NDIM];
    kith_grid_place(mesh->corners, c, i);
    CHECK(kith_grid_number(mesh->corners, i) == c);
    CHECK(color_of(i) >= 0 && color_of(i) < SHAPE_CORNERS);
    covered[color_of(i)] = true;
    for (int64_t d = 0; d < c; ++d) {
      int64_t j[NDIM], apart = 0;
      kith_grid_place(mesh->corners, d, j);
      for (int a = 0; a < NDIM; ++a) apart = KITH_MAX(apart, llabs((long long)(i[a] - j[a])));
      if (apart <= 1) CHECK(color_of(i) != color_of(j));
    }
  }
  for (int color = 0; color < SHAPE_CORNERS; ++color)
    CHECK(covered[color]); /* there are at least two corners along each axis */
}

/* Corners on faces of the box stay there; volumes are positive, and sum to that of the box; the midpoint of
 * every cell is in the shape of its owner. All numbers are integers, so all comparisons are exact. */
static void check_cover(const struct kith_partition *partition) {
  const struct mesh *mesh = partition->self;
  int64_t sum = 0, box = NDIM == 3 ? 6 : NDIM;
  for (int a = 0; a < NDIM; ++a) box *= mesh->length[a];
  for (int64_t c = 0; c < mesh->n_corners; ++c) {
    int64_t i[NDIM];
    kith_grid_place(mesh->corners, c, i);
    for (int a = 0; a < NDIM; ++a) {
      const int64_t x = mesh->corner[c * NDIM + a];
      CHECK(x >= 0 && x <= mesh->length[a]);
      CHECK((i[a] != 0 || x == 0) && (i[a] != mesh->ranks[a] || x == mesh->length[a]));
    }
  }
  for (int r = 0; r < partition->n_ranks; ++r) {
    int64_t i[NDIM];
    kith_grid_place(mesh->ranks, r, i);
    const struct shape shape = shape_at(mesh, mesh->corner, i);
    for (int s = 0; s < SIMPLICES; ++s) {
      const int64_t own = volume(&shape, s, -1, NULL);
      CHECK(own > 0);
      sum += own;
    }
    for (int64_t c = 0; c < partition->cells->n; ++c) {
      int64_t k[NDIM];
      if (partition->owner[c] != r) continue;
      kith_grid_place(partition->cells->count, c, k);
      for (int a = 0; a < NDIM; ++a) k[a] = k[a] * mesh->unit + mesh->unit / 2;
      CHECK(contains(&shape, k));
    }
  }
  CHECK(sum == box);
}

/* Weights peak in a corner, later in the middle, so that the mesh moves one way and back. */
static void update_with_peak(struct kith_partition *partition, int k) {
  static double weight[MOST_CELLS];
  bool changed;
  for (int64_t c = 0; c < partition->cells->n; ++c) {
    int64_t at[NDIM];
    double r2 = 0;
    kith_grid_place(partition->cells->count, c, at);
    for (int a = 0; a < NDIM; ++a) {
      const double x = (double)at[a] / (double)partition->cells->count[a] - (k < UPDATES ? 0 : 0.5);
      r2 += x * x;
    }
    weight[c] = 1 + 100 * exp(-20 * r2);
  }
  CHECK_OK(kith_partition_update(partition, weight, &changed));
}

int main(void) {
  const int count[][3] = {{15, 10, 7}, {3, 3, 3}, {1, 64, 2}};
  for (size_t g = 0; g < sizeof count / sizeof count[0]; ++g)
    for (int n_ranks = 1; n_ranks <= MOST_RANKS && check_failures == 0; ++n_ranks) {
      const struct kith_cells cells = grid(count[g], g % 2 == 1 ? ~0 : 0);
      struct kith_partition *partition = partition_of(&cells, n_ranks, "gridbased");
      check_colors(partition->self);
      check_cover(partition);
      for (int k = 0; k < 2 * UPDATES; ++k) {
        update_with_peak(partition, k);
        check_cover(partition);
      }
      if (check_failures > 0) fprintf(stderr, "  %d ranks, %d cells\n", n_ranks, (int)cells.n);
      kith_partition_destroy(&partition);
    }
  return check_failed();
}
