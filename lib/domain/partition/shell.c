/* The surroundings of a rank: own cells, ghost cells, neighbor ranks. */
#include "lib/domain/partition/shell.h"

#include <stdlib.h>

static int ascending(const void *a, const void *b) {
  const int64_t p = *(const int64_t *)a, q = *(const int64_t *)b;
  return (p > q) - (p < q);
}

/* Scratch of a build. Until make_rows entries of `send` and `receive` are rank * number of cells + cell. */
struct found {
  int64_t n_send, n_receive;
  size_t send_capacity, receive_capacity;
  int64_t *told;  /* [ranks] the last own cell that this rank is sent, plus 1 */
  uint8_t *known; /* [cells] is it a ghost cell already? */
};

/* Entries become rows of cells: the row of neighbor k is cell[first[k]] .. cell[first[k + 1] - 1], ascending.
 * `neighbor` and `first` have room for all ranks. */
static void make_rows(int64_t *entry, int64_t n, int64_t cells, struct kith_shell *shell, int64_t *first) {
  shell->n_neighbors = 0;
  if (n > 0) qsort(entry, (size_t)n, sizeof *entry, ascending);
  for (int64_t k = 0; k < n; ++k) {
    const int32_t rank = (int32_t)(entry[k] / cells);
    if (shell->n_neighbors == 0 || shell->neighbor[shell->n_neighbors - 1] != rank) {
      shell->neighbor[shell->n_neighbors] = rank;
      first[shell->n_neighbors++] = k;
    }
    entry[k] %= cells;
  }
  first[shell->n_neighbors] = n;
}

static kith_status add(struct kith_shell *shell, struct found *f, const struct kith_partition *partition,
                       int64_t c, int64_t d) {
  const int64_t q = partition->owner[d], n = partition->cells->n;
  if (q == shell->rank) return KITH_OK;
  if (f->told[q] != c + 1) {
    KITH_TRY(kith_grow(&shell->send, &f->send_capacity, (size_t)f->n_send, (size_t)f->n_send + 1,
                       sizeof *shell->send));
    shell->send[f->n_send++] = q * n + c;
    f->told[q] = c + 1;
  }
  if (f->known[d]) return KITH_OK;
  KITH_TRY(kith_grow(&shell->receive, &f->receive_capacity, (size_t)f->n_receive, (size_t)f->n_receive + 1,
                     sizeof *shell->receive));
  shell->receive[f->n_receive++] = q * n + d;
  f->known[d] = 1;
  return KITH_OK;
}

/* The offsets along an axis of the cells within reach of cell k, at most once around the box. */
static void range(const struct kith_cells *cells, int axis, int64_t k, double reach, int64_t *low,
                  int64_t *high) {
  const double steps = floor(reach / cells->edge[axis] * (1 + 1e-12)) + 1;
  const int64_t count = cells->count[axis], most = steps < (double)count ? (int64_t)steps : count;
  *low = cells->periodic[axis] ? -most : -KITH_MIN(most, k);
  *high = cells->periodic[axis] ? most : KITH_MIN(most, count - 1 - k);
}

/* Adds the cells of other ranks within reach of c. */
static kith_status look_around(struct kith_shell *shell, struct found *f,
                               const struct kith_partition *partition, int64_t c) {
  const struct kith_cells *cells = partition->cells;
  int64_t k[NDIM], low[NDIM], high[NDIM], offset[NDIM], there[NDIM];
  kith_grid_place(cells->count, c, k);
  for (int a = 0; a < NDIM; ++a) range(cells, a, k[a], shell->reach, &low[a], &high[a]), offset[a] = low[a];
  for (int a = 0; a < NDIM;) {
    double d2 = 0;
    for (int b = 0; b < NDIM; ++b) {
      const double gap = (double)KITH_MAX(llabs(offset[b]) - 1, 0) * cells->edge[b];
      there[b] = ((k[b] + offset[b]) % cells->count[b] + cells->count[b]) % cells->count[b];
      d2 += gap * gap;
    }
    if (d2 <= shell->reach * shell->reach * (1 + 1e-12))
      KITH_TRY(add(shell, f, partition, c, kith_grid_number(cells->count, there)));
    for (a = 0; a < NDIM && ++offset[a] > high[a]; ++a) offset[a] = low[a];
  }
  return KITH_OK;
}

static kith_status build(struct kith_shell *shell, const struct kith_partition *partition, struct found *f) {
  const int64_t cells = partition->cells->n;
  const size_t ranks = (size_t)partition->n_ranks;
  for (int64_t c = 0; c < cells; ++c) shell->n_cells += partition->owner[c] == shell->rank;
  KITH_TRY(kith_resize(&shell->cell, 0, (size_t)shell->n_cells, sizeof *shell->cell));
  KITH_TRY(kith_resize(&shell->neighbor, 0, ranks, sizeof *shell->neighbor));
  KITH_TRY(kith_resize(&shell->receive_first, 0, ranks + 1, sizeof *shell->receive_first));
  KITH_TRY(kith_resize(&shell->send_first, 0, ranks + 1, sizeof *shell->send_first));
  KITH_TRY(kith_resize(&f->told, 0, ranks, sizeof *f->told));
  KITH_TRY(kith_resize(&f->known, 0, (size_t)cells, 1));
  for (int64_t c = 0, i = 0; c < cells; ++c) {
    if (partition->owner[c] != shell->rank) continue;
    shell->cell[i++] = c;
    KITH_TRY(look_around(shell, f, partition, c));
  }
  make_rows(shell->send, f->n_send, cells, shell, shell->send_first); /* both have the same neighbors */
  make_rows(shell->receive, f->n_receive, cells, shell, shell->receive_first);
  shell->n_ghosts = f->n_receive;
  return KITH_OK;
}

kith_status kith_shell_build(struct kith_shell *shell, const struct kith_partition *partition, int rank,
                             double reach) {
  struct found found = {0};
  if (rank < 0 || rank >= partition->n_ranks)
    KITH_FAIL(BAD_INPUT, "shell of rank %d: there are %d", rank, partition->n_ranks);
  if (!(reach >= 0)) KITH_FAIL(BAD_INPUT, "shell of cells within %g", reach);
  kith_shell_clear(shell);
  shell->rank = rank, shell->reach = reach;
  const kith_status status = build(shell, partition, &found);
  KITH_FREE(&found.told, &found.known);
  if (status != KITH_OK) kith_shell_clear(shell);
  return status;
}

void kith_shell_clear(struct kith_shell *shell) {
  KITH_FREE(&shell->cell, &shell->neighbor, &shell->receive_first, &shell->send_first, &shell->receive,
            &shell->send);
  *shell = (struct kith_shell){0};
}

kith_status kith_shell_find(const struct kith_shell *shell, const struct kith_partition *partition,
                            const double *x, int64_t *own) {
  const struct kith_cells *cells = partition->cells;
  const int64_t c = kith_cells_of(cells, x);
  if (c < 0) KITH_FAIL(BAD_INPUT, "a position is not finite");
  for (int a = 0; a < NDIM; ++a)
    if (!cells->periodic[a] && !(x[a] >= cells->lower[a] && x[a] <= cells->upper[a]))
      KITH_FAIL(BAD_INPUT, "%g is outside of [%g, %g] on axis %d", x[a], cells->lower[a], cells->upper[a], a);
  if (partition->owner[c] != shell->rank)
    KITH_FAIL(BAD_INPUT, "cell %lld belongs to rank %d, not to rank %d", (long long)c,
              (int)partition->owner[c], shell->rank);
  const int64_t *found = bsearch(&c, shell->cell, (size_t)shell->n_cells, sizeof c, ascending);
  if (found == NULL) KITH_FAIL(INTERNAL, "the shell of rank %d is not of this map", shell->rank);
  *own = found - shell->cell;
  return KITH_OK;
}
