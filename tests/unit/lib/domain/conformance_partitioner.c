/* conformance_partitioner.c - every partitioner, with each value of each of its parameters, on grids of every
 * kind: thinner than a cell, one and two cells along a periodic axis, more ranks than cells.
 *
 * Every cell has one owner, which is a rank. Two runs give the same maps; `changed` and the generation are
 * right; only the ratio of weights counts. Unknown names and parameters, values out of range, and weights
 * that are negative or not finite are refused, and change nothing. How well loads are balanced:
 * test_partition_balance.c; restarts: test_partition_restart.c. */
#include "lib/domain/partition/partition.h"

#include <stdlib.h>
#include <string.h>

#include "tests/unit/lib/domain/cell_box.h"
#include "tests/unit/lib/domain/partition_world.h"

enum { UPDATES = 4, MOST_CELLS = 1024, MOST_TEXTS = 40 };

/* ---- members and parameters ---- */

/* Writes the v-th value of a parameter to try: one of its choices, or the lower end of its range. Returns
 * false if there are no more. */
static bool find_value(const struct kith_param *p, int v, char *value) {
  const char *at = p->kind == KITH_PARAM_CHOICE ? p->allowed : p->allowed + 1;
  for (; at != NULL && v > 0; --v) at = strchr(at, '|') == NULL ? NULL : strchr(at, '|') + 1;
  if (at != NULL) snprintf(value, 64, "%.*s", (int)strcspn(at, "|,"), at);
  return at != NULL;
}

/* Lists every available member, alone and with each value of each of its parameters. */
static int list_texts(char (*text)[64]) {
  int n = 0;
  char value[64];
  for (const struct kith_partitioner_ops *const *p = kith_partitioner_all(); *p != NULL; ++p) {
    if ((*p)->needs != NULL) continue;
    snprintf(text[n++], 64, "%s", (*p)->name);
    for (const struct kith_param *row = (*p)->params; row != NULL && row->key != NULL; ++row)
      for (int v = 0; row->allowed[0] != '(' && find_value(row, v, value); ++v)
        snprintf(text[n++], 64, "%s:%.20s=%.20s", (*p)->name, row->key, value);
  }
  snprintf(text[n++], 64, "diffusion:flow=willebeek neighbors=fixed");
  snprintf(text[n++], 64, "diffusion:flow=second_order neighbors=fixed start=morton");
  CHECK(n <= MOST_TEXTS);
  return n;
}

static bool has_map(const struct kith_partition *p, const int32_t *owner) {
  return memcmp(p->owner, owner, (size_t)p->cells->n * sizeof *owner) == 0;
}

static void copy_map(const struct kith_partition *p, int32_t *owner) {
  memcpy(owner, p->owner, (size_t)p->cells->n * sizeof *owner);
}

/* Kinds: equal; a blast in a corner; random over ten orders of magnitude; all zero. */
static void weights(const struct kith_cells *cells, int kind, double *weight) {
  uint64_t random = 11;
  for (int64_t c = 0; c < cells->n; ++c) {
    const struct kith_box box = cell_box(cells, c);
    double r2 = 0;
    for (int a = 0; a < NDIM; ++a) r2 += box.lower[a] * box.lower[a] / (cells->upper[a] * cells->upper[a]);
    const double values[] = {3, 100 * exp(-20 * r2), pow(10, 10 * check_random(&random) - 5), 0};
    weight[c] = values[kind];
  }
}

/* ---- what is refused has no effect ---- */

static void test_refused(void) {
  const int count[] = {5, 4, 3};
  const struct kith_cells cells = grid(count, 2);
  const double bad[] = {-1, -1e-300, NAN, INFINITY};
  char text[MOST_TEXTS][64];
  const int n_texts = list_texts(text);
  double weight[MOST_CELLS];
  for (int t = 0; t < n_texts; ++t) {
    struct kith_partition *partition = partition_of(&cells, 3, text[t]),
                          *twin = partition_of(&cells, 3, text[t]);
    int32_t before[MOST_CELLS], *const place = partition->owner;
    bool changed;
    copy_map(partition, before);
    for (int k = 0; k < 4; ++k) {
      weights(&cells, 1, weight);
      weight[cells.n / 2] = bad[k];
      CHECK_STATUS(KITH_BAD_INPUT, kith_partition_update(partition, weight, &changed));
      CHECK(!changed);
    }
    CHECK(partition->owner == place && partition->generation == 1 && has_map(partition, before));
    weights(&cells, 1, weight); /* a refused update has no effect later either */
    CHECK_OK(kith_partition_update(partition, weight, &changed));
    CHECK_OK(kith_partition_update(twin, weight, &changed));
    CHECK(has_map(partition, twin->owner));
    kith_partition_destroy(&partition);
    kith_partition_destroy(&twin);
  }
}

/* ---- names, parameters, first maps ---- */

static void check_unknown(const struct kith_cells *cells, const char *text, const char *what,
                          const char *named) {
  struct kith_partition *partition = NULL;
  CHECK_STATUS(KITH_BAD_INPUT, kith_partition_create(&partition, cells, 2, text));
  CHECK(partition == NULL && strstr(kith_failure(), what) != NULL && strstr(kith_failure(), named) != NULL);
}

/* A partition can be made from the name that another one reports; unknown names are refused, with a list of
 * all names. */
static void test_names(void) {
  const int count[] = {4, 4, 4};
  const struct kith_cells cells = grid(count, 0);
  const char *const wrong[] = {"metis", "", "KD", "kd|cart", "kdd", "k", ":fixed"};
  for (const struct kith_partitioner_ops *const *p = kith_partitioner_all(); *p != NULL; ++p) {
    CHECK(kith_partitioner_find((*p)->name) == *p);
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; ++k)
      check_unknown(&cells, wrong[k], "partitioner: ", (*p)->name);
    if ((*p)->needs != NULL) continue;
    struct kith_partition *made = partition_of(&cells, 2, (*p)->name),
                          *again = partition_of(&cells, 2, made->ops->name);
    CHECK(made->ops == *p && again->ops == *p && has_map(made, again->owner));
    kith_partition_destroy(&made);
    kith_partition_destroy(&again);
  }
}

/* Values that are allowed are accepted (test_repeats); other values and parameters are refused, here -1
 * unless it is allowed. */
static void test_parameters(void) {
  const int count[] = {4, 4, 4};
  const struct kith_cells cells = grid(count, 0);
  const char *const wrong[] = {"fast", "speed=1", "=", "flow", "flow=fast"};
  for (const struct kith_partitioner_ops *const *p = kith_partitioner_all(); *p != NULL; ++p) {
    if ((*p)->needs != NULL) continue;
    char text[80];
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; ++k) {
      snprintf(text, sizeof text, "%s:%s", (*p)->name, wrong[k]);
      check_unknown(&cells, text, (*p)->name, (*p)->name);
    }
    for (const struct kith_param *row = (*p)->params; row != NULL && row->key != NULL; ++row) {
      double allowed[64]; /* a value of any kind */
      if (kith_param_parse(row, "-1", allowed) == KITH_OK) continue;
      snprintf(text, sizeof text, "%s:%.20s=-1", (*p)->name, row->key);
      check_unknown(&cells, text, (*p)->name, row->key);
    }
  }
}

/* Settings are formatted with all their values. */
static void test_format(void) {
  char text[128];
  void *settings = NULL;
  const struct kith_member member = kith_family_member(kith_partitioner_member, "diffusion");
  CHECK_OK(kith_settings_create(&settings, member, "iterations=3 flow=second-order"));
  kith_settings_format(member, settings, text, sizeof text);
  CHECK(strcmp(text, "diffusion:start=cart neighbors=free flow=second-order iterations=3 momentum=1.8") == 0);
  kith_settings_format(kith_family_member(kith_partitioner_member, "kd"), NULL, text, sizeof text);
  CHECK(strcmp(text, "kd") == 0);
  kith_free(&settings);
}

/* With one axis, cart makes slabs. */
static void test_slabs(void) {
  const int count[] = {8, 4, 4};
  const struct kith_cells cells = grid(count, 0);
  struct kith_partition *slabs = partition_of(&cells, 4, "cart:axes=1");
  for (int64_t c = 0; c < cells.n; ++c) CHECK(slabs->owner[c] == c % 8 / 2);
  kith_partition_destroy(&slabs);
}

/* Members that start with the map of another member. */
static void test_start_maps(void) {
  const int count[] = {7, 3, 2};
  const struct kith_cells cells = grid(count, 0);
  const char *const like[][2] = {{"diffusion", "cart"},
                                 {"diffusion:start=cart", "cart"},
                                 {"diffusion:start=morton", "morton"},
                                 {"hybrid", "graph"}};
  for (size_t k = 0; k < sizeof like / sizeof like[0]; ++k)
    for (int n_ranks = 1; n_ranks <= 8; ++n_ranks) {
      if (k == 3 && kith_partitioner_graph.needs != NULL) continue;
      struct kith_partition *one = partition_of(&cells, n_ranks, like[k][0]),
                            *other = partition_of(&cells, n_ranks, like[k][1]);
      CHECK(has_map(one, other->owner));
      kith_partition_destroy(&one);
      kith_partition_destroy(&other);
    }
}

/* The first update of hybrid is that of graph, all others are those of diffusion. */
static void test_hybrid(void) {
  if (kith_partitioner_hybrid.needs != NULL) return;
  const int count[] = {6, 4, 2};
  const struct kith_cells cells = grid(count, 0);
  double weight[MOST_CELLS];
  int32_t before[MOST_CELLS];
  bool changed;
  struct kith_partition *hybrid = partition_of(&cells, 4, "hybrid"),
                        *graph = partition_of(&cells, 4, "graph"),
                        *diffusion = partition_of(&cells, 4, "diffusion");
  for (int k = 0; k < 4; ++k) {
    weights(&cells, 1 + k % 2, weight);
    copy_map(hybrid, before);
    struct kith_partition *next = k == 0 ? graph : diffusion; /* continues from the same map */
    memcpy(next->owner, before, (size_t)cells.n * sizeof *before);
    CHECK_OK(kith_partition_update(hybrid, weight, &changed));
    CHECK_OK(kith_partition_update(next, weight, &changed));
    CHECK(has_map(hybrid, next->owner));
  }
  kith_partition_destroy(&hybrid);
  kith_partition_destroy(&graph);
  kith_partition_destroy(&diffusion);
}

/* ---- repeated runs, scale of weights ---- */

static void check_owners(const struct kith_partition *partition) {
  int64_t bad = 0;
  for (int64_t c = 0; c < partition->cells->n; ++c)
    bad += partition->owner[c] < 0 || partition->owner[c] >= partition->n_ranks;
  CHECK(bad == 0);
}

/* Updates a partition with all kinds of weights, and stores its maps one after the other. */
static void run(const struct kith_cells *cells, int n_ranks, const char *text, int32_t *maps) {
  struct kith_partition *partition = partition_of(cells, n_ranks, text);
  const size_t size = (size_t)cells->n * sizeof *maps;
  const int32_t *const place = partition->owner;
  double weight[MOST_CELLS];
  CHECK(partition->generation == 1);
  check_owners(partition);
  memcpy(maps, partition->owner, size);
  for (int k = 0; k < UPDATES; ++k) {
    const uint64_t before = partition->generation;
    bool changed = true;
    weights(cells, k, weight);
    CHECK_OK(kith_partition_update(partition, weight, &changed));
    check_owners(partition);
    CHECK(partition->owner == place);
    CHECK(changed == (memcmp(partition->owner, maps, size) != 0));
    CHECK(partition->generation == before + changed);
    maps += cells->n;
    memcpy(maps, partition->owner, size);
  }
  kith_partition_destroy(&partition);
  CHECK(partition == NULL);
}

static void check_repeats(const struct kith_cells *cells, int n_ranks, const char *text) {
  static int32_t maps[2][(UPDATES + 1) * MOST_CELLS];
  const size_t size = (size_t)cells->n * (UPDATES + 1) * sizeof maps[0][0];
  run(cells, n_ranks, text, maps[0]);
  run(cells, n_ranks, text, maps[1]);
  CHECK(memcmp(maps[0], maps[1], size) == 0);
  if (check_failures > 0) fprintf(stderr, "  %s, %d ranks, %d cells\n", text, n_ranks, (int)cells->n);
}

/* 1, 2, 3 and more cells along an axis, open and periodic, with up to 4096 ranks. */
static void test_repeats(void) {
  const struct {
    int count[3], periodic;
  } world[] = {{{1, 1, 1}, 7}, {{2, 2, 2}, 7}, {{3, 3, 3}, 7}, {{1, 2, 2}, 5},
               {{2, 1, 9}, 6}, {{8, 8, 6}, 3}, {{13, 5, 3}, 0}};
  const int ranks[] = {1, 2, 3, 4, 7, 8, 64, 4096};
  char text[MOST_TEXTS][64];
  const int n_texts = list_texts(text);
  for (size_t w = 0; w < sizeof world / sizeof world[0]; ++w) {
    const struct kith_cells cells = grid(world[w].count, world[w].periodic);
    for (size_t r = 0; r < sizeof ranks / sizeof ranks[0]; ++r)
      for (int t = 0; t < n_texts && check_failures == 0; ++t) check_repeats(&cells, ranks[r], text[t]);
  }
}

/* Only the ratio of weights matters, however large or small they are. */
static void test_scale(void) {
  const int count[] = {16, 4, 4};
  const struct kith_cells cells = grid(count, 0);
  for (const struct kith_partitioner_ops *const *p = kith_partitioner_all(); *p != NULL; ++p) {
    if ((*p)->needs != NULL) continue;
    int32_t first[MOST_CELLS];
    const double unit[] = {1, 0x1p-1000, 0x1p1010}; /* powers of two: no rounding */
    for (int k = 0; k < 3; ++k) {
      struct kith_partition *partition = partition_of(&cells, 4, (*p)->name);
      double weight[MOST_CELLS];
      bool changed;
      weights(&cells, 1, weight);
      for (int64_t c = 0; c < cells.n; ++c) weight[c] = ceil(weight[c]) * unit[k];
      CHECK_OK(kith_partition_update(partition, weight, &changed));
      if (k == 0) memcpy(first, partition->owner, (size_t)cells.n * sizeof *first);
      CHECK(memcmp(first, partition->owner, (size_t)cells.n * sizeof *first) == 0);
      kith_partition_destroy(&partition);
    }
  }
}

/* A partitioner without its library is in the list, and choosing it says what is missing. */
static void test_unavailable(void) {
  const int count[] = {4, 4, 4};
  const struct kith_cells cells = grid(count, 0);
  for (const struct kith_partitioner_ops *const *p = kith_partitioner_all(); *p != NULL; ++p) {
    struct kith_partition *partition = NULL;
    if ((*p)->needs == NULL) continue;
    CHECK_STATUS(KITH_UNSUPPORTED, kith_partition_create(&partition, &cells, 2, (*p)->name));
    CHECK(strstr(kith_failure(), (*p)->needs) != NULL);
  }
}

static void test_no_ranks(void) {
  const int count[] = {4, 4, 4};
  const struct kith_cells cells = grid(count, 0);
  struct kith_partition *partition = NULL;
  CHECK_STATUS(KITH_BAD_INPUT, kith_partition_create(&partition, &cells, 0, "kd"));
}

int main(void) {
  test_refused();
  test_names();
  test_parameters();
  test_format();
  test_slabs();
  test_start_maps();
  test_hybrid();
  test_repeats();
  test_scale();
  test_unavailable();
  test_no_ranks();
  return check_failed();
}
