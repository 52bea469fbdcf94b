/* build.c - rows of neighbors from a search.
 *
 * Targets that are close together (a group) share their candidates: those are cut down to the box of the
 * group, sorted by node once, and packed; then each row follows from one streamed distance test in ascending
 * order. Pass 1 keeps the candidates and one bit for each candidate and target; pass 2 turns bits into
 * entries at their final position. So no distance is tested twice, and what is kept in between is smaller
 * than the rows themselves.
 *
 * With block time steps only active nodes are targets, ghosts among them. The row of an idle node holds its
 * active neighbors: it is found from their rows, which have the idle node, and is counted and filled with
 * them. Active ghosts are targets for this alone, so only idle nodes are their candidates. */
#include <omp.h>
#include <string.h>
#include "lib/connectivity/build/fill.h"
#include "lib/connectivity/build/group.h"

/* --- pass 1 --- */

/* Broad excluders are asked about all candidates, narrow ones about what the distance test leaves. */
static kith_status exclude(struct kith_worker *worker, const struct kith_build *build, kith_index i,
                           uint64_t *hit, int *count) {
  const struct kith_packed *near = &worker->near;
  KITH_TRY(kith_reserve(&worker->hit, &worker->hit_capacity, (size_t)near->words, sizeof *worker->hit));
  uint64_t *allowed = worker->hit;
  for (int w = 0; w < near->words; ++w) allowed[w] = ~UINT64_C(0);
  if (near->n % 64 != 0) allowed[near->words - 1] >>= 64 - near->n % 64;
  kith_build_exclude(build, KITH_BROAD, i, kith_build_zero(build), near, allowed);
  for (int w = 0; w < near->words; ++w) hit[w] &= allowed[w];
  *count = kith_build_exclude(build, KITH_NARROW, i, kith_build_zero(build), near, hit);
  return KITH_OK;
}

/* Makes room for `more` words. If there is too little, the chunk gets as much as it will need in all if the
 * groups that are left are like those of which it has the part `done` now. */
static kith_status reserve_chunk(struct kith_words *chunk, size_t more, double done) {
  const size_t need = chunk->n + more;
  if (need <= chunk->capacity) return KITH_OK;
  const size_t whole = (size_t)((double)need / done * 1.06);
  const size_t capacity = KITH_MAX(whole, need + need / 16);
  uint64_t *fresh = NULL;
  KITH_TRY(kith_resize(&fresh, 0, capacity, sizeof *fresh));
  if (chunk->n > 0) memcpy(fresh, chunk->word, chunk->n * sizeof *fresh);
  kith_free(&chunk->own);
  chunk->word = chunk->own = fresh, chunk->capacity = capacity;
  return KITH_OK;
}

/* Shares out the memory of kith_nodes_work to the chunks: each gets what it is expected to need, and an equal
 * part of what is left. A chunk is expected to need a little more than the last time, or almost as much as
 * was expected then, because with block time steps many nodes are active in some ticks, and few between them.
 * The first time it gets what lists of packages mostly need. */
static kith_status share_memory(const struct kith_build *build) {
  enum { FIRST = NDIM == 1 ? 2 : NDIM == 2 ? 5 : 16 }; /* words for each target */
  struct kith_words *chunk = build->scratch->chunk;
  const kith_index targets = build->row != NULL ? build->rows : build->targets->nodes->n_internal;
  size_t all = 0;
  uint64_t *word = NULL;
  for (int c = 0; c < KITH_ROW_CHUNKS; ++c)
    all += chunk[c].expected = KITH_MAX(chunk[c].n + chunk[c].n / 8, chunk[c].expected / 32 * 31);
  if (all == 0)
    for (int c = 0; c < KITH_ROW_CHUNKS; ++c)
      all += chunk[c].expected = FIRST * (size_t)targets / KITH_ROW_CHUNKS;
  const size_t room = kith_nodes_work_bytes(build->nodes) / sizeof *word,
               spare = room > all ? (room - all) / KITH_ROW_CHUNKS : 0;
  KITH_TRY(kith_nodes_work(build->nodes, KITH_MAX(room, all) * sizeof *word, &word));
  for (int c = 0; c < KITH_ROW_CHUNKS; word += chunk[c++].capacity)
    chunk[c].word = word, chunk[c].capacity = chunk[c].expected + spare;
  return KITH_OK;
}

/* Marks the candidates that are idle internal nodes: targets that are their neighbors are added to their
 * rows. */
static kith_status mark_idle(struct kith_worker *worker, const struct kith_nodes *nodes) {
  const struct kith_packed *near = &worker->near;
  KITH_TRY(kith_reserve(&worker->idle, &worker->idle_capacity, (size_t)near->words, sizeof *worker->idle));
  for (int w = 0; w < near->words; ++w) {
    const int n = KITH_MIN(64, near->n - 64 * w);
    worker->idle[w] = 0;
    for (int k = 0; k < n; ++k) {
      const kith_index node = near->node[64 * w + k];
      worker->idle[w] |= (uint64_t)(node < nodes->n_internal && !kith_node_active(nodes, node)) << k;
    }
  }
  return KITH_OK;
}

/* Counts one more entry for the row of each idle node in these bits. A single thread needs no atomics. */
static void count_idle(const struct kith_worker *worker, const uint64_t *hit, size_t *length) {
  const bool alone = omp_get_num_threads() == 1;
  for (int w = 0; w < worker->near.words; ++w)
    for (uint64_t bits = hit[w] & worker->idle[w]; bits != 0; bits &= bits - 1) {
      size_t *mine = &length[worker->near.node[64 * w + __builtin_ctzll(bits)]];
      if (alone)
        ++*mine;
      else
#pragma omp atomic
        ++*mine;
    }
}

/* The candidates whose box touches that of target i at x. */
static int box_hits(const struct kith_packed *near, const struct kith_build *build, kith_index i,
                    const double *x, uint64_t *hit) {
  const double radius = build->targets->search->radius->f64[i];
  int count = 0;
  memset(hit, 0, (size_t)near->words * sizeof *hit);
  for (int p = 0; p < near->n; ++p) {
    const double both = radius + build->search->radius->f64[near->node[p]];
    bool touches = true;
    for (int a = 0; a < NDIM; ++a) touches = touches && fabs(near->coordinate[a][p] - x[a]) <= both;
    hit[p / 64] |= (uint64_t)touches << (p % 64);
    count += touches;
  }
  return count;
}

/* The candidates that are neighbors of the target i in this slot, seen from x. */
KITH_INLINE int hits_from(const struct kith_packed *near, const struct kith_build *build, kith_index slot,
                          const double *x, uint64_t *hit) {
  const struct kith_search *search = build->targets->search;
  if (build->cutoff == KITH_CUTOFF_boxes) return box_hits(near, build, search->node[slot], x, hit);
  const double radius2 = build->cutoff == KITH_CUTOFF_number    ? build->number * build->number
                         : build->cutoff == KITH_CUTOFF_scatter ? -1
                                                                : search->radius2[slot];
  return kith_packed_hits(near, x, radius2, hit);
}

/* As hits_from, for candidates with shifts: the words of each shift at a time. */
static int hits_of_images(const struct kith_packed *near, const struct kith_build *build, kith_index slot,
                          const double *x, uint64_t *hit) {
  double seen_from[NDIM];
  int count = 0;
  for (int w = 0, end; w < near->words; w = end) {
    const uint16_t s = near->shift[64 * w];
    for (end = w + 1; end < near->words && near->shift[64 * end] == s;) ++end;
    const struct kith_packed part = kith_packed_part(near, w, end);
    for (int a = 0; a < NDIM; ++a)
      seen_from[a] = kith_build_moves_source(build, s) ? x[a] : x[a] - kith_build_shift(build, s, a);
    count += hits_from(&part, build, slot, seen_from, hit + w);
  }
  return count;
}

static int hits_of(const struct kith_packed *near, const struct kith_build *build, kith_index slot,
                   uint64_t *hit) {
  double x[NDIM];
  for (int a = 0; a < NDIM; ++a) x[a] = build->targets->search->coordinate[a][slot];
  return build->shifts != NULL ? hits_of_images(near, build, slot, x, hit)
                               : hits_from(near, build, slot, x, hit);
}

static kith_status test_targets(struct kith_worker *worker, const struct kith_build *build,
                                struct kith_run targets, const int *self, bool idle, size_t *length,
                                uint64_t *hit) {
  const kith_index *node = build->targets->search->node;
  const bool all = kith_build_all_targets(build);
  size_t tested = 0;
  for (kith_index m = 0; m < targets.count; ++m) {
    const kith_index slot = targets.first + m, i = node[slot];
    if (!all && !kith_build_is_target(build, i)) continue;
    int count = hits_of(&worker->near, build, slot, hit);
    if (self[m] >= 0 && !build->self) {
      uint64_t *word = &hit[self[m] / 64];
      const uint64_t bit = UINT64_C(1) << (self[m] % 64);
      count -= (*word & bit) != 0;
      *word &= ~bit;
    }
    if (build->excluders != NULL) KITH_TRY(exclude(worker, build, i, hit, &count));
    if (idle) count_idle(worker, hit, length);
    length[all ? i : kith_build_row(build, i)] = (size_t)count;
    hit += worker->near.words;
    ++tested;
  }
  worker->candidates += tested * (size_t)worker->near.n;
  return KITH_OK;
}

/* Boxes around the idle internal nodes of each chunk. They save work where there are ghosts, as most active
 * ghosts have no idle node near. */
static void enclose_idle(const struct kith_build *build) {
  const struct kith_search *search = build->search;
  if (!build->selected || build->nodes->n_ghost == 0) return;
#pragma omp parallel for schedule(static) if (search->n > KITH_FEW)
  for (int c = 0; c < KITH_ROW_CHUNKS; ++c) {
    const int start = kith_part_start(search->n_groups, c, KITH_ROW_CHUNKS),
              stop = kith_part_start(search->n_groups, c + 1, KITH_ROW_CHUNKS);
    struct kith_extent idle = {kith_box_empty(), 0};
    for (int g = start; g < stop; ++g)
      for (kith_index k = 0; k < search->group[g].count; ++k) {
        const kith_index slot = search->group[g].first + k, i = search->node[slot];
        double x[NDIM];
        if (i >= build->nodes->n_internal || kith_node_active(build->nodes, i)) continue;
        for (int a = 0; a < NDIM; ++a) x[a] = search->coordinate[a][slot];
        kith_extent_include(&idle, x, search->radius->f64[i]);
      }
    build->scratch->idle[c] = idle;
  }
}

/* May targets of the group have an idle neighbor? */
static bool idle_near(const struct kith_build *build, const struct kith_group *group) {
  if (!build->selected) return false;
  bool near = build->nodes->n_ghost == 0 || build->shifts != NULL;
  for (int c = 0; c < KITH_ROW_CHUNKS && !near; ++c) {
    const struct kith_extent *idle = &build->scratch->idle[c], *mine = &group->extent;
    near =
        kith_box_near(&mine->box, &idle->box, (1 + KITH_SEARCH_SLACK) * KITH_MAX(mine->radius, idle->radius));
  }
  return near;
}

/* Marks the ghosts that the rows of the group will hold. It is done for a group at a time because its bits
 * are still in the cache. */
static void mark_wanted(const struct kith_packed *near, kith_index targets, const uint64_t *hit,
                        kith_index n_internal, uint8_t *wanted) {
  for (int w = 0; w < near->words; ++w) {
    uint64_t any = 0;
    kith_index last = 0;
    for (int p = 64 * w; p < KITH_MIN(near->n, 64 * (w + 1)); ++p) last = KITH_MAX(last, near->node[p]);
    if (last < n_internal) continue;
    for (kith_index t = 0; t < targets; ++t) any |= hit[(size_t)t * (size_t)near->words + (size_t)w];
    for (; any != 0; any &= any - 1) {
      const kith_index ghost = near->node[64 * w + __builtin_ctzll(any)] - n_internal;
      if (ghost < 0) continue;
#pragma omp atomic write
      wanted[ghost] = 1;
    }
  }
}

/* Tests one group: appends its record to the chunk, and writes the length of row i to first[i + 1]. With it
 * the part `done` of the groups of the chunk is tested. */
static kith_status test_group(struct kith_worker *worker, const struct kith_build *build,
                              struct kith_words *chunk, struct kith_rows *rows,
                              const struct kith_group *group, double done) {
  int self[KITH_GROUP_SLOTS];
  const bool idle = idle_near(build, group);
  if (kith_group_serves_idle(build, group) && !idle) return KITH_OK;
  KITH_TRY(kith_group_candidates(worker, build, group, self));
  if (idle) KITH_TRY(mark_idle(worker, build->nodes));
  const size_t n = (size_t)worker->near.n, words = (size_t)worker->near.words,
               all_words = kith_record_head(build, n, idle) + words * (size_t)group->targets;
  KITH_TRY(reserve_chunk(chunk, all_words, done));
  uint64_t *word = chunk->word + chunk->n;
  word[0] = (uint64_t)idle << 32 | n;
  word[1] = (uint64_t)group->run.first << 32 | (uint64_t)group->run.count;
  const struct kith_record record = kith_record_at(build, word);
  if (n > 0) memcpy(record.node, worker->near.node, n * sizeof *record.node);
  if (n > 0 && build->shifts != NULL) memcpy(record.shift, worker->near.shift, n * sizeof *record.shift);
  if (idle && words > 0) memcpy(record.idle, worker->idle, words * sizeof *record.idle);
  chunk->n += all_words;
  KITH_TRY(test_targets(worker, build, group->run, self, idle, rows->first + 1, record.hit));
  if (rows->wanted != NULL)
    mark_wanted(&worker->near, group->targets, record.hit, build->nodes->n_internal, rows->wanted);
  return KITH_OK;
}

static int first_awake(const struct kith_build *build, int group, int end) {
  return build->selected ? kith_search_next_awake(build->targets->search, group, end) : group;
}

/* Tests the groups of a chunk: large ones are cut, small ones joined. No group has both internal nodes and
 * ghosts. */
static kith_status test_chunk(struct kith_worker *worker, const struct kith_build *build, int chunk_number,
                              struct kith_rows *rows) {
  const struct kith_search *search = build->targets->search;
  const bool ghosts = build->targets->ghosts || build->selected;
  struct kith_words *chunk = &build->scratch->chunk[chunk_number];
  const int start = kith_part_start(search->n_groups, chunk_number, KITH_ROW_CHUNKS),
            stop = kith_part_start(search->n_groups, chunk_number + 1, KITH_ROW_CHUNKS);
  struct kith_group open = {0};
  chunk->n = 0;
  for (int g = first_awake(build, start, stop); g < stop; g = first_awake(build, g + 1, stop)) {
    const struct kith_run group = search->group[g];
    if (group.count == 0 || (!ghosts && search->node[group.first] >= search->n_internal)) continue;
    const kith_index parts = (group.count + KITH_GROUP_SIZE - 1) / KITH_GROUP_SIZE;
    for (kith_index p = 0; p < parts; ++p) {
      const kith_index from = kith_part_start(group.count, p, parts),
                       to = kith_part_start(group.count, p + 1, parts);
      const struct kith_group next = kith_group_of(build, group.first + from, to - from);
      if (next.targets == 0 || (open.targets > 0 && kith_group_join(&open, &next))) continue;
      if (open.targets > 0)
        KITH_TRY(test_group(worker, build, chunk, rows, &open, (double)(g + 1 - start) / (stop - start)));
      open = next;
    }
  }
  return open.targets > 0 ? test_group(worker, build, chunk, rows, &open, 1) : KITH_OK;
}

/* Tests all chunks. A failure gets a new message: its own stays on its thread. */
static kith_status test_chunks(const struct kith_build *build, struct kith_rows *rows) {
  struct kith_builder *scratch = build->scratch;
  int status = KITH_OK;
#pragma omp parallel for schedule(dynamic, 1) reduction(max \
                                                        : status) if (build->targets->search->n > KITH_FEW)
  for (int c = 0; c < KITH_ROW_CHUNKS; ++c) {
    const int mine = (int)test_chunk(&scratch->worker[omp_get_thread_num()], build, c, rows);
    status = KITH_MAX(status, mine);
  }
  if (status == KITH_OK) return KITH_OK;
  return kith_fail((kith_status)status, "the neighbor lists could not be built: %s",
                   kith_status_text((kith_status)status));
}

/* `wanted` is known for rows of all internal nodes, with the same nodes and their ghosts as sources. It is
 * there then, also if there are no ghosts: ranks wait for each other in when_marked. */
static kith_status begin_wanted(struct kith_rows *rows, const struct kith_build *build, bool of_ghosts) {
  kith_free(&rows->wanted);
  if (of_ghosts || !kith_build_all_targets(build) || build->targets->search != build->search) return KITH_OK;
  rows->wanted_bytes = (size_t)build->nodes->n_ghost + 1;
  return kith_resize(&rows->wanted, 0, rows->wanted_bytes, 1);
}

kith_status kith_rows_build(struct kith_rows *rows, const struct kith_build *build, size_t *candidates) {
  struct kith_builder *scratch = build->scratch;
  const bool ghosts = build->targets->ghosts || build->selected;
  KITH_TRY(kith_rows_reserve(rows, build->row != NULL ? build->rows
                                   : ghosts           ? kith_nodes_count(build->nodes)
                                                      : build->nodes->n_internal));
  memset(rows->first, 0, ((size_t)rows->n + 1) * sizeof(size_t));
  for (int t = 0; t < scratch->threads; ++t) scratch->worker[t].candidates = 0;
  enclose_idle(build);
  KITH_TRY(share_memory(build));
  KITH_TRY(begin_wanted(rows, build, ghosts));
  KITH_TRY(test_chunks(build, rows));
  *candidates = 0;
  for (int t = 0; t < scratch->threads; ++t) *candidates += scratch->worker[t].candidates;
  KITH_TRY(kith_rows_sum(rows, build->shifts != NULL ? build->shifts->zero : -1));
  const size_t longest = build->shifts != NULL ? kith_rows_longest(rows) : 0;
  for (int t = 0; t < scratch->threads && build->shifts != NULL; ++t)
    KITH_TRY(kith_reserve(&scratch->worker[t].key, &scratch->worker[t].key_capacity, 2 * longest,
                          sizeof *scratch->worker[t].key));
  if (build->selected) KITH_TRY(kith_rows_begin_idle(rows, build));
  if (build->when_marked != NULL && rows->wanted != NULL) KITH_TRY(build->when_marked(build->context));
#pragma omp parallel for schedule(dynamic, 1) if (rows->n > KITH_FEW)
  for (int c = 0; c < KITH_ROW_CHUNKS; ++c) {
    kith_chunk_fill(rows, build, &scratch->chunk[c]);
    kith_free(&scratch->chunk[c].own);
    if (omp_get_thread_num() == 0) kith_ranks_progress(build->nodes->ranks);
  }
  if (build->selected) kith_rows_end_idle(rows, build);
  return KITH_OK;
}
