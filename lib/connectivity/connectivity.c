/* connectivity.c - builds what is required and answers questions about it. */
#include "lib/connectivity/connectivity.h"

/* What both agree on, if both require intersections. */
static const struct kith_field *agreed(const struct kith_requirements *a, const struct kith_field *of_a,
                                       const struct kith_requirements *b, const struct kith_field *of_b) {
  if (!a->intersection || !b->intersection) return a->intersection ? of_a : of_b;
  return of_a == of_b ? of_a : NULL;
}

struct kith_requirements kith_requirements_or(struct kith_requirements a, struct kith_requirements b) {
  return (struct kith_requirements){.rows = a.rows || b.rows,
                                    .pairs = a.pairs || b.pairs,
                                    .ghost_rows = a.ghost_rows || b.ghost_rows,
                                    .overlap = a.overlap || b.overlap || a.overlap_pairs || b.overlap_pairs,
                                    .overlap_pairs = a.overlap_pairs || b.overlap_pairs,
                                    .intersection = a.intersection || b.intersection,
                                    /* if one requires all common neighbors, there are all */
                                    .on_segment = (a.on_segment || !a.intersection) &&
                                                  (b.on_segment || !b.intersection) &&
                                                  (a.on_segment || b.on_segment),
                                    .obstacles = agreed(&a, a.obstacles, &b, b.obstacles),
                                    .barriers = agreed(&a, a.barriers, &b, b.barriers)};
}

/* --- memory --- */

/* Marks it as empty: nothing is built. */
static void reset(struct kith_connectivity *c) {
  c->built = (struct kith_requirements){0};
  c->canonical = false;
  c->rows.n = c->overlap.n = c->intersection.n = c->n = c->n_internal = 0;
  c->pairs.n = c->overlap_pairs.n = c->candidates = 0;
  ++c->pairs.generation, ++c->overlap_pairs.generation;
  c->ghosts = UINT64_MAX;
}

kith_status kith_connectivity_create(struct kith_connectivity **out) {
  *out = NULL;
  KITH_TRY(kith_resize(out, 0, 1, sizeof **out));
  reset(*out);
  return KITH_OK;
}

void kith_connectivity_destroy(struct kith_connectivity **connectivity) {
  struct kith_connectivity *c = *connectivity;
  if (c == NULL) return;
  kith_builder_clear(&c->scratch);
  kith_rows_clear(&c->rows);
  kith_rows_clear(&c->overlap);
  kith_rows_clear(&c->intersection);
  kith_pairs_clear(&c->pairs);
  kith_pairs_clear(&c->overlap_pairs);
  kith_free(connectivity);
}

size_t kith_connectivity_bytes(const struct kith_connectivity *c) {
  return sizeof *c + kith_builder_bytes(&c->scratch) + kith_rows_bytes(&c->rows) +
         kith_rows_bytes(&c->overlap) + kith_rows_bytes(&c->intersection) + kith_pairs_bytes(&c->pairs) +
         kith_pairs_bytes(&c->overlap_pairs);
}

/* --- building --- */

/* `need`, and what the required structures are made from. */
static struct kith_requirements completed(struct kith_requirements need) {
  need.overlap = need.overlap || need.overlap_pairs;
  need.pairs = need.pairs || need.intersection;
  need.rows = need.rows || need.pairs || need.overlap || need.ghost_rows;
  need.on_segment = need.on_segment && need.intersection;
  if (!need.intersection || need.ghost_rows) /* rows of ghosts depend on culling */
    need.obstacles = need.barriers = NULL;
  return need;
}

/* Bytes of rows; of what the first pass over groups stores for the second. */
static double bytes_of(const struct kith_rows *rows) {
  const size_t entry = sizeof *rows->node + (rows->shift != NULL ? sizeof *rows->shift : 0);
  return (double)(rows->first[rows->n] * entry + (size_t)rows->n * sizeof *rows->first);
}
static double bytes_of_records(const struct kith_builder *scratch) {
  size_t words = 0;
  for (int k = 0; k < KITH_ROW_CHUNKS; ++k) words += scratch->chunk[k].n;
  return (double)(words * sizeof(uint64_t));
}

/* Stages with their counter "bytes": each array that one needs is read or written once. */
static kith_status build_stages(struct kith_connectivity *c, const struct kith_build *build,
                                struct kith_profile *profile) {
  const struct kith_requirements need = c->built;
  const kith_index stored = need.ghost_rows ? c->n : c->n_internal;
  kith_status status = KITH_OK;
#define STAGE(name, wanted, bytes, call)                                \
  if (status == KITH_OK && (wanted)) {                                  \
    kith_profile_begin(profile, name);                                  \
    status = call;                                                      \
    if (status == KITH_OK) kith_profile_count(profile, "bytes", bytes); \
    kith_profile_end(profile);                                          \
  }
  const double slots = (double)((NDIM + 1) * sizeof(double) + sizeof(kith_index)) * c->n;
  STAGE("rows", need.rows, slots + 2 * bytes_of_records(&c->scratch) + bytes_of(&c->rows),
        kith_rows_build(&c->rows, build, &c->candidates))
  STAGE("overlap", need.overlap, bytes_of(&c->rows) + bytes_of(&c->overlap),
        kith_overlap_build(&c->overlap, &c->rows, stored, build))
  struct kith_rows internal = c->overlap;
  internal.n = c->n_internal;
  STAGE("overlap pairs", need.overlap_pairs, 2 * bytes_of(&internal) + 8.0 * (double)c->overlap_pairs.n,
        kith_pairs_build(&c->overlap_pairs, &internal, c->n_internal))
  if (need.rows) c->rows.n = stored; /* the overlap needed rows of ghosts */
  STAGE("pairs", need.pairs, 2 * bytes_of(&c->rows) + 8.0 * (double)c->pairs.n, /* rows and of_row; pairs */
        kith_pairs_build(&c->pairs, &c->rows, c->n_internal))
  STAGE("intersection", need.intersection,
        bytes_of(&c->rows) + bytes_of(&c->intersection) + 8.0 * (double)c->pairs.n,
        kith_intersection_build(
            &c->intersection, &c->rows, &c->pairs,
            (struct kith_intersection_spec){need.on_segment, need.obstacles, need.barriers}, build))
#undef STAGE
  return status;
}

static bool any_idle(const struct kith_nodes *nodes) {
  const kith_index n = nodes->activity != NULL ? kith_nodes_count(nodes) : 0;
  for (kith_index from = 0; from < n; from += KITH_STRETCH) {
    uint8_t all = KITH_ACTIVE; /* whose bit no other has */
    for (kith_index i = from; i < KITH_MIN(from + KITH_STRETCH, n); ++i) all &= nodes->activity->u8[i];
    if (all != KITH_ACTIVE) return true;
  }
  return false;
}

kith_status kith_connectivity_build(struct kith_connectivity *c, const struct kith_nodes *nodes,
                                    struct kith_search *search, struct kith_requirements need,
                                    struct kith_excluder *excluders, struct kith_profile *profile) {
  need = completed(need);
  struct kith_excluder self;
  struct kith_list_spec spec = kith_list_spec_among(nodes, search, &self, excluders);
  spec.targets.ghosts = need.ghost_rows || need.overlap;
  struct kith_build build;
  reset(c);
  if (nodes->stretched != NULL && (need.overlap || need.intersection))
    KITH_FAIL(UNSUPPORTED, "overlap and intersection of supports that are ellipsoids");
  const bool idle = any_idle(nodes);
  if (idle && (need.ghost_rows || need.overlap))
    KITH_FAIL(UNSUPPORTED, "rows of ghosts and overlap while nodes are idle");
  KITH_TRY(kith_excluder_keeps_pairs(excluders));
  KITH_TRY(kith_search_fresh(search));
  KITH_TRY(kith_list_spec_prepare(&spec, &c->scratch, &build));
  build.selected = idle;
  build.when_marked = c->when_marked, build.context = c->context;
  c->built = need;
  c->n = kith_nodes_count(nodes);
  c->n_internal = nodes->n_internal;
  const kith_status status = build_stages(c, &build, profile);
  if (status != KITH_OK) {
    reset(c);
    return status;
  }
  c->ghosts = nodes->ghosts;
  kith_profile_count(profile, "candidates", (double)c->candidates);
  kith_profile_count(profile, "row entries", c->rows.n > 0 ? (double)c->rows.first[c->rows.n] : 0);
  if (need.pairs) kith_profile_count(profile, "flattened pairs", (double)c->pairs.n);
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

kith_status kith_connectivity_provides(const struct kith_connectivity *connectivity,
                                       const struct kith_nodes *nodes, struct kith_requirements need) {
  const struct kith_requirements *built = &connectivity->built;
  KITH_TRY(kith_connectivity_fresh(connectivity, nodes));
  const char *lacks = need.rows && !built->rows                     ? "rows"
                      : need.ghost_rows && !built->ghost_rows       ? "rows of ghosts"
                      : need.pairs && !built->pairs                 ? "pairs"
                      : need.overlap && !built->overlap             ? "overlap rows"
                      : need.overlap_pairs && !built->overlap_pairs ? "overlap pairs"
                      : need.intersection && !built->intersection   ? "intersections"
                                                                    : NULL;
  if (lacks != NULL) KITH_FAIL(UNSUPPORTED, "the connectivity has no %s: they were not required", lacks);
  return KITH_OK;
}

/* Ghosts are the tail of a row, but in canonical order anywhere. */
void kith_connectivity_mark_ghosts(const struct kith_connectivity *connectivity,
                                   const struct kith_nodes *nodes, uint8_t *keep) {
  const struct kith_rows *rows = &connectivity->rows;
  const kith_index n = nodes->n_internal;
  if (rows->n == 0) return;
  if (rows->wanted != NULL) {
    for (kith_index g = 0; g < nodes->n_ghost; ++g) keep[g] |= rows->wanted[g];
    return;
  }
#pragma omp parallel for schedule(static) if (n > KITH_FEW)
  for (kith_index i = 0; i < n; ++i)
    for (size_t e = rows->first[i + 1]; e > rows->first[i]; --e) {
      const kith_index j = rows->node[e - 1];
      if (j < n && !connectivity->canonical) break;
      if (j < n) continue;
#pragma omp atomic write
      keep[j - n] = 1;
    }
}
