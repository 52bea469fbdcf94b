/* Ghost shells against brute force over all pairs of cells, from both sides of every exchange. */
#include "lib/domain/partition/shell.h"

#include <stdlib.h>
#include <string.h>

#include "tests/unit/lib/domain/partition_world.h"

enum { MOST_RANKS = 64 };

/* Do the cells share a face, an edge or a corner, over periodic faces too? */
static bool adjacent(const struct kith_cells *cells, int64_t c, int64_t d) {
  for (int a = 0; a < NDIM; ++a) {
    const int64_t m = cells->count[a], apart = llabs(c % m - d % m);
    if (apart > 1 && !(cells->periodic[a] && apart == m - 1)) return false;
    c /= m, d /= m;
  }
  return true;
}

/* Checks the shell of a rank: every cell that should be a ghost is one, once, in its owner's list; nothing
 * else is. */
static void check_shell(const struct kith_partition *partition, const struct kith_shell *shell) {
  const struct kith_cells *cells = partition->cells;
  int64_t own = 0, ghosts = 0;
  for (int64_t d = 0; d < cells->n; ++d) {
    if (partition->owner[d] == shell->rank) CHECK(shell->cell[own++] == d);
    bool wanted = false;
    for (int64_t c = 0; c < cells->n && partition->owner[d] != shell->rank; ++c)
      wanted = wanted || (partition->owner[c] == shell->rank && adjacent(cells, c, d));
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

/* What p sends to q is, place by place, what q expects of p. */
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

static void check_map(const struct kith_partition *partition) {
  struct kith_shell shell[MOST_RANKS] = {{0}};
  for (int r = 0; r < partition->n_ranks; ++r) {
    CHECK_OK(kith_shell_build(&shell[r], partition, r, 0));
    CHECK_OK(kith_shell_build(&shell[r], partition, r, 0)); /* again, in the same memory */
    check_shell(partition, &shell[r]);
  }
  check_both_sides(shell, partition->n_ranks);
  for (int r = 0; r < partition->n_ranks; ++r) kith_shell_clear(&shell[r]);
}

/* Any map will do: owners by lot, the worst shells there are, and blocks. */
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
        check_map(partition);
        for (int64_t c = 0; c < cells.n; ++c)
          partition->owner[c] = (int32_t)(check_random(&random) * ranks[r]);
        check_map(partition);
        kith_partition_destroy(&partition);
        if (check_failures > 0) return;
      }
}

/* Two ranks on 10 cells an axis, all periodic: half of the cells each, and two layers of ghosts (R5 of the
 * grids that this follows: 500 and 200 in 3-D). */
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
  kith_shell_clear(&shell);
  kith_partition_destroy(&partition);
}

int main(void) {
  test_shells();
  test_two_ranks();
  return check_failed();
}
