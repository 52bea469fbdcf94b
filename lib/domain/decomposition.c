/* The map of cells to ranks, load balance, redistribution of nodes, and what checkpoints store of them. */
#include "lib/domain/decomposition.h"

#include <math.h>
#include <string.h>

#include "lib/nodes/migrate.h"

/* ---- life ---- */

kith_status kith_decomposition_cells(struct kith_cells *cells, const struct kith_nodes *nodes,
                                     const struct kith_box *box, const bool *periodic, int64_t most) {
  double least = INFINITY;
  for (kith_index i = 0; i < nodes->n_internal; ++i) least = KITH_MIN(least, nodes->support->f64[i]);
  return kith_cells_init(cells, box->lower, box->upper, periodic, 0.5 * least, KITH_MIN(most, 1 << 22));
}

/* Sets `home` to the global number of the node's cell; set_homes makes it an index among the own cells. */
static kith_status find_cells(const struct kith_decomposition *decomposition,
                              const struct kith_nodes *nodes) {
  kith_index lost = INT32_MAX;
#pragma omp parallel for schedule(static) reduction(min : lost)
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    decomposition->home->i64[i] =
        kith_cells_of(&decomposition->cells, nodes->position->f64 + (size_t)i * NDIM);
    if (decomposition->home->i64[i] < 0) lost = KITH_MIN(lost, i);
  }
  if (lost < INT32_MAX)
    KITH_FAIL(DIVERGED, "the position of node %lld is not finite", (long long)nodes->id->i64[lost]);
  return KITH_OK;
}

static void set_homes(const struct kith_decomposition *decomposition, const struct kith_nodes *nodes) {
  int64_t *home = decomposition->home->i64;
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < nodes->n_internal; ++i) home[i] = decomposition->place[home[i]];
}

/* The own cells of the present map. */
static kith_status find_own(struct kith_decomposition *decomposition) {
  const int me = kith_ranks_rank(decomposition->ranks);
  const int32_t *owner = decomposition->partition->owner;
  int64_t n = 0;
  if (decomposition->own != NULL && decomposition->map == decomposition->partition->generation)
    return KITH_OK;
  for (int64_t c = 0; c < decomposition->cells.n; ++c) n += owner[c] == me;
  KITH_TRY(kith_resize(&decomposition->own, 0, (size_t)n + 1, sizeof *decomposition->own));
  decomposition->n_own = 0;
  for (int64_t c = 0; c < decomposition->cells.n; ++c) {
    decomposition->place[c] = (int32_t)(owner[c] == me ? decomposition->n_own : n);
    if (owner[c] == me) decomposition->own[decomposition->n_own++] = c;
  }
  decomposition->map = decomposition->partition->generation;
  return KITH_OK;
}

/* Work of each cell on this rank, after find_cells: integers, so that sums over ranks have no order. */
static void weigh(const struct kith_decomposition *decomposition, const struct kith_nodes *nodes,
                  uint64_t *work) {
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    work[decomposition->home->i64[i]] += (uint64_t)decomposition->work->i64[i] + 1;
}

/* A new map by this work of all cells; changed NULL: the first one. */
static kith_status remap(const struct kith_decomposition *decomposition, const uint64_t *work,
                         bool *changed) {
  double *weight = NULL;
  KITH_TRY(kith_resize(&weight, 0, (size_t)decomposition->cells.n, sizeof *weight));
  for (int64_t c = 0; c < decomposition->cells.n; ++c) weight[c] = (double)work[c];
  const kith_status status = changed != NULL
                                 ? kith_partition_update(decomposition->partition, weight, NULL, changed)
                                 : kith_partition_converge(decomposition->partition, weight);
  kith_free(&weight);
  return status;
}

static kith_status make_map(struct kith_decomposition *decomposition, const struct kith_nodes *nodes,
                            const char *text) {
  uint64_t *work = NULL;
  KITH_TRY(kith_partition_create(&decomposition->partition, &decomposition->cells,
                                 kith_ranks_size(decomposition->ranks), text));
  KITH_TRY(find_cells(decomposition, nodes));
  KITH_TRY(
      kith_resize(&decomposition->place, 0, (size_t)decomposition->cells.n, sizeof *decomposition->place));
  KITH_TRY(kith_resize(&work, 0, (size_t)decomposition->cells.n, sizeof *work));
  weigh(decomposition, nodes, work);
  const kith_status status = remap(decomposition, work, NULL);
  kith_free(&work);
  return status;
}

kith_status kith_decomposition_create(struct kith_decomposition **out, struct kith_nodes *nodes,
                                      const struct kith_box *box, const bool *periodic,
                                      const struct kith_decomposition_options *options) {
  static const struct kith_field_spec home = {"home",    KITH_SCALAR, KITH_I64,
                                              KITH_WORK, NULL,        "cell of the map cell -> rank"};
  static const struct kith_field_spec work = {"work",    KITH_SCALAR, KITH_I64,
                                              KITH_WORK, NULL,        "entries of the last row"};
  struct kith_decomposition *decomposition = NULL;
  *out = NULL;
  KITH_TRY(kith_resize(&decomposition, 0, 1, sizeof *decomposition));
  decomposition->ranks = nodes->ranks;
  decomposition->every = options->every;
  decomposition->imbalance = options->imbalance;
  kith_status status = kith_nodes_field(nodes, &home, &decomposition->home);
  if (status == KITH_OK) status = kith_nodes_field(nodes, &work, &decomposition->work);
  if (status == KITH_OK)
    status = kith_decomposition_cells(&decomposition->cells, nodes, box, periodic,
                                      (int64_t)options->cells * kith_ranks_size(decomposition->ranks));
  if (status == KITH_OK) status = make_map(decomposition, nodes, options->partitioner);
  if (status != KITH_OK) kith_decomposition_destroy(&decomposition);
  *out = decomposition;
  return status;
}

void kith_decomposition_destroy(struct kith_decomposition **decomposition) {
  if (*decomposition == NULL) return;
  kith_partition_destroy(&(*decomposition)->partition);
  kith_free(&(*decomposition)->own);
  kith_free(&(*decomposition)->place);
  kith_free(decomposition);
}

kith_status kith_decomposition_keep_own(struct kith_decomposition *decomposition, struct kith_nodes *nodes) {
  const int me = kith_ranks_rank(decomposition->ranks);
  uint8_t *gone = NULL;
  KITH_TRY(find_own(decomposition));
  KITH_TRY(find_cells(decomposition, nodes));
  KITH_TRY(kith_resize(&gone, 0, (size_t)nodes->n_internal, 1));
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    gone[i] = decomposition->partition->owner[decomposition->home->i64[i]] != me;
  kith_status status = kith_nodes_delete(nodes, gone);
  kith_free(&gone);
  if (status == KITH_OK) status = kith_nodes_shrink(nodes);
  if (status == KITH_OK) set_homes(decomposition, nodes);
  return status;
}

/* ---- balance ---- */

/* Busiest rank over the mean, by the present map. */
static kith_status imbalance_of(const struct kith_decomposition *decomposition, const uint64_t *work,
                                double *out) {
  const int size = kith_ranks_size(decomposition->ranks);
  double *of_rank = NULL, most = 0, sum = 0;
  KITH_TRY(kith_resize(&of_rank, 0, (size_t)size, sizeof *of_rank));
  for (int64_t c = 0; c < decomposition->cells.n; ++c)
    of_rank[decomposition->partition->owner[c]] += (double)work[c];
  for (int r = 0; r < size; ++r) most = KITH_MAX(most, of_rank[r]), sum += of_rank[r];
  *out = sum > 0 ? most * size / sum : 1;
  kith_free(&of_rank);
  return KITH_OK;
}

/* Sums the work over all ranks, and asks for a new map if it is out of balance. */
static kith_status check_balance(struct kith_decomposition *decomposition, uint64_t *work) {
  bool changed = false;
  kith_ranks_sum_counts(decomposition->ranks, work, (int)decomposition->cells.n);
  KITH_TRY(imbalance_of(decomposition, work, &decomposition->last_imbalance));
  ++decomposition->balance_checks;
  if (decomposition->last_imbalance <= decomposition->imbalance) return KITH_OK;
  KITH_TRY(remap(decomposition, work, &changed));
  decomposition->repartitions += changed;
  return KITH_OK;
}

/* By where the nodes are now. */
static kith_status weigh_own(const struct kith_decomposition *decomposition, const struct kith_nodes *nodes,
                             uint64_t **work) {
  KITH_TRY(find_cells(decomposition, nodes));
  KITH_TRY(kith_resize(work, 0, (size_t)decomposition->cells.n, sizeof **work));
  weigh(decomposition, nodes, *work);
  return KITH_OK;
}

static kith_status balance(struct kith_decomposition *decomposition, const struct kith_nodes *nodes) {
  uint64_t *work = NULL;
  if (decomposition->every == 0 || ++decomposition->redistributions % (uint64_t)decomposition->every != 0)
    return KITH_OK;
  kith_status status =
      kith_ranks_allreduce_status(decomposition->ranks, weigh_own(decomposition, nodes, &work));
  if (status == KITH_OK)
    status = kith_ranks_allreduce_status(decomposition->ranks, check_balance(decomposition, work));
  kith_free(&work);
  return status;
}

void kith_decomposition_measure(struct kith_decomposition *decomposition, const struct kith_nodes *nodes,
                                const size_t *row_first) {
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    decomposition->work->i64[i] = (int64_t)(row_first[i + 1] - row_first[i]);
}

/* ---- redistribution ---- */

static kith_status find_ranks(struct kith_decomposition *decomposition, const struct kith_nodes *nodes,
                              int32_t **to) {
  KITH_TRY(find_own(decomposition));
  KITH_TRY(find_cells(decomposition, nodes));
  KITH_TRY(kith_resize(to, 0, (size_t)nodes->n_internal, sizeof **to));
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    (*to)[i] = decomposition->partition->owner[decomposition->home->i64[i]];
  return KITH_OK;
}

kith_status kith_decomposition_redistribute(struct kith_decomposition *decomposition,
                                            struct kith_nodes *nodes) {
  int32_t *to = NULL;
  uint64_t moved = 0;
  KITH_TRY(balance(decomposition, nodes));
  kith_status status =
      kith_ranks_allreduce_status(decomposition->ranks, find_ranks(decomposition, nodes, &to));
  if (status == KITH_OK) status = kith_nodes_migrate(nodes, to, &moved);
  if (status == KITH_OK) set_homes(decomposition, nodes);
  decomposition->migrated += moved;
  kith_free(&to);
  return status;
}

/* ---- checkpoints ---- */

/* Words of a state: ranks, lists, cells, counters; then counts [rank][list]; then owners; then the state of
 * the partitioner. */
enum {
  WORD_RANKS,
  WORD_LISTS,
  WORD_CELLS,
  WORD_REDISTRIBUTIONS,
  WORD_BALANCE_CHECKS,
  WORD_REPARTITIONS,
  WORD_MIGRATED,
  WORD_LAST_IMBALANCE,
  WORDS
};

static void describe(const struct kith_decomposition *decomposition, const struct kith_nodes *nodes,
                     const int64_t *counts, uint64_t migrated, int64_t *word) {
  const int size = kith_ranks_size(decomposition->ranks);
  const size_t n_counts = (size_t)size * (size_t)nodes->n_lists;
  int64_t head[WORDS] = {size,
                         nodes->n_lists,
                         decomposition->cells.n,
                         (int64_t)decomposition->redistributions,
                         (int64_t)decomposition->balance_checks,
                         (int64_t)decomposition->repartitions,
                         (int64_t)migrated};
  memcpy(&head[WORD_LAST_IMBALANCE], &decomposition->last_imbalance, sizeof decomposition->last_imbalance);
  memcpy(word, head, sizeof head);
  memcpy(word + WORDS, counts, n_counts * sizeof *word);
  word += WORDS + n_counts;
  for (int64_t c = 0; c < decomposition->cells.n; ++c) word[c] = decomposition->partition->owner[c];
  kith_partition_state(decomposition->partition, word + decomposition->cells.n);
}

kith_status kith_decomposition_describe(const struct kith_decomposition *decomposition,
                                        const struct kith_nodes *nodes,
                                        struct kith_decomposition_state *out) {
  int64_t *counts = NULL;
  uint64_t migrated = decomposition->migrated;
  KITH_TRY(kith_nodes_counts(nodes, &counts));
  kith_ranks_sum_counts(decomposition->ranks, &migrated, 1);
  out->n = WORDS + (size_t)kith_ranks_size(decomposition->ranks) * (size_t)nodes->n_lists +
           (size_t)decomposition->cells.n + kith_partition_state(decomposition->partition, NULL);
  const kith_status status = kith_resize(&out->word, 0, out->n, sizeof *out->word);
  if (status == KITH_OK) describe(decomposition, nodes, counts, migrated, out->word);
  kith_free(&counts);
  return status;
}

/* Marks the nodes that other ranks had; a list is stored rank by rank. */
static kith_status mark_others(const struct kith_nodes *nodes, const int64_t *counts, int size, int me,
                               uint8_t *gone) {
  for (int l = 0; l < nodes->n_lists; ++l) {
    int64_t at = nodes->lists[l].first;
    const int64_t end = at + nodes->lists[l].count;
    for (int r = 0; r < size; ++r) {
      const int64_t count = counts[r * nodes->n_lists + l];
      if (count < 0 || count > end - at)
        KITH_FAIL(BAD_FILE, "the decomposition in the checkpoint is damaged");
      if (r != me && count > 0) memset(gone + at, 1, (size_t)count);
      at += count;
    }
    if (at != end) KITH_FAIL(BAD_FILE, "the decomposition in the checkpoint is damaged");
  }
  return KITH_OK;
}

static kith_status take_back(struct kith_decomposition *decomposition, struct kith_nodes *nodes,
                             const int64_t *counts) {
  uint8_t *gone = NULL;
  KITH_TRY(kith_resize(&gone, 0, (size_t)nodes->n_internal, 1));
  kith_status status = mark_others(nodes, counts, kith_ranks_size(decomposition->ranks),
                                   kith_ranks_rank(decomposition->ranks), gone);
  if (status == KITH_OK) status = kith_nodes_delete(nodes, gone);
  kith_free(&gone);
  if (status == KITH_OK) status = kith_nodes_shrink(nodes);
  KITH_TRY(status);
  kith_free(&decomposition->own);
  KITH_TRY(find_own(decomposition)); /* of the map that was read */
  KITH_TRY(find_cells(decomposition, nodes));
  set_homes(decomposition, nodes);
  return KITH_OK;
}

kith_status kith_decomposition_restore(struct kith_decomposition *decomposition, struct kith_nodes *nodes,
                                       const struct kith_decomposition_state *state) {
  const int size = kith_ranks_size(decomposition->ranks);
  const size_t n_counts = (size_t)size * (size_t)nodes->n_lists;
  const int64_t *word = state->word;
  if (state->n < WORDS || word[WORD_RANKS] != size || word[WORD_LISTS] != nodes->n_lists ||
      word[WORD_CELLS] != decomposition->cells.n)
    return kith_decomposition_keep_own(decomposition, nodes);
  const size_t n_map = WORDS + n_counts + (size_t)decomposition->cells.n;
  if (state->n < n_map) KITH_FAIL(BAD_FILE, "the decomposition in the checkpoint is damaged");
  KITH_TRY(kith_partition_restore(decomposition->partition, word + n_map, state->n - n_map));
  for (int64_t c = 0; c < decomposition->cells.n; ++c) {
    const int64_t owner = word[WORDS + n_counts + (size_t)c];
    if (owner < 0 || owner >= size)
      KITH_FAIL(BAD_FILE, "the map of cells to ranks in the checkpoint is damaged");
    decomposition->partition->owner[c] = (int32_t)owner;
  }
  decomposition->redistributions = (uint64_t)word[WORD_REDISTRIBUTIONS];
  decomposition->balance_checks = (uint64_t)word[WORD_BALANCE_CHECKS];
  decomposition->repartitions = (uint64_t)word[WORD_REPARTITIONS];
  decomposition->migrated =
      kith_ranks_rank(decomposition->ranks) == 0 ? (uint64_t)word[WORD_MIGRATED] : 0; /* of all */
  memcpy(&decomposition->last_imbalance, &word[WORD_LAST_IMBALANCE], sizeof decomposition->last_imbalance);
  return take_back(decomposition, nodes, word + WORDS);
}
