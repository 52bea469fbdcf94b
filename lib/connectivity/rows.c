/* rows.c - rows of neighbors from a search, and what is done with rows.
 *
 * Targets that are close together (a group) share their candidates: those are cut down to the box of the
 * group, sorted by node once, and packed; then each row follows from one streamed distance test in ascending
 * order. Pass 1 keeps the candidates and one bit for each candidate and target; pass 2 turns bits into
 * entries at their final position. So no distance is tested twice, and what is kept in between is smaller
 * than the rows themselves. */
#include "lib/connectivity/rows.h"

#include <omp.h>
#include <string.h>

/* Fewer targets: a smaller box and fewer tests each; more: candidates are packed less often. The time is flat
 * between 16 and 48. */
enum { GROUP_SIZE = 32 };

/* --- groups --- */

/* Targets: their slots, their box, their largest search radius. */
struct group {
  struct kith_run run;
  struct kith_box box;
  double radius, radius2;
};

static struct group group_of(const struct kith_search *search, kith_index first, kith_index count) {
  struct group group = {.run = {first, count}, .box = kith_box_empty()};
  for (kith_index slot = first; slot < first + count; ++slot) {
    double x[NDIM];
    for (int a = 0; a < NDIM; ++a) x[a] = search->coordinate[a][slot];
    kith_box_include(&group.box, x);
    group.radius = KITH_MAX(group.radius, search->nodes->search_radius->f64[search->node[slot]]);
    group.radius2 = KITH_MAX(group.radius2, search->radius2[slot]);
  }
  return group;
}

/* Volume in which candidates may lie. */
static double volume(const struct group *group) {
  double v = 1;
  for (int a = 0; a < NDIM; ++a) v *= group->box.upper[a] - group->box.lower[a] + 2 * group->radius;
  return v;
}

/* Joins b to a if it follows in the slots and lies close by, which it does not where the curve jumps. */
static bool join(struct group *a, const struct group *b) {
  if (a->run.first + a->run.count != b->run.first || a->run.count + b->run.count > GROUP_SIZE) return false;
  struct group both = {.run = {a->run.first, a->run.count + b->run.count}, .box = a->box};
  kith_box_include(&both.box, b->box.lower);
  kith_box_include(&both.box, b->box.upper);
  both.radius = KITH_MAX(a->radius, b->radius);
  both.radius2 = KITH_MAX(a->radius2, b->radius2);
  if (!(volume(&both) <= 1.5 * KITH_MAX(volume(a), volume(b)))) return false;
  *a = both;
  return true;
}

/* First group of a chunk. */
static int chunk_start(const struct kith_search *search, int chunk) {
  return (int)((int64_t)search->n_groups * chunk / KITH_ROW_CHUNKS);
}

/* --- candidates of a group --- */

static bool ascending(const uint64_t *key, size_t n) {
  for (size_t k = 1; k < n; ++k)
    if (key[k] < key[k - 1]) return false;
  return true;
}

static size_t ascent(const uint64_t *key, size_t from, size_t n) {
  size_t k = from + 1;
  while (k < n && key[k] > key[k - 1]) ++k;
  return KITH_MIN(k, n);
}

static void merge(const uint64_t *a, const uint64_t *a_end, const uint64_t *b, const uint64_t *b_end,
                  uint64_t *out) {
  while (a < a_end && b < b_end) {
    const bool first = *a < *b;
    *out++ = first ? *a : *b;
    a += first, b += !first;
  }
  if (a < a_end) memcpy(out, a, (size_t)(a_end - a) * sizeof *out);
  if (b < b_end) memcpy(out, b, (size_t)(b_end - b) * sizeof *out);
}

/* Natural merge sort: slots nearly follow the nodes, so there are few ascending sequences. Returns the array
 * that holds the sorted keys. */
static uint64_t *sort_keys(uint64_t *key, uint64_t *spare, size_t n) {
  while (!ascending(key, n)) {
    for (size_t from = 0; from < n;) {
      const size_t middle = ascent(key, from, n);
      const size_t to = middle < n ? ascent(key, middle, n) : n;
      merge(key + from, key + middle, key + middle, key + to, spare + from);
      from = to;
    }
    uint64_t *swap = key;
    key = spare, spare = swap;
  }
  return key;
}

static kith_status reserve_keys(struct kith_worker *worker) {
  size_t total = 0;
  for (int r = 0; r < worker->runs.n; ++r) total += (size_t)worker->runs.run[r].count;
  if (total <= worker->keys_capacity) return KITH_OK;
  const size_t capacity = total + total / 2;
  worker->keys_capacity = 0;
  for (int k = 0; k < 3; ++k) KITH_TRY(kith_resize(&worker->key[k], 0, capacity, sizeof(uint64_t)));
  KITH_TRY(kith_resize(&worker->slot, 0, capacity, sizeof(kith_index)));
  worker->keys_capacity = capacity;
  return KITH_OK;
}

/* Keys of the slots within range of the box, internal nodes and ghosts apart: each of the two is nearly
 * ascending. */
static void collect(struct kith_worker *worker, const struct kith_search *search, const struct kith_box *box,
                    double radius2, kith_index n_internal, size_t *n_inner, size_t *n_outer) {
  uint64_t *inner = worker->key[0], *outer = worker->key[1];
  size_t n = 0;
  for (int r = 0; r < worker->runs.n; ++r)
    n += kith_box_slots(search, worker->runs.run[r], box, radius2, worker->slot + n);
  for (size_t k = 0; k < n; ++k) {
    const kith_index slot = worker->slot[k], node = search->node[slot];
    *inner = *outer = (uint64_t)node << 32 | (uint64_t)slot;
    inner += node < n_internal, outer += node >= n_internal;
  }
  *n_inner = (size_t)(inner - worker->key[0]);
  *n_outer = (size_t)(outer - worker->key[1]);
}

/* self[m]: the position of target m among the candidates, -1 if it is not one of them (coordinates that are
 * not a number). */
static void pack(struct kith_packed *near, const struct kith_search *search, const uint64_t *key, int from,
                 int n, struct kith_run targets, int *self) {
  for (int p = 0; p < n; ++p) {
    const kith_index slot = (kith_index)(key[p] & 0xffffffffu);
    near->node[from + p] = (kith_index)(key[p] >> 32);
    for (int a = 0; a < NDIM; ++a) near->coordinate[a][from + p] = search->coordinate[a][slot];
    near->radius2[from + p] = search->radius2[slot];
    const kith_index m = slot - targets.first;
    if (m >= 0 && m < targets.count) self[m] = from + p;
  }
}

static kith_status candidates(struct kith_worker *worker, const struct kith_build *build,
                              const struct group *group, int *self) {
  const struct kith_search *search = build->search;
  for (kith_index m = 0; m < group->run.count; ++m) self[m] = -1;
  worker->runs.n = 0;
  KITH_TRY(search->ops->coarse(search, &group->box, group->radius, KITH_GATHER_SCATTER, &worker->runs));
  KITH_TRY(reserve_keys(worker));
  size_t n_inner, n_outer;
  collect(worker, search, &group->box, group->radius2, build->nodes->n_internal, &n_inner, &n_outer);
  KITH_TRY(kith_packed_reserve(&worker->near, n_inner + n_outer));
  /* Sorted keys may end in the spare array, so each part is packed before the next is sorted. */
  pack(&worker->near, search, sort_keys(worker->key[0], worker->key[2], n_inner), 0, (int)n_inner, group->run,
       self);
  pack(&worker->near, search, sort_keys(worker->key[1], worker->key[2], n_outer), (int)n_inner, (int)n_outer,
       group->run, self);
  kith_packed_close(&worker->near, (int)(n_inner + n_outer));
  return KITH_OK;
}

/* --- pass 1 --- */

/* Broad excluders are asked about all candidates, narrow ones about what the distance test leaves. */
static kith_status exclude(struct kith_worker *worker, const struct kith_build *build, kith_index i,
                           uint64_t *hit, int *count) {
  const struct kith_packed *near = &worker->near;
  KITH_TRY(kith_reserve(&worker->allowed, &worker->allowed_capacity, (size_t)near->words, sizeof(uint64_t)));
  for (int w = 0; w < near->words; ++w) worker->allowed[w] = ~UINT64_C(0);
  if (near->n % 64 != 0) worker->allowed[near->words - 1] >>= 64 - near->n % 64;
  kith_build_exclude(build, KITH_BROAD, i, near->node, near->words, worker->allowed);
  for (int w = 0; w < near->words; ++w) hit[w] &= worker->allowed[w];
  *count = kith_build_exclude(build, KITH_NARROW, i, near->node, near->words, hit);
  return KITH_OK;
}

/* One record: number of candidates; slots of the targets; the candidates, two in a word; the bits, target by
 * target. */
enum { HEAD = 2 };

static size_t record_words(const struct kith_packed *near, kith_index targets) {
  return HEAD + ((size_t)near->n + 1) / 2 + (size_t)near->words * (size_t)targets;
}

/* Grows to what the whole chunk will need if the rest is like its first `done` of `all` groups. */
static kith_status reserve_chunk(struct kith_words *chunk, size_t more, int done, int all) {
  const size_t need = chunk->n + more;
  if (need <= chunk->capacity) return KITH_OK;
  const size_t whole = (size_t)((double)need / done * all * 1.06);
  const size_t capacity = KITH_MAX(whole, need + need / 16);
  KITH_TRY(kith_resize(&chunk->word, chunk->n, capacity, sizeof *chunk->word));
  chunk->capacity = capacity;
  return KITH_OK;
}

static kith_status test_targets(struct kith_worker *worker, const struct kith_build *build,
                                struct kith_run targets, const int *self, size_t *length, uint64_t *hit) {
  const struct kith_search *search = build->search;
  for (kith_index m = 0; m < targets.count; ++m, hit += worker->near.words) {
    const kith_index slot = targets.first + m, i = search->node[slot];
    double x[NDIM];
    for (int a = 0; a < NDIM; ++a) x[a] = search->coordinate[a][slot];
    int count = kith_packed_hits(&worker->near, x, search->radius2[slot], hit);
    if (self[m] >= 0) {
      uint64_t *word = &hit[self[m] / 64];
      const uint64_t bit = UINT64_C(1) << (self[m] % 64);
      count -= (*word & bit) != 0;
      *word &= ~bit;
    }
    if (build->excluders != NULL) KITH_TRY(exclude(worker, build, i, hit, &count));
    length[i] = (size_t)count;
  }
  worker->candidates += (size_t)worker->near.n * (size_t)targets.count;
  return KITH_OK;
}

/* With this group, `done` of `all` groups of the chunk have been tested. length[i]: of row i. */
static kith_status test_group(struct kith_worker *worker, const struct kith_build *build,
                              struct kith_words *chunk, size_t *length, const struct group *group, int done,
                              int all) {
  int self[GROUP_SIZE];
  KITH_TRY(candidates(worker, build, group, self));
  const size_t words = record_words(&worker->near, group->run.count), n = (size_t)worker->near.n;
  KITH_TRY(reserve_chunk(chunk, words, done, all));
  uint64_t *record = chunk->word + chunk->n;
  record[0] = n;
  record[1] = (uint64_t)group->run.first << 32 | (uint64_t)group->run.count;
  memcpy(record + HEAD, worker->near.node, n * sizeof(kith_index));
  chunk->n += words;
  return test_targets(worker, build, group->run, self, length, record + HEAD + (n + 1) / 2);
}

/* Cuts large groups, joins small ones. Ghosts and internal nodes are never in one group. */
static kith_status test_chunk(struct kith_worker *worker, const struct kith_build *build,
                              struct kith_words *chunk, size_t *length, int chunk_number, bool ghosts) {
  const struct kith_search *search = build->search;
  const int start = chunk_start(search, chunk_number), stop = chunk_start(search, chunk_number + 1);
  struct group open = {0};
  chunk->n = 0;
  for (int g = start; g < stop; ++g) {
    const struct kith_run group = search->group[g];
    if (group.count == 0 || (!ghosts && search->node[group.first] >= build->nodes->n_internal)) continue;
    const kith_index parts = (group.count + GROUP_SIZE - 1) / GROUP_SIZE;
    for (kith_index p = 0; p < parts; ++p) {
      const kith_index from = (kith_index)((int64_t)group.count * p / parts);
      const kith_index to = (kith_index)((int64_t)group.count * (p + 1) / parts);
      const struct group next = group_of(search, group.first + from, to - from);
      if (open.run.count > 0 && join(&open, &next)) continue;
      if (open.run.count > 0)
        KITH_TRY(test_group(worker, build, chunk, length, &open, g + 1 - start, stop - start));
      open = next;
    }
  }
  if (open.run.count > 0) KITH_TRY(test_group(worker, build, chunk, length, &open, 1, 1));
  return KITH_OK;
}

static kith_status test_all(struct kith_rows *rows, const struct kith_build *build, bool ghosts,
                            struct kith_row_chunks *chunks) {
  kith_status status = KITH_OK;
#pragma omp parallel for schedule(dynamic, 1) if (rows->n > KITH_FEW)
  for (int c = 0; c < KITH_ROW_CHUNKS; ++c) {
    const kith_status mine = test_chunk(&build->workers->worker[omp_get_thread_num()], build,
                                        &chunks->chunk[c], rows->first + 1, c, ghosts);
    if (mine != KITH_OK) {
#pragma omp critical(kith_rows)
      status = mine;
    }
  }
  /* The message of the failure stayed on its thread. */
  if (status != KITH_OK)
    return kith_fail(status, "the rows could not be built: %s", kith_status_text(status));
  return KITH_OK;
}

/* --- pass 2 --- */

static void fill_chunk(struct kith_rows *rows, const struct kith_search *search,
                       const struct kith_words *chunk) {
  const uint64_t *record = chunk->word;
  while (record < chunk->word + chunk->n) {
    const int n = (int)record[0], words = (n + 63) / 64;
    const kith_index first = (kith_index)(record[1] >> 32), count = (kith_index)(record[1] & 0xffffffffu);
    const kith_index *node = (const kith_index *)(record + HEAD);
    record += HEAD + (n + 1) / 2;
    for (kith_index slot = first; slot < first + count; ++slot, record += words)
      kith_packed_extract(node, words, record, rows->node + rows->first[search->node[slot]]);
  }
}

kith_status kith_rows_build(struct kith_rows *rows, const struct kith_build *build, bool ghosts,
                            struct kith_row_chunks *chunks, size_t *candidates) {
  KITH_TRY(kith_rows_reserve(rows, ghosts ? kith_nodes_count(build->nodes) : build->nodes->n_internal));
  memset(rows->first, 0, ((size_t)rows->n + 1) * sizeof(size_t));
  for (int t = 0; t < build->workers->n; ++t) build->workers->worker[t].candidates = 0;
  KITH_TRY(test_all(rows, build, ghosts, chunks));
  *candidates = 0;
  for (int t = 0; t < build->workers->n; ++t) *candidates += build->workers->worker[t].candidates;
  KITH_TRY(kith_rows_sum(rows));
#pragma omp parallel for schedule(dynamic, 1) if (rows->n > KITH_FEW)
  for (int c = 0; c < KITH_ROW_CHUNKS; ++c) fill_chunk(rows, build->search, &chunks->chunk[c]);
  return KITH_OK;
}

/* --- rows --- */

kith_status kith_rows_reserve(struct kith_rows *rows, kith_index n) {
  KITH_TRY(kith_reserve(&rows->first, &rows->rows_capacity, (size_t)n + 1, sizeof *rows->first));
  rows->n = n;
  return KITH_OK;
}

kith_status kith_rows_sum(struct kith_rows *rows) {
  for (kith_index i = 0; i < rows->n; ++i) rows->first[i + 1] += rows->first[i];
  return kith_reserve(&rows->node, &rows->entries_capacity, rows->first[rows->n], sizeof *rows->node);
}

void kith_rows_clear(struct kith_rows *rows) {
  kith_free(&rows->first);
  kith_free(&rows->node);
  *rows = (struct kith_rows){0};
}

size_t kith_rows_bytes(const struct kith_rows *rows) {
  return rows->rows_capacity * sizeof *rows->first + rows->entries_capacity * sizeof *rows->node;
}

size_t kith_rows_longest(const struct kith_rows *rows) {
  size_t longest = 0;
#pragma omp parallel for schedule(static) reduction(max : longest)
  for (kith_index i = 0; i < rows->n; ++i) longest = KITH_MAX(longest, rows->first[i + 1] - rows->first[i]);
  return longest;
}

/* Each share is compacted where it is; then the shares are moved together. */
void kith_rows_compact(struct kith_rows *rows) {
  size_t start[KITH_SHARES], length[KITH_SHARES], gap[KITH_SHARES], to = 0;
  if (rows->n == 0) return;
  for (int s = 0; s < KITH_SHARES; ++s) start[s] = rows->first[kith_share_start(rows->n, s)];
#pragma omp parallel for schedule(dynamic, 1) if (rows->n > KITH_FEW)
  for (int s = 0; s < KITH_SHARES; ++s) {
    size_t e = start[s], kept = start[s];
    for (kith_index i = kith_share_start(rows->n, s); i < kith_share_start(rows->n, s + 1); ++i) {
      for (; e < rows->first[i + 1]; ++e)
        if (rows->node[e] >= 0) rows->node[kept++] = rows->node[e];
      rows->first[i + 1] = kept;
    }
    length[s] = kept - start[s];
  }
  for (int s = 0; s < KITH_SHARES; ++s, to += length[s - 1]) {
    gap[s] = start[s] - to;
    if (gap[s] > 0) memmove(rows->node + to, rows->node + start[s], length[s] * sizeof *rows->node);
  }
#pragma omp parallel for schedule(static) if (rows->n > KITH_FEW)
  for (int s = 0; s < KITH_SHARES; ++s)
    for (kith_index i = kith_share_start(rows->n, s); i < kith_share_start(rows->n, s + 1); ++i)
      rows->first[i + 1] -= gap[s];
}
