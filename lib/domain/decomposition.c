/* The map of cells to ranks, load balance, redistribution of nodes, and what checkpoints store of them. Here
 * `d` is the decomposition. */
#include "lib/domain/decomposition.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "lib/nodes/migrate.h"

/* ---- cells ---- */

kith_status kith_decomposition_cells(struct kith_cells *cells, const struct kith_nodes *nodes,
                                     const struct kith_box *box, const bool *periodic, int64_t most) {
  double least = INFINITY;
  for (kith_index i = 0; i < nodes->n_internal; ++i) least = KITH_MIN(least, nodes->support->f64[i]);
  kith_ranks_min(nodes->ranks, &least, 1);
  return kith_cells_init(cells, box->lower, box->upper, periodic, 0.5 * least, KITH_MIN(most, 1 << 22));
}

/* How far x is out of a cell, over periodic sides too. */
static double distance_from(const struct kith_cells *cells, int64_t c, const double *x) {
  int64_t k[NDIM];
  double d[NDIM];
  kith_grid_place(cells->count, c, k);
  for (int a = 0; a < NDIM; ++a) {
    const double below = kith_cells_face(cells, a, k[a]) - x[a],
                 above = x[a] - kith_cells_face(cells, a, k[a] + 1);
    d[a] = kith_gap(below, above, kith_cells_period(cells, a));
  }
  return kith_norm(d);
}

static struct kith_box box_of(const struct kith_cells *cells, int64_t c) {
  int64_t k[NDIM];
  struct kith_box box;
  kith_grid_place(cells->count, c, k);
  for (int a = 0; a < NDIM; ++a)
    box.lower[a] = kith_cells_face(cells, a, k[a]), box.upper[a] = kith_cells_face(cells, a, k[a] + 1);
  return box;
}

static inline bool is_in(const struct kith_box *box, const double *x) {
  bool in = true;
  for (int a = 0; a < NDIM; ++a) in = in && x[a] >= box->lower[a] && x[a] < box->upper[a];
  return in;
}

/* The cell of the last node, for find_cells: a node is mostly in the cell of the node before it. */
struct cell {
  struct kith_box box;
  int64_t number, home;
  bool leaves, far;
};

static struct cell cell_at(const struct kith_decomposition *d, const double *x, const uint8_t *near) {
  const int64_t c = kith_cells_of(&d->cells, x);
  if (c < 0) return (struct cell){.box = kith_box_empty(), .number = c};
  if (near == NULL) return (struct cell){.box = box_of(&d->cells, c), .number = c, .home = c};
  const bool own = d->place[c] < d->n_own;
  return (struct cell){.box = box_of(&d->cells, c),
                       .number = c,
                       .home = own ? d->place[c] : -1 - c,
                       .leaves = !own,
                       .far = near[d->partition->owner[c]] == 0};
}

/* Sets `home` and `outside`. near NULL: `home` is the global number of the node's cell. Else it is the index
 * among the own cells, or -1 - the number of a cell of another rank, until set_homes; and `leaving` and `far`
 * are set. near[rank]: is it this one or a neighbor? */
static kith_status find_cells(struct kith_decomposition *d, const struct kith_nodes *nodes,
                              const uint8_t *near) {
  kith_index lost = INT32_MAX;
  double outside = 0;
  uint64_t leaving = 0, far = 0;
#pragma omp parallel reduction(min : lost) reduction(max : outside) reduction(+ : leaving, far)
  {
    struct cell cell = {.box = kith_box_empty()};
#pragma omp for schedule(static)
    for (kith_index i = 0; i < nodes->n_internal; ++i) {
      const double *x = nodes->position->f64 + (size_t)i * NDIM;
      if (!is_in(&cell.box, x)) {
        cell = cell_at(d, x, near);
        if (cell.number < 0)
          lost = KITH_MIN(lost, i);
        else if (!is_in(&cell.box, x))
          outside = KITH_MAX(outside, distance_from(&d->cells, cell.number, x));
      }
      d->home->i64[i] = cell.home;
      leaving += cell.leaves, far += cell.far;
    }
  }
  d->outside = outside;
  if (near != NULL) d->leaving = leaving, d->far = far;
  if (lost < INT32_MAX)
    KITH_FAIL_NODE(DIVERGED, nodes->id->i64[lost], "the position of node %lld is not finite",
                   (long long)nodes->id->i64[lost]);
  return KITH_OK;
}

double kith_decomposition_outside(const struct kith_decomposition *d, const struct kith_nodes *nodes) {
  double most = 0;
#pragma omp parallel for schedule(static) reduction(max : most)
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    const double *x = nodes->position->f64 + (size_t)i * NDIM;
    most = KITH_MAX(most, distance_from(&d->cells, d->own[d->home->i64[i]], x));
  }
  return most;
}

static int64_t nearest_own(const struct kith_decomposition *d, const double *x) {
  int64_t best = 0;
  for (int64_t k = 1; k < d->n_own; ++k)
    if (distance_from(&d->cells, d->own[k], x) < distance_from(&d->cells, d->own[best], x)) best = k;
  return best;
}

/* Sets the homes of nodes that have come, and of those that stay though their cell is of another rank. */
static void set_homes(const struct kith_decomposition *d, const struct kith_nodes *nodes) {
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    if (d->home->i64[i] >= 0) continue;
    const int64_t home = d->place[-1 - d->home->i64[i]];
    d->home->i64[i] = home < d->n_own ? home : nearest_own(d, nodes->position->f64 + (size_t)i * NDIM);
  }
}

/* Lists the own cells of the present map, unless they are known. */
static kith_status find_own(struct kith_decomposition *d) {
  const int me = kith_ranks_rank(d->ranks);
  const int32_t *owner = d->partition->owner;
  if (d->map == d->partition->generation) return KITH_OK;
  d->n_own = 0;
  for (int64_t c = 0; c < d->cells.n; ++c)
    if (owner[c] == me) d->place[c] = (int32_t)d->n_own++;
  KITH_TRY(kith_resize(&d->own, 0, (size_t)d->n_own, sizeof *d->own));
  for (int64_t c = 0; c < d->cells.n; ++c)
    if (owner[c] != me)
      d->place[c] = (int32_t)d->n_own;
    else
      d->own[d->place[c]] = (int32_t)c;
  d->map = d->partition->generation;
  return KITH_OK;
}

/* Work of each cell, as its weight, by where the nodes of all ranks are now. Summed as integers: sums over
 * ranks have no order. *weight is owned by the caller. The status is that of this rank. */
static kith_status weigh(struct kith_decomposition *d, const struct kith_nodes *nodes, kith_status status,
                         double **weight) {
  uint64_t *work = NULL;
  KITH_TRY(kith_ranks_must(d->ranks, kith_resize(&work, 0, (size_t)d->cells.n, sizeof *work)));
  kith_ranks_must(d->ranks, kith_resize(weight, 0, (size_t)d->cells.n, sizeof **weight));
  if (status == KITH_OK) status = find_cells(d, nodes, NULL);
  for (kith_index i = 0; status == KITH_OK && i < nodes->n_internal; ++i)
    work[d->home->i64[i]] += (uint64_t)d->work->i64[i] + 1;
  kith_ranks_sum_counts(d->ranks, work, (int)d->cells.n);
  for (int64_t c = 0; c < d->cells.n; ++c) (*weight)[c] = (double)work[c];
  kith_free(&work);
  return status;
}

static kith_status make_map(struct kith_decomposition *d, const struct kith_nodes *nodes, const char *text) {
  double *weight = NULL;
  kith_status status = kith_partition_create(&d->partition, &d->cells, kith_ranks_size(d->ranks), text);
  if (status == KITH_OK) status = kith_resize(&d->place, 0, (size_t)d->cells.n, sizeof *d->place);
  KITH_TRY(kith_ranks_allreduce_status(d->ranks, status));
  status = weigh(d, nodes, KITH_OK, &weight);
  if (status == KITH_OK) status = kith_partition_converge(d->partition, weight);
  kith_free(&weight);
  return kith_ranks_allreduce_status(d->ranks, status);
}

/* ---- balance ---- */

/* If a check is due: requests a new map if the work of all ranks is out of balance. */
static kith_status balance(struct kith_decomposition *d, const struct kith_nodes *nodes, kith_status status) {
  double *weight = NULL, *load = NULL;
  bool changed = false;
  if (d->every == 0 || ++d->redistributions % (uint64_t)d->every != 0) return status;
  status = weigh(d, nodes, status, &weight);
  d->balance_checks += status == KITH_OK;
  if (status == KITH_OK) status = kith_resize(&load, 0, (size_t)d->partition->n_ranks, sizeof *load);
  if (status == KITH_OK) {
    d->last_imbalance = kith_partition_loads(d->partition, d->partition->owner, weight, load);
    if (d->last_imbalance > d->imbalance) status = kith_partition_update(d->partition, weight, &changed);
  }
  d->repartitions += changed;
  KITH_FREE(&weight, &load);
  return status;
}

void kith_decomposition_measure(struct kith_decomposition *d, const struct kith_nodes *nodes,
                                const size_t *row_first) {
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    d->work->i64[i] = (int64_t)(row_first[i + 1] - row_first[i]);
}

/* ---- redistribution ---- */

/* (*near)[rank]: is it this one or a neighbor? Owned by the caller. */
static kith_status near_ranks(const struct kith_decomposition *d, uint8_t **near) {
  KITH_TRY(kith_resize(near, 0, (size_t)kith_ranks_size(d->ranks), 1));
  (*near)[kith_ranks_rank(d->ranks)] = 1;
  for (int k = 0; k < d->shell.n_neighbors; ++k) (*near)[d->shell.neighbor[k]] = 1;
  return KITH_OK;
}

/* Finds the cell of each node, and counts those that leave. */
static kith_status find_leaving(struct kith_decomposition *d, const struct kith_nodes *nodes) {
  uint8_t *near = NULL;
  KITH_TRY(find_own(d));
  KITH_TRY(kith_reserve(&d->to, &d->to_capacity, (size_t)nodes->n_internal, sizeof *d->to));
  KITH_TRY(near_ranks(d, &near));
  const kith_status status = find_cells(d, nodes, near);
  d->surrounded = false;
  kith_free(&near);
  return status;
}

/* The rank that each node goes to. */
static void find_ranks(struct kith_decomposition *d, const struct kith_nodes *nodes) {
  const int32_t *owner = d->partition->owner, me = (int32_t)kith_ranks_rank(d->ranks);
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    d->to[i] = d->home->i64[i] >= 0 ? me : owner[-1 - d->home->i64[i]];
}

kith_status kith_decomposition_assign(struct kith_decomposition *d, struct kith_nodes *nodes,
                                      kith_status status) {
  status = balance(d, nodes, status);
  return status == KITH_OK ? find_leaving(d, nodes) : status;
}

kith_status kith_decomposition_move(struct kith_decomposition *d, struct kith_nodes *nodes, uint64_t leaving,
                                    uint64_t far) {
  uint64_t moved = 0;
  const int32_t *neighbor = far > 0 || d->surrounded ? NULL : d->shell.neighbor;
  if (leaving == 0) return KITH_OK;
  find_ranks(d, nodes);
  KITH_TRY(kith_nodes_migrate(nodes, d->to, d->shell.n_neighbors, neighbor, &moved));
  d->migrated += moved;
  set_homes(d, nodes);
  return KITH_OK;
}

kith_status kith_decomposition_surround(struct kith_decomposition *d, double reach, bool *changed) {
  *changed = d->shell_map != d->partition->generation || reach > d->shell.reach || 4 * reach < d->shell.reach;
  if (!*changed) return KITH_OK;
  d->shell_map = 0, d->surrounded = true;
  KITH_TRY(kith_shell_build(&d->shell, d->partition, kith_ranks_rank(d->ranks), 1.25 * reach));
  d->shell_map = d->partition->generation;
  return KITH_OK;
}

/* ---- life ---- */

/* Nodes that may be anywhere go to the owners of their cells. */
static kith_status take_own(struct kith_decomposition *d, struct kith_nodes *nodes) {
  const uint64_t migrated = d->migrated;
  KITH_TRY(kith_ranks_allreduce_status(d->ranks, find_leaving(d, nodes)));
  kith_status status = kith_decomposition_move(d, nodes, 1, 1);
  d->migrated = migrated;
  if (status == KITH_OK) status = kith_nodes_shrink(nodes);
  return kith_ranks_allreduce_status(d->ranks, status);
}

kith_status kith_decomposition_create(struct kith_decomposition **out, struct kith_nodes *nodes,
                                      const struct kith_box *box, const bool *periodic,
                                      const struct kith_decomposition_options *options) {
  struct kith_decomposition *d = NULL;
  *out = NULL;
  KITH_TRY(kith_ranks_allreduce_status(nodes->ranks, kith_resize(&d, 0, 1, sizeof *d)));
  d->ranks = nodes->ranks;
  d->every = options->every;
  d->imbalance = options->imbalance;
  snprintf(d->partitioner, sizeof d->partitioner, "%s", options->partitioner);
  const struct kith_field_row fields[] = {
      {true, {"home", KITH_SCALAR, KITH_I64, KITH_DERIVED, NULL, "cell of the map cell -> rank"}, &d->home},
      {true, {"work", KITH_SCALAR, KITH_I64, KITH_DERIVED, NULL, "entries of the last row"}, &d->work},
      {0}};
  kith_status status = kith_ranks_allreduce_status(d->ranks, kith_nodes_fields(nodes, fields));
  if (status == KITH_OK)
    status = kith_decomposition_cells(&d->cells, nodes, box, periodic,
                                      (int64_t)options->cells * kith_ranks_size(d->ranks));
  if (status == KITH_OK) status = make_map(d, nodes, options->partitioner);
  if (status == KITH_OK) status = take_own(d, nodes);
  if (status == KITH_OK) status = kith_ranks_allreduce_status(d->ranks, kith_nodes_sort_by_id(nodes));
  if (status != KITH_OK) kith_decomposition_destroy(&d);
  *out = d;
  return status;
}

void kith_decomposition_destroy(struct kith_decomposition **decomposition) {
  if (*decomposition == NULL) return;
  kith_partition_destroy(&(*decomposition)->partition);
  KITH_FREE(&(*decomposition)->place, &(*decomposition)->own, &(*decomposition)->to);
  kith_shell_clear(&(*decomposition)->shell);
  kith_free(decomposition);
}

/* ---- checkpoints ---- */

/* The array "decomposition" begins with this; then come counts [rank][list]; then owners; then the state of
 * the partitioner. */
struct head {
  int64_t ranks, lists, cells, redistributions, balance_checks, repartitions, migrated; /* by all ranks */
  double last_imbalance;
  char partitioner[128];
};
enum { HEAD = sizeof(struct head) / sizeof(int64_t) };

static kith_status put_state(const struct kith_decomposition *d, const struct head *head,
                             const int64_t *counts, struct kith_checkpoint *c) {
  const size_t n_counts = (size_t)head->ranks * (size_t)head->lists, map = HEAD + n_counts;
  const size_t end = map + (size_t)head->cells, n = end + kith_partition_state(d->partition, NULL);
  int64_t *word = NULL;
  KITH_TRY(kith_resize(&word, 0, n, sizeof *word));
  memcpy(word, head, sizeof *head);
  memcpy(word + HEAD, counts, n_counts * sizeof *counts);
  for (size_t k = map; k < end; ++k) word[k] = d->partition->owner[k - map];
  kith_partition_state(d->partition, word + end);
  const kith_status status = kith_checkpoint_put(c, "decomposition", KITH_I64, word, n);
  kith_free(&word);
  return status;
}

kith_status kith_decomposition_save(const struct kith_decomposition *d, const struct kith_nodes *nodes,
                                    struct kith_checkpoint *c) {
  int64_t *counts = NULL;
  uint64_t migrated = d->migrated;
  KITH_TRY(kith_nodes_counts(nodes, &counts));
  kith_ranks_sum_counts(d->ranks, &migrated, 1);
  struct head head = {kith_ranks_size(d->ranks),
                      nodes->n_lists,
                      d->cells.n,
                      (int64_t)d->redistributions,
                      (int64_t)d->balance_checks,
                      (int64_t)d->repartitions,
                      (int64_t)migrated,
                      d->last_imbalance,
                      ""};
  memcpy(head.partitioner, d->partitioner, sizeof head.partitioner);
  kith_status status = kith_checkpoint_put_field(c, nodes, d->work);
  if (status == KITH_OK && c != NULL) status = put_state(d, &head, counts, c);
  kith_free(&counts);
  return status;
}

/* Is it the state of these ranks, cells and partitioner? */
static bool belongs(const struct kith_decomposition *d, const struct kith_nodes *nodes, const int64_t *word,
                    size_t n) {
  struct head head;
  if (n < HEAD) return false;
  memcpy(&head, word, sizeof head);
  return head.ranks == kith_ranks_size(d->ranks) && head.lists == nodes->n_lists &&
         head.cells == d->cells.n && memcmp(head.partitioner, d->partitioner, sizeof head.partitioner) == 0;
}

static kith_status restore(struct kith_decomposition *d, const struct kith_nodes *nodes, const int64_t *word,
                           size_t n) {
  const int size = kith_ranks_size(d->ranks);
  const size_t map = HEAD + (size_t)size * (size_t)nodes->n_lists, end = map + (size_t)d->cells.n;
  struct head head;
  memcpy(&head, word, sizeof head);
  if (n < end) KITH_FAIL(BAD_FILE, "the decomposition in the checkpoint is damaged");
  KITH_TRY(kith_partition_restore(d->partition, word + end, n - end));
  for (size_t k = map; k < end; ++k) {
    if (word[k] < 0 || word[k] >= size)
      KITH_FAIL(BAD_FILE, "the map of cells to ranks in the checkpoint is damaged");
    d->partition->owner[k - map] = (int32_t)word[k];
  }
  d->redistributions = (uint64_t)head.redistributions;
  d->balance_checks = (uint64_t)head.balance_checks;
  d->repartitions = (uint64_t)head.repartitions;
  d->migrated = kith_ranks_rank(d->ranks) == 0 ? (uint64_t)head.migrated : 0;
  d->last_imbalance = head.last_imbalance;
  d->map = d->shell_map = 0; /* another one was read */
  return KITH_OK;
}

static kith_status read_nodes(struct kith_decomposition *d, struct kith_nodes *nodes,
                              struct kith_checkpoint *c, const int64_t *word, size_t n) {
  d->resumed = belongs(d, nodes, word, n);
  if (d->resumed) KITH_TRY(restore(d, nodes, word, n));
  KITH_TRY(kith_checkpoint_nodes(c, nodes, d->resumed ? word + HEAD : NULL));
  if (kith_checkpoint_length(c, d->work->spec.name) == SIZE_MAX) return KITH_OK;
  return kith_checkpoint_get_field(c, nodes, d->work);
}

kith_status kith_decomposition_read(struct kith_decomposition *d, struct kith_nodes *nodes,
                                    struct kith_checkpoint *c) {
  const size_t length = kith_checkpoint_length(c, "decomposition"), n = length == SIZE_MAX ? 0 : length;
  int64_t *word = NULL;
  kith_status status = kith_resize(&word, 0, n, sizeof *word);
  if (status == KITH_OK && n > 0) status = kith_checkpoint_get(c, "decomposition", KITH_I64, word, n);
  if (status == KITH_OK) status = read_nodes(d, nodes, c, word, n);
  kith_free(&word);
  return status;
}

kith_status kith_decomposition_resume(struct kith_decomposition *d, struct kith_nodes *nodes) {
  if (!d->resumed) return take_own(d, nodes);
  kith_status status = find_leaving(d, nodes);
  if (status == KITH_OK && d->n_own == 0 && nodes->n_internal > 0)
    status = kith_fail(KITH_BAD_FILE, "the decomposition in the checkpoint is damaged");
  if (status == KITH_OK) set_homes(d, nodes);
  return kith_ranks_allreduce_status(d->ranks, status);
}
