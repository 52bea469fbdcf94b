/* test_connectivity.c - rows, pairs, overlap and intersection, built with every search, against loops over
 * all nodes (tests/unit/oracle.h): random nodes, ties, thin boxes, ghosts, idle nodes. Also reuse of memory,
 * and checks that find wrong rows. Excluders are tested by conformance_excluder.c, wrong use by
 * test_failure_modes.c. */
#include "tests/unit/oracle.h"

#include <omp.h>

#include "boundaries/boundary.h"

static const struct kith_requirements everything = {
    .rows = true, .pairs = true, .overlap_pairs = true, .intersection = true};

static void add_ghosts(struct kith_nodes *nodes, int kinds, double depth) {
  for (int a = 0; a < NDIM; ++a, kinds /= 3)
    if (kinds % 3 > 0) oracle_ghosts(nodes, a, kinds % 3 == 2, depth);
}

static void random_nodes(void) {
  const int counts[][3] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {40, 0, 0}, {25, 0, 15}, {0, 20, 7}, {70, 1, 1}};
  uint64_t state = 7;
  for (int c = 0; c < (int)(sizeof counts / sizeof *counts); ++c)
    for (int lists = 1; lists <= 3; lists += 2) {
      /* search radii differ by up to 8 : 1 */
      struct kith_nodes *nodes = oracle_random(lists, counts[c], NDIM == 3 ? 0.06 : 0.03, 8, &state);
      oracle_conforms(nodes, NULL);
      kith_nodes_destroy(&nodes);
    }
}

/* For each axis no ghosts (0), periodic (1) or mirror (2): all combinations, with corners. */
static void ghosts(void) {
  uint64_t state = 11;
  const int count[3] = {14, 6, 0};
  int kinds = 1;
  for (int a = 0; a < NDIM; ++a) kinds *= 3;
  for (int k = 0; k < kinds; ++k) {
    struct kith_nodes *nodes = oracle_random(3, count, 0.08, 3, &state);
    add_ghosts(nodes, k, 0.24);
    oracle_conforms(nodes, NULL);
    kith_nodes_destroy(&nodes);
  }
}

/* As above, with ghosts from boundaries (open, periodic or reflecting on each axis), twice as deep, as
 * overlap needs them. */
static void boundary_ghosts(void) {
  uint64_t state = 19;
  const int count[3] = {4, 0, 2};
  int kinds = 1;
  for (int a = 0; a < NDIM; ++a) kinds *= 3;
  for (int k = 0; k < kinds; ++k) {
    struct kith_nodes *nodes = oracle_random(3, count, 0.1, 2, &state);
    struct kith_boundaries boundaries = {0};
    for (int a = 0, rest = k; a < NDIM; ++a, rest /= 3)
      if (rest % 3 > 0)
        CHECK_OK(kith_boundaries_add(&boundaries,
                                     rest % 3 == 1 ? &kith_boundary_periodic : &kith_boundary_reflecting, a,
                                     0, 1, true, true));
    CHECK_OK(kith_boundaries_ghosts(&boundaries, nodes, 2, NULL));
    oracle_conforms(nodes, NULL);
    kith_boundaries_clear(&boundaries);
    kith_nodes_destroy(&nodes);
  }
}

/* In a periodic lattice of 2 cells with R = h every node has 2 NDIM neighbors: each partner counts twice, as
 * two images. */
static void thin_box(void) {
  struct kith_nodes *nodes = oracle_lattice(2, 2, 0.5);
  struct kith_boundaries boundaries = {0};
  for (int a = 0; a < NDIM; ++a)
    CHECK_OK(kith_boundaries_add(&boundaries, &kith_boundary_periodic, a, 0, 1, true, true));
  CHECK_OK(kith_boundaries_ghosts(&boundaries, nodes, 2, NULL));
  oracle_conforms(nodes, NULL);
  struct kith_connectivity *c = oracle_build(nodes, kith_search_find("tree"), everything, NULL);
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    CHECK(c->rows.first[i + 1] - c->rows.first[i] == 2 * NDIM);
  kith_connectivity_destroy(&c);
  kith_boundaries_clear(&boundaries);
  kith_nodes_destroy(&nodes);
}

/* The search radius is exactly a lattice distance: h, sqrt(2) h (where rounding decides, but everywhere in
 * the same way) or 2 h. A periodic box of one cell has its own images as neighbors. */
static void lattices(void) {
  for (int n = 1; n <= 4; n *= 2)
    for (int kind = 0; kind < 3; ++kind)
      for (int lists = 1; lists <= 2; ++lists) {
        const double h = 1.0 / n, search_radius = kind == 0 ? h : kind == 1 ? 2 * h : sqrt(2) * h;
        struct kith_nodes *nodes = oracle_lattice(lists, n, search_radius);
        if (n < 4) add_ghosts(nodes, 1 + 3 + 9, h); /* periodic, one layer deeper than the box */
        oracle_conforms(nodes, NULL);
        kith_nodes_destroy(&nodes);
      }
  /* Known: an inner node of a lattice with R = h has 2 NDIM neighbors; with R just below h it has none. */
  for (int below = 0; below < 2; ++below) {
    struct kith_nodes *nodes = oracle_lattice(1, 4, below ? nextafter(0.25, 0) : 0.25);
    struct kith_connectivity *c = oracle_build(nodes, kith_search_find("tree"), everything, NULL);
    const kith_index inner = NDIM == 1 ? 1 : NDIM == 2 ? 5 : 21;
    CHECK(c->rows.first[inner + 1] - c->rows.first[inner] == (below ? 0 : 2 * NDIM));
    kith_connectivity_destroy(&c);
    kith_nodes_destroy(&nodes);
  }
}

/* Rows of active nodes are complete; rows of idle nodes hold active nodes only, ghosts too; the intersection
 * of each of these pairs is complete. From no active node to all. What takes complete rows of other nodes is
 * refused while any is idle. */
static void activity(void) {
  const struct kith_requirements more[] = {{.ghost_rows = true}, {.overlap = true}};
  const int count[3] = {NDIM == 1 ? 80 : 300, 0, 60};
  struct kith_requirements need = {.rows = true, .pairs = true, .intersection = true};
  uint64_t state = 23;
  for (int percent = 0; percent <= 100; percent += percent < 4 ? 2 : 48) {
    struct kith_nodes *nodes = oracle_random(3, count, NDIM == 3 ? 0.1 : 0.02 * NDIM, 3, &state);
    CHECK_OK(kith_nodes_mark_activity(nodes));
    for (kith_index i = 0; i < nodes->n_internal; ++i)
      nodes->activity->u8[i] = 100 * check_random(&state) < percent ? KITH_ACTIVE : KITH_IDLE;
    add_ghosts(nodes, 1 + 2 * 3 + 9, 0.3);
    need.on_segment = percent % 4 == 0;
    for (const struct kith_search_ops *const *ops = kith_search_all(); *ops; ++ops) {
      struct kith_connectivity *c = oracle_build(nodes, *ops, need, NULL);
      oracle_check(c, nodes, NULL);
      CHECK((c->pairs.n > 0) == (percent > 0));
      struct kith_search *search;
      CHECK_OK(kith_search_create(&search, *ops, nodes));
      CHECK_OK(kith_search_update(search));
      for (int k = 0; k < 2; ++k)
        CHECK_STATUS(percent < 100 ? KITH_UNSUPPORTED : KITH_OK,
                     kith_connectivity_build(c, nodes, search, more[k], NULL, NULL));
      kith_search_destroy(&search);
      kith_connectivity_destroy(&c);
    }
    kith_nodes_destroy(&nodes);
  }
}

/* Ten nodes in one place, some with search radius 0, and a node far from all others. */
static void coincident(void) {
  uint64_t state = 3;
  const int count[3] = {12, 0, 0};
  struct kith_nodes *nodes = oracle_random(1, count, 0.1, 1, &state);
  for (int i = 0; i < 10 * NDIM; ++i) nodes->position->f64[i] = 0.5;
  for (int i = 0; i < 5; ++i) nodes->search_radius->f64[i] = 0;
  for (int a = 0; a < NDIM; ++a) nodes->position->f64[10 * NDIM + a] = 1e6;
  ++nodes->positions;
  oracle_conforms(nodes, NULL);
  kith_nodes_destroy(&nodes);
}

/* Enough nodes for many groups and for parts of threads: bitwise identical with any search and number of
 * threads. */
static void threads(void) {
  uint64_t state = 23;
  const int count[3] = {900, 300, 0};
  struct kith_requirements need = everything;
  need.ghost_rows = true;
  struct kith_nodes *nodes = oracle_random(2, count, NDIM == 1 ? 0.005 : NDIM == 2 ? 0.03 : 0.07, 2, &state);
  add_ghosts(nodes, 1, 0.2);
  struct kith_connectivity *first = oracle_build(nodes, kith_search_find("brute"), need, NULL);
  for (int t = 1; t <= 3; ++t) {
    omp_set_num_threads(t);
    for (const struct kith_search_ops *const *ops = kith_search_all(); *ops; ++ops) {
      struct kith_connectivity *other = oracle_build(nodes, *ops, need, NULL);
      CHECK(oracle_identical(first, other));
      kith_connectivity_destroy(&other);
    }
  }
  omp_set_num_threads(2);
  for (int i = 0; i < kith_nodes_count(nodes); ++i)
    ORACLE_ROW(&first->rows, i, kith_nodes_count(nodes), j, oracle_neighbors(nodes, NULL, i, j));
  kith_connectivity_destroy(&first);
  kith_nodes_destroy(&nodes);
}

/* --- reuse of memory, breaches, requirements --- */

static void memory_reuse(void) {
  uint64_t state = 13;
  const int count[3] = {50, 10, 0};
  struct kith_nodes *nodes = oracle_random(2, count, 0.2, 2, &state);
  add_ghosts(nodes, 1, 0.2);
  struct kith_search *search;
  struct kith_connectivity *c;
  struct kith_pairwise *factor;
  CHECK_OK(kith_search_create(&search, kith_search_find("tree"), nodes));
  CHECK_OK(kith_search_update(search));
  CHECK_OK(kith_connectivity_create(&c));
  omp_set_num_threads(1);
  CHECK_OK(kith_connectivity_build(c, nodes, search, everything, NULL, NULL));
  CHECK_OK(kith_pairwise_prepare(&c->pairs, &kith_f_couple, &factor));
  const size_t bytes = kith_connectivity_bytes(c), values = kith_pairwise_bytes(&c->pairs);
  CHECK(values >= c->pairs.n * sizeof(double) && kith_pairwise_bytes(&c->overlap_pairs) == 0);
  const void *const where[] = {c->rows.first,   c->rows.node,    c->pairs.node,
                               c->pairs.of_row, c->overlap.node, c->intersection.node};
  CHECK_OK(kith_connectivity_build(c, nodes, search, everything, NULL, NULL));
  const void *const now[] = {c->rows.first,   c->rows.node,    c->pairs.node,
                             c->pairs.of_row, c->overlap.node, c->intersection.node};
  CHECK(kith_connectivity_bytes(c) == bytes && memcmp(where, now, sizeof now) == 0);
  CHECK_STATUS(KITH_STALE, kith_pairwise_fresh(&c->pairs, factor));
  CHECK(kith_pairwise_bytes(&c->pairs) == values && bytes > c->pairs.n * sizeof(kith_index[2]));
  CHECK_OK(kith_connectivity_build(c, nodes, search, (struct kith_requirements){0}, NULL, NULL));
  CHECK(c->rows.n == 0 && !c->built.rows);
  CHECK_OK(kith_connectivity_valid(c, nodes));
  omp_set_num_threads(2);
  kith_connectivity_destroy(&c);
  kith_search_destroy(&search);
  kith_nodes_destroy(&nodes);
}

static void finds_wrong(const struct kith_connectivity *c, const struct kith_nodes *nodes, kith_index *place,
                        kith_index wrong) {
  const kith_index right = *place;
  CHECK(right != wrong);
  *place = wrong;
  CHECK_STATUS(KITH_INTERNAL, kith_connectivity_valid(c, nodes));
  *place = right;
  CHECK_OK(kith_connectivity_valid(c, nodes));
}

/* The check of validity finds one wrong number in any array. */
static void wrong_numbers(void) {
  struct kith_nodes *nodes = oracle_lattice(1, 4, 0.5);
  struct kith_connectivity *c = oracle_build(nodes, kith_search_find("tree"), everything, NULL);
  struct kith_pairwise *factor;
  CHECK_OK(kith_pairwise_prepare(&c->pairs, &kith_f_couple, &factor));
  const kith_index n = kith_nodes_count(nodes);
  finds_wrong(c, nodes, &c->rows.node[0], n);
  finds_wrong(c, nodes, &c->rows.node[0], 0);
  finds_wrong(c, nodes, &c->rows.node[1], c->rows.node[0]);
  finds_wrong(c, nodes, &c->rows.node[c->rows.first[1] - 1], n - 1);
  finds_wrong(c, nodes, &c->pairs.node[1][1], c->pairs.node[0][1]);
  finds_wrong(c, nodes, &c->pairs.node[0][0], 1);
  finds_wrong(c, nodes, (kith_index *)&c->pairs.of_row[1], 0);
  finds_wrong(c, nodes, &c->overlap_pairs.node[1][1], c->overlap_pairs.node[0][1]);
  finds_wrong(c, nodes, (kith_index *)&c->overlap_pairs.of_row[1], 0);
  finds_wrong(c, nodes, &c->overlap.node[0], 0);
  finds_wrong(c, nodes, &c->overlap.node[1], -1);
  finds_wrong(c, nodes, &c->intersection.node[0], -1);
  finds_wrong(c, nodes, &c->intersection.node[1], n - 1);
  --c->rows.first[2];
  CHECK_STATUS(KITH_INTERNAL, kith_connectivity_valid(c, nodes));
  ++c->rows.first[2];
  --c->pairs.n;
  CHECK_STATUS(KITH_INTERNAL, kith_connectivity_valid(c, nodes));
  ++c->pairs.n;
  factor->value[0] = NAN;
  CHECK_STATUS(KITH_INTERNAL, kith_connectivity_valid(c, nodes));
  kith_connectivity_destroy(&c);
  kith_nodes_destroy(&nodes);
}

/* The check of completeness finds a missing entry, and an additional one, in rows that are valid
 * otherwise. */
static void incomplete_rows(void) {
  const int count = 120;
  uint64_t state = 7;
  struct kith_nodes *nodes = oracle_random(1, &count, 0.4, 4, &state);
  struct kith_search *search;
  struct kith_connectivity *c = oracle_build(nodes, &kith_search_spacetree, everything, NULL);
  struct kith_rows *rows = &c->rows;
  CHECK_OK(kith_search_create(&search, &kith_search_spacetree, nodes));
  CHECK_STATUS(KITH_STALE, kith_connectivity_complete(c, search, false));
  CHECK_OK(kith_search_update(search));
  CHECK_OK(kith_connectivity_complete(c, search, false));
  const size_t end = rows->first[1];
  CHECK(end > 0);
  rows->first[1] = end - 1; /* the last entry of row 0 becomes one of row 1, where it is wrong */
  CHECK_STATUS(KITH_INTERNAL, kith_connectivity_complete(c, search, false));
  CHECK_STATUS(KITH_INTERNAL, kith_connectivity_complete(c, search, true));
  rows->first[1] = end;
  CHECK_OK(kith_connectivity_complete(c, search, true));
  kith_connectivity_destroy(&c);
  kith_search_destroy(&search);
  kith_nodes_destroy(&nodes);
}

static void requirements(void) {
  const struct kith_requirements none = {0}, pairs = {.pairs = true}, all = {.intersection = true},
                                 segment = {.intersection = true, .on_segment = true};
  CHECK(kith_requirements_or(none, pairs).pairs && !kith_requirements_or(none, pairs).rows);
  CHECK(kith_requirements_or(segment, none).on_segment && kith_requirements_or(pairs, segment).on_segment);
  CHECK(!kith_requirements_or(segment, all).on_segment && kith_requirements_or(segment, all).intersection);
}

int main(void) {
  random_nodes();
  ghosts();
  boundary_ghosts();
  thin_box();
  lattices();
  activity();
  coincident();
  threads();
  memory_reuse();
  wrong_numbers();
  incomplete_rows();
  requirements();
  return check_failed();
}
