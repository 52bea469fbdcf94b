/* Run by mpirun: neighbor lists and remote ghosts of several ranks. Every rank also runs the whole scene by
 * itself; in reproducible mode both have identical bits, so that rows are compared entry by entry, by id and
 * image. The remote ghosts that a rank must have, and no others, follow from distances, or from the rows of
 * the whole. */
#include "lib/comm/ranks.h"
#include "tests/unit/oracle.h"
#include "tests/unit/scenario.h"
#include "tests/unit/six_boxes.h"

static struct kith_ranks *ranks;

/* Periodic, reflecting and open sides, two materials, supports of different size, nodes that move from rank
 * to rank. */
static const char box[] = SCENARIO_UNIT
    "resolution: {1d: 40, 2d: 14, 3d: 7}\n"
    "boundaries: {x: periodic, y: reflecting, z: periodic}\n"
    "materials: {gas: {gamma: 1.4}, other: {gamma: 1.6666666666666667}}\n"
    "regions:\n"
    "  - {material: gas, where: {x: [0, 0.5]}, jitter: 0.3, seed: 5, lattice: cubic, density: 1, "
    "pressure: 0.1, velocity: [0.7, -0.4, 0.2]}\n"
    "  - {material: other, where: {x: [0.5, 1]}, jitter: 0.3, seed: 6, lattice: cubic, "
    "density: 0.3, pressure: 0.2, velocity: [0.7, -0.4, 0.2]}\n"
    "energy: {energy: 1, center: [0.4, 0.55, 0.6], over: ball, radius: 0.25}\n"
    "until: 1\n";

/* Nodes have many images: two axes are shorter than a support. */
static const char thin[] =
    "scene: thin\n"
    "dimension: 3\n"
    "resolution: {1d: 40, 2d: 40, 3d: 24}\n"
    "domain: {lower: [0, 0, 0], upper: [1, 0.06, 0.09]}\n"
    "boundaries: {x: reflecting, y: periodic, z: reflecting}\n"
    "materials: {gas: {gamma: 1.4}}\n"
    "regions:\n"
    "  - {material: gas, jitter: 0.2, seed: 5, lattice: cubic, density: 1, pressure: 0.1, "
    "velocity: [0.3, 0.4, 0.2]}\n"
    "until: 1\n";

static bool open_shared(struct scenario *s, const char *yaml, const char *settings) {
  char words[1024];
  snprintf(words, sizeof words, "%s", settings);
  return scenario_make(s, ranks, yaml, words) && check_failures == 0;
}

static int owner_of(const int32_t *owner, const struct kith_nodes *nodes, kith_index i) {
  return owner[nodes->id->i64[i]];
}

/* owner[id] of all nodes, on all ranks. */
static int32_t *owners(const struct scenario *shared, kith_index n) {
  double *of = calloc((size_t)n + 1, sizeof *of);
  int32_t *owner = calloc((size_t)n + 1, sizeof *owner);
  const struct kith_nodes *nodes = shared->simulation->nodes;
  for (kith_index i = 0; i < nodes->n_internal; ++i) of[nodes->id->i64[i]] += 1 + kith_ranks_rank(ranks);
  kith_ranks_sum(ranks, of, n);
  for (kith_index id = 0; id < n; ++id) {
    CHECK(of[id] >= 1 && of[id] <= kith_ranks_size(ranks)); /* each node is on one rank */
    owner[id] = (int32_t)of[id] - 1;
  }
  free(of);
  return owner;
}

/* Row i of the whole and row k of this rank have the same neighbors, by id and image, in the same order. */
static bool rows_agree(const struct scenario *whole, kith_index i, const struct scenario *shared,
                       kith_index k) {
  const struct kith_rows *a = &whole->simulation->connectivity->rows,
                         *b = &shared->simulation->connectivity->rows;
  const struct kith_nodes *m = whole->simulation->nodes, *n = shared->simulation->nodes;
  const size_t count = a->first[i + 1] - a->first[i];
  if (b->first[k + 1] - b->first[k] != count) return false;
  for (size_t e = 0; e < count; ++e) {
    const kith_index p = a->node[a->first[i] + e], q = b->node[b->first[k] + e];
    if (m->id->i64[p] != n->id->i64[q] || m->image->i64[p] != n->image->i64[q]) return false;
    if (memcmp(m->position->f64 + (size_t)p * NDIM, n->position->f64 + (size_t)q * NDIM,
               NDIM * sizeof(double)) != 0)
      return false;
  }
  return true;
}

/* Whether two nodes interact, by their distance. */
static bool interacts(const struct kith_nodes *nodes, kith_index i, kith_index j) {
  const double search_radius = fmax(nodes->search_radius->f64[i], nodes->search_radius->f64[j]);
  double d2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double d = nodes->position->f64[(size_t)i * NDIM + a] - nodes->position->f64[(size_t)j * NDIM + a];
    d2 += d * d;
  }
  return d2 <= search_radius * search_radius;
}

static bool in_row(const struct kith_rows *rows, kith_index i, kith_index j) {
  for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e)
    if (rows->node[e] == j) return true;
  return false;
}

/* The number of remote ghosts that this rank must have: of nodes and images of other ranks, in the whole,
 * that its nodes interact with. By distances if lists are of the present positions, else by the rows of the
 * whole. */
static kith_index needed_ghosts(const struct scenario *whole, const int32_t *owner) {
  const struct kith_nodes *nodes = whole->simulation->nodes;
  const bool lasting = kith_rebuilds_lasting(&whole->simulation->rebuilds);
  const int me = kith_ranks_rank(ranks);
  kith_index count = 0;
  for (kith_index j = 0; j < kith_nodes_count(nodes); ++j) {
    bool wanted = false;
    for (kith_index i = 0; owner_of(owner, nodes, j) != me && i < nodes->n_internal && !wanted; ++i)
      wanted = owner_of(owner, nodes, i) == me &&
               (lasting ? in_row(&whole->simulation->connectivity->rows, i, j) : interacts(nodes, i, j));
    count += wanted;
  }
  return count;
}

/* The number of remote ghosts of this rank. */
static kith_index remote_ghosts(const struct kith_nodes *nodes) {
  kith_index count = 0;
  for (int b = 0; b < nodes->n_blocks; ++b)
    if (nodes->blocks[b].kind == KITH_GHOST_REMOTE) count += nodes->blocks[b].count;
  return count;
}

/* Compares two scenarios at the same step. */
static void compare(const struct scenario *whole, const struct scenario *shared, const char *what) {
  const struct kith_nodes *all = whole->simulation->nodes, *mine = shared->simulation->nodes;
  int64_t most;
  kith_index *place = scenario_indices(whole, &most), wrong = 0;
  int32_t *owner = owners(shared, all->n_internal);
  for (kith_index k = 0; k < mine->n_internal; ++k)
    if (!rows_agree(whole, place[mine->id->i64[k]], shared, k)) ++wrong;
  const kith_index wanted = needed_ghosts(whole, owner), have = remote_ghosts(mine);
  const bool few = have >= wanted && 16 * (have - wanted) <= mine->n_ghost; /* not worth a cull */
  if (wrong > 0 || !few)
    fprintf(stderr, "rank %d, %d-D, %s: %d rows differ; %d remote ghosts, needed are %d\n",
            kith_ranks_rank(ranks), NDIM, what, wrong, have, wanted);
  CHECK(wrong == 0 && few);
  free(place);
  free(owner);
}

/* Compares the lists of every step. Where settings say so, all rebuilds of lists make a new map. */
static void lists_of_all_steps(const char *yaml, const char *settings, int steps) {
  struct scenario whole, shared;
  if (scenario_open(&whole, yaml, "%s", settings) && open_shared(&shared, yaml, settings)) {
    CHECK_OK(scenario_start(&whole));
    CHECK_OK(scenario_start(&shared));
    compare(&whole, &shared, settings);
    for (int k = 0; k < steps && check_failures == 0; ++k) {
      CHECK_OK(scenario_steps(&whole, 1));
      CHECK_OK(scenario_steps(&shared, 1));
      CHECK(whole.simulation->integrator.dt == shared.simulation->integrator.dt);
      compare(&whole, &shared, settings);
    }
    const struct kith_ledger all = kith_ledger_of_all(&shared.simulation->integrator.ledger, ranks);
    CHECK(kith_ledger_closes(&all));
    CHECK(all.row_entries == whole.simulation->integrator.ledger.row_entries);
    scenario_close(&shared);
  }
  scenario_close(&whole);
}

static void all_partitioners(void) {
  char settings[512];
  for (int p = 0; kith_partitioner_all()[p] != NULL; ++p) {
    if (kith_partitioner_all()[p]->needs != NULL) continue;
    snprintf(settings, sizeof settings,
             "reproducible=true partition.name=%s partition.every=1 partition.imbalance=1 partition.cells=40",
             kith_partitioner_all()[p]->name);
    lists_of_all_steps(box, settings, 4);
  }
}

/* A node of one rank diverges: all ranks get its message. */
static void one_diverges(void) {
  struct scenario s;
  const int bad = kith_ranks_size(ranks) - 1;
  char words[32];
  if (!open_shared(&s, box, "")) return;
  CHECK_OK(scenario_start(&s));
  CHECK_OK(scenario_steps(&s, 1));
  if (kith_ranks_rank(ranks) == bad) s.simulation->hydro.velocity->f64[0] = NAN;
  CHECK_STATUS(KITH_DIVERGED, scenario_steps(&s, 1));
  snprintf(words, sizeof words, "rank %d: node", bad);
  CHECK(strncmp(kith_failure(), words, strlen(words)) == 0 && kith_ranks_status_is_shared(ranks));
  scenario_close(&s);
}

static kith_status planted_ghosts(struct kith_boundary *boundary, struct kith_nodes *nodes, double factor) {
  (void)boundary, (void)factor;
  if (kith_ranks_rank(nodes->ranks) == kith_ranks_size(nodes->ranks) - 1) KITH_FAIL(DIVERGED, "planted");
  return KITH_OK;
}
static const struct kith_boundary_ops planted = {
    .name = "planted", .doc = "fails on one rank", .ghosts = planted_ghosts};

/* One rank fails while its neighbors wait for messages, or between two steps (as when a file cannot be
 * written): all end with its failure. */
static void one_fails_among_messages(void) {
  struct scenario s;
  const int bad = kith_ranks_size(ranks) - 1;
  char words[32];
  snprintf(words, sizeof words, "rank %d: planted", bad);
  for (int between = 0; between < 2; ++between) {
    if (!open_shared(&s, box, "")) return;
    struct kith_boundaries *all = &s.simulation->boundaries;
    CHECK_OK(scenario_start(&s));
    if (between) {
      if (kith_ranks_rank(ranks) == bad)
        s.simulation->integrator.pending = kith_fail(KITH_DIVERGED, "planted");
    } else { /* the boundary between ranks stays the last one */
      CHECK_OK(kith_boundaries_add(all, &planted, 0, 0, 1, false, false));
      struct kith_boundary *last = all->boundary[all->n - 1];
      all->boundary[all->n - 1] = all->boundary[all->n - 2], all->boundary[all->n - 2] = last;
      last->index -= 1, all->boundary[all->n - 1]->index += 1;
    }
    CHECK_STATUS(KITH_DIVERGED, scenario_steps(&s, 1));
    CHECK(strcmp(kith_failure(), words) == 0 && kith_ranks_status_is_shared(ranks));
    scenario_close(&s);
  }
}

/* Ranks on the communicator of a caller, which is not freed with them. */
static void callers_communicator(void) {
  struct kith_ranks *those;
  if (ranks == NULL) return;
  CHECK_OK(kith_ranks_create_on(&those, kith_ranks_communicator(ranks)));
  CHECK(kith_ranks_rank(those) == kith_ranks_rank(ranks) && kith_ranks_size(those) == kith_ranks_size(ranks));
  CHECK(kith_ranks_any(those, kith_ranks_rank(those) == 1) == (kith_ranks_size(those) > 1));
  kith_ranks_destroy(&those);
}

/* --- lists whose targets and sources differ --- */

static void count_pairs(void *context, const struct kith_neighbors *neighbors, struct kith_tally *tally) {
  const double *x = ((const struct kith_nodes *)context)->position->f64;
  for (size_t k = 0; k < neighbors->n; ++k) {
    kith_tally_add(tally, 0, 0);
    kith_tally_add(
        tally, 1,
        kith_distance2(x + (size_t)neighbors->node * NDIM, x + (size_t)neighbors->source[k] * NDIM));
  }
}

/* The number of pairs on all ranks, and the sum of their squared distances. */
static void sum_pairs(const struct kith_list_spec *spec, struct kith_reducer sums[2]) {
  struct kith_list *list;
  enum kith_rebuild_reason why;
  sums[0].kind = KITH_COUNT, sums[1].kind = KITH_SUM;
  CHECK_OK(kith_list_create(&list, spec));
  CHECK_OK(kith_list_update(list, &why));
  CHECK_OK(kith_list_visit_all(list, count_pairs, (void *)(uintptr_t)spec->sources.nodes, sums, 2));
  kith_list_destroy(&list);
}

static void pairs_of_six_boxes(void) {
  for (int relation = 0; relation < 4; ++relation)
    for (int chain = 0; chain < 4; ++chain) {
      struct kith_nodes *nodes = six_boxes(kith_ranks_rank(ranks), kith_ranks_size(ranks));
      struct kith_search *search;
      struct kith_excluder excluder[2];
      struct kith_reducer sums[2];
      nodes->ranks = ranks;
      CHECK_OK(kith_search_create(&search, kith_search_find("tree"), nodes));
      const struct kith_list_spec spec = six_boxes_spec(nodes, search, relation, chain, excluder);
      sum_pairs(&spec, sums);
      CHECK(sums[0].value == (double)six_boxes_pairs[relation][chain]);
      kith_search_destroy(&search);
      kith_nodes_destroy(&nodes);
    }
}

/* Lists of nodes of one material with neighbors of another: all ranks together have the pairs that one
 * process has, and those that have the distances of a brute-force sum. */
static void lists_between_materials(void) {
  struct scenario s[2] = {{0}};
  struct kith_reducer sums[2][2], oracle[2] = {{KITH_COUNT, 0}, {KITH_SUM, 0}};
  if (scenario_open(&s[0], box, "reproducible=true") && open_shared(&s[1], box, "reproducible=true")) {
    for (int k = 0; k < 2; ++k) {
      const struct kith_nodes *nodes = s[k].simulation->nodes;
      struct kith_search *search;
      CHECK_OK(scenario_start(&s[k]));
      CHECK_OK(scenario_steps(&s[k], 2));
      CHECK_OK(kith_search_create(&search, kith_search_find("grid"), nodes));
      const struct kith_list_spec spec = {.targets = {nodes, search, .lists = 1},
                                          .sources = {nodes, search, .lists = 2},
                                          .cutoff = KITH_CUTOFF_gather_scatter,
                                          .radius = "search_radius",
                                          .storage = k == 0 ? "csr" : "compressed",
                                          .rebuild = "always"};
      sum_pairs(&spec, sums[k]);
      kith_search_destroy(&search);
    }
    const struct kith_nodes *all = s[0].simulation->nodes;
    struct kith_sum sum = {0};
    for (kith_index i = 0; i < all->n_internal; ++i)
      for (kith_index j = 0; j < kith_nodes_count(all); ++j)
        if (all->list->u8[i] == 0 && all->list->u8[j] == 1 && interacts(all, i, j)) {
          oracle[0].value += 1;
          kith_sum_add(&sum, kith_distance2(all->position->f64 + (size_t)i * NDIM,
                                            all->position->f64 + (size_t)j * NDIM));
        }
    oracle[1].value = kith_sum_value(&sum);
    CHECK(oracle[0].value > 5);
    for (int k = 0; k < 2; ++k)
      for (int r = 0; r < 2; ++r) CHECK(sums[k][r].value == oracle[r].value);
  }
  scenario_close(&s[1]);
  scenario_close(&s[0]);
}

/* Lists of all ranks are rebuilt for a reason on one rank, and stale if one is. */
static void rebuilds_together(void) {
  struct kith_nodes *nodes = six_boxes(kith_ranks_rank(ranks), kith_ranks_size(ranks));
  struct kith_search *search;
  struct kith_excluder excluder[2];
  struct kith_list *list;
  enum kith_rebuild_reason why;
  const bool last = kith_ranks_rank(ranks) == kith_ranks_size(ranks) - 1;
  nodes->ranks = ranks;
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    nodes->support->f64[i] = 0.5 * nodes->search_radius->f64[i];
  CHECK_OK(kith_search_create(&search, kith_search_find("tree"), nodes));
  struct kith_list_spec spec = six_boxes_spec(nodes, search, 0, 1, excluder);
  spec.cutoff = KITH_CUTOFF_gather_scatter, spec.rebuild = "displacement";
  CHECK_OK(kith_list_create(&list, &spec));
  const enum kith_rebuild_reason wanted[4] = {KITH_BECAUSE_first_build, KITH_BECAUSE_none,
                                              KITH_BECAUSE_displacement, KITH_BECAUSE_entity_change};
  for (int k = 0; k < 4; ++k) {
    if (last && k == 2 && nodes->n_internal > 0) nodes->position->f64[0] += 5, ++nodes->positions;
    if (last && k == 3) ++nodes->ghosts;
    CHECK_OK(kith_list_update(list, &why));
    CHECK(why == wanted[k] || (kith_ranks_size(ranks) > 6 && k == 2));
  }
  struct kith_reducer count = {.kind = KITH_COUNT};
  if (last) ++nodes->ghosts;
  CHECK_STATUS(KITH_STALE, kith_list_visit_all(list, count_pairs, nodes, &count, 1));
  kith_list_destroy(&list);
  kith_search_destroy(&search);
  kith_nodes_destroy(&nodes);
}

/* Lists from which unneeded ghosts were culled are identical to lists that are built anew without these, also
 * just after nodes appeared or left: positions are still those that lists were built from. */
static void culled_lists_are_rebuilt_lists(void) {
  static const char stream[] =
      "scene: stream\ndimension: 1\nresolution: {1d: 40, 2d: 8, 3d: 5}\n"
      "domain: {lower: [0, 0, 0], upper: [1, 1, 1], across: {1d: 1, 2d: 6, 3d: 4}}\n"
      "boundaries: {x: [inflow, outflow], y: periodic, z: periodic}\nmaterials: {gas: {}}\n"
      "regions: [{material: gas, density: 1, pressure: 1, velocity: [2, 0, 0]}]\nuntil: 9\n";
  struct scenario s;
  uint64_t count[2] = {0}; /* rebuilds because nodes came or went; ghosts culled */
  if (!open_shared(&s, stream, "traversal=pairs") || !scenario_run(&s, 0)) return;
  struct kith_integrator *it = &s.simulation->integrator;
  for (int k = 0; k < 30; ++k) {
    struct kith_connectivity *again;
    CHECK_OK(kith_integrator_step(it, s.scene->until));
    CHECK_OK(kith_connectivity_create(&again));
    CHECK_OK(kith_search_update(it->search));
    CHECK_OK(kith_connectivity_build(again, it->nodes, it->search, it->need, NULL, NULL));
    CHECK(oracle_identical(it->connectivity, again));
    kith_connectivity_destroy(&again);
  }
  count[0] = it->ledger.because[KITH_BECAUSE_entity_change], count[1] = it->ledger.ghosts_culled;
  kith_ranks_sum_counts(ranks, count, 2);
  CHECK(count[0] > 1 && count[1] > 0);
  scenario_close(&s);
}

/* A cull removes a 16th of the ghosts at least, or it is left. Images that only other ranks read, as beyond
 * the ends of a periodic box, do not count among those that could go. */
static void culls_are_worth_it(void) {
  static const char lattice[] =
      "scene: lattice\ndimension: 1\nresolution: {1d: 64, 2d: 48, 3d: 20}\n"
      "domain: {lower: [0, 0, 0], upper: [1, 1, 1]}\nboundaries: {x: periodic, y: periodic, z: periodic}\n"
      "materials: {gas: {}}\nregions: [{material: gas, lattice: cubic, density: 1, pressure: 1}]\nuntil: 9\n";
  struct scenario s;
  if (!open_shared(&s, lattice, "partition.name=cart") || !scenario_run(&s, 0)) return;
  for (int k = 0; k < 3; ++k) {
    const struct kith_ledger before = s.simulation->integrator.ledger;
    CHECK_OK(kith_integrator_step(&s.simulation->integrator, s.scene->until));
    const struct kith_ledger *now = &s.simulation->integrator.ledger;
    const uint64_t culled = now->ghosts_culled - before.ghosts_culled,
                   created = now->ghosts_created - before.ghosts_created;
    CHECK(now->lifecycles == before.lifecycles + 1);
    CHECK(culled == 0 || 16 * culled + 16 > created);
  }
  scenario_close(&s);
}

int main(void) {
  CHECK_OK(kith_ranks_create(&ranks));
  callers_communicator();
  pairs_of_six_boxes();
  lists_between_materials();
  rebuilds_together();
  all_partitioners();
  culled_lists_are_rebuilt_lists();
  culls_are_worth_it();
  lists_of_all_steps(thin, "reproducible=true", 3);
  lists_of_all_steps(box, "reproducible=true connectivity.rebuild=displacement", 6);
  lists_of_all_steps(box, "reproducible=true partition.cells=1", 2);
  lists_of_all_steps(thin, "reproducible=true resolution=3", 2); /* 3 nodes in 1-D, fewer than 8 ranks */
  if (kith_ranks_size(ranks) > 1) one_diverges();
  if (kith_ranks_size(ranks) > 1) one_fails_among_messages();
  const int failed = kith_ranks_any(ranks, check_failed() != 0);
  kith_ranks_destroy(&ranks);
  return failed;
}
