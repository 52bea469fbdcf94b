/* test_spacetree.c - what is special to the spacetree: sweeps whose cells move their targets, counters of
 * what an update did, and nodes on faces, edges and corners of cells. Sweeps of all searches are tested by
 * conformance_search.c, with the oracle of search_world.h. */
#include "tests/unit/lib/neighbor/search_world.h"

/* Cells move their targets during a sweep: the sweep visits the same interactions, and the next one is
 * refused. */
static void test_moves_of_targets(const struct kith_search_ops *ops) {
  struct kith_nodes *nodes = make_nodes(EIGHT_TO_ONE, 200, 1);
  struct kith_search *s = create_search(ops, nodes);
  CHECK_OK(kith_search_update(s));
  check_sweep(s, nodes->position->f64);
  ++nodes->positions;
  CHECK_STATUS(KITH_STALE, kith_search_sweep(s, &(struct kith_sweep){NULL, NULL, NULL}, NULL));
  CHECK(strstr(kith_failure(), ops->name) != NULL);
  destroy(&s, &nodes);
}

/* Expects these counters after an update; nodes are a cloud of equal radii, and node 0 has changed. */
static void expect_counts(struct kith_search *s, bool selected, const uint64_t *expected) {
  const kith_index moved = 0;
  ++((struct kith_nodes *)(uintptr_t)s->nodes)->positions;
  CHECK_OK(selected ? kith_search_update_selected(s, &moved, 1) : kith_search_update(s));
  for (int k = 0; k < KITH_SEARCH_COUNTERS; ++k) CHECK(s->count[k] == expected[k]);
}

/* Counters of sorts from scratch, moves, nodes lifted to a coarser or dropped to a finer level, and nodes
 * that tunnelled, after both kinds of update. */
static void test_counters(void) {
  for (int selected = 0; selected < 2; ++selected) {
    struct kith_nodes *nodes = make_nodes(RANDOM, 400, 1);
    struct kith_search *s = create_search(&kith_search_spacetree, nodes);
    double *x = nodes->position->f64, *radius = nodes->search_radius->f64;
    for (kith_index i = 0; i < 400; ++i) radius[i] = i == 1 ? 0.08 : 0.01; /* cells 0.168 wide, and 0.021 */
    for (int a = 0; a < NDIM; ++a) x[NDIM + a] = 0, x[2 * NDIM + a] = 1;
    for (int a = 0; a < NDIM; ++a) x[a] = 0.3;
    expect_counts(s, false, (const uint64_t[]){1, 0, 0, 0, 0});
    expect_counts(s, selected, (const uint64_t[]){0, 0, 0, 0, 0});
    x[0] += 0.021;
    expect_counts(s, selected, (const uint64_t[]){0, 1, 0, 0, 0});
    radius[0] = 0.02; /* cells 0.042 wide */
    expect_counts(s, selected, (const uint64_t[]){0, 0, 1, 0, 0});
    radius[0] = 0.01;
    expect_counts(s, selected, (const uint64_t[]){0, 0, 0, 1, 0});
    x[NDIM - 1] += 7.3 * 0.021; /* to an adjacent vertex three levels up */
    expect_counts(s, selected, (const uint64_t[]){0, 0, 3, 3, 1});
    check_search(s, 40, false);
    destroy(&s, &nodes);
  }
}

/* Many ghosts are added, so that arrays grow; all ghosts are in one cell, whose key equals that of unused
 * memory. */
static void test_growth(void) {
  const kith_index n = 10000;
  struct kith_nodes *nodes = make_nodes(RANDOM, n, 1);
  struct kith_search *s = create_search(&kith_search_spacetree, nodes);
  for (kith_index i = 0; i < n; ++i) nodes->search_radius->f64[i] = 2;
  CHECK_OK(kith_search_update(s));
  add_ghosts(nodes, 0, true);
  for (size_t k = (size_t)n * NDIM; k < (size_t)kith_nodes_count(nodes) * NDIM; ++k)
    nodes->position->f64[k] = 0.5;
  ++nodes->positions;
  CHECK_OK(kith_search_update(s));
  uint8_t *found = calloc((size_t)s->n, 1);
  kith_index twice = 0;
  for (kith_index slot = 0; slot < s->n; ++slot) twice += found[s->node[slot]]++ > 0;
  CHECK(s->n > n && twice == 0);
  free(found);
  destroy(&s, &nodes);
}

/* Nodes on faces, edges and corners of cells and at their midpoints, on two levels: each must be a target of
 * one cell (check_sweep), the upper one. */
static void test_faces(void) {
  const kith_index n = 2 + (NDIM == 1 ? 30 : 200);
  struct kith_nodes *nodes = make_nodes(RANDOM, n, 1);
  struct kith_search *s = create_search(&kith_search_spacetree, nodes);
  int on_faces = 0, on_corners = 0;
  for (kith_index i = 0; i < n; ++i) nodes->search_radius->f64[i] = i % 2 ? 0.25 : 0.06;
  for (int a = 0; a < 2 * NDIM; ++a) nodes->position->f64[a] = a < NDIM;
  CHECK_OK(kith_search_update(s)); /* nodes 0 and 1 span the box */
  const struct kith_spacetree *tree = s->self;
  const int level = 2;
  for (kith_index i = 2; i < n; ++i) {
    int faces = 0;
    for (int a = 0; a < NDIM; ++a) {
      double *x = nodes->position->f64 + (size_t)i * NDIM + a;
      *x = tree->lower[a] + (3 + below(7)) * (0.5 / tree->per_length[level]);
      const double u = (*x - tree->lower[a]) * tree->per_length[level];
      faces += u == floor(u);
    }
    on_faces += faces > 0, on_corners += faces == NDIM;
  }
  ++nodes->positions;
  CHECK(on_faces > n / 4 && on_corners > n / 16);
  check_update(s, 40);
  destroy(&s, &nodes);
}

int main(void) {
  with_members(test_moves_of_targets);
  test_counters();
  test_growth();
  test_faces();
  return check_failed();
}
