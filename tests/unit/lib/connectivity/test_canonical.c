/* test_canonical.c - what makes runs independent of ranks, here on one process: numbered images (oracle: the
 * reflected or shifted position), rows in canonical order (oracle: sorted ids, and the partners of rows in
 * index order), bitwise identical runs with every search, and nodes gathered by id. */
#include <omp.h>
#include "lib/nodes/migrate.h"
#include "tests/unit/scenario.h"

static const char box[] =
    "scene: box\n"
    "dimension: 3\n"
    "resolution: {1d: 30, 2d: 10, 3d: 6}\n"
    "domain: {lower: [0, 0, 0], upper: [1, 0.12, 1]}\n"
    "boundaries: {x: periodic, y: reflecting, z: periodic}\n"
    "materials: {gas: {gamma: 1.4}, other: {gamma: 1.6666666666666667}}\n"
    "regions:\n"
    "  - {material: other, where: {x: [0, 0.5]}, jitter: 0.3, seed: 5, lattice: cubic, density: 1,\n"
    "     pressure: 0.1}\n"
    "  - {material: gas, where: {x: [0.5, 1]}, jitter: 0.3, seed: 6, lattice: cubic, density: 1,\n"
    "     pressure: 0.2}\n"
    "until: 1\n";

/* Decodes the number of periods or reflections along an axis: `image` is three digits of base 2^16, each in
 * -2^15 .. 2^15 - 1. */
static int digit(int64_t image, int axis) {
  for (int a = 0; a < axis; ++a) image = (image - (int16_t)(image & 0xffff)) / 65536;
  return (int16_t)(image & 0xffff);
}

/* Returns the position of image n of a node at x (see boundary.h): shifted along periodic axes, reflected if
 * n is odd along the others. */
static double image_position(double x, int n, int axis) {
  const double upper = axis == 1 ? 0.12 : 1;
  return axis != 1 || n % 2 == 0 ? x + n * upper : upper - x + n * upper;
}

/* Every ghost is where its image number says, and only nodes have number 0. */
static void images_are_numbered(const struct scenario *s) {
  const struct kith_nodes *nodes = s->simulation->nodes;
  int64_t most;
  kith_index *place = scenario_indices(s, &most);
  for (kith_index g = 0; g < kith_nodes_count(nodes); ++g) {
    const kith_index i = place[nodes->id->i64[g]];
    CHECK((nodes->image->i64[g] == 0) == (g < nodes->n_internal));
    for (int a = 0; a < NDIM; ++a) {
      const double x = nodes->position->f64[(size_t)i * NDIM + a];
      const double wanted = image_position(x, digit(nodes->image->i64[g], a), a);
      CHECK_CLOSE(nodes->position->f64[(size_t)g * NDIM + a], wanted, 1e-14); /* a few roundings of 1 */
    }
  }
  free(place);
}

static bool before(const struct kith_nodes *nodes, kith_index j, kith_index k) {
  if (nodes->id->i64[j] != nodes->id->i64[k]) return nodes->id->i64[j] < nodes->id->i64[k];
  return nodes->image->i64[j] < nodes->image->i64[k];
}

/* Rows ascend by id and image. test_canonical_pairs.c tests pairs. */
static void rows_are_in_order(const struct scenario *s) {
  const struct kith_connectivity *c = s->simulation->connectivity;
  for (kith_index i = 0; i < s->simulation->nodes->n_internal; ++i)
    for (size_t e = c->rows.first[i]; e < c->rows.first[i + 1]; ++e) {
      const kith_index j = c->rows.node[e];
      CHECK(e == c->rows.first[i] || before(s->simulation->nodes, c->rows.node[e - 1], j));
    }
}

/* Rows in canonical order have the partners of rows in index order. */
static void same_partners(const struct scenario *plain, const struct scenario *ordered) {
  const struct kith_rows *a = &plain->simulation->connectivity->rows,
                         *b = &ordered->simulation->connectivity->rows;
  int64_t most;
  kith_index *place = scenario_indices(plain, &most);
  for (kith_index i = 0; i < ordered->simulation->nodes->n_internal; ++i) {
    const kith_index k = place[ordered->simulation->nodes->id->i64[i]];
    int64_t sum = 0; /* equal sums of ids and of their squares mean equal sets */
    for (size_t e = b->first[i]; e < b->first[i + 1]; ++e) {
      const int64_t id = ordered->simulation->nodes->id->i64[b->node[e]];
      sum += id + id * id * 1000003;
    }
    for (size_t e = a->first[k]; e < a->first[k + 1]; ++e) {
      const int64_t id = plain->simulation->nodes->id->i64[a->node[e]];
      sum -= id + id * id * 1000003;
    }
    CHECK(sum == 0 && a->first[k + 1] - a->first[k] == b->first[i + 1] - b->first[i]);
  }
  free(place);
}

static void canonical_order(const char *settings) {
  struct scenario plain = {0}, ordered = {0};
  if (scenario_open(&plain, box, "%s", settings) &&
      scenario_open(&ordered, box, "reproducible=true %s", settings)) {
    CHECK_OK(scenario_start(&plain));
    CHECK_OK(scenario_start(&ordered));
    images_are_numbered(&ordered);
    rows_are_in_order(&ordered);
    same_partners(&plain, &ordered);
    scenario_close(&ordered);
  }
  scenario_close(&plain);
}

static void identical_with(const char *settings) {
  static const char *const searches[] = {"grid", "spacetree", "brute"};
  struct scenario tree = {0}, other = {0};
  if (scenario_open(&tree, box, "reproducible=true neighbor.search=tree %s", settings) &&
      scenario_run(&tree, 3))
    for (int k = 0; k < 3; ++k) {
      omp_set_num_threads(1 + k);
      if (scenario_open(&other, box, "reproducible=true neighbor.search=%s %s", searches[k], settings) &&
          scenario_run(&other, 3))
        scenario_identical(&tree, &other, searches[k]);
      scenario_close(&other);
    }
  scenario_close(&tree);
}

/* All searches and numbers of threads are bitwise identical. */
static void identical_for_all_searches(void) {
  identical_with("traversal=gather");
  identical_with("traversal=pairs");
  identical_with("traversal=gather method.package=mfm");
  identical_with("method.package=mfm method.faces=integrated resolution=4");
  identical_with("scheme.name=arkode method.energy=thermal");
}

/* Gathered nodes are sorted by list and id, and have their values. */
static void gathered_by_id(void) {
  struct scenario s = {0};
  struct kith_nodes *whole = NULL;
  if (scenario_open(&s, box, "%s", "") && scenario_run(&s, 1)) {
    const struct kith_nodes *nodes = s.simulation->nodes;
    int64_t most;
    kith_index *place = scenario_indices(&s, &most);
    CHECK_OK(kith_nodes_by_id(nodes, &whole));
    CHECK(whole->n_internal == nodes->n_internal && whole->n_ghost == 0);
    for (int l = 0; l < nodes->n_lists; ++l) CHECK(whole->lists[l].count == nodes->lists[l].count);
    const struct kith_field *mass = kith_nodes_field_named(whole, "mass");
    for (kith_index i = 0; i < whole->n_internal; ++i) {
      const kith_index k = place[whole->id->i64[i]];
      CHECK(i == 0 || whole->list->u8[i] > whole->list->u8[i - 1] ||
            whole->id->i64[i] > whole->id->i64[i - 1]);
      CHECK(whole->list->u8[i] == nodes->list->u8[k] && mass->f64[i] == s.simulation->hydro.mass->f64[k]);
      CHECK(memcmp(whole->position->f64 + (size_t)i * NDIM, nodes->position->f64 + (size_t)k * NDIM,
                   NDIM * sizeof(double)) == 0);
    }
    kith_nodes_destroy(&whole);
    free(place);
  }
  scenario_close(&s);
}

/* Without numbers of images there is no canonical order. */
static void refusals(void) {
  struct scenario s = {0};
  if (scenario_open(&s, box, "%s", "")) {
    CHECK_OK(scenario_start(&s));
    CHECK_STATUS(KITH_INTERNAL, kith_connectivity_canonical(s.simulation->connectivity, s.simulation->nodes));
  }
  scenario_close(&s);
}

int main(void) {
  canonical_order("traversal=pairs");
  canonical_order("traversal=gather");
  canonical_order("method.package=mfm");
  canonical_order("connectivity.cull=false");
  identical_for_all_searches();
  gathered_by_id();
  refusals();
  return check_failed();
}
