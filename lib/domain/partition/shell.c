/* Ghost cells of a rank, and the figures of a map. */
#include "lib/domain/partition/shell.h"

#include "lib/core/sfc_key.h"

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

/* ---- figures ---- */

static void count_faces(const struct kith_partition *partition, const double *face_weight, int64_t c,
                        struct kith_rank_figures *rank, struct kith_partition_figures *all) {
  for (int a = 0; a < NDIM; ++a) {
    const int64_t next = kith_cells_beside(partition->cells, c, a, 1);
    if (next < 0 || partition->owner[next] == partition->owner[c]) continue;
    ++rank[partition->owner[c]].cut_faces;
    ++rank[partition->owner[next]].cut_faces;
    ++all->cut_faces;
    all->cut += face_weight == NULL ? 1 : face_weight[c * NDIM + a];
  }
}

/* Cells in the order of their owners, so that a rank is met once as p; met_by[q] is the last rank, and the
 * last cell, that q was met by. */
static void count_contacts(const struct kith_partition *partition, const kith_index *by_owner,
                           int64_t (*met_by)[2], struct kith_rank_figures *rank) {
  for (int q = 0; q < partition->n_ranks; ++q) met_by[q][0] = met_by[q][1] = -1;
  for (int64_t i = 0; i < partition->cells->n; ++i) {
    const int64_t c = by_owner[i], p = partition->owner[c];
    struct kith_cell_image image[KITH_CELL_NEIGHBORS];
    const int n = kith_cells_neighbors(partition->cells, c, image, NULL);
    for (int k = 0; k < n; ++k) {
      const int32_t q = partition->owner[image[k].cell];
      if (q == p || met_by[q][1] == c) continue;
      ++rank[p].sends;
      ++rank[q].ghosts;
      rank[p].neighbors += met_by[q][0] != p;
      met_by[q][0] = p, met_by[q][1] = c;
    }
  }
}

static kith_status find_contacts(const struct kith_partition *partition, struct kith_rank_figures *rank) {
  const size_t n = (size_t)partition->cells->n;
  uint64_t *key = NULL;
  kith_index *by_owner = NULL;
  int64_t(*met_by)[2] = NULL;
  kith_status status = kith_resize(&key, 0, n, sizeof *key);
  if (status == KITH_OK) status = kith_resize(&by_owner, 0, n, sizeof *by_owner);
  if (status == KITH_OK) status = kith_resize(&met_by, 0, (size_t)partition->n_ranks, sizeof *met_by);
  for (size_t c = 0; status == KITH_OK && c < n; ++c) key[c] = (uint64_t)partition->owner[c];
  if (status == KITH_OK) status = kith_sfc_key_sort(n, key, NULL, by_owner);
  if (status == KITH_OK) count_contacts(partition, by_owner, met_by, rank);
  kith_free(&key);
  kith_free(&by_owner);
  kith_free(&met_by);
  return status;
}

static void sum_up(int n_ranks, const struct kith_rank_figures *rank, struct kith_partition_figures *all) {
  double total = 0;
  for (int r = 0; r < n_ranks; ++r) {
    total += rank[r].weight;
    all->largest_weight = KITH_MAX(all->largest_weight, rank[r].weight);
    all->largest_ghosts = KITH_MAX(all->largest_ghosts, rank[r].ghosts);
    all->largest_neighbors = KITH_MAX(all->largest_neighbors, rank[r].neighbors);
    all->empty_ranks += rank[r].cells == 0;
  }
  all->mean_weight = total / n_ranks;
  all->imbalance = total > 0 ? all->largest_weight / all->mean_weight : 1;
}

kith_status kith_partition_figures(const struct kith_partition *partition, const double *weight,
                                   const double *face_weight, struct kith_rank_figures *rank,
                                   struct kith_partition_figures *all) {
  for (int r = 0; r < partition->n_ranks; ++r) rank[r] = (struct kith_rank_figures){0};
  *all = (struct kith_partition_figures){0};
  KITH_TRY(find_contacts(partition, rank));
  for (int64_t c = 0; c < partition->cells->n; ++c) {
    rank[partition->owner[c]].weight += weight == NULL ? 1 : weight[c];
    ++rank[partition->owner[c]].cells;
    count_faces(partition, face_weight, c, rank, all);
  }
  sum_up(partition->n_ranks, rank, all);
  return KITH_OK;
}
