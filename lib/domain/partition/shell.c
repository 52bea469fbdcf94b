/* Ghost cells of a rank. */
#include "lib/domain/partition/shell.h"

#include <stdlib.h>

static int ascending(const void *a, const void *b) {
  const int64_t p = *(const int64_t *)a, q = *(const int64_t *)b;
  return (p > q) - (p < q);
}

/* Entries, rank times cells + cell, become rows of cells: the row of neighbor k is cell[first[k]] ..
 * cell[first[k + 1] - 1], ascending, each cell once. `neighbor` and `first` have room for all ranks. */
static void make_rows(int64_t *entry, size_t n, int64_t cells, struct kith_shell *shell, int64_t *first) {
  int64_t last = -1, left = 0;
  shell->n_neighbors = 0;
  if (n > 0) qsort(entry, n, sizeof *entry, ascending);
  for (size_t k = 0; k < n; last = entry[k++]) {
    if (entry[k] == last) continue;
    if (last < 0 || entry[k] / cells != last / cells) {
      shell->neighbor[shell->n_neighbors] = (int32_t)(entry[k] / cells);
      first[shell->n_neighbors++] = left;
    }
    entry[left++] = entry[k];
  }
  first[shell->n_neighbors] = left;
  for (int64_t k = 0; k < left; ++k) entry[k] %= cells;
}

kith_status kith_shell_build(struct kith_shell *shell, const struct kith_partition *partition, int rank) {
  const struct kith_cells *cells = partition->cells;
  const size_t ranks = (size_t)partition->n_ranks;
  if (rank < 0 || rank >= partition->n_ranks)
    KITH_FAIL(BAD_INPUT, "shell of rank %d: there are %d", rank, partition->n_ranks);
  kith_shell_clear(shell);
  shell->rank = rank;
  for (int64_t c = 0; c < cells->n; ++c) shell->n_cells += partition->owner[c] == rank;
  const size_t most = (size_t)shell->n_cells * KITH_CELL_NEIGHBORS;
  KITH_TRY(kith_resize(&shell->cell, 0, (size_t)shell->n_cells, sizeof *shell->cell));
  KITH_TRY(kith_resize(&shell->neighbor, 0, ranks, sizeof *shell->neighbor));
  KITH_TRY(kith_resize(&shell->receive_first, 0, ranks + 1, sizeof *shell->receive_first));
  KITH_TRY(kith_resize(&shell->send_first, 0, ranks + 1, sizeof *shell->send_first));
  KITH_TRY(kith_resize(&shell->receive, 0, most, sizeof *shell->receive));
  KITH_TRY(kith_resize(&shell->send, 0, most, sizeof *shell->send));
  size_t n = 0;
  for (int64_t c = 0, i = 0; c < cells->n; ++c) {
    if (partition->owner[c] != rank) continue;
    shell->cell[i++] = c;
    struct kith_cell_image image[KITH_CELL_NEIGHBORS];
    const int n_images = kith_cells_neighbors(cells, c, image, NULL);
    for (int k = 0; k < n_images; ++k) {
      const int64_t d = image[k].cell, q = partition->owner[d];
      if (q == rank) continue;
      shell->send[n] = q * cells->n + c;
      shell->receive[n++] = q * cells->n + d;
    }
  }
  make_rows(shell->send, n, cells->n, shell, shell->send_first); /* both have the same neighbors */
  make_rows(shell->receive, n, cells->n, shell, shell->receive_first);
  shell->n_ghosts = shell->receive_first[shell->n_neighbors];
  return KITH_OK;
}

void kith_shell_clear(struct kith_shell *shell) {
  kith_free(&shell->cell);
  kith_free(&shell->neighbor);
  kith_free(&shell->receive_first);
  kith_free(&shell->send_first);
  kith_free(&shell->receive);
  kith_free(&shell->send);
  *shell = (struct kith_shell){0};
}
