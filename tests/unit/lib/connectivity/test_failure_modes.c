/* test_failure_modes.c - common errors of code that uses connectivity: each is refused with a status and a
 * message, or cannot happen. Test names are the names of the errors. */
#include "tests/unit/oracle.h"

static const struct kith_requirements everything = {
    .rows = true, .pairs = true, .overlap_pairs = true, .intersection = true};

/* Nodes, a search and a connectivity, not yet built. */
struct world {
  struct kith_nodes *nodes;
  struct kith_search *search;
  struct kith_connectivity *c;
};

static void open_world(struct world *w) {
  const int count[3] = {20, 5, 0};
  uint64_t state = 9;
  w->nodes = oracle_random(2, count, 0.25, 1.5, &state);
  CHECK_OK(kith_nodes_number_images(w->nodes));
  oracle_ghosts(w->nodes, 0, false, 0.5);
  for (kith_index g = w->nodes->n_internal; g < kith_nodes_count(w->nodes); ++g)
    w->nodes->image->i64[g] = w->nodes->position->f64[g * NDIM] < 0.5 ? -1 : 1;
  CHECK_OK(kith_search_create(&w->search, kith_search_find("tree"), w->nodes));
  CHECK_OK(kith_connectivity_create(&w->c));
}

static void build(struct world *w, struct kith_requirements need) {
  CHECK_OK(kith_search_update(w->search));
  CHECK_OK(kith_connectivity_build(w->c, w->nodes, w->search, need, NULL, NULL));
}

static void close_world(struct world *w) {
  kith_connectivity_destroy(&w->c);
  kith_search_destroy(&w->search);
  kith_nodes_destroy(&w->nodes);
}

static void using_connectivity_before_neighbors_are_updated(void) {
  struct world w;
  open_world(&w);
  CHECK_STATUS(KITH_STALE, kith_connectivity_fresh(w.c, w.nodes)); /* nothing was built */
  CHECK_STATUS(KITH_STALE, kith_connectivity_build(w.c, w.nodes, w.search, everything, NULL, NULL));
  build(&w, everything);
  /* nodes may move while Verlet lists are kept, but no list is built from an old search */
  ++w.nodes->positions;
  CHECK_OK(kith_connectivity_fresh(w.c, w.nodes));
  CHECK_STATUS(KITH_STALE, kith_connectivity_build(w.c, w.nodes, w.search, everything, NULL, NULL));
  oracle_ghosts(w.nodes, 0, true, 0.1);
  CHECK_STATUS(KITH_STALE, kith_connectivity_fresh(w.c, w.nodes));
  CHECK_STATUS(KITH_STALE,
               kith_connectivity_provides(w.c, w.nodes, (struct kith_requirements){.rows = true}));
  CHECK_STATUS(KITH_STALE, kith_connectivity_valid(w.c, w.nodes));
  CHECK_STATUS(KITH_STALE, kith_connectivity_build(w.c, w.nodes, w.search, everything, NULL, NULL));
  close_world(&w);
}

static void retaining_pairwise_fields_across_rebuilds(void) {
  struct world w;
  const struct kith_pairwise_spec spec = {"flux", 4, false, "lives inside a step"},
                                  wider = {"flux", 5, false, "lives inside a step"};
  struct kith_pairwise *field, *again, *of_overlap;
  kith_index renumber[512];
  uint8_t keep[512] = {0};
  open_world(&w);
  CHECK(kith_pairwise_named(&w.c->pairs, "flux") == NULL);
  CHECK_STATUS(KITH_UNSUPPORTED, kith_pairwise_prepare(&w.c->pairs, &spec, &field)); /* there are no pairs */
  build(&w, everything);
  CHECK_OK(kith_pairwise_prepare(&w.c->pairs, &spec, &field));
  CHECK_OK(kith_pairwise_fresh(&w.c->pairs, field));
  CHECK(w.c->pairs.n > 0 && field->capacity >= 4 * w.c->pairs.n);
  CHECK(kith_pairwise_named(&w.c->pairs, "flux") == field);
  CHECK_STATUS(KITH_INTERNAL, kith_pairwise_prepare(&w.c->pairs, &wider, &again));
  /* another list has its own field of this name */
  CHECK_OK(kith_pairwise_prepare(&w.c->overlap_pairs, &wider, &of_overlap));
  CHECK(of_overlap != field && of_overlap->capacity >= 5 * w.c->overlap_pairs.n);
  const double *const before = field->value;
  build(&w, everything);
  CHECK_STATUS(KITH_STALE, kith_pairwise_fresh(&w.c->pairs, field));
  CHECK_STATUS(KITH_STALE, kith_pairwise_fresh(&w.c->overlap_pairs, of_overlap));
  CHECK_OK(kith_pairwise_prepare(&w.c->pairs, &spec, &again));
  CHECK(again == field && field->value == before); /* memory is reused */
  const kith_index old_count = kith_nodes_count(w.nodes);
  kith_connectivity_mark_ghosts(w.c, w.nodes, keep);
  CHECK_OK(kith_nodes_cull_ghosts(w.nodes, keep, renumber));
  CHECK_OK(kith_connectivity_patch(w.c, w.nodes, renumber, old_count));
  /* a patch renumbers the pairs, too */
  CHECK_STATUS(KITH_STALE, kith_pairwise_fresh(&w.c->pairs, field));
  CHECK_OK(kith_pairwise_prepare(&w.c->pairs, &spec, &field));
  CHECK_OK(kith_connectivity_canonical(w.c, w.nodes));
  CHECK_STATUS(KITH_STALE, kith_pairwise_fresh(&w.c->pairs, field));
  build(&w, (struct kith_requirements){.rows = true}); /* without pairs, their values are stale */
  CHECK_STATUS(KITH_STALE, kith_pairwise_fresh(&w.c->pairs, field));
  close_world(&w);
}

static void assuming_ghost_connectivity_exists(void) {
  static const struct {
    struct kith_requirements need;
    const char *name;
  } missing[] = {{{.ghost_rows = true}, "rows of ghosts"},   {{.overlap = true}, "overlap rows"},
                 {{.overlap_pairs = true}, "overlap pairs"}, {{.pairs = true}, "pairs"},
                 {{.intersection = true}, "intersections"},  {{.rows = true}, "rows"}};
  const int n = (int)(sizeof missing / sizeof missing[0]);
  struct world w;
  open_world(&w);
  build(&w, (struct kith_requirements){.rows = true});
  CHECK(w.nodes->n_ghost > 0 && w.c->rows.n == w.nodes->n_internal); /* ghosts have no rows at all */
  for (int k = 0; k < n; ++k) {
    if (k == n - 1) build(&w, (struct kith_requirements){0});
    CHECK_STATUS(KITH_UNSUPPORTED, kith_connectivity_provides(w.c, w.nodes, missing[k].need));
    CHECK(strstr(kith_failure(), missing[k].name) != NULL);
  }
  /* To build the overlap, rows of ghosts are needed for a while, but are not provided. */
  build(&w, everything);
  CHECK_STATUS(KITH_UNSUPPORTED,
               kith_connectivity_provides(w.c, w.nodes, (struct kith_requirements){.ghost_rows = true}));
  CHECK_OK(kith_connectivity_provides(w.c, w.nodes, everything));
  build(&w, (struct kith_requirements){.ghost_rows = true});
  CHECK_OK(kith_connectivity_provides(w.c, w.nodes, (struct kith_requirements){.ghost_rows = true}));
  CHECK(w.c->rows.n == kith_nodes_count(w.nodes));
  close_world(&w);
}

/* Each interaction is in the list once, and the rows of both ends lead to it, in index and in canonical
 * order. */
static void double_counting_pair_interactions(void) {
  for (int canonical = 0; canonical < 2; ++canonical) {
    struct world w;
    open_world(&w);
    build(&w, everything);
    if (canonical) CHECK_OK(kith_connectivity_canonical(w.c, w.nodes));
    const kith_index n = kith_nodes_count(w.nodes);
    size_t interactions = 0;
    uint8_t *counted = calloc(w.c->pairs.n + 1, 1);
    for (kith_index i = 0; i < n; ++i)
      for (kith_index j = i; j < n; ++j) {
        const bool here = i < w.nodes->n_internal && oracle_neighbors(w.nodes, NULL, i, j);
        const size_t p = oracle_pair(w.c, i, j);
        CHECK(oracle_pair(w.c, j, i) == p && (p < w.c->pairs.n) == here);
        if (!here || p >= w.c->pairs.n) continue;
        const kith_index *ends = w.c->pairs.node[p];
        CHECK((ends[0] == i && ends[1] == j) || (ends[0] == j && ends[1] == i));
        CHECK(counted[p]++ == 0);
        ++interactions;
      }
    CHECK(interactions == w.c->pairs.n && interactions > 0);
    free(counted);
    close_world(&w);
  }
}

/* Patches need index order: after a change to canonical order they are refused, but the rows stay valid. */
static void breaking_deterministic_order(void) {
  struct world w;
  kith_index renumber[512];
  open_world(&w);
  build(&w, everything);
  CHECK_OK(kith_connectivity_canonical(w.c, w.nodes));
  const kith_index n = kith_nodes_count(w.nodes);
  for (kith_index i = 0; i < n; ++i) renumber[i] = i;
  CHECK_STATUS(KITH_UNSUPPORTED, kith_connectivity_patch(w.c, w.nodes, renumber, n));
  CHECK_OK(kith_connectivity_valid(w.c, w.nodes));
  const uint32_t first = w.c->pairs.of_row[0];
  w.c->pairs.of_row[0] = w.c->pairs.of_row[1]; /* the pair of another partner */
  CHECK_STATUS(KITH_INTERNAL, kith_connectivity_valid(w.c, w.nodes));
  w.c->pairs.of_row[0] = first;
  --w.c->pairs.n; /* the last pair is lost */
  CHECK_STATUS(KITH_INTERNAL, kith_connectivity_valid(w.c, w.nodes));
  ++w.c->pairs.n;
  CHECK_STATUS(KITH_UNSUPPORTED,
               kith_connectivity_provides(w.c, w.nodes, (struct kith_requirements){.intersection = true}));
  /* In canonical order ghosts are not at the end of rows, but are marked all the same. */
  uint8_t *keep = calloc((size_t)w.nodes->n_ghost, 1);
  kith_connectivity_mark_ghosts(w.c, w.nodes, keep);
  for (kith_index g = w.nodes->n_internal; g < n; ++g) {
    bool needed = false;
    for (kith_index i = 0; i < w.nodes->n_internal; ++i) needed |= oracle_neighbors(w.nodes, NULL, i, g);
    CHECK(keep[g - w.nodes->n_internal] == needed);
  }
  free(keep);
  close_world(&w);
}

/* What was not required costs nothing: no memory is reserved, and nothing remains of the build before. */
static void ignoring_overlap_and_intersection_cost(void) {
  struct world w;
  open_world(&w);
  build(&w, everything);
  CHECK(w.c->overlap.n > 0 && w.c->overlap_pairs.n > 0 && w.c->intersection.n > 0);
  build(&w, (struct kith_requirements){.rows = true, .pairs = true});
  CHECK(w.c->overlap.n == 0 && w.c->overlap_pairs.n == 0 && w.c->intersection.n == 0);
  CHECK(!w.c->built.overlap && !w.c->built.overlap_pairs && !w.c->built.intersection && w.c->built.pairs);
  build(&w, (struct kith_requirements){.rows = true});
  CHECK(w.c->pairs.n == 0 && !w.c->built.pairs && w.c->rows.n == w.nodes->n_internal);
  struct kith_connectivity *lean;
  CHECK_OK(kith_connectivity_create(&lean));
  CHECK_OK(
      kith_connectivity_build(lean, w.nodes, w.search, (struct kith_requirements){.rows = true}, NULL, NULL));
  CHECK(lean->overlap.entries_capacity == 0 && lean->intersection.entries_capacity == 0);
  CHECK(lean->pairs.capacity == 0 && lean->overlap_pairs.capacity == 0 &&
        lean->scratch.spans.rows_capacity == 0);
  CHECK(kith_connectivity_bytes(lean) < kith_connectivity_bytes(w.c));
  kith_connectivity_destroy(&lean);
  close_world(&w);
}

int main(void) {
  using_connectivity_before_neighbors_are_updated();
  retaining_pairwise_fields_across_rebuilds();
  assuming_ghost_connectivity_exists();
  double_counting_pair_interactions();
  breaking_deterministic_order();
  ignoring_overlap_and_intersection_cost();
  return check_failed();
}
