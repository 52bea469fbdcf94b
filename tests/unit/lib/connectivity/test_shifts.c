/* test_shifts.c - periodic images as shifts of row entries. Oracles: loops over all images of all nodes, for
 * rows, pairs, half lists, overlap and intersection, in boxes of 0.4 to 3 supports; and the same nodes with
 * images as ghosts. */
#include <omp.h>

#include "boundaries/boundary.h"
#include "lib/connectivity/list.h"
#include "tests/unit/oracle.h"

/* Adds a periodic boundary whose images are as `settings` say, or ghosts if they are NULL. */
static void add_periodic(struct kith_boundaries *all, int axis, double length, void *settings) {
  CHECK_OK(kith_boundaries_add(all, &kith_boundary_periodic, axis, 0, length, true, true));
  all->boundary[all->n - 1]->settings = settings;
}

static void *shifts_settings(void) {
  void *settings;
  CHECK_OK(
      kith_settings_create(&settings, kith_family_member(kith_boundary_member, "periodic"), "images=shifts"));
  return settings;
}

/* --- the oracle: all images of all nodes --- */

struct image {
  kith_index node;
  int lengths[NDIM];
  double x[NDIM];
};
struct images {
  const struct kith_nodes *nodes;
  int n;
  struct image *image;
};

/* Lists images one length beyond the shifts along each axis, sorted as rows are: by node, then along the last
 * axis, ..., the first. */
static struct images all_images(const struct kith_nodes *nodes, const double *length) {
  int each = 1, wide[NDIM];
  for (int a = 0; a < NDIM; ++a) each *= wide[a] = 2 * nodes->shifts.most[a] + 3;
  struct images all = {nodes, each * nodes->n_internal, NULL};
  all.image = calloc((size_t)all.n, sizeof *all.image);
  for (int v = 0; v < all.n; ++v) {
    struct image *image = &all.image[v];
    image->node = v / each;
    for (int a = 0, rest = v % each; a < NDIM; rest /= wide[a++]) {
      image->lengths[a] = rest % wide[a] - wide[a] / 2;
      image->x[a] = nodes->position->f64[image->node * NDIM + a] + image->lengths[a] * length[a];
    }
  }
  return all;
}

static bool unmoved(const struct image *p) {
  for (int a = 0; a < NDIM; ++a)
    if (p->lengths[a] != 0) return false;
  return true;
}
static bool same_image(const struct image *p, const struct image *q) {
  return p->node == q->node && memcmp(p->lengths, q->lengths, sizeof p->lengths) == 0;
}
/* Is q within the support of p? */
static bool supports(const struct images *all, const struct image *p, const struct image *q) {
  const double r = all->nodes->search_radius->f64[p->node];
  double d2 = 0;
  for (int a = 0; a < NDIM; ++a) d2 += (p->x[a] - q->x[a]) * (p->x[a] - q->x[a]);
  return d2 <= r * r;
}
static bool neighbors(const struct images *all, const struct image *p, const struct image *q) {
  return !same_image(p, q) && (supports(all, p, q) || supports(all, q, p)) &&
         (kith_node_active(all->nodes, p->node) || kith_node_active(all->nodes, q->node));
}
static bool overlap(const struct images *all, const struct image *p, const struct image *q) {
  if (same_image(p, q)) return false;
  for (int v = 0; v < all->n; ++v)
    if (supports(all, p, &all->image[v]) && supports(all, q, &all->image[v])) return true;
  return neighbors(all, p, q);
}
static bool between(const struct image *p, const struct image *q, const struct image *k) {
  double from_p = 0, from_q = 0;
  for (int a = 0; a < NDIM; ++a) {
    from_p += (k->x[a] - p->x[a]) * (q->x[a] - p->x[a]);
    from_q += (k->x[a] - q->x[a]) * (p->x[a] - q->x[a]);
  }
  return from_p > 0 && from_q > 0;
}

static bool is_entry(const struct kith_nodes *nodes, const struct kith_rows *rows, size_t e,
                     const struct image *image) {
  const struct kith_shifts *s = &nodes->shifts;
  int number = 0;
  for (int a = NDIM - 1; a >= 0; --a) number = number * (2 * s->most[a] + 1) + image->lengths[a] + s->most[a];
  return rows->node[e] == image->node && kith_row_shift(rows, e) == number;
}

/* Checks that row r holds exactly the images that satisfy the predicate of `v`, in order. */
#define CHECK_ROW(all, rows, r, v, predicate)                                              \
  do {                                                                                     \
    size_t e_ = (rows)->first[r];                                                          \
    bool same_ = true;                                                                     \
    for (int m_ = 0; m_ < (all)->n; ++m_) {                                                \
      const struct image *v = &(all)->image[m_];                                           \
      if (!(predicate)) continue;                                                          \
      same_ = same_ && e_ < (rows)->first[(r) + 1] && is_entry((all)->nodes, rows, e_, v); \
      ++e_;                                                                                \
    }                                                                                      \
    CHECK(same_ &&e_ == (rows)->first[(r) + 1]);                                           \
  } while (0)

static const struct image *find(const struct images *all, kith_index node, const int *lengths) {
  struct image wanted = {.node = node};
  int v = 0;
  if (lengths != NULL) memcpy(wanted.lengths, lengths, sizeof wanted.lengths);
  while (!same_image(&all->image[v], &wanted)) ++v;
  return &all->image[v];
}

/* Counts interactions: each is found twice, once from each end. */
static size_t count_interactions(const struct images *all) {
  size_t twice = 0;
  for (kith_index i = 0; i < all->nodes->n_internal; ++i)
    for (int v = 0; v < all->n; ++v) twice += neighbors(all, find(all, i, NULL), &all->image[v]);
  CHECK(twice % 2 == 0);
  return twice / 2;
}

static void check_pairs(const struct images *all, const struct kith_connectivity *c) {
  const struct kith_shifts *s = &all->nodes->shifts;
  CHECK(c->pairs.n == count_interactions(all));
  for (size_t p = 0; p < c->pairs.n; ++p) {
    const struct image *i = find(all, c->pairs.node[p][0], NULL);
    int lengths[NDIM], rest = c->pairs.shift[p];
    for (int a = 0; a < NDIM; rest /= 2 * s->most[a++] + 1)
      lengths[a] = rest % (2 * s->most[a] + 1) - s->most[a];
    const struct image *j = find(all, c->pairs.node[p][1], lengths);
    CHECK(neighbors(all, i, j));
    if (!c->built.intersection) continue;
    const struct kith_field *barriers = c->built.barriers;
    const bool ends_alone = barriers != NULL && (barriers->u8[i->node] || barriers->u8[j->node]);
    CHECK_ROW(all, &c->intersection, p, k,
              same_image(k, i) || same_image(k, j) ||
                  (!ends_alone && neighbors(all, i, k) && neighbors(all, j, k) &&
                   (!c->built.on_segment || between(i, j, k))));
  }
  for (kith_index i = 0; i < c->rows.n; ++i) /* an entry at each end that is not a ghost */
    for (size_t e = c->rows.first[i]; e < c->rows.first[i + 1]; ++e) {
      const size_t p = c->pairs.of_row[e];
      const int here = kith_row_shift(&c->rows, e);
      const bool starts = kith_pair_starts(c, i, e);
      CHECK(c->pairs.node[p][starts ? 0 : 1] == i && c->pairs.node[p][starts ? 1 : 0] == c->rows.node[e]);
      CHECK(c->pairs.shift[p] == (starts ? here : 2 * s->zero - here));
    }
}

/* Lists, full and half, have as many entries as rows and pairs; compressed ones refuse shifts. */
static void check_lists(const struct images *all, const struct kith_connectivity *c) {
  struct kith_search *search;
  CHECK_OK(kith_search_create(&search, kith_search_find("tree"), all->nodes));
  for (int half = 0; half < 3; ++half) {
    struct kith_excluder self;
    struct kith_list *list;
    enum kith_rebuild_reason why;
    struct kith_list_spec spec = kith_list_spec_among(all->nodes, search, &self, NULL);
    spec.storage = half == 0 ? "csr" : half == 1 ? "half" : "compressed";
    CHECK_OK(kith_list_create(&list, &spec));
    if (half == 2) {
      CHECK(kith_list_update(list, &why) == KITH_UNSUPPORTED && strstr(kith_failure(), "image shifts"));
    } else {
      CHECK_OK(kith_list_update(list, &why));
      CHECK(list->stored.rows.first[list->n_targets] == (half ? c->pairs.n : c->rows.first[c->rows.n]));
    }
    kith_list_destroy(&list);
  }
  kith_search_destroy(&search);
}

static void check_connectivity(const struct images *all, const struct kith_connectivity *c) {
  for (kith_index i = 0; i < all->nodes->n_internal; ++i) {
    const struct image *self = find(all, i, NULL);
    CHECK(unmoved(self));
    CHECK_ROW(all, &c->rows, i, v, neighbors(all, self, v));
    if (c->built.overlap) CHECK_ROW(all, &c->overlap, i, v, overlap(all, self, v));
  }
  check_pairs(all, c);
}

/* Box lengths are in units of the support, on all axes (b < 4) or on the first one; then the others are 3. */
static void thin_boxes(void) {
  static const double supports[] = {0.4, 1, 1.5, 3};
  static const struct kith_field_spec spec = {"barrier", KITH_SCALAR, KITH_U8, KITH_STATE, NULL, "1: a wall"};
  const struct kith_requirements need = {.rows = true, .overlap_pairs = true, .intersection = true};
  void *settings = shifts_settings();
  uint64_t state = 5;
  for (int b = 0; b < 8; ++b) {
    const int thin = b % 4, count[] = {thin == 3 ? 10 : b < 4 ? 2 + thin : 6};
    struct kith_nodes *nodes = oracle_random(1, count, 1 / 1.2, 1.2, &state);
    struct kith_boundaries boundaries = {0};
    struct kith_field *barrier;
    double length[NDIM];
    CHECK_OK(kith_nodes_field(nodes, &spec, &barrier));
    for (kith_index i = 0; i < count[0]; ++i) barrier->u8[i] = i % 3 == 1;
    nodes->shifts.wanted = true;
    if (b % 3 == 1) CHECK_OK(kith_nodes_mark_activity(nodes));
    for (int a = 0; a < NDIM; ++a) {
      length[a] = a == 0 || b < 4 ? supports[thin] : 3;
      add_periodic(&boundaries, a, length[a], settings);
      for (kith_index i = 0; i < count[0]; ++i) nodes->position->f64[i * NDIM + a] *= length[a];
    }
    for (kith_index i = 0; nodes->activity != NULL && i < count[0]; ++i)
      nodes->activity->u8[i] = i % 2 ? KITH_ACTIVE : KITH_IDLE;
    CHECK_OK(kith_boundaries_ghosts(&boundaries, nodes, 2, NULL));
    CHECK(nodes->n_ghost == 0 && nodes->shifts.n > 1);
    struct images all = all_images(nodes, length);
    struct kith_requirements these = need;
    if (nodes->activity != NULL) these = (struct kith_requirements){.pairs = true}; /* as with idle nodes */
    these.on_segment = these.intersection && b % 2;
    if (these.intersection && b % 4 > 1) these.barriers = barrier;
    for (const struct kith_search_ops *const *ops = kith_search_all(); *ops; ++ops) {
      if (NDIM == 3 && (ops - kith_search_all()) % 2 != b / 2 % 2) continue; /* half of them, to save time */
      omp_set_num_threads(1 + b % 3);
      struct kith_connectivity *c = oracle_build(nodes, *ops, these, NULL);
      check_connectivity(&all, c);
      if (nodes->activity == NULL) check_lists(&all, c);
      kith_connectivity_destroy(&c);
    }
    free(all.image);
    kith_boundaries_clear(&boundaries);
    kith_nodes_destroy(&nodes);
  }
  kith_free(&settings);
}

/* In a lattice of 2 cells with R = h every node has 2 NDIM neighbors: each partner counts twice, as two
 * images. In one of 1 cell all neighbors are images of the node itself, in NDIM pairs. */
static void thin_lattices(void) {
  void *settings = shifts_settings();
  for (int cells = 1; cells <= 2; ++cells) {
    struct kith_nodes *nodes = oracle_lattice(1, cells, 1.0 / cells);
    struct kith_boundaries boundaries = {0};
    nodes->shifts.wanted = true;
    for (int a = 0; a < NDIM; ++a) add_periodic(&boundaries, a, 1, settings);
    CHECK_OK(kith_boundaries_ghosts(&boundaries, nodes, 1, NULL));
    struct kith_connectivity *c =
        oracle_build(nodes, kith_search_find("tree"), (struct kith_requirements){.pairs = true}, NULL);
    for (kith_index i = 0; i < nodes->n_internal; ++i)
      CHECK(c->rows.first[i + 1] - c->rows.first[i] == 2 * NDIM);
    CHECK(c->pairs.n == (size_t)(NDIM * nodes->n_internal));
    kith_connectivity_destroy(&c);
    kith_boundaries_clear(&boundaries);
    kith_nodes_destroy(&nodes);
  }
  kith_free(&settings);
}

/* --- against ghosts --- */

/* Each axis is open, periodic with ghosts, periodic with shifts or reflecting; `ghosts` turns shifts into
 * ghosts. */
static struct kith_nodes *mixed_boundaries(int kinds, bool ghosts, void *settings,
                                           struct kith_connectivity **c) {
  const int count[3] = {9, 0, 4};
  uint64_t state = 23 + (uint64_t)kinds;
  struct kith_nodes *nodes = oracle_random(3, count, 0.3, 2, &state);
  struct kith_boundaries boundaries = {0};
  struct kith_requirements need = {.pairs = true, .overlap_pairs = true, .ghost_rows = kinds % 2};
  nodes->shifts.wanted = !ghosts;
  CHECK_OK(kith_nodes_number_images(nodes));
  for (int a = 0; a < NDIM; ++a, kinds /= 4)
    if (kinds % 4 == 3)
      CHECK_OK(kith_boundaries_add(&boundaries, &kith_boundary_reflecting, a, 0, 1, true, true));
    else if (kinds % 4 > 0)
      add_periodic(&boundaries, a, 1, kinds % 4 == 2 ? settings : NULL);
  CHECK_OK(kith_boundaries_ghosts(&boundaries, nodes, 2, NULL));
  *c = oracle_build(nodes, kith_search_find("grid"), need, NULL);
  CHECK_OK(kith_connectivity_canonical(*c, nodes));
  kith_boundaries_clear(&boundaries);
  return nodes;
}

struct side {
  const struct kith_nodes *nodes;
  const struct kith_rows *rows;
  const struct kith_pairs *pairs;
};
static void check_equal(const struct side *g, const struct side *s) {
  CHECK(g->pairs->n == s->pairs->n);
  for (kith_index i = 0; i < g->nodes->n_internal; ++i) {
    CHECK(g->rows->first[i + 1] == s->rows->first[i + 1] && g->pairs->first[i + 1] == s->pairs->first[i + 1]);
    if (g->rows->first[i + 1] != s->rows->first[i + 1]) return;
    for (size_t e = g->rows->first[i]; e < g->rows->first[i + 1]; ++e) {
      const kith_index j = g->rows->node[e], k = s->rows->node[e];
      const int64_t by = s->rows->shift != NULL ? s->nodes->shifts.image[s->rows->shift[e]] : 0;
      CHECK(g->nodes->id->i64[j] == s->nodes->id->i64[k] &&
            g->nodes->image->i64[j] == s->nodes->image->i64[k] + by);
      CHECK(g->pairs->of_row[e] == s->pairs->of_row[e]);
    }
  }
}

/* In canonical order rows, overlap and their pairs must be equal with ghosts and with shifts. */
static void against_ghosts(void) {
  void *settings = shifts_settings();
  int kinds = 1;
  for (int a = 0; a < NDIM; ++a) kinds *= 4;
  for (int k = 0; k < kinds; ++k) {
    struct kith_connectivity *c[2];
    struct kith_nodes *nodes[2] = {mixed_boundaries(k, true, settings, &c[0]),
                                   mixed_boundaries(k, false, settings, &c[1])};
    for (int over = 0; over < 2; ++over) {
      struct side side[2];
      for (int m = 0; m < 2; ++m)
        side[m] = (struct side){nodes[m], over ? &c[m]->overlap : &c[m]->rows,
                                over ? &c[m]->overlap_pairs : &c[m]->pairs};
      check_equal(&side[0], &side[1]);
    }
    for (int m = 0; m < 2; ++m) kith_connectivity_destroy(&c[m]), kith_nodes_destroy(&nodes[m]);
  }
  kith_free(&settings);
}

/* More images than an entry can number are refused; a connectivity is stale after its shifts have changed. */
static void refusals(void) {
  struct kith_shifts shifts = {0};
  kith_shifts_drop(&shifts);
  CHECK(kith_shifts_add(&shifts, 0, 32768, 1) == KITH_DIVERGED && strstr(kith_failure(), "65537"));
  kith_shifts_clear(&shifts);
  void *settings = shifts_settings();
  struct kith_nodes *nodes = oracle_lattice(1, 2, 0.5);
  struct kith_boundaries boundaries = {0};
  nodes->shifts.wanted = true;
  add_periodic(&boundaries, 0, 1, settings);
  CHECK_OK(kith_boundaries_ghosts(&boundaries, nodes, 1, NULL));
  struct kith_connectivity *c =
      oracle_build(nodes, kith_search_find("tree"), (struct kith_requirements){.rows = true}, NULL);
  CHECK_OK(kith_connectivity_fresh(c, nodes));
  nodes->search_radius->f64[0] = 1.5;
  CHECK_OK(kith_boundaries_ghosts(&boundaries, nodes, 1, NULL));
  CHECK(kith_connectivity_fresh(c, nodes) == KITH_STALE);
  nodes->search_radius->f64[0] = 1e4;
  CHECK(kith_boundaries_ghosts(&boundaries, nodes, 1, NULL) == KITH_DIVERGED);
  kith_connectivity_destroy(&c);
  kith_boundaries_clear(&boundaries);
  kith_nodes_destroy(&nodes);
  kith_free(&settings);
}

int main(void) {
  thin_boxes();
  thin_lattices();
  against_ghosts();
  refusals();
  return check_failed();
}
