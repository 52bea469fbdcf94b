/* test_coupling.c - coupling of pairs through barriers. Oracles: factors as sums over all nodes; pairs that a
 * barrier cuts against a search that excludes them from the start; a disturbance on one side of a plate,
 * which must not change a bit on the other side; and a plate against a reflecting wall. */
#include "lib/connectivity/connectivity.h"
#include "tests/unit/scenario.h"
#include "tests/unit/oracle.h"

/* ---- the factor of a pair, as a sum over all nodes ---- */

struct rule {
  const struct kith_field *barrier, *damage; /* damage NULL: barriers have damage 1, all others 0 */
  double thickness;
};

static double damage_of(const struct rule *rule, kith_index k) {
  return rule->damage != NULL ? rule->damage->f64[k] : rule->barrier->u8[k];
}

/* Whether k is i or j, or a neighbor of both that lies between them: its projection on the line through i and
 * j is between these, and its distance from the line, by Pythagoras, is below the thickness. */
static bool on_the_way(const struct rule *rule, const struct kith_nodes *nodes, kith_index i, kith_index j,
                       kith_index k) {
  const double *x = nodes->position->f64;
  double ik2 = 0, ij2 = 0, dot = 0;
  if (k == i || k == j) return true;
  if (!oracle_near(nodes, NULL, i, k) || !oracle_near(nodes, NULL, j, k)) return false;
  for (int a = 0; a < NDIM; ++a) {
    const double p = x[k * NDIM + a] - x[i * NDIM + a], e = x[j * NDIM + a] - x[i * NDIM + a];
    ik2 += p * p, ij2 += e * e, dot += p * e;
  }
  const double radius = rule->thickness * nodes->support->f64[k];
  return dot > 0 && dot < ij2 && ik2 - dot * dot / ij2 < radius * radius;
}

/* Equation (1) of connectivity.h; -1 if a barrier cuts the pair. */
static double factor_of(const struct rule *rule, const struct kith_nodes *nodes, kith_index i, kith_index j) {
  double n = 0, sum = 0;
  if (rule->barrier->u8[i] || rule->barrier->u8[j]) return 1;
  for (kith_index k = 0; k < kith_nodes_count(nodes); ++k) {
    if (!on_the_way(rule, nodes, i, j, k)) continue;
    if (rule->barrier->u8[k] && damage_of(rule, k) == 1) return -1;
    n += 1, sum += 1 / (1 - damage_of(rule, k));
  }
  return n / sum;
}

static bool crosses(const struct kith_excluder *excluder, const struct kith_candidate *c) {
  return factor_of(excluder->context, c->sources->nodes, c->i, c->j) < 0;
}
static const struct kith_excluder_ops crossing = {
    .name = "crossing", .phase = KITH_NARROW, .reject = crosses};

/* Compares all factors, of which some must be 0, some 1 and some between. */
static void check_factors(const struct kith_connectivity *c, const struct kith_nodes *nodes,
                          const struct rule *rule) {
  const double *factor = kith_connectivity_factors(&c->pairs);
  size_t none = 0, all = 0, part = 0;
  CHECK((factor != NULL) == (rule->damage != NULL));
  for (size_t p = 0; factor != NULL && p < c->pairs.n; ++p) {
    CHECK_CLOSE(factor[p], factor_of(rule, nodes, c->pairs.node[p][0], c->pairs.node[p][1]), 1e-6);
    CHECK(factor[p] >= 0 && factor[p] <= 1);
    none += factor[p] == 0, all += factor[p] == 1, part += factor[p] > 0 && factor[p] < 1;
  }
  CHECK(factor == NULL || (none > 0 && all > 0 && part > 0));
}

/* Nodes of list 1 are barriers. With damage, barriers and nodes are sound, partly damaged or broken. idle:
 * half of the nodes are. Returns the number of pairs that are cut. */
static size_t check_coupling(uint64_t seed, bool on_segment, bool damaged, bool idle) {
  const struct kith_field_spec spec = {"barrier", KITH_SCALAR, KITH_U8, KITH_STATE, NULL, "1: a wall"},
                               other = {"damage", KITH_SCALAR, KITH_F64, KITH_STATE, NULL, "D"};
  const struct kith_requirements need = {
      .rows = true, .pairs = true, .ghost_rows = !idle, .intersection = true, .on_segment = on_segment};
  const int count[2] = {30, 12};
  struct kith_nodes *nodes = oracle_random(2, count, NDIM == 1 ? 0.12 : 0.3, 1.8, &seed);
  struct rule rule = {.thickness = 0.4};
  struct kith_field *barrier, *damage = NULL;
  CHECK_OK(kith_nodes_field(nodes, &spec, &barrier));
  if (damaged) CHECK_OK(kith_nodes_field(nodes, &other, &damage));
  rule.barrier = barrier, rule.damage = damage;
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    nodes->support->f64[i] = nodes->search_radius->f64[i];
    barrier->u8[i] = nodes->list->u8[i] == 1;
    if (damaged) damage->f64[i] = i % 4 == 0 ? 1 : barrier->u8[i] ? 0.75 : i % 4 == 1 ? 0.01 * i : 0;
  }
  CHECK_OK(kith_nodes_number_images(nodes));
  if (idle) {
    CHECK_OK(kith_nodes_mark_activity(nodes));
    for (kith_index i = 0; i < nodes->n_internal; ++i)
      nodes->activity->u8[i] = check_random(&seed) < 0.5 ? KITH_ACTIVE : KITH_IDLE;
  }
  oracle_ghosts(nodes, 0, false, 0.4);
  struct kith_connectivity *c = oracle_build(nodes, kith_search_find("tree"), need, NULL);
  const size_t before = c->pairs.n;
  CHECK_OK(kith_connectivity_couple(
      c, nodes, &(struct kith_coupling){barrier->u8, damaged ? damage->f64 : NULL, rule.thickness}));
  const size_t cut = before - c->pairs.n;
  CHECK_OK(kith_connectivity_valid(c, nodes));
  check_factors(c, nodes, &rule);
  struct kith_excluder excluder = {.ops = &crossing, .context = &rule};
  struct kith_connectivity *fresh = oracle_build(nodes, kith_search_find("tree"), need, &excluder);
  if (idle) /* their rows do not tell which inactive nodes are cut from them, and the intersection may */
    CHECK(oracle_identical_rows(&c->rows, &fresh->rows) &&
          oracle_identical_pairs(&c->pairs, &fresh->pairs, &c->rows, c->rows.n));
  else
    CHECK(oracle_identical(c, fresh));
  CHECK_OK(kith_connectivity_canonical(c, nodes));
  check_factors(c, nodes, &rule);
  kith_connectivity_destroy(&fresh);
  kith_connectivity_destroy(&c);
  kith_nodes_destroy(&nodes);
  return cut;
}

/* With obstacles and barriers, pairs of nodes that see no obstacle, and those of barriers, have no common
 * nodes but their ends, the others all; cuts and factors are the same. */
static void check_obstacles(uint64_t seed, bool damaged, bool folded) {
  const struct kith_field_spec spec[2] = {{"barrier", KITH_SCALAR, KITH_U8, KITH_STATE, NULL, "1: a wall"},
                                          {"damage", KITH_SCALAR, KITH_F64, KITH_STATE, NULL, "D"}};
  const int count[2] = {60, 2};
  struct kith_nodes *nodes = oracle_random(2, count, NDIM == 1 ? 0.06 : 0.25, 1.8, &seed);
  struct kith_field *barrier, *damage = NULL;
  CHECK_OK(kith_nodes_field(nodes, &spec[0], &barrier));
  if (damaged) CHECK_OK(kith_nodes_field(nodes, &spec[1], &damage));
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    nodes->support->f64[i] = nodes->search_radius->f64[i];
    barrier->u8[i] = nodes->list->u8[i] == 1;
    if (damaged) damage->f64[i] = barrier->u8[i] ? 1 : i == 7 ? 0.5 : 0;
  }
  CHECK_OK(kith_nodes_number_images(nodes));
  if (folded) oracle_ghosts(nodes, 0, false, 0.4);
  const struct kith_field *obstacles = damaged ? damage : barrier;
  struct kith_requirements need = {.pairs = true, .intersection = true, .on_segment = true};
  struct kith_connectivity *whole = oracle_build(nodes, kith_search_find("tree"), need, NULL);
  need.obstacles = obstacles, need.barriers = barrier;
  struct kith_connectivity *c = oracle_build(nodes, kith_search_find("tree"), need, NULL);
  size_t ends = 0, others = 0;
  CHECK(c->pairs.n == whole->pairs.n);
  for (kith_index i = 0; i < c->rows.n && check_failures == 0; ++i) {
    bool sees = damaged ? damage->f64[i] > 0 : barrier->u8[i] > 0;
    for (size_t e = c->rows.first[i]; e < c->rows.first[i + 1]; ++e)
      sees = sees || (damaged ? damage->f64[c->rows.node[e]] > 0 : barrier->u8[c->rows.node[e]] > 0);
    for (size_t p = c->pairs.first[i]; p < c->pairs.first[i + 1]; ++p) {
      const size_t a = c->intersection.first[p], n = c->intersection.first[p + 1] - a,
                   b = whole->intersection.first[p], all = whole->intersection.first[p + 1] - b;
      const kith_index *end = c->pairs.node[p];
      const bool full = sees && !barrier->u8[end[0]] && !barrier->u8[end[1]];
      CHECK(n == (full ? all : 2));
      if (full)
        CHECK(memcmp(c->intersection.node + a, whole->intersection.node + b, n * sizeof(kith_index)) == 0);
      else
        CHECK(c->intersection.node[a] == end[0] && c->intersection.node[a + 1] == end[1]);
      ends += !full && all > 2, others += full && all > 2;
    }
  }
  CHECK(ends > 0 && others > 0);
  const struct kith_coupling by = {barrier->u8, damaged ? damage->f64 : NULL, 0.4};
  CHECK_OK(kith_connectivity_valid(c, nodes));
  CHECK_OK(kith_connectivity_couple(c, nodes, &by));
  CHECK_OK(kith_connectivity_couple(whole, nodes, &by));
  CHECK_OK(kith_connectivity_valid(c, nodes));
  const double *factor = kith_connectivity_factors(&c->pairs),
               *wanted = kith_connectivity_factors(&whole->pairs);
  CHECK(c->pairs.n == whole->pairs.n && (factor != NULL) == damaged && (wanted != NULL) == damaged);
  for (size_t p = 0; p < c->pairs.n && check_failures == 0; ++p) {
    CHECK(memcmp(c->pairs.node[p], whole->pairs.node[p], sizeof c->pairs.node[p]) == 0);
    CHECK(factor == NULL || factor[p] == wanted[p]);
  }
  kith_connectivity_destroy(&whole);
  kith_connectivity_destroy(&c);
  kith_nodes_destroy(&nodes);
}

static void check_needs(void) {
  const int count[1] = {5};
  uint64_t seed = 3;
  struct kith_nodes *nodes = oracle_random(1, count, 0.5, 1, &seed);
  struct kith_connectivity *c = oracle_build(nodes, kith_search_find("tree"),
                                             (struct kith_requirements){.rows = true, .pairs = true}, NULL);
  const struct kith_coupling by = {.barrier = nodes->list->u8, .thickness = 0.5};
  CHECK_STATUS(KITH_UNSUPPORTED, kith_connectivity_couple(c, nodes, &by));
  kith_connectivity_destroy(&c);
  kith_nodes_destroy(&nodes);
}

/* ---- a plate in a tube ---- */

static const char tube[] =
    "dimension: {1d: 1, 2d: 2, 3d: 3}\nresolution: 25\narrangement: equal-spacing\n"
    "domain: {lower: [-0.6, 0, 0], upper: [0.4, 0.16, 0.16]}\n"
    "boundaries: {x: reflecting, y: periodic, z: periodic}\n"
    "materials: {gas: {eos: ideal, gamma: 1.4}}\n"
    "regions:\n"
    "  - {material: gas, lattice: cubic, where: {x: [-0.6, -0.2]}, density: 1, pressure: 3}\n"
    "  - {material: gas, lattice: cubic, where: {x: [-0.2, 0]}, density: 1, pressure: 1}\n"
    "  - {material: gas, lattice: cubic, where: {x: [0, 0.04]}, density: 1, pressure: 1,\n"
    "     spacing: 0.02, barrier: true}\n"
    "  - {material: gas, lattice: cubic, where: {x: [0.04, 0.4]}, density: 1, pressure: 1}\n"
    /* steps of constant length and no reordering: else the two sides would affect each other */
    "until: 0.3\nscheme: {dt: 0.003}\nconnectivity: {reorder: 0}\n";

/* This tube ends where the plate stands. */
static const char walled_tube[] =
    "dimension: {1d: 1, 2d: 2, 3d: 3}\nresolution: 25\narrangement: equal-spacing\n"
    "domain: {lower: [-0.6, 0, 0], upper: [0, 0.16, 0.16]}\n"
    "boundaries: {x: reflecting, y: periodic, z: periodic}\n"
    "materials: {gas: {eos: ideal, gamma: 1.4}}\n"
    "regions:\n"
    "  - {material: gas, lattice: cubic, where: {x: [-0.6, -0.2]}, density: 1, pressure: 3}\n"
    "  - {material: gas, lattice: cubic, where: {x: [-0.2, 0]}, density: 1, pressure: 1}\n"
    "until: 0.3\nscheme: {dt: 0.003}\nconnectivity: {reorder: 0}\n";

static bool behind(const struct scenario *s, kith_index i) {
  return s->simulation->nodes->position->f64[(size_t)i * NDIM] > 0.04;
}

/* No pair joins the two sides, and nodes behind the plate are bitwise identical with and without a shock in
 * front of it. */
static void nothing_passes_plate(const char *package) {
  struct scenario calm = {0}, shocked = {0};
  const int steps = NDIM == 3 ? 12 : 100;
  scenario_open(&calm, tube, "method.package=%s regions.0.pressure=1", package);
  scenario_open(&shocked, tube, "method.package=%s", package);
  if (scenario_run(&calm, steps) && scenario_run(&shocked, steps)) {
    const struct kith_connectivity *c = shocked.simulation->connectivity;
    const kith_index n = shocked.simulation->nodes->n_internal;
    /* in 1-D the plate is as thick as a support, so that no pair is cut */
    CHECK(shocked.simulation->integrator.ledger.pairs_cut > 0 || NDIM == 1);
    for (size_t p = 0; p < c->pairs.n; ++p)
      if (c->pairs.node[p][1] < n)
        CHECK(behind(&shocked, c->pairs.node[p][0]) == behind(&shocked, c->pairs.node[p][1]));
    int64_t most, other;
    kith_index *of_calm = scenario_indices(&calm, &most), *of_shocked = scenario_indices(&shocked, &other);
    const struct kith_field *v = calm.simulation->hydro.velocity, *w = shocked.simulation->hydro.velocity;
    double moved = 0;
    for (int64_t id = 0; id <= most; ++id) {
      if (of_calm[id] < 0) continue;
      bool same = true;
      for (int a = 0; a < NDIM; ++a)
        same = same && v->f64[of_calm[id] * NDIM + a] == w->f64[of_shocked[id] * NDIM + a];
      if (behind(&calm, of_calm[id]))
        CHECK(same);
      else if (!same)
        moved += fabs(w->f64[of_shocked[id] * NDIM]);
    }
    CHECK(moved > 1);
    CHECK(scenario_energy_error(&shocked) < 1e-12); /* the plate does no work; round-off */
    free(of_calm);
    free(of_shocked);
  }
  scenario_close(&calm);
  scenario_close(&shocked);
}

/* Compares kinetic energy and mean position in front of a plate and in front of a wall. */
static void plate_acts_as_wall(const char *package, double tolerance) {
  struct scenario plate = {0}, wall = {0};
  const int steps = NDIM == 3 ? 12 : 100;
  scenario_open(&plate, tube, "method.package=%s", package);
  scenario_open(&wall, walled_tube, "method.package=%s", package);
  if (scenario_run(&plate, steps) && scenario_run(&wall, steps)) {
    double kinetic[2] = {0}, place[2] = {0};
    const struct scenario *const both[2] = {&plate, &wall};
    for (int s = 0; s < 2; ++s)
      for (kith_index i = 0; i < both[s]->simulation->nodes->n_internal; ++i) {
        const double *v = both[s]->simulation->hydro.velocity->f64 + (size_t)i * NDIM;
        const double x = both[s]->simulation->nodes->position->f64[(size_t)i * NDIM];
        if (x > 0.02) continue;
        for (int a = 0; a < NDIM; ++a)
          kinetic[s] += 0.5 * both[s]->simulation->hydro.mass->f64[i] * v[a] * v[a];
        place[s] += both[s]->simulation->hydro.mass->f64[i] * x;
      }
    /* The plate is a fraction of a spacing from the place of the wall, and the tube is 15 spacings long.
     * Differences are larger for packages whose kernels a wall mirrors, and a barrier does not. */
    const int before = check_failures;
    CHECK_CLOSE(kinetic[0], kinetic[1], tolerance * kinetic[1]);
    CHECK_CLOSE(place[0], place[1], fmax(0.01, tolerance / 20) * fabs(place[1]));
    if (check_failures > before) fprintf(stderr, "package %s\n", package);
  }
  scenario_close(&plate);
  scenario_close(&wall);
}

int main(void) {
  size_t cut[2] = {0};
  for (uint64_t seed = 1; seed <= 12; ++seed)
    for (int idle = 0; idle < 2; ++idle) cut[seed > 6] += check_coupling(seed, seed % 2 == 0, seed > 6, idle);
  CHECK(cut[0] > 0 && cut[1] > 0);
  for (int k = 0; k < 8; ++k) check_obstacles(60 + (uint64_t)k, k % 2, k % 4 > 1);
  check_needs();
  for (const struct kith_package_ops *const *p = kith_package_all(); *p != NULL; ++p)
    nothing_passes_plate((*p)->name);
  plate_acts_as_wall("sph", 0.08);
  plate_acts_as_wall("crk", 0.05);
  plate_acts_as_wall("mfm", 0.05);
  plate_acts_as_wall("magma2", 0.05);
  plate_acts_as_wall("remix", 0.05);
  return check_failed();
}
