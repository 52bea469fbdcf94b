/* Ghost cells of a rank, and the figures of a map. */
#include "lib/domain/partition/shell.h"

#include "lib/core/sfc_key.h"

/* What is counted while a shell is built, then the place to write next. */
struct tally {
  int64_t ghosts, sent; /* from and to a rank */
  int64_t last;         /* cell that was sent there: a cell may touch a rank often */
};

static kith_status find_own_cells(struct kith_shell *shell, const struct kith_partition *partition) {
  shell->n_cells = 0;
  for (int64_t c = 0; c < partition->cells->n; ++c) shell->n_cells += partition->owner[c] == shell->rank;
  KITH_TRY(kith_resize(&shell->cell, 0, (size_t)shell->n_cells, sizeof *shell->cell));
  for (int64_t c = 0, i = 0; c < partition->cells->n; ++c)
    if (partition->owner[c] == shell->rank) shell->cell[i++] = c;
  return KITH_OK;
}

/* Counts the cells of all lists; if `write`, tally[] has the places where they begin. Cells are met in
 * ascending order. */
static void sweep(struct kith_shell *shell, const struct kith_partition *partition, struct tally *tally,
                  uint8_t *is_ghost, bool write) {
  for (int q = 0; q < partition->n_ranks; ++q) tally[q].last = -1;
  for (int64_t i = 0; i < shell->n_cells; ++i) {
    const int64_t c = shell->cell[i];
    struct kith_cell_image image[KITH_CELL_NEIGHBORS];
    const int n = kith_cells_neighbors(partition->cells, c, image, NULL);
    for (int k = 0; k < n; ++k) {
      const int32_t q = partition->owner[image[k].cell];
      if (q == shell->rank) continue;
      is_ghost[image[k].cell] = 1;
      if (tally[q].last == c) continue;
      if (write) shell->send[tally[q].sent] = c;
      ++tally[q].sent;
      tally[q].last = c;
    }
  }
  for (int64_t d = 0; d < partition->cells->n; ++d) {
    if (!is_ghost[d]) continue;
    struct tally *from = &tally[partition->owner[d]];
    if (write) shell->receive[from->ghosts] = d;
    ++from->ghosts;
  }
}

/* From counts to rows, and to the places where they begin. */
static kith_status make_rows(struct kith_shell *shell, int n_ranks, struct tally *tally) {
  shell->n_neighbors = 0;
  for (int q = 0; q < n_ranks; ++q) shell->n_neighbors += tally[q].ghosts > 0;
  const size_t rows = (size_t)shell->n_neighbors;
  KITH_TRY(kith_resize(&shell->neighbor, 0, rows, sizeof *shell->neighbor));
  KITH_TRY(kith_resize(&shell->receive_first, 0, rows + 1, sizeof *shell->receive_first));
  KITH_TRY(kith_resize(&shell->send_first, 0, rows + 1, sizeof *shell->send_first));
  int64_t *received = shell->receive_first, *sent = shell->send_first;
  int row = 0;
  for (int q = 0; q < n_ranks; ++q) {
    if (tally[q].ghosts == 0) continue;
    shell->neighbor[row++] = q;
    received[row] = received[row - 1] + tally[q].ghosts;
    sent[row] = sent[row - 1] + tally[q].sent;
    tally[q].ghosts = received[row - 1], tally[q].sent = sent[row - 1];
  }
  shell->n_ghosts = received[row];
  KITH_TRY(kith_resize(&shell->receive, 0, (size_t)received[row], sizeof *shell->receive));
  return kith_resize(&shell->send, 0, (size_t)sent[row], sizeof *shell->send);
}

kith_status kith_shell_build(struct kith_shell *shell, const struct kith_partition *partition, int rank) {
  if (rank < 0 || rank >= partition->n_ranks)
    KITH_FAIL(BAD_INPUT, "shell of rank %d: there are %d", rank, partition->n_ranks);
  shell->rank = rank;
  KITH_TRY(find_own_cells(shell, partition));
  struct tally *tally = NULL;
  uint8_t *is_ghost = NULL;
  kith_status status = kith_resize(&tally, 0, (size_t)partition->n_ranks, sizeof *tally);
  if (status == KITH_OK) status = kith_resize(&is_ghost, 0, (size_t)partition->cells->n, sizeof *is_ghost);
  if (status == KITH_OK) {
    sweep(shell, partition, tally, is_ghost, false);
    status = make_rows(shell, partition->n_ranks, tally);
  }
  if (status == KITH_OK) sweep(shell, partition, tally, is_ghost, true);
  kith_free(&tally);
  kith_free(&is_ghost);
  return status;
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
