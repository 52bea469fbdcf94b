/* test_shell.c - ghost cells of ranks, and the lists of cells that ranks exchange. Oracle: brute force over
 * all pairs of cells, from both sides of every exchange. */
#include "lib/domain/partition/shell.h"

#include <stdlib.h>
#include <string.h>

#include "tests/unit/lib/domain/partition_world.h"

enum { MOST_RANKS = 64 };

/* Are two cells, or periodic images of them, within reach of each other? */
static bool are_near(const struct kith_cells *cells, int64_t c, int64_t d, double reach) {
  double gap2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    const int64_t m = cells->count[a];
    int64_t apart = llabs(c % m - d % m);
    if (cells->periodic[a]) apart = KITH_MIN(apart, m - apart);
    const double gap = (double)KITH_MAX(apart - 1, 0) * cells->edge[a];
    gap2 += gap * gap;
    c /= m, d /= m;
  }
  return gap2 <= reach * reach;
}

/* Every cell that should be a ghost is one, once, in the list of its owner, and there are no others. */
static void check_shell(const struct kith_partition *partition, const struct kith_shell *shell) {
  const struct kith_cells *cells = partition->cells;
  int64_t own = 0, ghosts = 0;
  for (int64_t d = 0; d < cells->n; ++d) {
    if (partition->owner[d] == shell->rank) CHECK(shell->cell[own++] == d);
    bool wanted = false;
    for (int64_t c = 0; c < cells->n && partition->owner[d] != shell->rank; ++c)
      wanted = wanted || (partition->owner[c] == shell->rank && are_near(cells, c, d, shell->reach));
    int found = 0;
    for (int k = 0; k < shell->n_neighbors; ++k)
      for (int64_t i = shell->receive_first[k]; i < shell->receive_first[k + 1]; ++i) {
        if (shell->receive[i] != d) continue;
        ++found;
        CHECK(shell->neighbor[k] == partition->owner[d]);
      }
    CHECK(found == wanted);
    ghosts += wanted;
  }
  CHECK(own == shell->n_cells && ghosts == shell->n_ghosts);
  for (int k = 0; k < shell->n_neighbors; ++k) {
    CHECK(shell->neighbor[k] != shell->rank && (k == 0 || shell->neighbor[k] > shell->neighbor[k - 1]));
    for (int64_t i = shell->receive_first[k] + 1; i < shell->receive_first[k + 1]; ++i)
      CHECK(shell->receive[i] > shell->receive[i - 1]);
  }
}

/* What p sends to q is, in the same order, what q receives from p. */
static void check_both_sides(const struct kith_shell *shell, int n_ranks) {
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

/* A point in a cell of this rank finds it; points in other cells are refused. */
static void check_find(const struct kith_partition *partition, const struct kith_shell *shell) {
  const struct kith_cells *cells = partition->cells;
  for (int64_t c = 0; c < cells->n; ++c) {
    int64_t k[NDIM], own = -1;
    double x[NDIM];
    kith_grid_place(cells->count, c, k);
    for (int a = 0; a < NDIM; ++a) x[a] = kith_cells_face(cells, a, k[a]);
    const bool mine = partition->owner[c] == shell->rank;
    CHECK_STATUS(mine ? KITH_OK : KITH_BAD_INPUT, kith_shell_find(shell, partition, x, &own));
    if (mine) CHECK(own >= 0 && own < shell->n_cells && shell->cell[own] == c);
    if (!mine) CHECK(strstr(kith_failure(), "belongs to rank") != NULL);
  }
}

static void check_map(const struct kith_partition *partition, double reach) {
  struct kith_shell shell[MOST_RANKS] = {{0}};
  for (int r = 0; r < partition->n_ranks; ++r) {
    CHECK_OK(kith_shell_build(&shell[r], partition, r, 0));
    CHECK_OK(kith_shell_build(&shell[r], partition, r, reach)); /* again, in the memory of the first */
    check_shell(partition, &shell[r]);
    if (r < 3) check_find(partition, &shell[r]);
  }
  check_both_sides(shell, partition->n_ranks);
  for (int r = 0; r < partition->n_ranks; ++r) kith_shell_clear(&shell[r]);
}

/* Maps with random owners, which have the largest shells, and blocks; kith_shell_build takes any map. */
static void test_shells(void) {
  const int count[][3] = {{1, 1, 1}, {2, 1, 3}, {1, 2, 2}, {3, 3, 3}, {7, 4, 2}, {12, 2, 1}};
  const int ranks[] = {1, 2, 3, 4, 7, 8, 64};
  uint64_t random = 3;
  for (size_t g = 0; g < sizeof count / sizeof count[0]; ++g)
    for (int periodic = 0; periodic < 4; ++periodic)
      for (size_t r = 0; r < sizeof ranks / sizeof ranks[0]; ++r) {
        const struct kith_cells cells = grid(count[g], (periodic & 1) | (periodic & 2 ? ~1 : 0));
        struct kith_partition *partition = NULL;
        CHECK_OK(kith_partition_create(&partition, &cells, ranks[r], "cart"));
        check_map(partition, 0);
        for (int64_t c = 0; c < cells.n; ++c)
          partition->owner[c] = (int32_t)(check_random(&random) * ranks[r]);
        const double edge = cells.edge[0], reach[] = {0, 0.99 * edge, 1.5 * edge, 1e9 * edge};
        check_map(partition, reach[(g + r) % 4]);
        kith_partition_destroy(&partition);
        if (check_failures > 0) return;
      }
}

/* Two ranks with 10 cells along each periodic axis: each has half of the cells and two layers of ghosts; in
 * 3-D 500 cells and 200 ghosts. */
static void test_two_ranks(void) {
  const int count[] = {10, 10, 10};
  const struct kith_cells cells = grid(count, ~0);
  struct kith_partition *partition = NULL;
  CHECK_OK(kith_partition_create(&partition, &cells, 2, "cart"));
  struct kith_shell shell = {0};
  for (int r = 0; r < 2; ++r) {
    CHECK_OK(kith_shell_build(&shell, partition, r, 0));
    CHECK(2 * shell.n_cells == cells.n && 5 * shell.n_ghosts == cells.n);
    CHECK(shell.n_neighbors == 1 && shell.send_first[1] == shell.n_ghosts);
  }
  CHECK_STATUS(KITH_BAD_INPUT, kith_shell_build(&shell, partition, 2, 0));
  CHECK_STATUS(KITH_BAD_INPUT, kith_shell_build(&shell, partition, -1, 0));
  CHECK_STATUS(KITH_BAD_INPUT, kith_shell_build(&shell, partition, 0, NAN));
  kith_shell_clear(&shell);
  kith_partition_destroy(&partition);
}

/* Positions that kith_shell_find refuses, with their messages. */
static void test_refused_positions(void) {
  const int count[] = {4, 4, 4};
  const struct kith_cells open = grid(count, 0), around = grid(count, ~0);
  struct kith_partition *partition = NULL;
  struct kith_shell shell = {0};
  double x[NDIM];
  int64_t own;
  for (int periodic = 0; periodic < 2; ++periodic) {
    const struct kith_cells *cells = periodic ? &around : &open;
    CHECK_OK(kith_partition_create(&partition, cells, 1, "cart"));
    CHECK_OK(kith_shell_build(&shell, partition, 0, 0));
    /* the upper face belongs to the last cell; in periodic boxes to the first */
    memcpy(x, cells->upper, sizeof x);
    CHECK_OK(kith_shell_find(&shell, partition, x, &own));
    CHECK(own == (periodic ? 0 : cells->n - 1));
    x[NDIM - 1] += cells->edge[NDIM - 1];
    CHECK_STATUS(periodic ? KITH_OK : KITH_BAD_INPUT, kith_shell_find(&shell, partition, x, &own));
    if (!periodic) CHECK(strstr(kith_failure(), "is outside of") != NULL);
    x[0] = NAN;
    CHECK_STATUS(KITH_BAD_INPUT, kith_shell_find(&shell, partition, x, &own));
    CHECK(strstr(kith_failure(), "not finite") != NULL);
    kith_partition_destroy(&partition);
  }
  kith_shell_clear(&shell);
}

int main(void) {
  test_shells();
  test_refused_positions();
  test_two_ranks();
  return check_failed();
}
