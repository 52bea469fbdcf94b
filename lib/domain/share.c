#include "lib/domain/share.h"

#include <math.h>
#include <string.h>

#include "lib/domain/migrate.h"

/* ---- life ---- */

kith_status kith_share_cells(struct kith_cells *cells, const struct kith_nodes *nodes,
                             const struct kith_box *box, const bool *periodic, int64_t most) {
  double least = INFINITY;
  for (kith_index i = 0; i < nodes->n_internal; ++i) least = KITH_MIN(least, nodes->support->f64[i]);
  return kith_cells_init(cells, box->lower, box->upper, periodic, 0.5 * least, KITH_MIN(most, 1 << 22));
}

/* The cells of all nodes, for now. */
static kith_status find_cells(const struct kith_share *share, const struct kith_nodes *nodes) {
  kith_index lost = INT32_MAX;
#pragma omp parallel for schedule(static) reduction(min : lost)
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    share->home->i64[i] = kith_cells_of(&share->cells, nodes->position->f64 + (size_t)i * NDIM);
    if (share->home->i64[i] < 0) lost = KITH_MIN(lost, i);
  }
  if (lost < INT32_MAX)
    KITH_FAIL(DIVERGED, "the position of node %lld is not finite", (long long)nodes->id->i64[lost]);
  return KITH_OK;
}

/* Cells become places among the own ones. */
static void settle_homes(const struct kith_share *share, const struct kith_nodes *nodes) {
  int64_t *home = share->home->i64;
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < nodes->n_internal; ++i) home[i] = share->place[home[i]];
}

/* The own cells of the present map. */
static kith_status find_own(struct kith_share *share) {
  const int me = kith_ranks_rank(share->ranks);
  const int32_t *owner = share->partition->owner;
  int64_t n = 0;
  if (share->own != NULL && share->map == share->partition->generation) return KITH_OK;
  for (int64_t c = 0; c < share->cells.n; ++c) n += owner[c] == me;
  KITH_TRY(kith_resize(&share->own, 0, (size_t)n + 1, sizeof *share->own));
  share->n_own = 0;
  for (int64_t c = 0; c < share->cells.n; ++c) {
    share->place[c] = (int32_t)(owner[c] == me ? share->n_own : n);
    if (owner[c] == me) share->own[share->n_own++] = c;
  }
  share->map = share->partition->generation;
  return KITH_OK;
}

/* Work of each cell on this rank, after find_cells: whole numbers, so that sums over ranks have no order. */
static void weigh(const struct kith_share *share, const struct kith_nodes *nodes, uint64_t *work) {
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    work[share->home->i64[i]] += (uint64_t)share->work->i64[i] + 1;
}

/* A new map by this work of all cells; changed NULL: the first one. */
static kith_status remap(const struct kith_share *share, const uint64_t *work, bool *changed) {
  double *weight = NULL;
  KITH_TRY(kith_resize(&weight, 0, (size_t)share->cells.n, sizeof *weight));
  for (int64_t c = 0; c < share->cells.n; ++c) weight[c] = (double)work[c];
  const kith_status status = changed != NULL ? kith_partition_update(share->partition, weight, NULL, changed)
                                             : kith_partition_settle(share->partition, weight);
  kith_free(&weight);
  return status;
}

static kith_status make_map(struct kith_share *share, const struct kith_nodes *nodes, const char *text) {
  uint64_t *work = NULL;
  KITH_TRY(kith_partition_create(&share->partition, &share->cells, kith_ranks_size(share->ranks), text));
  KITH_TRY(find_cells(share, nodes));
  KITH_TRY(kith_resize(&share->place, 0, (size_t)share->cells.n, sizeof *share->place));
  KITH_TRY(kith_resize(&work, 0, (size_t)share->cells.n, sizeof *work));
  weigh(share, nodes, work);
  const kith_status status = remap(share, work, NULL);
  kith_free(&work);
  return status;
}

kith_status kith_share_create(struct kith_share **out, struct kith_nodes *nodes, const struct kith_box *box,
                              const bool *periodic, const struct kith_sharing *sharing) {
  static const struct kith_field_spec home = {"home",    KITH_SCALAR, KITH_I64,
                                              KITH_WORK, NULL,        "cell of the map cell -> rank"};
  static const struct kith_field_spec work = {"work",    KITH_SCALAR, KITH_I64,
                                              KITH_WORK, NULL,        "entries of the last row"};
  struct kith_share *share = NULL;
  *out = NULL;
  KITH_TRY(kith_resize(&share, 0, 1, sizeof *share));
  share->ranks = nodes->ranks;
  share->every = sharing->every;
  share->imbalance = sharing->imbalance;
  kith_status status = kith_nodes_field(nodes, &home, &share->home);
  if (status == KITH_OK) status = kith_nodes_field(nodes, &work, &share->work);
  if (status == KITH_OK)
    status = kith_share_cells(&share->cells, nodes, box, periodic,
                              (int64_t)sharing->cells * kith_ranks_size(share->ranks));
  if (status == KITH_OK) status = make_map(share, nodes, sharing->partitioner);
  if (status != KITH_OK) kith_share_destroy(&share);
  *out = share;
  return status;
}

void kith_share_destroy(struct kith_share **share) {
  if (*share == NULL) return;
  kith_partition_destroy(&(*share)->partition);
  kith_free(&(*share)->own);
  kith_free(&(*share)->place);
  kith_free(share);
}

kith_status kith_share_keep(struct kith_share *share, struct kith_nodes *nodes) {
  const int me = kith_ranks_rank(share->ranks);
  uint8_t *gone = NULL;
  KITH_TRY(find_own(share));
  KITH_TRY(find_cells(share, nodes));
  KITH_TRY(kith_resize(&gone, 0, (size_t)nodes->n_internal, 1));
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    gone[i] = share->partition->owner[share->home->i64[i]] != me;
  kith_status status = kith_nodes_delete(nodes, gone);
  kith_free(&gone);
  if (status == KITH_OK) status = kith_nodes_shrink(nodes);
  if (status == KITH_OK) settle_homes(share, nodes);
  return status;
}

/* ---- balance ---- */

/* Busiest rank over the mean, by the present map. */
static kith_status imbalance_of(const struct kith_share *share, const uint64_t *work, double *out) {
  const int size = kith_ranks_size(share->ranks);
  double *of_rank = NULL, most = 0, sum = 0;
  KITH_TRY(kith_resize(&of_rank, 0, (size_t)size, sizeof *of_rank));
  for (int64_t c = 0; c < share->cells.n; ++c) of_rank[share->partition->owner[c]] += (double)work[c];
  for (int r = 0; r < size; ++r) most = KITH_MAX(most, of_rank[r]), sum += of_rank[r];
  *out = sum > 0 ? most * size / sum : 1;
  kith_free(&of_rank);
  return KITH_OK;
}

static kith_status look(struct kith_share *share, uint64_t *work) {
  bool changed = false;
  kith_ranks_sum_counts(share->ranks, work, (int)share->cells.n);
  KITH_TRY(imbalance_of(share, work, &share->seen));
  ++share->looks;
  if (share->seen <= share->imbalance) return KITH_OK;
  KITH_TRY(remap(share, work, &changed));
  share->repartitions += changed;
  return KITH_OK;
}

/* By where the nodes are now. */
static kith_status weigh_own(const struct kith_share *share, const struct kith_nodes *nodes,
                             uint64_t **work) {
  KITH_TRY(find_cells(share, nodes));
  KITH_TRY(kith_resize(work, 0, (size_t)share->cells.n, sizeof **work));
  weigh(share, nodes, *work);
  return KITH_OK;
}

static kith_status balance(struct kith_share *share, const struct kith_nodes *nodes) {
  uint64_t *work = NULL;
  if (share->every == 0 || ++share->settled % (uint64_t)share->every != 0) return KITH_OK;
  kith_status status = kith_ranks_agree(share->ranks, weigh_own(share, nodes, &work));
  if (status == KITH_OK) status = kith_ranks_agree(share->ranks, look(share, work));
  kith_free(&work);
  return status;
}

void kith_share_measure(struct kith_share *share, const struct kith_nodes *nodes, const size_t *row_first) {
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    share->work->i64[i] = (int64_t)(row_first[i + 1] - row_first[i]);
}

/* ---- settling ---- */

static kith_status find_ranks(struct kith_share *share, const struct kith_nodes *nodes, int32_t **to) {
  KITH_TRY(find_own(share));
  KITH_TRY(find_cells(share, nodes));
  KITH_TRY(kith_resize(to, 0, (size_t)nodes->n_internal, sizeof **to));
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < nodes->n_internal; ++i) (*to)[i] = share->partition->owner[share->home->i64[i]];
  return KITH_OK;
}

kith_status kith_share_settle(struct kith_share *share, struct kith_nodes *nodes) {
  int32_t *to = NULL;
  uint64_t moved = 0;
  KITH_TRY(balance(share, nodes));
  kith_status status = kith_ranks_agree(share->ranks, find_ranks(share, nodes, &to));
  if (status == KITH_OK) status = kith_nodes_migrate(nodes, to, &moved);
  if (status == KITH_OK) settle_homes(share, nodes);
  share->migrated += moved;
  kith_free(&to);
  return status;
}

/* ---- checkpoints ---- */

/* Words of a description: ranks, lists, cells, counters; then counts [rank][list]; then owners; then the memory of the partitioner. */
enum {
  WORD_RANKS,
  WORD_LISTS,
  WORD_CELLS,
  WORD_SETTLED,
  WORD_LOOKS,
  WORD_REPARTITIONS,
  WORD_MIGRATED,
  WORD_SEEN,
  WORDS
};

static void describe(const struct kith_share *share, const struct kith_nodes *nodes, const int64_t *counts,
                     uint64_t migrated, int64_t *word) {
  const int size = kith_ranks_size(share->ranks);
  const size_t n_counts = (size_t)size * (size_t)nodes->n_lists;
  int64_t head[WORDS] = {size,
                         nodes->n_lists,
                         share->cells.n,
                         (int64_t)share->settled,
                         (int64_t)share->looks,
                         (int64_t)share->repartitions,
                         (int64_t)migrated};
  memcpy(&head[WORD_SEEN], &share->seen, sizeof share->seen);
  memcpy(word, head, sizeof head);
  memcpy(word + WORDS, counts, n_counts * sizeof *word);
  word += WORDS + n_counts;
  for (int64_t c = 0; c < share->cells.n; ++c) word[c] = share->partition->owner[c];
  kith_partition_state(share->partition, word + share->cells.n);
}

kith_status kith_share_describe(const struct kith_share *share, const struct kith_nodes *nodes,
                                struct kith_shared *out) {
  int64_t *counts = NULL;
  uint64_t migrated = share->migrated;
  KITH_TRY(kith_nodes_counts(nodes, &counts));
  kith_ranks_sum_counts(share->ranks, &migrated, 1);
  out->n = WORDS + (size_t)kith_ranks_size(share->ranks) * (size_t)nodes->n_lists + (size_t)share->cells.n +
           kith_partition_state(share->partition, NULL);
  const kith_status status = kith_resize(&out->word, 0, out->n, sizeof *out->word);
  if (status == KITH_OK) describe(share, nodes, counts, migrated, out->word);
  kith_free(&counts);
  return status;
}

/* Node i of a list that is stored rank by rank: who had it. */
static kith_status mark_others(const struct kith_nodes *nodes, const int64_t *counts, int size, int me,
                               uint8_t *gone) {
  for (int l = 0; l < nodes->n_lists; ++l) {
    int64_t at = nodes->lists[l].first;
    const int64_t end = at + nodes->lists[l].count;
    for (int r = 0; r < size; ++r) {
      const int64_t count = counts[r * nodes->n_lists + l];
      if (count < 0 || count > end - at) KITH_FAIL(BAD_FILE, "the shares of the ranks are damaged");
      if (r != me && count > 0) memset(gone + at, 1, (size_t)count);
      at += count;
    }
    if (at != end) KITH_FAIL(BAD_FILE, "the shares of the ranks are damaged");
  }
  return KITH_OK;
}

static kith_status take_back(struct kith_share *share, struct kith_nodes *nodes, const int64_t *counts) {
  uint8_t *gone = NULL;
  KITH_TRY(kith_resize(&gone, 0, (size_t)nodes->n_internal, 1));
  kith_status status =
      mark_others(nodes, counts, kith_ranks_size(share->ranks), kith_ranks_rank(share->ranks), gone);
  if (status == KITH_OK) status = kith_nodes_delete(nodes, gone);
  kith_free(&gone);
  if (status == KITH_OK) status = kith_nodes_shrink(nodes);
  KITH_TRY(status);
  kith_free(&share->own);
  KITH_TRY(find_own(share)); /* of the map that was read */
  KITH_TRY(find_cells(share, nodes));
  settle_homes(share, nodes);
  return KITH_OK;
}

kith_status kith_share_restore(struct kith_share *share, struct kith_nodes *nodes,
                               const struct kith_shared *shared) {
  const int size = kith_ranks_size(share->ranks);
  const size_t n_counts = (size_t)size * (size_t)nodes->n_lists;
  const int64_t *word = shared->word;
  if (shared->n < WORDS || word[WORD_RANKS] != size || word[WORD_LISTS] != nodes->n_lists ||
      word[WORD_CELLS] != share->cells.n)
    return kith_share_keep(share, nodes);
  const size_t n_map = WORDS + n_counts + (size_t)share->cells.n;
  if (shared->n < n_map) KITH_FAIL(BAD_FILE, "the shares of the ranks are damaged");
  KITH_TRY(kith_partition_restore(share->partition, word + n_map, shared->n - n_map));
  for (int64_t c = 0; c < share->cells.n; ++c) {
    const int64_t owner = word[WORDS + n_counts + (size_t)c];
    if (owner < 0 || owner >= size) KITH_FAIL(BAD_FILE, "the map of the ranks is damaged");
    share->partition->owner[c] = (int32_t)owner;
  }
  share->settled = (uint64_t)word[WORD_SETTLED];
  share->looks = (uint64_t)word[WORD_LOOKS];
  share->repartitions = (uint64_t)word[WORD_REPARTITIONS];
  share->migrated = kith_ranks_rank(share->ranks) == 0 ? (uint64_t)word[WORD_MIGRATED] : 0; /* of all */
  memcpy(&share->seen, &word[WORD_SEEN], sizeof share->seen);
  return take_back(share, nodes, word + WORDS);
}
