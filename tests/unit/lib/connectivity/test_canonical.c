/* What does not depend on ranks: numbered images, rows in canonical order, all nodes by id. On one
 * process. */
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

/* The image along an axis that a number stands for: digits of -2^15 .. 2^15 - 1. */
static int digit(int64_t image, int axis) {
  for (int a = 0; a < axis; ++a) image = (image - (int16_t)(image & 0xffff)) / 65536;
  return (int16_t)(image & 0xffff);
}

/* Where image n of a node at x is: the unfolded line of boundary.h. */
static double place_of(double x, int n, int axis) {
  const double upper = axis == 1 ? 0.12 : 1;
  return axis != 1 || n % 2 == 0 ? x + n * upper : upper - x + n * upper;
}

/* Every ghost is where its number says; no two partners have the same id and number. */
static void images_are_numbered(const struct scenario *s) {
  const struct kith_nodes *nodes = s->simulation->nodes;
  int64_t most;
  kith_index *place = scenario_places(s, &most);
  for (kith_index g = 0; g < kith_nodes_count(nodes); ++g) {
    const kith_index i = place[nodes->id->i64[g]];
    CHECK((nodes->image->i64[g] == 0) == (g < nodes->n_internal));
    for (int a = 0; a < NDIM; ++a) {
      const double x = nodes->position->f64[(size_t)i * NDIM + a];
      const double wanted = place_of(x, digit(nodes->image->i64[g], a), a);
      CHECK_CLOSE(nodes->position->f64[(size_t)g * NDIM + a], wanted, 1e-14); /* round-off of a few lengths */
    }
  }
  free(place);
}

static bool before(const struct kith_nodes *nodes, kith_index j, kith_index k) {
  if (nodes->id->i64[j] != nodes->id->i64[k]) return nodes->id->i64[j] < nodes->id->i64[k];
  return nodes->image->i64[j] < nodes->image->i64[k];
}

/* In order, and each entry knows its pair, which starts at the lower id (images follow their node). */
static void rows_are_in_order(const struct scenario *s) {
  const struct kith_connectivity *c = s->simulation->connectivity;
  for (kith_index i = 0; i < s->simulation->nodes->n_internal; ++i)
    for (size_t e = c->rows.first[i]; e < c->rows.first[i + 1]; ++e) {
      const kith_index j = c->rows.node[e];
      CHECK(e == c->rows.first[i] || before(s->simulation->nodes, c->rows.node[e - 1], j));
      if (!c->built.pairs) continue;
      const kith_index *pair = c->pairs.node[c->pairs.of_row[e]];
      const bool ghost = j >= s->simulation->nodes->n_internal,
                 starts = ghost || before(s->simulation->nodes, i, j);
      CHECK(pair[0] == (starts ? i : j) && pair[1] == (starts ? j : i));
    }
}

/* The same partners as rows by index have. */
static void same_partners(const struct scenario *plain, const struct scenario *ordered) {
  const struct kith_rows *a = &plain->simulation->connectivity->rows,
                         *b = &ordered->simulation->connectivity->rows;
  int64_t most;
  kith_index *place = scenario_places(plain, &most);
  for (kith_index i = 0; i < ordered->simulation->nodes->n_internal; ++i) {
    const kith_index k = place[ordered->simulation->nodes->id->i64[i]];
    int64_t sum = 0; /* of ids and their squares: the same set, for all purposes */
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

static void order(const char *settings) {
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

static void same_with(const char *settings) {
  static const char *const searches[] = {"grid", "spacetree", "brute"};
  struct scenario tree = {0}, other = {0};
  if (scenario_open(&tree, box, "reproducible=true neighbor.search=tree %s", settings) &&
      scenario_run(&tree, 3))
    for (int k = 0; k < 3; ++k) {
      omp_set_num_threads(1 + k);
      if (scenario_open(&other, box, "reproducible=true neighbor.search=%s %s", searches[k], settings) &&
          scenario_run(&other, 3))
        scenario_same(&tree, &other, searches[k]);
      scenario_close(&other);
    }
  scenario_close(&tree);
}

/* Any search and number of threads, the same bits. */
static void same_for_all_searches(void) {
  same_with("");
  same_with("traversal=pairs");
  same_with("traversal=gather method.package=mfm");
  same_with("method.package=mfm method.faces=integrated resolution=4");
  same_with("scheme.name=arkode method.energy=thermal");
}

/* All nodes, list by list, by id, with their values; also when they were reordered. */
static void by_id(void) {
  struct scenario s = {0};
  struct kith_nodes *whole = NULL;
  if (scenario_open(&s, box, "%s", "") && scenario_run(&s, 1)) {
    const struct kith_nodes *nodes = s.simulation->nodes;
    int64_t most;
    kith_index *place = scenario_places(&s, &most);
    CHECK_OK(kith_nodes_by_id(nodes, 1, &whole));
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

/* Images without numbers have no order. */
static void refusals(void) {
  struct scenario s = {0};
  if (scenario_open(&s, box, "%s", "")) {
    CHECK_OK(scenario_start(&s));
    CHECK_STATUS(KITH_INTERNAL, kith_connectivity_canonical(s.simulation->connectivity, s.simulation->nodes));
  }
  scenario_close(&s);
}

int main(void) {
  order("traversal=pairs");
  order("");
  order("method.package=mfm");
  order("connectivity.cull=false");
  same_for_all_searches();
  by_id();
  refusals();
  return check_failed();
}
