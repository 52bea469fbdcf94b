#include "lib/domain/shell.h"

#include <stdlib.h>

#include "lib/core/key.h"

/* A cell to be exchanged with a rank. */
struct entry {
  int64_t cell;
  int32_t rank;
};

struct entries {
  int64_t n, room;
  struct entry *entry; /* owned */
};

static kith_status add(struct entries *list, int32_t rank, int64_t cell) {
  if (list->n > 0 && list->entry[list->n - 1].rank == rank && list->entry[list->n - 1].cell == cell)
    return KITH_OK;
  if (list->n == list->room) {
    const int64_t room = list->room > 0 ? 2 * list->room : 256;
    KITH_TRY(kith_resize(&list->entry, (size_t)list->n, (size_t)room, sizeof *list->entry));
    list->room = room;
  }
  list->entry[list->n++] = (struct entry){cell, rank};
  return KITH_OK;
}

static int by_rank_then_cell(const void *a, const void *b) {
  const struct entry *p = a, *q = b;
  if (p->rank != q->rank) return p->rank < q->rank ? -1 : 1;
  return (p->cell > q->cell) - (p->cell < q->cell);
}

static void sort_unique(struct entries *list) {
  if (list->n == 0) return;
  qsort(list->entry, (size_t)list->n, sizeof *list->entry, by_rank_then_cell);
  int64_t n = 1;
  for (int64_t i = 1; i < list->n; ++i)
    if (by_rank_then_cell(&list->entry[i], &list->entry[n - 1]) != 0) list->entry[n++] = list->entry[i];
  list->n = n;
}

/* The ghosts of the rank and its cells that others have as ghosts. */
static kith_status collect(const struct kith_partition *partition, const struct kith_shell *shell,
                           struct entries *ghosts, struct entries *sent) {
  for (int64_t i = 0; i < shell->n_cells; ++i) {
    struct kith_cell_image image[KITH_CELL_NEIGHBORS];
    const int n = kith_cells_neighbors(partition->cells, shell->cell[i], image, NULL);
    for (int k = 0; k < n; ++k) {
      const int32_t rank = partition->owner[image[k].cell];
      if (rank == shell->rank) continue;
      KITH_TRY(add(ghosts, rank, image[k].cell));
      KITH_TRY(add(sent, rank, shell->cell[i]));
    }
  }
  sort_unique(ghosts);
  sort_unique(sent);
  return KITH_OK;
}

/* Rows by rank; the ranks are those of `list`, and the same in ghosts and sent, as adjacency is mutual. */
static kith_status to_rows(const struct entries *list, int n_neighbors, int64_t **first, int64_t **cell) {
  KITH_TRY(kith_resize(first, 0, (size_t)n_neighbors + 1, sizeof **first));
  KITH_TRY(kith_resize(cell, 0, (size_t)list->n, sizeof **cell));
  int row = 0;
  for (int64_t i = 0; i < list->n; ++i) {
    if (i > 0 && list->entry[i].rank != list->entry[i - 1].rank) (*first)[++row] = i;
    (*cell)[i] = list->entry[i].cell;
  }
  (*first)[n_neighbors] = list->n;
  return KITH_OK;
}

static kith_status find_neighbors(struct kith_shell *shell, const struct entries *ghosts) {
  KITH_TRY(kith_resize(&shell->neighbor, 0, (size_t)ghosts->n, sizeof *shell->neighbor));
  shell->n_neighbors = 0;
  for (int64_t i = 0; i < ghosts->n; ++i)
    if (i == 0 || ghosts->entry[i].rank != ghosts->entry[i - 1].rank)
      shell->neighbor[shell->n_neighbors++] = ghosts->entry[i].rank;
  return KITH_OK;
}

static kith_status find_own_cells(struct kith_shell *shell, const struct kith_partition *partition) {
  shell->n_cells = 0;
  for (int64_t c = 0; c < partition->cells->n; ++c) shell->n_cells += partition->owner[c] == shell->rank;
  KITH_TRY(kith_resize(&shell->cell, 0, (size_t)shell->n_cells, sizeof *shell->cell));
  for (int64_t c = 0, i = 0; c < partition->cells->n; ++c)
    if (partition->owner[c] == shell->rank) shell->cell[i++] = c;
  return KITH_OK;
}

kith_status kith_shell_build(struct kith_shell *shell, const struct kith_partition *partition, int rank) {
  if (rank < 0 || rank >= partition->n_ranks)
    KITH_FAIL(BAD_INPUT, "shell of rank %d: there are %d", rank, partition->n_ranks);
  shell->rank = rank;
  KITH_TRY(find_own_cells(shell, partition));
  struct entries ghosts = {0}, sent = {0};
  kith_status status = collect(partition, shell, &ghosts, &sent);
  shell->n_ghosts = ghosts.n;
  if (status == KITH_OK) status = find_neighbors(shell, &ghosts);
  if (status == KITH_OK)
    status = to_rows(&ghosts, shell->n_neighbors, &shell->receive_first, &shell->receive);
  if (status == KITH_OK) status = to_rows(&sent, shell->n_neighbors, &shell->send_first, &shell->send);
  kith_free(&ghosts.entry);
  kith_free(&sent.entry);
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

/* The foreign ranks next to a cell, each once; returns their number. */
static int ranks_beside(const struct kith_partition *partition, int64_t c, int32_t *rank) {
  struct kith_cell_image image[KITH_CELL_NEIGHBORS];
  const int n_images = kith_cells_neighbors(partition->cells, c, image, NULL);
  int n = 0;
  for (int k = 0; k < n_images; ++k) {
    const int32_t other = partition->owner[image[k].cell];
    int known = 0;
    while (known < n && rank[known] != other) ++known;
    if (other != partition->owner[c] && known == n) rank[n++] = other;
  }
  return n;
}

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

/* pair[] gets the number rank * n_ranks + other of every rank that is met beside every cell. */
static kith_status count_cells(const struct kith_partition *partition, const double *weight,
                               const double *face_weight, struct kith_rank_figures *rank,
                               struct kith_partition_figures *all, uint64_t **pair, int64_t *n_pairs) {
  int64_t room = 0;
  for (int64_t c = 0; c < partition->cells->n; ++c) {
    int32_t other[KITH_CELL_NEIGHBORS];
    const int own = partition->owner[c], n = ranks_beside(partition, c, other);
    if (*n_pairs + n > room) {
      room = 2 * (*n_pairs + n);
      KITH_TRY(kith_resize(pair, (size_t)*n_pairs, (size_t)room, sizeof **pair));
    }
    for (int k = 0; k < n; ++k) {
      ++rank[other[k]].ghosts;
      (*pair)[(*n_pairs)++] = (uint64_t)own * (uint64_t)partition->n_ranks + (uint64_t)other[k];
    }
    rank[own].sends += n;
    rank[own].weight += weight == NULL ? 1 : weight[c];
    ++rank[own].cells;
    count_faces(partition, face_weight, c, rank, all);
  }
  return KITH_OK;
}

static kith_status count_neighbors(int n_ranks, uint64_t *pair, int64_t n_pairs,
                                   struct kith_rank_figures *rank) {
  kith_index *order = NULL;
  KITH_TRY(kith_resize(&order, 0, (size_t)n_pairs, sizeof *order));
  const kith_status status = kith_key_sort((size_t)n_pairs, pair, NULL, order);
  for (int64_t i = 0; status == KITH_OK && i < n_pairs; ++i)
    if (i == 0 || pair[order[i]] != pair[order[i - 1]]) ++rank[pair[order[i]] / (uint64_t)n_ranks].neighbors;
  kith_free(&order);
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
  uint64_t *pair = NULL;
  int64_t n_pairs = 0;
  kith_status status = count_cells(partition, weight, face_weight, rank, all, &pair, &n_pairs);
  if (status == KITH_OK) status = count_neighbors(partition->n_ranks, pair, n_pairs, rank);
  kith_free(&pair);
  if (status == KITH_OK) sum_up(partition->n_ranks, rank, all);
  return status;
}
