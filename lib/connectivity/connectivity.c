#include "lib/connectivity/connectivity.h"

#include <omp.h>

#include "lib/connectivity/internal.h"

struct kith_requirements kith_requirements_or(struct kith_requirements a, struct kith_requirements b) {
  return (struct kith_requirements){.rows = a.rows || b.rows,
                                    .pairs = a.pairs || b.pairs,
                                    .ghost_rows = a.ghost_rows || b.ghost_rows,
                                    .overlap = a.overlap || b.overlap,
                                    .intersection = a.intersection || b.intersection,
                                    /* who asks for all common neighbors must get them all */
                                    .on_segment = (a.on_segment || !a.intersection) &&
                                                  (b.on_segment || !b.intersection) &&
                                                  (a.on_segment || b.on_segment)};
}

/* --- memory --- */

kith_status kith_room(void *p, size_t *capacity, size_t count, size_t size) {
  if (count <= *capacity) return KITH_OK;
  const size_t more = *capacity == 0 ? count : count + count / 16;
  *capacity = 0;
  KITH_TRY(kith_resize(p, 0, more, size));
  *capacity = more;
  return KITH_OK;
}

kith_status kith_rows_room(struct kith_rows *rows, kith_index n) {
  KITH_TRY(kith_room(&rows->first, &rows->rows_capacity, (size_t)n + 1, sizeof *rows->first));
  rows->n = n;
  return KITH_OK;
}

kith_status kith_rows_sum(struct kith_rows *rows) {
  for (kith_index i = 0; i < rows->n; ++i) rows->first[i + 1] += rows->first[i];
  return kith_room(&rows->node, &rows->entries_capacity, rows->first[rows->n], sizeof *rows->node);
}

static void worker_clear(struct kith_worker *worker) {
  kith_runs_clear(&worker->runs);
  kith_packed_clear(&worker->near);
  for (int k = 0; k < 3; ++k) kith_free(&worker->key[k]);
  kith_free(&worker->slot);
  kith_free(&worker->hit);
  kith_free(&worker->allowed);
  kith_free(&worker->bitmap);
  kith_free(&worker->touched);
}

kith_status kith_workers_room(struct kith_connectivity_scratch *scratch) {
  const int threads = omp_get_max_threads();
  if (threads <= scratch->n_workers) return KITH_OK;
  KITH_TRY(
      kith_resize(&scratch->worker, (size_t)scratch->n_workers, (size_t)threads, sizeof *scratch->worker));
  scratch->n_workers = threads;
  return KITH_OK;
}

static void rows_clear(struct kith_rows *rows) {
  kith_free(&rows->first);
  kith_free(&rows->node);
}

kith_status kith_connectivity_create(struct kith_connectivity **out) {
  *out = NULL;
  struct kith_connectivity *connectivity = NULL;
  KITH_TRY(kith_resize(&connectivity, 0, 1, sizeof *connectivity));
  const kith_status status = kith_resize(&connectivity->scratch, 0, 1, sizeof *connectivity->scratch);
  if (status != KITH_OK) {
    kith_free(&connectivity);
    return status;
  }
  connectivity->positions = connectivity->ghosts = UINT64_MAX; /* made from nothing yet */
  *out = connectivity;
  return KITH_OK;
}

static void scratch_clear(struct kith_connectivity_scratch *scratch) {
  for (int t = 0; t < scratch->n_workers; ++t) worker_clear(&scratch->worker[t]);
  for (int c = 0; c < KITH_CHUNKS; ++c) kith_free(&scratch->chunk[c].word);
  kith_free(&scratch->worker);
  kith_free(&scratch->cursor);
  kith_free(&scratch->span_first);
  kith_free(&scratch->span);
  kith_free(&scratch->span_bits);
  kith_free(&scratch->couple);
}

void kith_connectivity_destroy(struct kith_connectivity **connectivity) {
  struct kith_connectivity *c = *connectivity;
  if (c == NULL) return;
  scratch_clear(c->scratch);
  kith_free(&c->scratch);
  rows_clear(&c->rows);
  rows_clear(&c->overlap);
  rows_clear(&c->intersection);
  kith_free(&c->pairs.node);
  kith_free(&c->pairs.first);
  kith_free(&c->pairs.of_row);
  kith_free(connectivity);
}

static size_t rows_bytes(const struct kith_rows *rows) {
  return rows->rows_capacity * sizeof *rows->first + rows->entries_capacity * sizeof *rows->node;
}

static size_t worker_bytes(const struct kith_worker *worker) {
  return sizeof *worker + (size_t)worker->runs.capacity * sizeof(struct kith_run) +
         (size_t)worker->near.capacity * (sizeof(kith_index) + (NDIM + 1) * sizeof(double)) +
         (3 * worker->keys_capacity + worker->hit_capacity + worker->allowed_capacity +
          worker->bitmap_capacity + worker->touched_capacity) *
             sizeof(uint64_t) +
         worker->keys_capacity * sizeof(kith_index);
}

size_t kith_connectivity_bytes(const struct kith_connectivity *connectivity) {
  const struct kith_pairs *pairs = &connectivity->pairs;
  const struct kith_connectivity_scratch *scratch = connectivity->scratch;
  size_t bytes = sizeof *connectivity + sizeof *scratch;
  bytes += rows_bytes(&connectivity->rows) + rows_bytes(&connectivity->overlap) +
           rows_bytes(&connectivity->intersection);
  bytes += pairs->capacity * sizeof *pairs->node + pairs->first_capacity * sizeof *pairs->first;
  bytes += pairs->of_row_capacity * sizeof *pairs->of_row;
  for (int t = 0; t < scratch->n_workers; ++t) bytes += worker_bytes(&scratch->worker[t]);
  for (int c = 0; c < KITH_CHUNKS; ++c) bytes += scratch->chunk[c].capacity * sizeof(uint64_t);
  bytes += scratch->cursor_capacity * sizeof *scratch->cursor;
  bytes += scratch->span_first_capacity * sizeof(size_t) + scratch->span_capacity * sizeof *scratch->span;
  bytes += scratch->span_bits_capacity * sizeof(uint64_t) + scratch->couple_capacity * sizeof(double);
  return bytes;
}

/* --- building --- */

/* What has to be there for the rest to be made. */
static struct kith_requirements completed(struct kith_requirements need) {
  need.pairs = need.pairs || need.intersection;
  need.rows = need.rows || need.pairs || need.overlap || need.ghost_rows;
  need.on_segment = need.on_segment && need.intersection;
  return need;
}

static kith_status build_stages(const struct kith_build *build, struct kith_profile *profile) {
  struct kith_connectivity *connectivity = build->connectivity;
  const struct kith_requirements need = connectivity->built;
  const kith_index n_internal = build->nodes->n_internal, n = kith_nodes_count(build->nodes);
  kith_status status = KITH_OK;
#define STAGE(name, wanted, call)      \
  if (status == KITH_OK && (wanted)) { \
    kith_profile_begin(profile, name); \
    status = call;                     \
    kith_profile_end(profile);         \
  }
  STAGE("rows", need.rows, kith_rows_build(build, need.ghost_rows || need.overlap))
  STAGE("overlap", need.overlap, kith_overlap_build(build, need.ghost_rows ? n : n_internal))
  if (status == KITH_OK && need.rows && !need.ghost_rows) kith_rows_strip(&connectivity->rows, n_internal);
  STAGE("pairs", need.pairs, kith_pairs_build(build))
  STAGE("intersection", need.intersection, kith_intersection_build(build))
#undef STAGE
  return status;
}

static void report(const struct kith_connectivity *connectivity, struct kith_profile *profile) {
  kith_profile_count(profile, "candidates", (double)connectivity->candidates);
  kith_profile_count(profile, "row entries",
                     connectivity->rows.n > 0 ? (double)connectivity->rows.first[connectivity->rows.n] : 0);
  kith_profile_count(profile, "pairs", (double)connectivity->pairs.n);
}

kith_status kith_connectivity_build(struct kith_connectivity *connectivity, const struct kith_nodes *nodes,
                                    const struct kith_search *search, struct kith_requirements need,
                                    const struct kith_excluder *excluders, struct kith_profile *profile) {
  if (search->nodes != nodes) KITH_FAIL(INTERNAL, "the search belongs to other nodes");
  KITH_TRY(kith_search_fresh(search));
  const struct kith_build build = {connectivity, nodes, search, excluders};
  connectivity->built = completed(need);
  connectivity->canonical = false;
  connectivity->rows.n = connectivity->overlap.n = connectivity->intersection.n = 0;
  connectivity->pairs.n = connectivity->candidates = 0;
  connectivity->pairs.f_couple = NULL;
  ++connectivity->generation;
  kith_status status = kith_workers_room(connectivity->scratch);
  if (status == KITH_OK) status = build_stages(&build, profile);
  if (status != KITH_OK) { /* nothing is there, rather than half of it */
    connectivity->built = (struct kith_requirements){0};
    connectivity->rows.n = connectivity->overlap.n = connectivity->intersection.n = 0;
    connectivity->pairs.n = 0;
    connectivity->positions = connectivity->ghosts = UINT64_MAX;
    return status;
  }
  connectivity->positions = nodes->positions;
  connectivity->ghosts = nodes->ghosts;
  report(connectivity, profile);
  return KITH_OK;
}

/* --- questions --- */

kith_status kith_connectivity_fresh(const struct kith_connectivity *connectivity,
                                    const struct kith_nodes *nodes) {
  if (connectivity->ghosts != nodes->ghosts)
    KITH_FAIL(STALE, "the connectivity was made from ghosts of generation %lld, there is %lld",
              (long long)connectivity->ghosts, (long long)nodes->ghosts);
  return KITH_OK;
}

void kith_connectivity_mark_ghosts(const struct kith_connectivity *connectivity,
                                   const struct kith_nodes *nodes, uint8_t *keep) {
  const struct kith_rows *rows = &connectivity->rows;
  if (rows->n == 0) return;
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    for (size_t e = rows->first[i + 1]; e > rows->first[i] && rows->node[e - 1] >= nodes->n_internal; --e)
      keep[rows->node[e - 1] - nodes->n_internal] = 1;
}

size_t kith_connectivity_pair(const struct kith_connectivity *connectivity, kith_index i, kith_index j) {
  const struct kith_pairs *pairs = &connectivity->pairs;
  const kith_index low = KITH_MIN(i, j), high = KITH_MAX(i, j);
  if (!connectivity->built.pairs || low < 0 || high >= connectivity->rows.n) return pairs->n;
  const size_t first = pairs->first[low], stop = connectivity->rows.first[low + 1];
  const size_t start = stop - (pairs->first[low + 1] - first);
  const size_t e = kith_lower_bound(connectivity->rows.node, start, stop, high);
  return e < stop && connectivity->rows.node[e] == high ? first + (e - start) : pairs->n;
}

kith_status kith_connectivity_couple(struct kith_connectivity *connectivity) {
  struct kith_pairs *pairs = &connectivity->pairs;
  struct kith_connectivity_scratch *scratch = connectivity->scratch;
  if (pairs->f_couple != NULL) return KITH_OK;
  KITH_TRY(kith_room(&scratch->couple, &scratch->couple_capacity, KITH_MAX(pairs->n, 1), sizeof(double)));
  for (size_t p = 0; p < pairs->n; ++p) scratch->couple[p] = 1;
  pairs->f_couple = scratch->couple;
  return KITH_OK;
}
