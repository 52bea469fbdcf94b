/* test_canonical_pairs.c - canonical pairs against their definition, by brute force. Random points are
 * distributed over two "ranks" (one process takes the place of each; nodes and images of the other are remote
 * ghosts), and given to one that has all. All must have the same pairs, starting at the same ends. */
#include <stdlib.h>
#include <string.h>
#include "lib/connectivity/connectivity.h"
#include "tests/check.h"

enum { NODES = 60, FROZEN = 12, POINTS = 3 * NODES + FROZEN, ALL = 2 };

/* A node, one of its images at -1 and +1 along axis 0, or a frozen node. */
struct point {
  int64_t id, image;
  bool frozen;
  int owner; /* rank */
  double x[NDIM], search_radius;
};

static struct point point[POINTS];

static int by_hash(const void *a, const void *b) {
  const uint64_t p = (uint64_t) * (const int64_t *)a * 0x9e3779b97f4a7c15u,
                 q = (uint64_t) * (const int64_t *)b * 0x9e3779b97f4a7c15u;
  return (p > q) - (p < q);
}

/* Draws points whose ids are in random order. With the largest search radius a node reaches its own images.
 * */
static void draw(uint64_t seed, double search_radius) {
  int64_t id[NODES + FROZEN];
  for (int k = 0; k < NODES + FROZEN; ++k) id[k] = k + (int64_t)(seed % 7);
  qsort(id, NODES + FROZEN, sizeof *id, by_hash);
  for (int k = 0; k < NODES + FROZEN; ++k) {
    struct point p = {.id = id[k], .frozen = k >= NODES, .owner = check_random(&seed) < 0.5};
    for (int a = 0; a < NDIM; ++a) p.x[a] = check_random(&seed);
    p.search_radius = search_radius * (0.7 + 0.6 * check_random(&seed));
    point[k < NODES ? k : 2 * NODES + k] = p;
    for (int image = -1; k < NODES && image <= 1; image += 2) {
      struct point *q = &point[(image < 0 ? NODES : 2 * NODES) + k];
      *q = p;
      q->image = image, q->x[0] += image;
    }
  }
}

static bool near(const struct point *p, const struct point *q) {
  double d2 = 0;
  for (int a = 0; a < NDIM; ++a) d2 += (p->x[a] - q->x[a]) * (p->x[a] - q->x[a]);
  return d2 <= p->search_radius * p->search_radius || d2 <= q->search_radius * q->search_radius;
}

static bool is_node(const struct point *p) {
  return p->image == 0 && !p->frozen;
}

/* The definition of which end a pair starts at; one of the two points at least is a node. */
static bool should_start(const struct point *p, const struct point *q) {
  return is_node(p) && (!is_node(q) || p->id < q->id);
}

/* ---- a rank ---- */

struct rank {
  struct kith_nodes *nodes;
  struct kith_search *search;
  struct kith_connectivity *connectivity;
  int of[POINTS]; /* node -> point */
};

static void set_node(struct rank *r, kith_index i, int k) {
  for (int a = 0; a < NDIM; ++a) r->nodes->position->f64[(size_t)i * NDIM + a] = point[k].x[a];
  r->nodes->search_radius->f64[i] = r->nodes->support->f64[i] = point[k].search_radius;
  r->nodes->id->i64[i] = point[k].id;
  r->nodes->image->i64[i] = point[k].image;
  r->of[i] = k;
}

static bool is_ours(int k, int me) {
  return is_node(&point[k]) && (me == ALL || point[k].owner == me);
}

static void add_ghosts(struct rank *r, enum kith_ghost_kind kind, int begin, int end, int me) {
  kith_index n = 0, at = kith_nodes_count(r->nodes);
  for (int k = begin; k < end; ++k) n += !is_ours(k, me);
  const struct kith_ghost_block block = {.kind = kind, .count = n};
  CHECK_OK(kith_nodes_add_ghosts(r->nodes, &block));
  for (int k = begin; k < end; ++k)
    if (!is_ours(k, me)) set_node(r, at++, k);
}

/* Nodes are added from the last to the first, so that the order of indices is not that of ids. */
static void rank_make(struct rank *r, int me, struct kith_requirements need) {
  const char *const names[] = {"gas"};
  kith_index n = 0, first;
  *r = (struct rank){0};
  CHECK_OK(kith_nodes_create(&r->nodes, 1, names));
  CHECK_OK(kith_nodes_number_images(r->nodes));
  for (int k = 0; k < NODES; ++k) n += is_ours(k, me);
  CHECK_OK(kith_nodes_append(r->nodes, 0, n, &first));
  for (int k = NODES - 1, i = 0; k >= 0; --k)
    if (is_ours(k, me)) set_node(r, i++, k);
  const int early = me == 1 ? FROZEN / 2 : 0; /* on rank 1 half of the frozen nodes come first */
  add_ghosts(r, KITH_GHOST_FROZEN, 3 * NODES, 3 * NODES + early, me);
  add_ghosts(r, KITH_GHOST_REMOTE, 0, 3 * NODES, me);
  add_ghosts(r, KITH_GHOST_FROZEN, 3 * NODES + early, POINTS, me);
  ++r->nodes->positions;
  CHECK_OK(kith_search_create(&r->search, kith_search_find(me == 1 ? "tree" : "brute"), r->nodes));
  CHECK_OK(kith_search_update(r->search));
  CHECK_OK(kith_connectivity_create(&r->connectivity));
  CHECK_OK(kith_connectivity_build(r->connectivity, r->nodes, r->search, need, NULL, NULL));
  CHECK_OK(kith_connectivity_canonical(r->connectivity, r->nodes));
}

static void rank_clear(struct rank *r) {
  kith_connectivity_destroy(&r->connectivity);
  kith_search_destroy(&r->search);
  kith_nodes_destroy(&r->nodes);
}

/* ---- checks ---- */

/* found[k][l]: how often points k and l are a pair that starts at k. */
static uint8_t found[POINTS][POINTS];

static void count_pairs(const struct rank *r, const struct kith_pairs *pairs) {
  memset(found, 0, sizeof found);
  CHECK(r->connectivity->canonical && pairs->starts == kith_nodes_count(r->nodes));
  CHECK(pairs->first[0] == 0 && pairs->first[pairs->starts] == pairs->n);
  for (kith_index i = 0; i < pairs->starts; ++i)
    for (size_t p = pairs->first[i]; p < pairs->first[i + 1]; ++p) {
      CHECK(pairs->node[p][0] == i);
      ++found[r->of[i]][r->of[pairs->node[p][1]]];
    }
}

static bool before(const struct point *p, const struct point *q) {
  return p->id != q->id ? p->id < q->id : p->image < q->image;
}

/* Rows ascend, and each entry refers to its pair. */
static void check_rows(const struct rank *r, const struct kith_rows *rows, const struct kith_pairs *pairs) {
  for (kith_index i = 0; i < r->nodes->n_internal; ++i)
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
      const kith_index j = rows->node[e];
      const size_t p = pairs->of_row[e];
      const bool starts = should_start(&point[r->of[i]], &point[r->of[j]]);
      CHECK(e == rows->first[i] || before(&point[r->of[rows->node[e - 1]]], &point[r->of[j]]));
      CHECK(p < pairs->n && pairs->node[p][0] == (starts ? i : j) && pairs->node[p][1] == (starts ? j : i));
      CHECK((pairs->node[p][0] == i) == starts);
      if (pairs == &r->connectivity->pairs) CHECK(kith_pair_starts(r->connectivity, i, e) == starts);
    }
}

/* Each interaction of a node of this rank is there once, from the end that the definition says, and there are
 * no others. */
static void check_pairs(const struct rank *r, int me) {
  const struct kith_connectivity *c = r->connectivity;
  count_pairs(r, &c->pairs);
  check_rows(r, &c->rows, &c->pairs);
  size_t wanted = 0, ghosts = 0;
  for (int k = 0; k < POINTS; ++k)
    for (int l = 0; l < POINTS; ++l) {
      const bool here = is_ours(k, me) || is_ours(l, me);
      const bool pair = k != l && here && near(&point[k], &point[l]) && should_start(&point[k], &point[l]);
      CHECK(found[k][l] == pair);
      wanted += pair, ghosts += pair && !is_ours(k, me);
    }
  CHECK(c->pairs.n == wanted);
  CHECK((ghosts > 0) == (me != ALL)); /* else ghosts are not tested */
  CHECK(c->pairs.n - c->pairs.first[r->nodes->n_internal] == ghosts);
}

/* Overlapping supports are pairs once, from the same end on all ranks. */
static void check_overlap(uint8_t starts[POINTS][POINTS], int me) {
  const struct kith_requirements need = {.overlap_pairs = true, .ghost_rows = true};
  struct rank r;
  rank_make(&r, me, need);
  count_pairs(&r, &r.connectivity->overlap_pairs);
  check_rows(&r, &r.connectivity->overlap, &r.connectivity->overlap_pairs);
  for (int k = 0; k < POINTS; ++k)
    for (int l = 0; l < POINTS; ++l) {
      CHECK(found[k][l] <= should_start(&point[k], &point[l]));
      if (me == ALL) starts[k][l] = found[k][l];
      if (is_ours(k, me) || is_ours(l, me)) CHECK(found[k][l] == starts[k][l]);
    }
  rank_clear(&r);
}

int main(void) {
  static uint8_t starts[POINTS][POINTS];
  /* few partners; some; all, and images of the node itself */
  static const double search_radius[] = {0.05, 0.25, 1.1};
  const struct kith_requirements need = {.pairs = true};
  for (uint64_t seed = 1; seed <= 3; ++seed)
    for (int k = NDIM == 3; k < 3; ++k) {
      draw(seed, search_radius[k] * (NDIM == 1 ? 1 : 1.5));
      for (int me = ALL; me >= 0; --me) {
        struct rank r;
        rank_make(&r, me, need);
        check_pairs(&r, me);
        rank_clear(&r);
        check_overlap(starts, me);
      }
    }
  return check_failed();
}
