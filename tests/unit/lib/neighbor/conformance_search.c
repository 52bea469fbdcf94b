/* conformance_search.c - every neighbor search against loops over all nodes that use none of its code:
 * nothing within range is missed, queries at a position are exact, slots and groups are sound, and the order
 * of slots does not depend on the number of threads. On lattices with exact ties, clusters, coincident nodes,
 * radii that differ by 100 and 1000, none to three nodes, a box thinner than a support; after motion, growth,
 * a cull, and selected updates. */
#include "tests/check.h"

#include <omp.h>
#include <stdlib.h>
#include <string.h>
#include "lib/neighbor/cells.h"

static uint64_t seed = 20;
static double uniform(double lower, double upper) {
  return lower + (upper - lower) * check_random(&seed);
}
static kith_index below(kith_index n) {
  return (kith_index)(check_random(&seed) * n);
}

/* Members with parameters are tried with another value of the first one, too. */
static const void *settings;
static kith_status create(struct kith_search **s, const struct kith_search_ops *ops,
                          const struct kith_nodes *nodes) {
  const kith_status status = kith_search_create(s, ops, nodes);
  if (status == KITH_OK) (*s)->settings = settings;
  return status;
}

/* The oracle. Ties count: <=. */
static bool interact(const double *x, double radius, const double *y, double other,
                     enum kith_search_mode mode) {
  double d2 = 0;
  for (int a = 0; a < NDIM; ++a) d2 += (x[a] - y[a]) * (x[a] - y[a]);
  return (mode != KITH_SCATTER && d2 <= radius * radius) || (mode != KITH_GATHER && d2 <= other * other);
}

static const double *place(const struct kith_nodes *nodes, kith_index i) {
  return nodes->position->f64 + (size_t)i * NDIM;
}

static bool same_node(const struct kith_search *s, kith_index p, kith_index q) {
  const kith_index i = s->node[p], j = s->node[q], internal = s->nodes->n_internal;
  for (int a = 0; a < NDIM; ++a)
    if (s->coordinate[a][p] != s->coordinate[a][q]) return false;
  return s->radius2[p] == s->radius2[q] && (i < internal) == (j < internal);
}

/* Slots are a permutation, ascending where nothing else tells nodes apart (unless only some of them were
 * updated), packed as the nodes are; groups
 * hold every node once and never mix. */
static void check_slots(const struct kith_search *s, kith_index *slot_of, bool ordered) {
  const struct kith_nodes *nodes = s->nodes;
  const kith_index n = kith_nodes_count(nodes);
  CHECK(s->n == n);
  for (kith_index i = 0; i < n; ++i) slot_of[i] = -1;
  int wrong = 0;
  for (kith_index slot = 0; slot < n; ++slot) {
    const kith_index i = s->node[slot];
    if (i < 0 || i >= n || slot_of[i] >= 0) {
      ++wrong;
      continue;
    }
    slot_of[i] = slot;
    for (int a = 0; a < NDIM; ++a) wrong += s->coordinate[a][slot] != place(nodes, i)[a];
    wrong += ordered && slot > 0 && same_node(s, slot - 1, slot) && s->node[slot - 1] > i;
    wrong += s->radius2[slot] != nodes->search_radius->f64[i] * nodes->search_radius->f64[i];
  }
  CHECK(wrong == 0);
  kith_index targets = 0;
  uint8_t *visited = calloc((size_t)n + 1, 1);
  for (int g = 0; g < s->n_groups; ++g) {
    const struct kith_run run = s->group[g];
    CHECK(run.count > 0 && run.first >= 0 && run.first + run.count <= n);
    const bool ghosts = s->node[run.first] >= nodes->n_internal;
    for (kith_index slot = run.first; slot < run.first + run.count; ++slot) {
      wrong += visited[slot]++ != 0 || (s->node[slot] >= nodes->n_internal) != ghosts;
      targets += !ghosts;
    }
  }
  free(visited);
  CHECK(wrong == 0 && targets == nodes->n_internal);
}

static void check_group(const struct kith_search *s, int g, const kith_index *slot_of,
                        struct kith_runs *runs) {
  const struct kith_nodes *nodes = s->nodes;
  const struct kith_run group = s->group[g];
  struct kith_box box = kith_box_empty();
  double radius2 = 0;
  for (kith_index slot = group.first; slot < group.first + group.count; ++slot) {
    kith_box_include(&box, place(nodes, s->node[slot]));
    radius2 = KITH_MAX(radius2, s->radius2[slot]);
    const double radius = nodes->search_radius->f64[s->node[slot]];
    CHECK(s->radius2[slot] == radius * radius);
    for (int a = 0; a < NDIM; ++a) CHECK(s->coordinate[a][slot] == place(nodes, s->node[slot])[a]);
  }
  for (enum kith_search_mode mode = KITH_GATHER; mode <= KITH_GATHER_SCATTER; ++mode) {
    runs->n = 0;
    CHECK_OK(s->ops->coarse(s, &box, sqrt(radius2), mode, runs));
    int wrong = 0, missed = 0;
    uint8_t *found = calloc((size_t)s->n, 1);
    for (int r = 0; r < runs->n; ++r) {
      const struct kith_run run = runs->run[r];
      wrong += run.count <= 0 || run.first < 0 || run.first + run.count > s->n;
      wrong += r > 0 && run.first <= runs->run[r - 1].first + runs->run[r - 1].count;
      memset(found + run.first, 1, (size_t)run.count);
    }
    for (kith_index slot = group.first; slot < group.first + group.count; ++slot)
      for (kith_index j = 0; j < s->n; ++j)
        missed += interact(place(nodes, s->node[slot]), nodes->search_radius->f64[s->node[slot]],
                           place(nodes, j), nodes->search_radius->f64[j], mode) &&
                  !found[slot_of[j]];
    free(found);
    CHECK(wrong == 0);
    CHECK(missed == 0);
  }
}

static void check_at(const struct kith_search *s, const double *x, double radius) {
  const struct kith_nodes *nodes = s->nodes;
  kith_index *found = NULL, count = -1;
  size_t capacity = 0;
  for (enum kith_search_mode mode = KITH_GATHER; mode <= KITH_GATHER_SCATTER; ++mode) {
    CHECK_OK(kith_search_at(s, x, radius, mode, &found, &capacity, &count));
    kith_index k = 0, wrong = 0;
    for (kith_index j = 0; j < s->n; ++j)
      if (interact(x, radius, place(nodes, j), nodes->search_radius->f64[j], mode))
        wrong += k >= count || found[k++] != j;
    CHECK(wrong == 0 && k == count);
  }
  kith_free(&found);
}

/* Sweeps. `moves`: cells move their targets away, which must not matter. */
struct swept {
  const struct kith_search *search;
  int *hits, wrong;
  uint8_t *touched, *marked; /* 1: first, 2: last; targets so far */
  double *moves;
};

static kith_status touch_first(void *context, const struct kith_run *run, int n) {
  struct swept *w = context;
  for (int r = 0; r < n; ++r)
    for (kith_index p = run[r].first; p < run[r].first + run[r].count; ++p) w->wrong += w->touched[p]++ != 0;
  return KITH_OK;
}

static kith_status touch_last(void *context, const struct kith_run *run, int n) {
  struct swept *w = context;
  for (int r = 0; r < n; ++r)
    for (kith_index p = run[r].first; p < run[r].first + run[r].count; ++p)
      w->wrong += w->touched[p]++ != 1 || !w->marked[p];
  return KITH_OK;
}

static void packed_place(const struct kith_search *s, kith_index slot, double *x) {
  for (int a = 0; a < NDIM; ++a) x[a] = s->coordinate[a][slot];
}

/* f(target, other), and at once f(other, target) if the other one is of a coarser level. */
static kith_status count_hits(void *context, const struct kith_cell *cell) {
  struct swept *w = context;
  const struct kith_search *s = w->search;
  for (kith_index t = 0; t < cell->targets; ++t) {
    const kith_index p = cell->target[t];
    double x[NDIM], y[NDIM];
    packed_place(s, p, x);
    w->wrong += w->marked[p]++ != 0 || w->touched[p] != 1;
    for (int r = 0; r < cell->n_active; ++r)
      for (kith_index q = cell->active[r].first; q < cell->active[r].first + cell->active[r].count; ++q) {
        packed_place(s, q, y);
        w->wrong += w->touched[q] != 1;
        if (p == q || !interact(x, sqrt(s->radius2[p]), y, sqrt(s->radius2[q]), KITH_GATHER_SCATTER))
          continue;
        w->hits[p] += 1;
        w->hits[q] += r < cell->n_coarser;
      }
    if (w->moves != NULL) w->moves[(size_t)s->node[p] * NDIM] += 7;
  }
  return KITH_OK;
}

/* Every node is a target once, every interaction is met once in each direction, and events are in order. */
static void check_sweep(const struct kith_search *s, double *moves) {
  const size_t n = (size_t)s->n + 1;
  struct swept w = {.search = s, .moves = moves};
  const struct kith_sweep events = {touch_first, count_hits, touch_last};
  if (s->ops->sweep == NULL) {
    CHECK_STATUS(KITH_UNSUPPORTED, kith_search_sweep(s, &events, &w));
    CHECK(strstr(kith_failure(), s->ops->name) != NULL);
    return;
  }
  w.hits = calloc(n, sizeof *w.hits), w.touched = calloc(n, 1), w.marked = calloc(n, 1);
  CHECK_OK(kith_search_sweep(s, &events, &w));
  for (kith_index p = 0; p < s->n; ++p) {
    double x[NDIM], y[NDIM];
    int expected = 0;
    packed_place(s, p, x);
    for (kith_index q = 0; q < s->n; ++q) {
      packed_place(s, q, y);
      expected += p != q && interact(x, sqrt(s->radius2[p]), y, sqrt(s->radius2[q]), KITH_GATHER_SCATTER);
    }
    w.wrong += w.touched[p] != 2 || w.marked[p] != 1 || w.hits[p] != expected;
  }
  CHECK(w.wrong == 0);
  free(w.hits), free(w.touched), free(w.marked);
}

/* Everything, for at most `groups` groups. */
static void check_search(const struct kith_search *s, int groups, bool ordered) {
  const struct kith_nodes *nodes = s->nodes;
  kith_index *slot_of = malloc(sizeof *slot_of * (size_t)(s->n + 1));
  CHECK_OK(kith_search_fresh(s));
  check_slots(s, slot_of, ordered);
  struct kith_runs runs = {0};
  const int step = s->n_groups / groups + 1;
  for (int g = 0; g < s->n_groups; g += step) check_group(s, g, slot_of, &runs);
  kith_runs_clear(&runs);
  free(slot_of);
  for (int k = 0; k < 6; ++k) {
    double x[NDIM];
    for (int a = 0; a < NDIM; ++a) x[a] = k == 0 ? -50 : k == 1 ? 1e6 : uniform(-0.2, 1.2);
    check_at(s, x, k < 2 ? 60 : uniform(0, 0.3));
    if (s->n > 0) check_at(s, place(nodes, below(s->n)), nodes->search_radius->f64[below(s->n)]);
  }
  CHECK(kith_search_bytes(s) >= sizeof *s);
  if (s->n < 2000) check_sweep(s, NULL);
}

/* Sets of nodes. */

enum arrangement {
  RANDOM,
  LATTICE,
  CLUSTERED,
  COINCIDENT,
  EIGHT_TO_ONE,
  HUNDRED_TO_ONE,
  THOUSAND_TO_ONE,
  ALL_AT_ONE_PLACE,
  ARRANGEMENTS
};

static kith_index lattice_side(kith_index n) {
  kith_index side = 1;
  while (kith_pow_dim(side + 1) <= n) ++side;
  return side;
}

static double spacing(kith_index n) {
  return pow(n, -1.0 / NDIM);
}

/* Lattice: powers of two, so that distances and squares are exact, and radii that are lattice distances
 * (cells of half the largest radius then end where nodes are). */
static void put_on_lattice(double *x, double *radius, kith_index i, kith_index n) {
  const kith_index side = lattice_side(n);
  kith_index rest = i;
  for (int a = 0; a < NDIM; ++a) x[a] = 0.0625 * (rest % side), rest /= side;
  static const double multiple[3] = {1, 2, 4};
  *radius = 0.0625 * multiple[i % 3];
}

static void put(double *x, double *radius, enum arrangement how, kith_index i, kith_index n) {
  for (int a = 0; a < NDIM; ++a) x[a] = uniform(0, 1);
  *radius = uniform(1, 1.5) * spacing(n);
  if (how == LATTICE) put_on_lattice(x, radius, i, n);
  if (how == CLUSTERED)
    for (int a = 0; a < NDIM; ++a) x[a] = pow(x[a], 12);
  if (how == COINCIDENT)
    for (int a = 0; a < NDIM; ++a) x[a] = floor(4 * x[a]) / 4;
  if (how == EIGHT_TO_ONE && i % 2 == 0) *radius *= 8;
  if (how == HUNDRED_TO_ONE && i % 40 == 0) *radius *= 100;
  if (how == THOUSAND_TO_ONE) *radius = spacing(n) * pow(1000, uniform(-1, 0)) * (i % 50 ? 1 : 5);
  if (how == ALL_AT_ONE_PLACE) {
    for (int a = 0; a < NDIM; ++a) x[a] = 0.3;
    *radius = 0.1;
  }
}

static struct kith_nodes *make_nodes(enum arrangement how, kith_index n, int lists) {
  static const char *const names[] = {"one", "two", "three"};
  struct kith_nodes *nodes = NULL;
  CHECK_OK(kith_nodes_create(&nodes, lists, names));
  for (int l = 0; l < lists; ++l) {
    kith_index first;
    const kith_index count = n * (l + 1) / lists - n * l / lists;
    if (count > 0) CHECK_OK(kith_nodes_append(nodes, l, count, &first));
  }
  for (kith_index i = 0; i < n; ++i) {
    put(nodes->position->f64 + (size_t)i * NDIM, &nodes->search_radius->f64[i], how, i, n);
    nodes->id->i64[i] = i;
  }
  ++nodes->positions;
  return nodes;
}

/* Images of every third node, mirrored at 0 or shifted by 1 along an axis; ghosts of ghosts too. */
static void add_ghosts(struct kith_nodes *nodes, int axis, bool mirror) {
  struct kith_ghost_block block = {.kind = KITH_GHOST_IMAGE};
  const kith_index n = kith_nodes_count(nodes);
  CHECK_OK(kith_resize(&block.control, 0, (size_t)n + 1, sizeof *block.control));
  for (kith_index i = 0; i < n; i += 3)
    if (nodes->list->u8[i] == 0) block.control[block.count++] = i;
  for (int a = 0; a < NDIM; ++a) block.image.sign[a] = 1, block.image.shift[a] = 0;
  if (mirror)
    block.image.sign[axis] = -1;
  else
    block.image.shift[axis] = 1;
  CHECK_OK(kith_nodes_add_ghosts(nodes, &block));
}

/* Life. */

static void test_one_life(const struct kith_search_ops *ops, enum arrangement how, kith_index n, int lists) {
  struct kith_nodes *nodes = make_nodes(how, n, lists);
  struct kith_search *s = NULL;
  CHECK_OK(create(&s, ops, nodes));
  CHECK_STATUS(KITH_STALE, kith_search_fresh(s));
  CHECK_STATUS(KITH_STALE, kith_search_update_selected(s, NULL, 0));
  CHECK_OK(kith_search_update(s));
  check_search(s, 40, true);
  for (int a = 0; a < NDIM; ++a) {
    add_ghosts(nodes, a, a == 0);
    if (n > 0) CHECK_STATUS(KITH_STALE, kith_search_fresh(s));
    CHECK_OK(kith_search_update(s));
    check_search(s, 20, true);
  }
  kith_nodes_drop_ghosts(nodes);
  CHECK_OK(kith_search_update(s));
  check_search(s, 20, true);
  kith_search_destroy(&s);
  CHECK(s == NULL);
  kith_nodes_destroy(&nodes);
}

static void test_sets_of_nodes(const struct kith_search_ops *ops) {
  for (enum arrangement how = RANDOM; how < ARRANGEMENTS; ++how) test_one_life(ops, how, 400, 1 + how % 3);
  for (kith_index n = 0; n < 4; ++n) test_one_life(ops, RANDOM, n, 1);
  test_one_life(ops, COINCIDENT, 2, 2);
}

/* A periodic box thinner than a support: many images of each node, three layers on each side of axis 0. */
static void test_thin_box(const struct kith_search_ops *ops) {
  struct kith_nodes *nodes = make_nodes(RANDOM, 60, 1);
  struct kith_search *s = NULL;
  for (kith_index i = 0; i < 60; ++i) nodes->search_radius->f64[i] = uniform(1.5, 2.5);
  CHECK_OK(create(&s, ops, nodes));
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
  CHECK_OK(kith_search_update(s));
  check_search(s, 20, true);
  kith_search_destroy(&s);
  kith_nodes_destroy(&nodes);
}

/* After a cull a search is refused by name, also when as many ghosts were added as went. */
static void test_cull(const struct kith_search_ops *ops) {
  struct kith_nodes *nodes = make_nodes(RANDOM, 90, 2);
  struct kith_search *s = NULL;
  kith_index *found = NULL, count = 0, renumber[512], moved = 0;
  size_t capacity = 0;
  uint8_t keep[512];
  CHECK_OK(create(&s, ops, nodes));
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
    CHECK_OK(kith_search_update(s));
    check_search(s, 20, true);
  }
  kith_free(&found);
  kith_search_destroy(&s);
  kith_nodes_destroy(&nodes);
}

static void jolt(struct kith_nodes *nodes, kith_index i, int round) {
  /* Mostly small steps; sometimes across the box, or far out of it. */
  const double far = round % 7 == 6 ? 30 : round % 3 == 2 ? 1 : 0.02;
  for (int a = 0; a < NDIM; ++a) nodes->position->f64[(size_t)i * NDIM + a] += uniform(-far, far);
  /* Back to where many are. */
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
  struct kith_search *s = NULL;
  kith_index *moved = calloc(1000, sizeof *moved);
  CHECK_OK(create(&s, ops, nodes));
  CHECK_OK(kith_search_update(s));
  for (int round = 0; round < 16; ++round) {
    /* A few nodes, some named twice; none; ghosts too. */
    const kith_index count = round == 3 ? 0 : round == 5 ? 600 : 1 + below(40);
    for (kith_index k = 0; k < count; ++k) jolt(nodes, moved[k] = below(s->n), round);
    ++nodes->positions;
    CHECK_STATUS(KITH_STALE, kith_search_fresh(s));
    CHECK_OK(kith_search_update_selected(s, moved, count));
    check_search(s, 25, false);
    if (round == 9) {
      add_ghosts(nodes, NDIM - 1, false);
      CHECK_STATUS(KITH_STALE, kith_search_update_selected(s, moved, 1));
      CHECK_OK(kith_search_update(s));
      check_search(s, 25, true);
    }
  }
  free(moved);
  kith_search_destroy(&s);
  kith_nodes_destroy(&nodes);
}

/* Radii grow, nodes stay: whoever keeps a largest radius must hear of it. */
/* Nodes that moved and grew since the search was made, all their ghosts gone: whatever an active one may
 * interact with now is near; and when these are taken in, the search is right about them. */
static void test_near(const struct kith_search_ops *ops, enum arrangement how) {
  const double slack = 0.05;
  struct kith_nodes *nodes = make_nodes(how, 400, 2);
  struct kith_search *s = NULL;
  kith_index *near = NULL, *found = NULL, count = 0, n_found = 0;
  size_t capacity = 0, found_capacity = 0;
  CHECK_OK(kith_nodes_mark_activity(nodes));
  CHECK_OK(create(&s, ops, nodes));
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
        missed += !taken[j] && interact(place(nodes, i), nodes->search_radius->f64[i], place(nodes, j),
                                        nodes->search_radius->f64[j], KITH_GATHER_SCATTER);
    CHECK(missed == 0);
    CHECK_OK(kith_search_update_selected(s, near, count));
    for (kith_index i = 0; i < n; ++i) {
      if (!kith_node_active(nodes, i)) continue;
      CHECK(taken[i] == 1);
      CHECK_OK(kith_search_at(s, place(nodes, i), nodes->search_radius->f64[i], KITH_GATHER, &found,
                              &found_capacity, &n_found));
      kith_index expected = 0;
      for (kith_index j = 0; j < n; ++j)
        expected += interact(place(nodes, i), nodes->search_radius->f64[i], place(nodes, j), 0, KITH_GATHER);
      CHECK(n_found == expected);
    }
    free(taken);
  }
  kith_free(&near);
  kith_free(&found);
  kith_search_destroy(&s);
  kith_nodes_destroy(&nodes);
}

static void test_growth(const struct kith_search_ops *ops) {
  struct kith_nodes *nodes = make_nodes(RANDOM, 150, 1);
  struct kith_search *s = NULL;
  CHECK_OK(create(&s, ops, nodes));
  CHECK_OK(kith_search_update(s));
  for (int round = 0; round < 60; ++round) {
    const kith_index grown = round < 50 ? below(s->n) : 7;
    nodes->search_radius->f64[grown] *= 1.3;
    ++nodes->positions;
    CHECK_OK(kith_search_update_selected(s, &grown, 1));
    check_search(s, 30, true);
  }
  kith_search_destroy(&s);
  kith_nodes_destroy(&nodes);
}

/* A second swarm beyond anything that cells can count: clamped, but complete. */
static void test_far_off(const struct kith_search_ops *ops) {
  struct kith_nodes *nodes = make_nodes(RANDOM, 200, 1);
  struct kith_search *s = NULL;
  CHECK_OK(create(&s, ops, nodes));
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
  CHECK_OK(kith_search_update(s));
  check_search(s, 40, true);
  kith_search_destroy(&s);
  kith_nodes_destroy(&nodes);
}

/* Large enough for all threads to have work. `along`: nodes along the curve of the tree, and a few that
 * strayed. */
static void test_threads(const struct kith_search_ops *ops, bool along) {
  const kith_index n = 30000, strays = along ? 300 : 0;
  struct kith_nodes *nodes = make_nodes(CLUSTERED, n, 1);
  if (along) {
    double lower[NDIM], upper[NDIM];
    bool sorted;
    kith_index *order = malloc(sizeof *order * (size_t)n);
    kith_search_cube(nodes->position->f64, n, lower, upper);
    CHECK_OK(kith_nodes_curve_order(nodes, lower, upper, order, &sorted));
    CHECK_OK(kith_nodes_reorder(nodes, order));
    free(order);
  }
  add_ghosts(nodes, 0, true);
  kith_index *one = malloc(sizeof *one * (size_t)n * 2), *moved = malloc(sizeof *moved * 300);
  for (kith_index k = 0; k < 300; ++k) moved[k] = below(n);
  for (kith_index k = 0; k < strays; ++k) jolt(nodes, moved[k], 2);
  struct kith_search *s[3] = {NULL, NULL, NULL};
  for (int stage = 0; stage < 2; ++stage) {
    for (int threads = 1; threads <= 3; ++threads) {
      omp_set_num_threads(threads);
      if (stage == 0) CHECK_OK(create(&s[threads - 1], ops, nodes));
      CHECK_OK(stage == 0 ? kith_search_update(s[threads - 1])
                          : kith_search_update_selected(s[threads - 1], moved, 300));
      CHECK(s[threads - 1]->n_groups == s[0]->n_groups);
      CHECK(memcmp(s[threads - 1]->node, s[0]->node, sizeof(kith_index) * (size_t)s[0]->n) == 0);
      CHECK(memcmp(s[threads - 1]->group, s[0]->group, sizeof(struct kith_run) * (size_t)s[0]->n_groups) ==
            0);
    }
    check_search(s[2], ops == &kith_search_brute ? 3 : 25, stage == 0);
    for (kith_index k = 0; k < 300; ++k) jolt(nodes, moved[k], 1);
    ++nodes->positions;
  }
  free(one);
  free(moved);
  for (int k = 0; k < 3; ++k) kith_search_destroy(&s[k]);
  kith_nodes_destroy(&nodes);
}

static void test_runs(void) {
  struct kith_runs runs = {0};
  CHECK_OK(kith_runs_add(&runs, 10, 5));
  CHECK_OK(kith_runs_add(&runs, 15, 1));
  CHECK(runs.n == 1 && runs.run[0].first == 10 && runs.run[0].count == 6);
  /* Of the 200, every second one touches the next. */
  for (kith_index k = 0; k < 200; ++k) CHECK_OK(kith_runs_add(&runs, 20 + 4 * k, k % 2 ? 2 : 4));
  for (int r = 1; r < runs.n; ++r) CHECK(runs.run[r].first > runs.run[r - 1].first + runs.run[r - 1].count);
  kith_index sum = 0;
  for (int r = 0; r < runs.n; ++r) sum += runs.run[r].count;
  CHECK(runs.n == 101 && sum == 6 + 100 * 4 + 100 * 2);
  kith_runs_clear(&runs);
  CHECK(runs.n == 0 && runs.run == NULL);
}

static void test_family(void) {
  for (const struct kith_search_ops *const *ops = kith_search_all(); *ops; ++ops)
    CHECK(kith_search_find((*ops)->name) == *ops && (*ops)->doc[0] != 0);
  CHECK(kith_search_find("oracle") == NULL);
}

/* Cells move their targets while they are swept: sets stay what they were, and after that are refused. */
static void test_moves_of_targets(const struct kith_search_ops *ops) {
  struct kith_nodes *nodes = make_nodes(EIGHT_TO_ONE, 200, 1);
  struct kith_search *s = NULL;
  CHECK_OK(create(&s, ops, nodes));
  CHECK_OK(kith_search_update(s));
  check_sweep(s, nodes->position->f64);
  ++nodes->positions;
  CHECK_STATUS(KITH_STALE, kith_search_sweep(s, &(struct kith_sweep){NULL, NULL, NULL}, NULL));
  CHECK(strstr(kith_failure(), ops->name) != NULL);
  kith_search_destroy(&s);
  kith_nodes_destroy(&nodes);
}

/* What the spacetree did with node 0, in a cloud of equal radii that stays where it is. */
static void expect_counts(struct kith_search *s, bool selected, const uint64_t *expected) {
  const kith_index moved = 0;
  ++((struct kith_nodes *)(uintptr_t)s->nodes)->positions;
  CHECK_OK(selected ? kith_search_update_selected(s, &moved, 1) : kith_search_update(s));
  for (int k = 0; k < KITH_SEARCH_COUNTERS; ++k) CHECK(s->count[k] == expected[k]);
}

/* Sorts from scratch, moves, levels lifted and dropped, nodes that tunnelled; by either update. */
static void test_counters(void) {
  for (int selected = 0; selected < 2; ++selected) {
    struct kith_nodes *nodes = make_nodes(RANDOM, 400, 1);
    struct kith_search *s = NULL;
    double *x = nodes->position->f64, *radius = nodes->search_radius->f64;
    for (kith_index i = 0; i < 400; ++i) radius[i] = i == 1 ? 0.08 : 0.01; /* cells 0.168 wide, and 0.021 */
    for (int a = 0; a < NDIM; ++a) x[NDIM + a] = 0, x[2 * NDIM + a] = 1;
    for (int a = 0; a < NDIM; ++a) x[a] = 0.3;
    CHECK_OK(kith_search_create(&s, &kith_search_spacetree, nodes));
    expect_counts(s, false, (const uint64_t[]){1, 0, 0, 0, 0});
    expect_counts(s, selected, (const uint64_t[]){0, 0, 0, 0, 0});
    x[0] += 0.021;
    expect_counts(s, selected, (const uint64_t[]){0, 1, 0, 0, 0});
    radius[0] = 0.02; /* cells 0.042 wide */
    expect_counts(s, selected, (const uint64_t[]){0, 0, 1, 0, 0});
    radius[0] = 0.01;
    expect_counts(s, selected, (const uint64_t[]){0, 0, 0, 1, 0});
    x[NDIM - 1] += 7.3 * 0.021; /* an adjacent vertex three levels up */
    expect_counts(s, selected, (const uint64_t[]){0, 0, 3, 3, 1});
    check_search(s, 40, false);
    kith_search_destroy(&s);
    kith_nodes_destroy(&nodes);
  }
}

/* Nodes on the faces, edges and corners of cells, at their middles, of two levels: each is a target of one
 * cell (check_sweep), the upper one. */
static void test_faces(void) {
  const kith_index n = 2 + (NDIM == 1 ? 30 : 200);
  struct kith_nodes *nodes = make_nodes(RANDOM, n, 1);
  struct kith_search *s = NULL;
  int on_faces = 0, on_corners = 0;
  for (kith_index i = 0; i < n; ++i) nodes->search_radius->f64[i] = i % 2 ? 0.25 : 0.06;
  for (int a = 0; a < 2 * NDIM; ++a) nodes->position->f64[a] = a < NDIM;
  CHECK_OK(kith_search_create(&s, &kith_search_spacetree, nodes));
  CHECK_OK(kith_search_update(s)); /* nodes 0 and 1 make the frame */
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
  CHECK_OK(kith_search_update(s));
  check_search(s, 40, true);
  kith_search_destroy(&s);
  kith_nodes_destroy(&nodes);
}

static void test_member(const struct kith_search_ops *ops) {
  test_sets_of_nodes(ops);
  for (enum arrangement how = RANDOM; how < ARRANGEMENTS; ++how) test_motion(ops, how), test_near(ops, how);
  test_thin_box(ops);
  test_cull(ops);
  test_growth(ops);
  test_far_off(ops);
  test_moves_of_targets(ops);
  for (int along = 0; along < 2 && settings == NULL; ++along) test_threads(ops, along);
}

int main(void) {
  test_runs();
  test_family();
  for (const struct kith_search_ops *const *ops = kith_search_all(); *ops; ++ops) {
    test_member(*ops);
    if ((*ops)->params == NULL) continue;
    bool *other = calloc(1, (*ops)->settings_size);
    other[(*ops)->params->offset] = true;
    settings = other;
    test_member(*ops);
    settings = NULL;
    free(other);
  }
  test_counters();
  test_faces();
  return check_failed();
}
