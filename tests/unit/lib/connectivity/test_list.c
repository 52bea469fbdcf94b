/* test_list.c - neighbor lists of any targets and sources. Oracle: the distance of all pairs. Also numbers of
 * pairs that are known (six_boxes.h), errors in specifications, when lists are rebuilt, and reductions over
 * neighbors. */
#include <omp.h>

#include "lib/connectivity/list.h"
#include "tests/unit/six_boxes.h"

static struct kith_search *search_of(const struct kith_nodes *nodes, const char *name) {
  struct kith_search *search;
  CHECK_OK(kith_search_create(&search, kith_search_find(name), nodes));
  return search;
}

/* --- rows --- */

static bool by_definition(const struct kith_list_spec *spec, kith_index i, kith_index j) {
  const struct kith_nodes *t = spec->targets.nodes, *s = spec->sources.nodes;
  const double ri = t->search_radius->f64[i], rj = s->search_radius->f64[j];
  double d2 = 0, widest = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double d = s->position->f64[j * NDIM + a] - t->position->f64[i * NDIM + a];
    volatile const double square = d * d;
    d2 = d2 + square;
    widest = fmax(widest, fabs(d));
  }
  switch (spec->cutoff) {
    case KITH_CUTOFF_number:
      return d2 <= spec->number * spec->number;
    case KITH_CUTOFF_gather:
      return d2 <= ri * ri;
    case KITH_CUTOFF_scatter:
      return d2 <= rj * rj;
    case KITH_CUTOFF_gather_scatter:
      return d2 <= ri * ri || d2 <= rj * rj;
    default:
      return widest <= ri + rj;
  }
}

/* Compares every row with the definition, with storage half its upper part. Returns the number of entries. */
static size_t check_rows(const struct kith_list *l) {
  const struct kith_list_spec *spec = &l->spec;
  const struct kith_nodes *sources = spec->sources.nodes;
  kith_index *space = calloc(l->stored.longest + 1, sizeof *space);
  size_t entries = 0, n;
  for (kith_index t = 0; t < l->n_targets; ++t) {
    const kith_index i = l->target[t], *row = l->stored.ops->row(&l->stored, t, space, &n);
    size_t e = 0;
    for (kith_index j = 0; j < kith_nodes_count(sources); ++j) {
      const struct kith_candidate candidate = {&spec->targets, &spec->sources, i, j, 0};
      if (!kith_selects(&spec->sources, j) || !by_definition(spec, i, j)) continue;
      if (l->stored.ops->upper && j < i) continue;
      if (kith_excluder_rejects(spec->excluders, KITH_BROAD, &candidate) ||
          kith_excluder_rejects(spec->excluders, KITH_NARROW, &candidate))
        continue;
      bool there = e < n && row[e] == j;
      for (size_t k = 0; spec->unsorted && k < n; ++k) there = there || row[k] == j;
      CHECK(there);
      ++e;
    }
    CHECK(e == n);
    entries += n;
  }
  free(space);
  return entries;
}

/* Ordinals number the selected nodes in ascending order, and can be inverted. */
static void check_ordinals(const struct kith_list *l) {
  kith_index t = 0, s = 0;
  for (kith_index i = 0; i < kith_nodes_count(l->spec.targets.nodes); ++i) {
    const bool is_one = kith_selects(&l->spec.targets, i) &&
                        (i < l->spec.targets.nodes->n_internal || l->spec.targets.ghosts);
    CHECK(l->row[i] == (is_one ? t : -1));
    if (is_one) CHECK(l->target[t++] == i);
  }
  for (kith_index j = 0; j < kith_nodes_count(l->spec.sources.nodes); ++j) {
    CHECK(l->column[j] == (kith_selects(&l->spec.sources, j) ? s : -1));
    s += kith_selects(&l->spec.sources, j);
  }
  CHECK(t == l->n_targets && s == l->n_sources);
}

static size_t conforms(const struct kith_list_spec *spec) {
  struct kith_list *list;
  enum kith_rebuild_reason why;
  CHECK_OK(kith_list_create(&list, spec));
  if (list == NULL) return 0;
  CHECK_OK(kith_list_update(list, &why));
  CHECK(why == KITH_BECAUSE_first_build);
  check_ordinals(list);
  const size_t entries = check_rows(list);
  kith_list_destroy(&list);
  return entries;
}

static bool is_even(const void *context, const struct kith_nodes *nodes, kith_index i) {
  (void)context;
  return nodes->id->i64[i] % 2 == 0;
}

static struct kith_list_spec spec_of(struct kith_search *targets, struct kith_search *sources,
                                     enum kith_cutoff cutoff) {
  return (struct kith_list_spec){.targets = {.nodes = targets->nodes, .search = targets},
                                 .sources = {.nodes = sources->nodes, .search = sources},
                                 .cutoff = cutoff,
                                 .number = cutoff == KITH_CUTOFF_number ? 0.17 : 0,
                                 .radius = cutoff == KITH_CUTOFF_number ? NULL : "search_radius",
                                 .storage = "csr",
                                 .rebuild = "always"};
}

/* Equal, overlapping and disjoint selections, and points that are not nodes, as targets (relation 4) and as
 * sources (5), with all cutoffs, searches and storages, with periodic images, sorted and unsorted. */
static void check_definitions(void) {
  static const char *const storages[] = {"csr", "padded", "padded:width=3", "half", "compressed"};
  const int count[2] = {70, 40}, points_count[1] = {50};
  uint64_t state = 3;
  struct kith_nodes *nodes = oracle_random(2, count, 0.1, 3, &state),
                    *points = oracle_random(1, points_count, 0.05, 4, &state);
  oracle_ghosts(nodes, 0, false, 0.3);
  for (const struct kith_search_ops *const *ops = kith_search_all(); *ops != NULL; ++ops) {
    struct kith_search *search = search_of(nodes, (*ops)->name), *of_points = search_of(points, (*ops)->name);
    for (int cutoff = 1; cutoff <= KITH_CUTOFF_boxes; ++cutoff)
      for (int relation = 0; relation < 6; ++relation) {
        struct kith_list_spec spec =
            spec_of(relation == 4 ? of_points : search, relation == 5 ? of_points : search, cutoff);
        struct kith_excluder once = {.ops = &kith_excluder_symmetric_duplicates},
                             self = {.ops = &kith_excluder_self, .next = relation == 2 ? &once : NULL};
        spec.targets.ghosts = relation == 0;
        if (relation == 1 || relation == 3) spec.targets.lists = 1;
        if (relation == 1) spec.sources.lists = 2;
        if (relation >= 2) spec.sources.chosen = is_even;
        if (relation == 0 || relation == 2) spec.excluders = &self;
        spec.storage = storages[relation % 5 == 3 ? 0 : relation % 5];
        omp_set_num_threads(1 + relation % 3);
        CHECK(conforms(&spec) > 10);
        const bool halves = relation == 0 && cutoff != KITH_CUTOFF_gather && cutoff != KITH_CUTOFF_scatter;
        if (halves) spec.storage = "half";
        if (halves) CHECK(conforms(&spec) > 10);
        spec.storage = "csr", spec.unsorted = true, spec.expected = 5;
        CHECK(conforms(&spec) > 10);
      }
    kith_search_destroy(&of_points);
    kith_search_destroy(&search);
  }
  omp_set_num_threads(2);
  kith_nodes_destroy(&points);
  kith_nodes_destroy(&nodes);
}

/* A node that reaches its own images reaches two along each axis: one interaction if periodic, two if they
 * are mirrored. */
static void check_images_of_self(void) {
  for (int mirror = 0; mirror < 2; ++mirror) {
    struct kith_nodes *nodes = oracle_lattice(1, 1, 1.2);
    struct kith_search *search = search_of(nodes, "tree");
    for (int a = 0; a < NDIM; ++a) oracle_ghosts(nodes, a, mirror, 1.2);
    struct kith_list_spec spec = spec_of(search, search, KITH_CUTOFF_gather);
    struct kith_excluder once = {.ops = &kith_excluder_symmetric_duplicates},
                         self = {.ops = &kith_excluder_self, .next = &once};
    spec.excluders = &self;
    CHECK(conforms(&spec) == (mirror ? 2 * NDIM : NDIM));
    kith_search_destroy(&search);
    kith_nodes_destroy(&nodes);
  }
}

/* --- the table of six boxes --- */

static void check_six_boxes(void) {
  for (const struct kith_search_ops *const *ops = kith_search_all(); *ops != NULL; ++ops)
    for (int relation = 0; relation < 4; ++relation)
      for (int chain = 0; chain < 4; ++chain) {
        struct kith_nodes *nodes = six_boxes(0, 1);
        struct kith_search *search = search_of(nodes, (*ops)->name);
        struct kith_excluder excluder[2];
        const struct kith_list_spec spec = six_boxes_spec(nodes, search, relation, chain, excluder);
        CHECK(conforms(&spec) == six_boxes_pairs[relation][chain]);
        kith_search_destroy(&search);
        kith_nodes_destroy(&nodes);
      }
}

/* --- refusals --- */

static void refuses(const struct kith_list_spec *spec, const char *why) {
  struct kith_list *list;
  CHECK_STATUS(KITH_BAD_INPUT, kith_list_create(&list, spec));
  CHECK(list == NULL && check_says(why));
  kith_list_destroy(&list);
}

static void check_refusals(void) {
  const int count[1] = {8};
  uint64_t state = 9;
  struct kith_nodes *nodes = oracle_random(1, count, 0.4, 1, &state),
                    *other = oracle_random(1, count, 0.4, 1, &state);
  struct kith_search *search = search_of(nodes, "tree"), *second = search_of(nodes, "grid"),
                     *elsewhere = search_of(other, "tree");
  const struct kith_list_spec good = spec_of(search, search, KITH_CUTOFF_gather);
  struct kith_excluder once = {.ops = &kith_excluder_symmetric_duplicates},
                       twice = {.ops = &kith_excluder_symmetric_duplicates, .next = &once};
  struct kith_list_spec spec;
#define REFUSES(why, ...) \
  spec = good;            \
  __VA_ARGS__;            \
  refuses(&spec, why)
  REFUSES("no targets are given", spec.targets.nodes = NULL);
  REFUSES("no sources are given", spec.sources.nodes = NULL);
  REFUSES("the targets have no search", spec.targets.search = NULL);
  REFUSES("the sources have no search", spec.sources.search = NULL);
  REFUSES("the search of the sources belongs to other nodes", spec.sources.search = elsewhere);
  REFUSES("but of two searches", spec.sources.search = second);
  REFUSES("no cutoff is given", spec.cutoff = KITH_CUTOFF_missing);
  REFUSES("the cutoff needs a field of radii", spec.radius = NULL);
  REFUSES("is field 'search_radius' and the number 2", spec.number = 2);
  REFUSES("the search of the targets knows 'search_radius'", spec.radius = "support");
  REFUSES("the search of the sources knows", spec.cutoff = KITH_CUTOFF_scatter, spec.radius = "support");
  REFUSES("a number and field", spec.cutoff = KITH_CUTOFF_number, spec.number = 1);
  REFUSES("cutoff -1 is not above 0", spec.cutoff = KITH_CUTOFF_number, spec.radius = NULL, spec.number = -1);
  REFUSES("no storage is given", spec.storage = NULL);
  REFUSES("storage: 'heap' is not one of csr", spec.storage = "heap");
  REFUSES("csr has no parameter width", spec.storage = "csr:width=3");
  REFUSES("storage compressed needs sorted rows", spec.storage = "compressed", spec.unsorted = true);
  REFUSES("storage half needs targets that are the sources", spec.storage = "half",
          spec.sources = ((struct kith_selection){.nodes = other, .search = elsewhere}));
  REFUSES("storage half needs a cutoff that is the same for both", spec.storage = "half");
  REFUSES("would leave a quarter", spec.storage = "half", spec.cutoff = KITH_CUTOFF_boxes,
          spec.excluders = &once);
  REFUSES("no rebuild policy is given", spec.rebuild = NULL);
  REFUSES("rebuild policy: 'daily' is not one of always", spec.rebuild = "daily");
  REFUSES("follows one set of nodes", spec.rebuild = "displacement",
          spec.sources = ((struct kith_selection){.nodes = other, .search = elsewhere}));
  REFUSES("follows supports within field 'search_radius'", spec.rebuild = "displacement",
          spec.cutoff = KITH_CUTOFF_number, spec.radius = NULL, spec.number = 1);
  /* Errors that are found when the list is built. */
  static const struct {
    kith_status status;
    const char *why;
  } later[] = {{KITH_BAD_INPUT, "no node is a source of 8 targets"},
               {KITH_BAD_INPUT, "excluder symmetric_duplicates is in the chain twice"},
               {KITH_BAD_INPUT, "they are of different nodes"},
               {KITH_UNSUPPORTED, "does not fit into 1"}};
  for (int k = 0; k < 4; ++k) {
    struct kith_list *list;
    enum kith_rebuild_reason why;
    spec = good;
    if (k == 0) spec.sources.lists = 2;
    if (k == 1) spec.excluders = &twice;
    if (k == 2)
      spec.excluders = &once, spec.sources = (struct kith_selection){.nodes = other, .search = elsewhere};
    if (k == 3) spec.storage = "padded:width=1 overflow=false";
    CHECK_OK(kith_list_create(&list, &spec));
    CHECK_STATUS(later[k].status, kith_list_update(list, &why));
    CHECK(strstr(kith_failure(), later[k].why) != NULL);
    CHECK_STATUS(KITH_STALE, kith_list_current(list));
    kith_list_destroy(&list);
  }
  kith_search_destroy(&elsewhere);
  kith_search_destroy(&second);
  kith_search_destroy(&search);
  kith_nodes_destroy(&other);
  kith_nodes_destroy(&nodes);
}

/* --- updates --- */

static void move_all(struct kith_nodes *nodes, double by) {
  for (kith_index i = 0; i < nodes->n_internal; ++i) nodes->position->f64[i * NDIM] += i % 2 ? by : 0;
  ++nodes->positions;
}

static void check_updates(void) {
  static const struct {
    const char *rebuild;
    enum kith_rebuild_reason near, far;
  } policy[] = {{"always", KITH_BECAUSE_always, KITH_BECAUSE_always},
                {"displacement", KITH_BECAUSE_none, KITH_BECAUSE_displacement},
                {"never | entity-change | displacement", KITH_BECAUSE_none, KITH_BECAUSE_displacement}};
  for (size_t k = 0; k < sizeof policy / sizeof *policy; ++k) {
    const int count[1] = {40};
    uint64_t state = 4;
    struct kith_nodes *nodes = oracle_random(1, count, 0.3, 1, &state);
    struct kith_search *search = search_of(nodes, "grid");
    struct kith_list_spec spec = spec_of(search, search, KITH_CUTOFF_gather_scatter);
    struct kith_list *list;
    enum kith_rebuild_reason why;
    for (kith_index i = 0; i < 40; ++i) nodes->support->f64[i] = 0.28;
    spec.rebuild = policy[k].rebuild;
    CHECK_OK(kith_list_create(&list, &spec));
    CHECK_STATUS(KITH_STALE, kith_list_current(list));
#define UPDATES(reason)                   \
  CHECK_OK(kith_list_update(list, &why)); \
  CHECK(why == (reason))
    UPDATES(KITH_BECAUSE_first_build);
    CHECK_OK(kith_list_current(list));
    move_all(nodes, 0.001);
    UPDATES(policy[k].near);
    kith_list_invalidate(list);
    CHECK_STATUS(KITH_STALE, kith_list_current(list));
    UPDATES(KITH_BECAUSE_requested);
    move_all(nodes, 0.2);
    UPDATES(policy[k].far);
    check_rows(list);
    oracle_ghosts(nodes, 0, false, 0.3); /* other nodes cause a rebuild whatever the policy */
    CHECK_STATUS(KITH_STALE, kith_list_current(list));
    UPDATES(KITH_BECAUSE_entity_change);
    check_rows(list);
    CHECK(list->builds == 5 - (policy[k].near == KITH_BECAUSE_none));
    kith_list_destroy(&list);
    kith_search_destroy(&search);
    kith_nodes_destroy(&nodes);
  }
}

static bool is_before(const void *context, const struct kith_nodes *nodes, kith_index i) {
  return nodes->id->i64[i] < *(const int *)context;
}

/* Sources may vanish from the selection; then rows are empty. */
static void check_vanishing_sources(void) {
  const int count[1] = {20};
  int most = 10;
  uint64_t state = 6;
  struct kith_nodes *nodes = oracle_random(1, count, 0.5, 1, &state);
  struct kith_search *search = search_of(nodes, "tree");
  struct kith_list_spec spec = spec_of(search, search, KITH_CUTOFF_gather);
  struct kith_list *list;
  enum kith_rebuild_reason why;
  spec.sources.chosen = is_before, spec.sources.context = &most;
  CHECK_OK(kith_list_create(&list, &spec));
  for (; most >= 0; most -= 5) {
    CHECK_OK(kith_list_update(list, &why));
    CHECK(list->n_sources == most && (list->stored.entries > 0) == (most > 0));
    check_rows(list);
  }
  kith_list_destroy(&list);
  kith_search_destroy(&search);
  kith_nodes_destroy(&nodes);
}

/* --- iteration --- */

static void tally_distances(void *context, const struct kith_neighbors *neighbors, struct kith_tally *tally) {
  const double *x = ((const struct kith_nodes *)context)->position->f64;
  kith_tally_add(tally, 0, 0);
  for (size_t k = 0; k < neighbors->n; ++k) {
    const double d = sqrt(kith_distance2(x + neighbors->node * NDIM, x + neighbors->source[k] * NDIM)) - 0.05;
    kith_tally_add(tally, 1, 0);
    kith_tally_add(tally, 2, d), kith_tally_add(tally, 3, d), kith_tally_add(tally, 4, d);
  }
}

/* Targets without neighbors are visited. Sums are bitwise identical with any storage, order and number of
 * threads. */
static void check_reducers(void) {
  static const char *const storages[] = {"csr", "padded:width=7", "compressed"};
  struct kith_reducer first[5] = {{KITH_COUNT, 0},
                                  {KITH_COUNT, 0},
                                  {KITH_SUM, 0},
                                  {KITH_LEAST, 0},
                                  {KITH_MOST, 0}},
                      other[5];
  const int count[1] = {2000}, lone[1] = {1};
  uint64_t state = 8;
  struct kith_nodes *nodes = oracle_random(1, count, 0.02, 2, &state),
                    *one = oracle_random(1, lone, 1, 1, &state);
  for (int k = 0; k < 4; ++k) {
    struct kith_search *search = search_of(nodes, k == 1 ? "grid" : "tree");
    struct kith_list_spec spec = spec_of(search, search, KITH_CUTOFF_gather_scatter);
    struct kith_excluder self = {.ops = &kith_excluder_self};
    struct kith_list *list;
    enum kith_rebuild_reason why;
    spec.excluders = &self, spec.storage = storages[k % 3], spec.unsorted = k == 3;
    omp_set_num_threads(1 + k);
    memcpy(other, first, sizeof other);
    CHECK_OK(kith_list_create(&list, &spec));
    CHECK_OK(kith_list_update(list, &why));
    CHECK_OK(kith_list_visit_all(list, tally_distances, nodes, other, 5));
    if (k == 0) memcpy(first, other, sizeof first);
    for (int r = 0; r < 5; ++r) CHECK(first[r].value == other[r].value);
    CHECK(other[0].value == 2000 && other[1].value == (double)list->stored.entries);
    kith_list_destroy(&list);
    kith_search_destroy(&search);
  }
  omp_set_num_threads(2);
  struct kith_search *search = search_of(one, "tree");
  struct kith_list_spec spec = spec_of(search, search, KITH_CUTOFF_gather);
  struct kith_excluder self = {.ops = &kith_excluder_self};
  struct kith_list *list;
  enum kith_rebuild_reason why;
  spec.excluders = &self;
  CHECK_OK(kith_list_create(&list, &spec));
  CHECK_STATUS(KITH_STALE, kith_list_visit_all(list, tally_distances, one, other, 5));
  CHECK_OK(kith_list_update(list, &why));
  CHECK_OK(kith_list_visit_all(list, tally_distances, one, other, 5));
  CHECK(other[0].value == 1 && other[1].value == 0 && other[2].value == 0);
  CHECK(other[3].value == INFINITY && other[4].value == -INFINITY);
  kith_list_destroy(&list);
  kith_search_destroy(&search);
  kith_nodes_destroy(&one);
  kith_nodes_destroy(&nodes);
}

int main(void) {
  check_definitions();
  check_images_of_self();
  check_six_boxes();
  check_refusals();
  check_updates();
  check_vanishing_sources();
  check_reducers();
  return check_failed();
}
