/* Rows. Masters that are close together (a bunch) share their candidates: those are cut down to the bunch's
 * box, sorted by node once, and packed; then each row falls out of one streamed distance test in ascending
 * order.
 *
 * Pass 1 leaves the candidates and one bit per candidate and master; pass 2 turns bits into entries at their
 * final place. So no distance is tested twice, and what is kept in between is smaller than the rows
 * themselves. */
#include "lib/connectivity/internal.h"

#include <omp.h>
#include <string.h>

#include "lib/connectivity/excluder.h"

/* Fewer masters: a smaller box and fewer tests each; more: the candidates are packed less often. Flat between
 * 16 and 48. */
enum { BUNCH = 32 };

/* --- bunches --- */

/* Masters: slots, their box, their largest reach. */
struct bunch {
  struct kith_run run;
  struct kith_box box;
  double radius, radius2;
};

static struct bunch bunch_of(const struct kith_search *search, kith_index first, kith_index count) {
  struct bunch bunch = {.run = {first, count}, .box = kith_box_empty()};
  for (kith_index slot = first; slot < first + count; ++slot) {
    double x[NDIM];
    for (int a = 0; a < NDIM; ++a) x[a] = search->coordinate[a][slot];
    kith_box_include(&bunch.box, x);
    bunch.radius = KITH_MAX(bunch.radius, search->nodes->reach->f64[search->node[slot]]);
    bunch.radius2 = KITH_MAX(bunch.radius2, search->radius2[slot]);
  }
  return bunch;
}

/* Volume in which candidates may lie. */
static double volume(const struct bunch *bunch) {
  double v = 1;
  for (int a = 0; a < NDIM; ++a) v *= bunch->box.upper[a] - bunch->box.lower[a] + 2 * bunch->radius;
  return v;
}

/* Joins b to a if it follows in the slots and lies close by: not where a curve jumps. */
static bool join(struct bunch *a, const struct bunch *b) {
  if (a->run.first + a->run.count != b->run.first || a->run.count + b->run.count > BUNCH) return false;
  struct bunch both = {.run = {a->run.first, a->run.count + b->run.count}, .box = a->box};
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
  return (int)((int64_t)search->n_groups * chunk / KITH_CHUNKS);
}

/* --- candidates of a bunch --- */

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

/* Natural merge sort: slots nearly follow the nodes, so there are few ascents. Returns where the sorted keys
 * are. */
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

static kith_status keys_room(struct kith_worker *worker) {
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

/* Keys of the slots that reach the box, internal nodes and ghosts apart: each of the two is nearly ascending.
 */
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

/* self[m]: the place of master m among the candidates, -1 if it is not there (a position that is no number).
 */
static void pack(struct kith_packed *near, const struct kith_search *search, const uint64_t *key, int from,
                 int n, struct kith_run masters, int *self) {
  for (int p = 0; p < n; ++p) {
    const kith_index slot = (kith_index)(key[p] & 0xffffffffu);
    near->node[from + p] = (kith_index)(key[p] >> 32);
    for (int a = 0; a < NDIM; ++a) near->coordinate[a][from + p] = search->coordinate[a][slot];
    near->radius2[from + p] = search->radius2[slot];
    const kith_index m = slot - masters.first;
    if (m >= 0 && m < masters.count) self[m] = from + p;
  }
}

static kith_status candidates(struct kith_worker *worker, const struct kith_build *build,
                              const struct bunch *bunch, int *self) {
  const struct kith_search *search = build->search;
  for (kith_index m = 0; m < bunch->run.count; ++m) self[m] = -1;
  worker->runs.n = 0;
  KITH_TRY(search->ops->coarse(search, &bunch->box, bunch->radius, KITH_GATHER_SCATTER, &worker->runs));
  KITH_TRY(keys_room(worker));
  size_t n_inner, n_outer;
  collect(worker, search, &bunch->box, bunch->radius2, build->nodes->n_internal, &n_inner, &n_outer);
  KITH_TRY(kith_packed_reserve(&worker->near, n_inner + n_outer));
  /* Sorted keys may end in the spare array, so each part is packed before the next is sorted. */
  pack(&worker->near, search, sort_keys(worker->key[0], worker->key[2], n_inner), 0, (int)n_inner, bunch->run,
       self);
  pack(&worker->near, search, sort_keys(worker->key[1], worker->key[2], n_outer), (int)n_inner, (int)n_outer,
       bunch->run, self);
  kith_packed_close(&worker->near, (int)(n_inner + n_outer));
  return KITH_OK;
}

/* --- pass 1 --- */

static int exclude_phase(const struct kith_build *build, enum kith_phase phase, kith_index i,
                         const struct kith_packed *near, uint64_t *hit) {
  int count = 0;
  for (int w = 0; w < near->words; ++w) {
    for (uint64_t bits = hit[w]; bits != 0; bits &= bits - 1) {
      const int k = __builtin_ctzll(bits);
      if (kith_excluder_rejects(build->excluders, phase, build->nodes, i, near->node[64 * w + k]))
        hit[w] &= ~(UINT64_C(1) << k);
    }
    count += __builtin_popcountll(hit[w]);
  }
  return count;
}

/* Broad excluders see the candidates, narrow ones what is left after the distance test. */
static kith_status exclude(struct kith_worker *worker, const struct kith_build *build, kith_index i,
                           uint64_t *hit, int *count) {
  const struct kith_packed *near = &worker->near;
  KITH_TRY(kith_room(&worker->allowed, &worker->allowed_capacity, (size_t)near->words, sizeof(uint64_t)));
  for (int w = 0; w < near->words; ++w) worker->allowed[w] = ~UINT64_C(0);
  if (near->n % 64 != 0) worker->allowed[near->words - 1] >>= 64 - near->n % 64;
  exclude_phase(build, KITH_BROAD, i, near, worker->allowed);
  for (int w = 0; w < near->words; ++w) hit[w] &= worker->allowed[w];
  *count = exclude_phase(build, KITH_NARROW, i, near, hit);
  return KITH_OK;
}

/* One record: number of candidates; masters; the candidates, two in a word; the bits, master by master. */
enum { HEAD = 2 };

static size_t record_words(const struct kith_packed *near, kith_index masters) {
  return HEAD + ((size_t)near->n + 1) / 2 + (size_t)near->words * (size_t)masters;
}

/* Grows to what the whole chunk will need if the rest is like the first `done` of `all` groups. */
static kith_status chunk_room(struct kith_words *chunk, size_t more, int done, int all) {
  const size_t need = chunk->n + more;
  if (need <= chunk->capacity) return KITH_OK;
  const size_t whole = (size_t)((double)need / done * all * 1.06);
  const size_t capacity = KITH_MAX(whole, need + need / 16);
  KITH_TRY(kith_resize(&chunk->word, chunk->n, capacity, sizeof *chunk->word));
  chunk->capacity = capacity;
  return KITH_OK;
}

static kith_status test_masters(struct kith_worker *worker, const struct kith_build *build,
                                struct kith_run masters, const int *self, uint64_t *hit) {
  const struct kith_search *search = build->search;
  size_t *length = build->connectivity->rows.first + 1;
  for (kith_index m = 0; m < masters.count; ++m, hit += worker->near.words) {
    const kith_index slot = masters.first + m, i = search->node[slot];
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
  worker->candidates += (size_t)worker->near.n * (size_t)masters.count;
  return KITH_OK;
}

/* `done` of `all` groups of the chunk are dealt with when this bunch is. */
static kith_status test_bunch(struct kith_worker *worker, const struct kith_build *build,
                              struct kith_words *chunk, const struct bunch *bunch, int done, int all) {
  int self[BUNCH];
  KITH_TRY(candidates(worker, build, bunch, self));
  const size_t words = record_words(&worker->near, bunch->run.count), n = (size_t)worker->near.n;
  KITH_TRY(chunk_room(chunk, words, done, all));
  uint64_t *record = chunk->word + chunk->n;
  record[0] = n;
  record[1] = (uint64_t)bunch->run.first << 32 | (uint64_t)bunch->run.count;
  memcpy(record + HEAD, worker->near.node, n * sizeof(kith_index));
  chunk->n += words;
  return test_masters(worker, build, bunch->run, self, record + HEAD + (n + 1) / 2);
}

/* Cuts large groups, joins small ones. Ghosts and internal nodes are never in one group. */
static kith_status test_chunk(struct kith_worker *worker, const struct kith_build *build, int chunk_number,
                              bool ghosts) {
  const struct kith_search *search = build->search;
  struct kith_words *chunk = &build->connectivity->scratch->chunk[chunk_number];
  const int start = chunk_start(search, chunk_number), stop = chunk_start(search, chunk_number + 1);
  struct bunch open = {0};
  chunk->n = 0;
  for (int g = start; g < stop; ++g) {
    const struct kith_run group = search->group[g];
    if (group.count == 0 || (!ghosts && search->node[group.first] >= build->nodes->n_internal)) continue;
    const kith_index parts = (group.count + BUNCH - 1) / BUNCH;
    for (kith_index p = 0; p < parts; ++p) {
      const kith_index from = (kith_index)((int64_t)group.count * p / parts);
      const kith_index to = (kith_index)((int64_t)group.count * (p + 1) / parts);
      const struct bunch next = bunch_of(search, group.first + from, to - from);
      if (open.run.count > 0 && join(&open, &next)) continue;
      if (open.run.count > 0) KITH_TRY(test_bunch(worker, build, chunk, &open, g + 1 - start, stop - start));
      open = next;
    }
  }
  if (open.run.count > 0) KITH_TRY(test_bunch(worker, build, chunk, &open, 1, 1));
  return KITH_OK;
}

static kith_status test_all(const struct kith_build *build, bool ghosts) {
  struct kith_connectivity_scratch *scratch = build->connectivity->scratch;
  kith_status status = KITH_OK;
#pragma omp parallel for schedule(dynamic, 1) if (build->connectivity->rows.n > KITH_FEW)
  for (int c = 0; c < KITH_CHUNKS; ++c) {
    const kith_status mine = test_chunk(&scratch->worker[omp_get_thread_num()], build, c, ghosts);
    if (mine != KITH_OK) {
#pragma omp critical(kith_rows)
      status = mine;
    }
  }
  /* The message stayed on the thread that failed. */
  if (status != KITH_OK)
    return kith_fail(status, "the rows could not be built: %s", kith_status_text(status));
  return KITH_OK;
}

/* --- pass 2 --- */

static void fill_chunk(const struct kith_build *build, int chunk_number) {
  const struct kith_words *chunk = &build->connectivity->scratch->chunk[chunk_number];
  const struct kith_rows *rows = &build->connectivity->rows;
  const uint64_t *record = chunk->word;
  while (record < chunk->word + chunk->n) {
    const int n = (int)record[0], words = (n + 63) / 64;
    const kith_index first = (kith_index)(record[1] >> 32), count = (kith_index)(record[1] & 0xffffffffu);
    const kith_index *node = (const kith_index *)(record + HEAD);
    record += HEAD + (n + 1) / 2;
    for (kith_index slot = first; slot < first + count; ++slot, record += words)
      kith_packed_extract(node, words, record, rows->node + rows->first[build->search->node[slot]]);
  }
}

kith_status kith_rows_build(const struct kith_build *build, bool ghosts) {
  struct kith_connectivity *connectivity = build->connectivity;
  struct kith_connectivity_scratch *scratch = connectivity->scratch;
  KITH_TRY(kith_rows_room(&connectivity->rows, kith_nodes_count(build->nodes)));
  memset(connectivity->rows.first, 0, ((size_t)connectivity->rows.n + 1) * sizeof(size_t));
  for (int t = 0; t < scratch->n_workers; ++t) scratch->worker[t].candidates = 0;
  KITH_TRY(test_all(build, ghosts));
  connectivity->candidates = 0;
  for (int t = 0; t < scratch->n_workers; ++t) connectivity->candidates += scratch->worker[t].candidates;
  KITH_TRY(kith_rows_sum(&connectivity->rows));
#pragma omp parallel for schedule(dynamic, 1) if (build->connectivity->rows.n > KITH_FEW)
  for (int c = 0; c < KITH_CHUNKS; ++c) fill_chunk(build, c);
  return KITH_OK;
}

void kith_rows_strip(struct kith_rows *rows, kith_index n_internal) {
  for (kith_index i = n_internal; i < rows->n; ++i) rows->first[i + 1] = rows->first[n_internal];
}
