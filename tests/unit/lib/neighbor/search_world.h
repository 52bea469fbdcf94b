/* search_world.h - for tests of searches: sets of nodes, and the oracle, loops over all nodes that use no
 * code of the searches. */
#ifndef KITH_TEST_NEIGHBOR_SEARCH_WORLD_H
#define KITH_TEST_NEIGHBOR_SEARCH_WORLD_H

#include "tests/check.h"

#include <stdlib.h>
#include <string.h>
#include "lib/neighbor/spacetree_cells.h"
#include "tests/unit/choices_of.h"

static uint64_t seed = 20;
static inline double uniform(double lower, double upper) {
  return lower + (upper - lower) * check_random(&seed);
}
static inline kith_index below(kith_index n) {
  return (kith_index)(check_random(&seed) * n);
}

/* Members are also tested with every other choice of each parameter. */
static const void *settings;
static inline struct kith_search *create_search(const struct kith_search_ops *ops,
                                                const struct kith_nodes *nodes) {
  struct kith_search *s;
  CHECK_OK(kith_search_create(&s, ops, nodes));
  s->settings = settings;
  return s;
}

static inline void destroy(struct kith_search **s, struct kith_nodes **nodes) {
  kith_search_destroy(s);
  kith_nodes_destroy(nodes);
}

static inline void with_members(void (*test)(const struct kith_search_ops *ops)) {
  for (const struct kith_search_ops *const *ops = kith_search_all(); *ops; ++ops) {
    test(*ops);
    for (const struct kith_param *p = (*ops)->params; p != NULL && p->key != NULL; ++p) {
      char value[64], assignment[128];
      for (int k = 0; choice_of(p, k, value, sizeof value); ++k) {
        void *other;
        snprintf(assignment, sizeof assignment, "%s=%s", p->key, value);
        CHECK_OK(
            kith_settings_create(&other, kith_family_member(kith_search_member, (*ops)->name), assignment));
        settings = other;
        test(*ops);
        settings = NULL;
        kith_free(&other);
      }
    }
  }
}

/* The oracle: do a target and a source interact? Ties count. */
static inline bool interact(const double *x, double radius, const double *y, double other,
                            enum kith_search_mode mode) {
  double d2 = 0;
  for (int a = 0; a < NDIM; ++a) d2 += (x[a] - y[a]) * (x[a] - y[a]);
  return (mode != KITH_SCATTER && d2 <= radius * radius) || (mode != KITH_GATHER && d2 <= other * other);
}

static inline const double *position_of(const struct kith_nodes *nodes, kith_index i) {
  return nodes->position->f64 + (size_t)i * NDIM;
}

static inline bool equal_nodes(const struct kith_search *s, kith_index p, kith_index q) {
  const kith_index i = s->node[p], j = s->node[q], internal = s->nodes->n_internal;
  for (int a = 0; a < NDIM; ++a)
    if (s->coordinate[a][p] != s->coordinate[a][q]) return false;
  return s->radius2[p] == s->radius2[q] && (i < internal) == (j < internal);
}

/* Slots are a permutation of the nodes and hold their positions and radii; equal nodes are in ascending order
 * (`ordered`: not after partial updates). Groups hold every node once, and never both nodes and ghosts. */
static inline void check_slots(const struct kith_search *s, kith_index *slot_of, bool ordered) {
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
    for (int a = 0; a < NDIM; ++a) wrong += s->coordinate[a][slot] != position_of(nodes, i)[a];
    wrong += ordered && slot > 0 && equal_nodes(s, slot - 1, slot) && s->node[slot - 1] > i;
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

static inline void check_group(const struct kith_search *s, int g, const kith_index *slot_of,
                               struct kith_runs *runs) {
  const struct kith_nodes *nodes = s->nodes;
  const struct kith_run group = s->group[g];
  struct kith_box box = kith_box_empty();
  double radius2 = 0;
  for (kith_index slot = group.first; slot < group.first + group.count; ++slot) {
    kith_box_include(&box, position_of(nodes, s->node[slot]));
    radius2 = KITH_MAX(radius2, s->radius2[slot]);
    const double radius = nodes->search_radius->f64[s->node[slot]];
    CHECK(s->radius2[slot] == radius * radius);
    for (int a = 0; a < NDIM; ++a) CHECK(s->coordinate[a][slot] == position_of(nodes, s->node[slot])[a]);
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
        missed += interact(position_of(nodes, s->node[slot]), nodes->search_radius->f64[s->node[slot]],
                           position_of(nodes, j), nodes->search_radius->f64[j], mode) &&
                  !found[slot_of[j]];
    free(found);
    CHECK(wrong == 0);
    CHECK(missed == 0);
  }
}

static inline void check_at(const struct kith_search *s, const double *x, double radius) {
  const struct kith_nodes *nodes = s->nodes;
  kith_index *found = NULL, count = -1;
  size_t capacity = 0;
  for (enum kith_search_mode mode = KITH_GATHER; mode <= KITH_GATHER_SCATTER; ++mode) {
    CHECK_OK(kith_search_at(s, x, radius, mode, &found, &capacity, &count));
    kith_index k = 0, wrong = 0;
    for (kith_index j = 0; j < s->n; ++j)
      if (interact(x, radius, position_of(nodes, j), nodes->search_radius->f64[j], mode))
        wrong += k >= count || found[k++] != j;
    CHECK(wrong == 0 && k == count);
  }
  kith_free(&found);
}

/* State of a sweep. `moves`: positions that cells change while they are swept, which must not matter. */
struct swept {
  const struct kith_search *search;
  int *hits, wrong;
  /* touched: 1 after the first event, 2 after the last one; marked: targets so far */
  uint8_t *touched, *marked;
  double *moves;
};

static inline kith_status touch_first(void *context, const struct kith_run *run, int n) {
  struct swept *w = context;
  for (int r = 0; r < n; ++r)
    for (kith_index p = run[r].first; p < run[r].first + run[r].count; ++p) w->wrong += w->touched[p]++ != 0;
  return KITH_OK;
}

static inline kith_status touch_last(void *context, const struct kith_run *run, int n) {
  struct swept *w = context;
  for (int r = 0; r < n; ++r)
    for (kith_index p = run[r].first; p < run[r].first + run[r].count; ++p)
      w->wrong += w->touched[p]++ != 1 || !w->marked[p];
  return KITH_OK;
}

static inline void packed_place(const struct kith_search *s, kith_index slot, double *x) {
  for (int a = 0; a < NDIM; ++a) x[a] = s->coordinate[a][slot];
}

/* Counts each interaction of a target, and its reverse if the other node is of a coarser level. */
static inline kith_status count_hits(void *context, const struct kith_cell *cell) {
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

/* In a sweep every node is a target once, every interaction is met once in each direction, and events are in
 * order. */
static inline void check_sweep(const struct kith_search *s, double *moves) {
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

/* Makes all checks, for at most `groups` groups. */
static inline void check_search(const struct kith_search *s, int groups, bool ordered) {
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
    if (s->n > 0) check_at(s, position_of(nodes, below(s->n)), nodes->search_radius->f64[below(s->n)]);
  }
  CHECK(kith_search_bytes(s) >= sizeof *s);
  if (s->n < 2000) check_sweep(s, NULL);
}

/* Updates the search with all nodes, and makes all checks. */
static inline void check_update(struct kith_search *s, int groups) {
  CHECK_OK(kith_search_update(s));
  check_search(s, groups, true);
}

/* ---- sets of nodes ---- */

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

static inline kith_index lattice_side(kith_index n) {
  kith_index side = 1;
  while (kith_pow_dim(side + 1) <= n) ++side;
  return side;
}

static inline double spacing(kith_index n) {
  return pow(n, -1.0 / NDIM);
}

/* Coordinates are multiples of 1/16, so that distances and squares are exact, and radii are lattice distances
 * (cells of half the largest radius then end where nodes are). */
static inline void place_on_lattice(double *x, double *radius, kith_index i, kith_index n) {
  const kith_index side = lattice_side(n);
  kith_index rest = i;
  for (int a = 0; a < NDIM; ++a) x[a] = 0.0625 * (rest % side), rest /= side;
  static const double multiple[3] = {1, 2, 4};
  *radius = 0.0625 * multiple[i % 3];
}

static inline void place_node(double *x, double *radius, enum arrangement how, kith_index i, kith_index n) {
  for (int a = 0; a < NDIM; ++a) x[a] = uniform(0, 1);
  *radius = uniform(1, 1.5) * spacing(n);
  if (how == LATTICE) place_on_lattice(x, radius, i, n);
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

static inline struct kith_nodes *make_nodes(enum arrangement how, kith_index n, int lists) {
  static const char *const names[] = {"one", "two", "three"};
  struct kith_nodes *nodes = NULL;
  CHECK_OK(kith_nodes_create(&nodes, lists, names));
  for (int l = 0; l < lists; ++l) {
    kith_index first;
    const kith_index count = n * (l + 1) / lists - n * l / lists;
    if (count > 0) CHECK_OK(kith_nodes_append(nodes, l, count, &first));
  }
  for (kith_index i = 0; i < n; ++i) {
    place_node(nodes->position->f64 + (size_t)i * NDIM, &nodes->search_radius->f64[i], how, i, n);
    nodes->id->i64[i] = i;
  }
  ++nodes->positions;
  return nodes;
}

/* Adds images of every third node, mirrored at 0 or shifted by 1 along an axis; ghosts have images, too. */
static inline void add_ghosts(struct kith_nodes *nodes, int axis, bool mirror) {
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

#endif
