/* conformance_search.c - every neighbor search. Oracle: loops over all nodes (search_world.h). Candidates
 * contain every node within range, queries at a position are exact, slots and groups are valid, and the order
 * of slots does not depend on the number of threads. Nodes are on lattices with exact ties, in clusters,
 * coincident, with radii that differ by 100 and 1000, none to three of them, in a box thinner than a support;
 * after motion, growth of radii, culling and partial updates. */
#include "tests/unit/lib/neighbor/search_world.h"

#include <omp.h>

static void test_updates(const struct kith_search_ops *ops, enum arrangement how, kith_index n, int lists) {
  struct kith_nodes *nodes = make_nodes(how, n, lists);
  struct kith_search *s = create_search(ops, nodes);
  CHECK_STATUS(KITH_STALE, kith_search_fresh(s));
  CHECK_STATUS(KITH_STALE, kith_search_update_selected(s, NULL, 0));
  check_update(s, 40);
  for (int a = 0; a < NDIM; ++a) {
    add_ghosts(nodes, a, a == 0);
    if (n > 0) CHECK_STATUS(KITH_STALE, kith_search_fresh(s));
    check_update(s, 20);
  }
  kith_nodes_drop_ghosts(nodes);
  check_update(s, 20);
  kith_search_destroy(&s);
  CHECK(s == NULL);
  kith_nodes_destroy(&nodes);
}

static void test_sets_of_nodes(const struct kith_search_ops *ops) {
  for (enum arrangement how = RANDOM; how < ARRANGEMENTS; ++how) test_updates(ops, how, 400, 1 + how % 3);
  for (kith_index n = 0; n < 4; ++n) test_updates(ops, RANDOM, n, 1);
  test_updates(ops, COINCIDENT, 2, 2);
}

/* A periodic box thinner than a support: three layers of images on each side of axis 0. */
static void test_thin_box(const struct kith_search_ops *ops) {
  struct kith_nodes *nodes = make_nodes(RANDOM, 60, 1);
  struct kith_search *s = create_search(ops, nodes);
  for (kith_index i = 0; i < 60; ++i) nodes->search_radius->f64[i] = uniform(1.5, 2.5);
  CHECK_OK(kith_search_update(s));
  for (int image = -3; image <= 3; ++image) {
    struct kith_ghost_block block = {.kind = KITH_GHOST_IMAGE, .count = 60};
    if (image == 0) continue;
    CHECK_OK(kith_resize(&block.control, 0, 60, sizeof *block.control));
    for (kith_index i = 0; i < 60; ++i) block.control[i] = i;
    for (int a = 0; a < NDIM; ++a) block.image.sign[a] = 1;
    block.image.shift[0] = image;
    CHECK_OK(kith_nodes_add_ghosts(nodes, &block));
  }
  check_update(s, 20);
  destroy(&s, &nodes);
}

/* After culling a search is stale, also when as many ghosts were added as removed. */
static void test_cull(const struct kith_search_ops *ops) {
  struct kith_nodes *nodes = make_nodes(RANDOM, 90, 2);
  struct kith_search *s = create_search(ops, nodes);
  kith_index *found = NULL, count = 0, renumber[512], moved = 0;
  size_t capacity = 0;
  uint8_t keep[512];
  for (int round = 0; round < 3; ++round) {
    const double x[NDIM] = {0};
    add_ghosts(nodes, 0, true);
    CHECK_OK(kith_search_update(s));
    for (kith_index g = 0; g < nodes->n_ghost; ++g) keep[g] = (g + round) % 2 == 0;
    CHECK_OK(kith_nodes_cull_ghosts(nodes, keep, renumber));
    if (round == 2) add_ghosts(nodes, NDIM - 1, false);
    CHECK_STATUS(KITH_STALE, kith_search_fresh(s));
    CHECK(strstr(kith_failure(), ops->name) != NULL);
    CHECK_STATUS(KITH_STALE, kith_search_at(s, x, 0.5, KITH_GATHER, &found, &capacity, &count));
    CHECK_STATUS(KITH_STALE, kith_search_update_selected(s, &moved, 1));
    check_update(s, 20);
    CHECK_STATUS(KITH_BAD_INPUT, kith_search_at(s, x, -0.5, KITH_GATHER, &found, &capacity, &count));
  }
  kith_free(&found);
  destroy(&s, &nodes);
}

/* Nodes that were reordered are not the ones that the search knows, also without ghosts. */
static void test_reorder(const struct kith_search_ops *ops) {
  struct kith_nodes *nodes = make_nodes(RANDOM, 30, 1);
  struct kith_search *s = create_search(ops, nodes);
  kith_index order[30], moved = 0;
  for (kith_index i = 0; i < 30; ++i) order[i] = 29 - i;
  CHECK_OK(kith_search_update(s));
  CHECK_OK(kith_search_update_selected(s, &moved, 1));
  CHECK_OK(kith_nodes_reorder(nodes, order));
  CHECK_STATUS(KITH_STALE, kith_search_update_selected(s, &moved, 1));
  check_update(s, 10);
  destroy(&s, &nodes);
}

/* On a rank with ghosts alone, which then go. */
static void test_ghosts_alone(const struct kith_search_ops *ops) {
  const struct kith_ghost_block block = {.kind = KITH_GHOST_FROZEN, .count = 50};
  const double x[NDIM] = {0};
  struct kith_nodes *nodes = make_nodes(RANDOM, 0, 1);
  struct kith_search *s = create_search(ops, nodes);
  kith_index *found = NULL, count = 0;
  size_t capacity = 0;
  CHECK_OK(kith_nodes_add_ghosts(nodes, &block)); /* all at 0 */
  CHECK_OK(kith_search_update(s));
  CHECK_OK(kith_search_at(s, x, 0.5, KITH_GATHER, &found, &capacity, &count));
  CHECK(count == 50);
  kith_nodes_drop_ghosts(nodes);
  CHECK_OK(kith_search_update_selected(s, NULL, 0));
  CHECK_OK(kith_search_at(s, x, 0.5, KITH_GATHER, &found, &capacity, &count));
  CHECK(count == 0 && s->n_groups == 0);
  kith_free(&found);
  destroy(&s, &nodes);
}

static void displace(struct kith_nodes *nodes, kith_index i, int round) {
  /* Mostly small steps; sometimes across the box, or far out of it. */
  const double far = round % 7 == 6 ? 30 : round % 3 == 2 ? 1 : 0.02;
  for (int a = 0; a < NDIM; ++a) nodes->position->f64[(size_t)i * NDIM + a] += uniform(-far, far);
  /* To a place where many nodes are. */
  if (round % 4 == 1)
    for (int a = 0; a < NDIM; ++a) nodes->position->f64[(size_t)i * NDIM + a] = 0.3;
  if (round % 4 == 1)
    nodes->search_radius->f64[i] = 0.1;
  else if (below(2))
    nodes->search_radius->f64[i] *= round % 5 == 4 ? uniform(0.1, 6) : uniform(0.95, 1.05);
}

static void test_motion(const struct kith_search_ops *ops, enum arrangement how) {
  struct kith_nodes *nodes = make_nodes(how, 500, 2);
  add_ghosts(nodes, 0, true);
  struct kith_search *s = create_search(ops, nodes);
  kith_index *moved = calloc(1000, sizeof *moved);
  CHECK_OK(kith_search_update(s));
  for (int round = 0; round < 16; ++round) {
    /* A few nodes, some named twice; none; more than there are. */
    const kith_index count = round == 3 ? 0 : round == 5 ? 600 : 1 + below(40);
    for (kith_index k = 0; k < count; ++k) displace(nodes, moved[k] = below(s->n), round);
    ++nodes->positions;
    CHECK_STATUS(KITH_STALE, kith_search_fresh(s));
    CHECK_OK(kith_search_update_selected(s, moved, count));
    check_search(s, 25, false);
    if (round == 9) {
      add_ghosts(nodes, NDIM - 1, false);
      CHECK_STATUS(KITH_STALE, kith_search_update_selected(s, moved, 1));
      check_update(s, 25);
    }
  }
  free(moved);
  destroy(&s, &nodes);
}

/* Updates of all nodes, as in successive steps: what a search keeps between them must not matter, even if
 * ghosts come and go, or nodes are reordered or deleted in between. */
static void test_steps(const struct kith_search_ops *ops, enum arrangement how) {
  struct kith_nodes *nodes = make_nodes(how, 300, 2);
  struct kith_search *s = create_search(ops, nodes);
  for (int round = 0; round < 24; ++round) {
    for (int k = 0; k < 20; ++k) displace(nodes, below(nodes->n_internal), round);
    if (round % 10 == 9) { /* reverses the order in each list */
      kith_index *order = calloc((size_t)nodes->n_internal, sizeof *order);
      for (int l = 0; l < nodes->n_lists; ++l)
        for (kith_index k = 0; k < nodes->lists[l].count; ++k)
          order[nodes->lists[l].first + k] = nodes->lists[l].first + nodes->lists[l].count - 1 - k;
      CHECK_OK(kith_nodes_reorder(nodes, order));
      free(order);
    }
    if (round == 14) {
      uint8_t *dead = calloc((size_t)nodes->n_internal, 1);
      for (kith_index i = 0; i < nodes->n_internal; ++i) dead[i] = below(10) == 0;
      CHECK_OK(kith_nodes_delete(nodes, dead));
      free(dead);
    }
    kith_nodes_drop_ghosts(nodes);
    if (round % 3 != 0) add_ghosts(nodes, round % NDIM, round % 2 == 0);
    ++nodes->positions;
    check_update(s, 20);
  }
  destroy(&s, &nodes);
}

/* Nodes have moved and grown since the search was updated, and their ghosts are gone: kith_search_near finds
 * all nodes that active ones may interact with, and after an update of these, queries are exact. */
static void test_near(const struct kith_search_ops *ops, enum arrangement how) {
  const double slack = 0.05;
  struct kith_nodes *nodes = make_nodes(how, 400, 2);
  struct kith_search *s = create_search(ops, nodes);
  kith_index *near = NULL, *found = NULL, count = 0, n_found = 0;
  size_t capacity = 0, found_capacity = 0;
  CHECK_OK(kith_nodes_mark_activity(nodes));
  for (int round = 0; round < 12; ++round) {
    const kith_index n = nodes->n_internal;
    int missed = 0;
    if (round % 3 == 0) {
      add_ghosts(nodes, 0, true);
      CHECK_OK(kith_search_update(s));
    }
    uint8_t *taken = calloc((size_t)n, 1);
    for (kith_index i = 0; i < n; ++i) {
      nodes->activity->u8[i] = below(30) < round ? KITH_ACTIVE : KITH_IDLE;
      if (round % 3 == 0) nodes->position->f64[i * NDIM] += uniform(-0.9, 0.9) * slack;
      if (round % 3 == 0) nodes->search_radius->f64[i] += 0.1 * slack;
    }
    ++nodes->positions;
    kith_nodes_drop_ghosts(nodes);
    CHECK_OK(kith_search_near(s, slack, &near, &capacity, &count));
    for (kith_index k = 0; k < count; ++k) taken[near[k]]++;
    for (kith_index i = 0; i < n; ++i)
      for (kith_index j = 0; j < n && kith_node_active(nodes, i); ++j)
        missed +=
            !taken[j] && interact(position_of(nodes, i), nodes->search_radius->f64[i], position_of(nodes, j),
                                  nodes->search_radius->f64[j], KITH_GATHER_SCATTER);
    CHECK(missed == 0);
    CHECK_OK(kith_search_update_selected(s, near, count));
    for (kith_index i = 0; i < n; ++i) {
      if (!kith_node_active(nodes, i)) continue;
      CHECK(taken[i] == 1);
      CHECK_OK(kith_search_at(s, position_of(nodes, i), nodes->search_radius->f64[i], KITH_GATHER, &found,
                              &found_capacity, &n_found));
      kith_index expected = 0;
      for (kith_index j = 0; j < n; ++j)
        expected += interact(position_of(nodes, i), nodes->search_radius->f64[i], position_of(nodes, j), 0,
                             KITH_GATHER);
      CHECK(n_found == expected);
    }
    free(taken);
  }
  KITH_FREE(&near, &found);
  destroy(&s, &nodes);
}

/* Radii grow while nodes stay: a search that stores a largest radius must update it. */
static void test_growth(const struct kith_search_ops *ops) {
  struct kith_nodes *nodes = make_nodes(RANDOM, 150, 1);
  struct kith_search *s = create_search(ops, nodes);
  CHECK_OK(kith_search_update(s));
  for (int round = 0; round < 60; ++round) {
    const kith_index grown = round < 50 ? below(s->n) : 7;
    nodes->search_radius->f64[grown] *= 1.3;
    ++nodes->positions;
    CHECK_OK(kith_search_update_selected(s, &grown, 1));
    check_search(s, 30, true);
  }
  destroy(&s, &nodes);
}

/* Nodes so far away that numbers of cells overflow: they are clamped, but all are found. */
static void test_far_off(const struct kith_search_ops *ops) {
  struct kith_nodes *nodes = make_nodes(RANDOM, 200, 1);
  struct kith_search *s = create_search(ops, nodes);
  CHECK_OK(kith_search_update(s));
  kith_index moved[100];
  for (kith_index k = 0; k < 100; ++k) {
    moved[k] = 2 * k;
    for (int a = 0; a < NDIM; ++a)
      nodes->position->f64[(size_t)moved[k] * NDIM + a] += k % 4 < 2 ? 1e10 : -1e10;
  }
  ++nodes->positions;
  CHECK_OK(kith_search_update_selected(s, moved, 100));
  check_search(s, 40, false);
  check_update(s, 40);
  destroy(&s, &nodes);
}

/* Enough nodes to occupy all threads. `along`: nodes are sorted along the curve of the tree, except a few
 * that have moved. */
static void test_threads(const struct kith_search_ops *ops, bool along) {
  const kith_index n = 30000, strays = along ? 300 : 0;
  struct kith_nodes *nodes = make_nodes(CLUSTERED, n, 1);
  if (along) CHECK_OK(kith_search_sort_nodes(nodes, NULL));
  add_ghosts(nodes, 0, true);
  kith_index *moved = malloc(sizeof *moved * 300);
  for (kith_index k = 0; k < 300; ++k) moved[k] = below(n);
  for (kith_index k = 0; k < strays; ++k) displace(nodes, moved[k], 2);
  struct kith_search *s[3] = {NULL, NULL, NULL};
  for (int stage = 0; stage < 2; ++stage) {
    for (int threads = 1; threads <= 3; ++threads) {
      omp_set_num_threads(threads);
      if (stage == 0) s[threads - 1] = create_search(ops, nodes);
      CHECK_OK(stage == 0 ? kith_search_update(s[threads - 1])
                          : kith_search_update_selected(s[threads - 1], moved, 300));
      CHECK(s[threads - 1]->n_groups == s[0]->n_groups);
      CHECK(memcmp(s[threads - 1]->node, s[0]->node, sizeof(kith_index) * (size_t)s[0]->n) == 0);
      CHECK(memcmp(s[threads - 1]->group, s[0]->group, sizeof(struct kith_run) * (size_t)s[0]->n_groups) ==
            0);
    }
    check_search(s[2], ops == &kith_search_brute ? 3 : 25, stage == 0);
    for (kith_index k = 0; k < 300; ++k) displace(nodes, moved[k], 1);
    ++nodes->positions;
  }
  free(moved);
  for (int k = 0; k < 3; ++k) kith_search_destroy(&s[k]);
  kith_nodes_destroy(&nodes);
}

static void test_runs(void) {
  struct kith_runs runs = {0};
  CHECK_OK(kith_runs_add(&runs, 10, 5));
  CHECK_OK(kith_runs_add(&runs, 15, 1));
  CHECK(runs.n == 1 && runs.run[0].first == 10 && runs.run[0].count == 6);
  /* 200 runs, of which every second one touches the next. */
  for (kith_index k = 0; k < 200; ++k) CHECK_OK(kith_runs_add(&runs, 20 + 4 * k, k % 2 ? 2 : 4));
  for (int r = 1; r < runs.n; ++r) CHECK(runs.run[r].first > runs.run[r - 1].first + runs.run[r - 1].count);
  kith_index sum = 0;
  for (int r = 0; r < runs.n; ++r) sum += runs.run[r].count;
  CHECK(runs.n == 101 && sum == 6 + 100 * 4 + 100 * 2);
  kith_runs_clear(&runs);
  CHECK(runs.n == 0 && runs.run == NULL);
}

static void test_family(void) {
  struct kith_search *search;
  CHECK_STATUS(KITH_BAD_INPUT, kith_search_create(&search, kith_search_find("octree"), NULL));
  CHECK(search == NULL);
  for (const struct kith_search_ops *const *ops = kith_search_all(); *ops; ++ops)
    CHECK(kith_search_find((*ops)->name) == *ops && (*ops)->doc[0] != 0);
  CHECK(kith_search_find("oracle") == NULL);
}

static void test_member(const struct kith_search_ops *ops) {
  test_sets_of_nodes(ops);
  for (enum arrangement how = RANDOM; how < ARRANGEMENTS; ++how) {
    test_motion(ops, how);
    test_steps(ops, how);
    test_near(ops, how);
  }
  test_thin_box(ops);
  test_cull(ops);
  test_reorder(ops);
  test_ghosts_alone(ops);
  test_growth(ops);
  test_far_off(ops);
  for (int along = 0; along < 2 && settings == NULL; ++along) test_threads(ops, along);
}

int main(void) {
  test_runs();
  test_family();
  with_members(test_member);
  return check_failed();
}
