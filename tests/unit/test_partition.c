/* What every partitioner must do, with every word that it knows, on every kind of grid and weight: each cell has one
 * owner in range, twice the same is the same bit by bit, `changed` tells the truth, and bad input is refused. */
#include "lib/domain/partition.h"

#include <stdlib.h>
#include <string.h>

#include "tests/unit/partition_world.h"

enum { UPDATES = 4, MOST_CELLS = 1024 };

/* Equal, a blast in a corner, by lot with ten orders of magnitude between them, all zero. */
static void weights(const struct kith_cells *cells, int kind, double *weight) {
  uint64_t random = 11;
  for (int64_t c = 0; c < cells->n; ++c) {
    const struct kith_box box = kith_cells_box(cells, c);
    double r2 = 0;
    for (int a = 0; a < NDIM; ++a) r2 += box.lower[a] * box.lower[a] / (cells->upper[a] * cells->upper[a]);
    const double values[] = {3, 100 * exp(-20 * r2), pow(10, 10 * check_random(&random) - 5), 0};
    weight[c] = values[kind];
  }
}

static void check_owners(const struct kith_partition *partition) {
  int64_t bad = 0;
  for (int64_t c = 0; c < partition->cells->n; ++c)
    bad += partition->owner[c] < 0 || partition->owner[c] >= partition->n_ranks;
  CHECK(bad == 0);
}

/* Runs one partitioner through all weights and writes its maps, one after the other. */
static void run(const struct kith_cells *cells, int n_ranks, const char *text, int32_t *maps) {
  struct kith_partition *partition = NULL;
  CHECK_OK(kith_partition_create(&partition, cells, n_ranks, text));
  if (partition == NULL) return;
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
    CHECK_OK(kith_partition_update(partition, weight, NULL, &changed));
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

static void check_text(const struct kith_cells *cells, int n_ranks, const char *text) {
  static int32_t maps[2][(UPDATES + 1) * MOST_CELLS];
  const size_t size = (size_t)cells->n * (UPDATES + 1) * sizeof maps[0][0];
  run(cells, n_ranks, text, maps[0]);
  run(cells, n_ranks, text, maps[1]);
  CHECK(memcmp(maps[0], maps[1], size) == 0);
  if (check_failures > 0) fprintf(stderr, "  %s, %d ranks, %d cells\n", text, n_ranks, (int)cells->n);
}

/* Also thinner than a cell, 1 and 2 cells on a periodic axis, and more ranks than cells. */
static void test_all(void) {
  const int count[][3] = {{1, 1, 1}, {1, 2, 2}, {2, 1, 9}, {8, 8, 6}, {13, 5, 3}};
  const int ranks[] = {1, 2, 3, 4, 7, 8, 64, 4096};
  for (const struct kith_partitioner_ops *const *p = kith_partitioner_all(); *p != NULL; ++p) {
    if ((*p)->needs != NULL) continue;
    for (size_t g = 0; g < sizeof count / sizeof count[0]; ++g) {
      const struct kith_cells cells = grid(count[g], (int)(0x5a >> g & 7));
      for (size_t r = 0; r < sizeof ranks / sizeof ranks[0] && check_failures == 0; ++r) {
        check_text(&cells, ranks[r], (*p)->name);
        for (int w = 0; (*p)->words != NULL && (*p)->words[w] != NULL; ++w) {
          char text[64];
          snprintf(text, sizeof text, "%s:%s", (*p)->name, (*p)->words[w]);
          check_text(&cells, ranks[r], text);
        }
      }
    }
  }
}

/* Every position has the rank of its cell; none: -1. */
static void test_rank_of(void) {
  const int count[] = {6, 4, 3};
  const struct kith_cells cells = grid(count, 1);
  struct kith_partition *partition = NULL;
  CHECK_OK(kith_partition_create(&partition, &cells, 5, "hilbert"));
  for (int64_t c = 0; c < cells.n; ++c) {
    const struct kith_box box = kith_cells_box(&cells, c);
    double middle[NDIM];
    for (int a = 0; a < NDIM; ++a) middle[a] = 0.5 * (box.lower[a] + box.upper[a]);
    CHECK(kith_partition_rank_of(partition, box.lower) == partition->owner[c]);
    CHECK(kith_partition_rank_of(partition, middle) == partition->owner[c]);
    middle[0] += 6; /* around the periodic axis */
    CHECK(kith_partition_rank_of(partition, middle) == partition->owner[c]);
    middle[NDIM - 1] = NAN;
    CHECK(kith_partition_rank_of(partition, middle) == -1);
  }
  kith_partition_destroy(&partition);
}

/* ---- names ---- */

static void check_refused(const char *text, const char *named) {
  const int count[] = {4, 4, 4};
  const struct kith_cells cells = grid(count, 0);
  struct kith_partition *partition = NULL;
  CHECK_STATUS(KITH_BAD_INPUT, kith_partition_create(&partition, &cells, 2, text));
  CHECK(partition == NULL);
  CHECK(strstr(kith_failure(), named) != NULL);
}

static void test_names(void) {
  const char *const wanted[] = {"cart",  "kd",        "morton",    "hilbert", "graph",
                                "p4est", "diffusion", "gridbased", "hybrid"};
  int n = 0;
  for (const struct kith_partitioner_ops *const *p = kith_partitioner_all(); *p != NULL; ++p, ++n) {
    CHECK(n < 9 && strcmp((*p)->name, wanted[n]) == 0);
    CHECK(kith_partitioner_find((*p)->name) == *p);
    CHECK((*p)->doc != NULL && (*p)->doc[0] != '\0');
    CHECK((*p)->needs != NULL || (*p)->first != NULL);
  }
  CHECK(n == 9 && kith_partitioner_find("car") == NULL && kith_partitioner_find("") == NULL);
  check_refused("metis", "hilbert"); /* names what there is */
  check_refused("", "hilbert");
  check_refused("cart ", "hilbert");
  check_refused("cart:", "no variants");
  check_refused("cart:fixed", "no variants");
  check_refused("diffusion:", "schornbaum");
  check_refused("diffusion:fixed,", "schornbaum");
  check_refused("diffusion:,fixed", "schornbaum");
  check_refused("diffusion:third-order", "second-order");
  check_refused("diffusion:fixed:morton", "second-order");
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

static void test_commands(void) {
  const int count[] = {4, 4, 4};
  const struct kith_cells cells = grid(count, 0);
  struct kith_partition *partition = NULL;
  CHECK_OK(kith_partition_create(&partition, &cells, 2,
                                 "diffusion:second_order,fixed")); /* - and _ are one letter */
  CHECK_OK(kith_partition_command(partition, "willebeek,free"));
  CHECK_STATUS(KITH_BAD_INPUT, kith_partition_command(partition, "fast"));
  CHECK(strstr(kith_failure(), "willebeek") != NULL && strstr(kith_failure(), "fast") != NULL);
  kith_partition_destroy(&partition);
  kith_partition_destroy(&partition);
  CHECK_OK(kith_partition_create(&partition, &cells, 2, "kd"));
  CHECK_STATUS(KITH_BAD_INPUT, kith_partition_command(partition, "toggle"));
  kith_partition_destroy(&partition);
}

/* ---- weights ---- */

static void test_bad_weights(void) {
  const int count[] = {4, 4, 4};
  const struct kith_cells cells = grid(count, 0);
  struct kith_partition *partition = NULL;
  CHECK_STATUS(KITH_BAD_INPUT, kith_partition_create(&partition, &cells, 0, "kd"));
  CHECK_OK(kith_partition_create(&partition, &cells, 3, "kd"));
  int32_t before[MOST_CELLS];
  double weight[MOST_CELLS], face_weight[MOST_CELLS * NDIM];
  memcpy(before, partition->owner, (size_t)cells.n * sizeof *before);
  const double bad[] = {-1, NAN, INFINITY, -INFINITY};
  for (int k = 0; k < 4; ++k) {
    bool changed = true;
    weights(&cells, 1, weight);
    weight[cells.n - 1] = bad[k];
    CHECK_STATUS(KITH_BAD_INPUT, kith_partition_update(partition, weight, NULL, &changed));
    CHECK(!changed);
    for (int64_t f = 0; f < cells.n * NDIM; ++f) face_weight[f] = 1;
    face_weight[0] = bad[k];
    CHECK_STATUS(KITH_BAD_INPUT, kith_partition_update(partition, NULL, face_weight, &changed));
    CHECK(!changed && memcmp(before, partition->owner, (size_t)cells.n * sizeof *before) == 0);
  }
  kith_partition_destroy(&partition);
}

/* Huge and tiny weights are weights: what counts is their ratio. */
static void test_scale(void) {
  const int count[] = {16, 4, 4};
  const struct kith_cells cells = grid(count, 0);
  for (const struct kith_partitioner_ops *const *p = kith_partitioner_all(); *p != NULL; ++p) {
    if ((*p)->needs != NULL) continue;
    int32_t first[MOST_CELLS];
    const double unit[] = {1, 0x1p-1000, 0x1p1010}; /* powers of two: the same bits */
    for (int k = 0; k < 3; ++k) {
      struct kith_partition *partition = NULL;
      double weight[MOST_CELLS];
      bool changed;
      CHECK_OK(kith_partition_create(&partition, &cells, 4, (*p)->name));
      weights(&cells, 1, weight);
      for (int64_t c = 0; c < cells.n; ++c) weight[c] = ceil(weight[c]) * unit[k];
      CHECK_OK(kith_partition_update(partition, weight, NULL, &changed));
      if (k == 0) memcpy(first, partition->owner, (size_t)cells.n * sizeof *first);
      CHECK(memcmp(first, partition->owner, (size_t)cells.n * sizeof *first) == 0);
      kith_partition_destroy(&partition);
    }
  }
}

int main(void) {
  test_all();
  test_rank_of();
  test_names();
  test_unavailable();
  test_commands();
  test_bad_weights();
  test_scale();
  return check_failed();
}
