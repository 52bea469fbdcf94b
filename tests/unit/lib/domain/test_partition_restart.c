/* test_partition_restart.c - restarts of every partitioner. Oracle: the partition that was not restarted,
 * whose maps must be equal from then on. Damaged state is refused. */
#include "lib/domain/partition/partition.h"

#include <stdlib.h>
#include <string.h>

#include "tests/check.h"
#include "tests/unit/lib/domain/cell_box.h"

enum { RANKS = 6, ROUNDS = 5 };

static const struct kith_cells *make_cells(void) {
  static struct kith_cells cells;
  static const double lower[3] = {0, 0, 0}, upper[3] = {1, 1.5, 1};
  static const bool periodic[3] = {true, false, false};
  CHECK_OK(kith_cells_init(&cells, lower, upper, periodic, NDIM == 1 ? 0.004 : NDIM == 2 ? 0.05 : 0.1, 5000));
  return &cells;
}

/* The weights have a peak that moves. */
static void moving_weights(const struct kith_cells *cells, int round, double *weight) {
  for (int64_t c = 0; c < cells->n; ++c) {
    const struct kith_box box = cell_box(cells, c);
    double d2 = 0;
    for (int a = 0; a < NDIM; ++a) {
      const double d = box.lower[a] - (0.2 + 0.12 * round) * (a == 1 ? 0.5 : 1);
      d2 += d * d;
    }
    weight[c] = 1 + 40 * exp(-20 * d2);
  }
}

static int64_t *state_of(const struct kith_partition *partition, size_t *n) {
  *n = kith_partition_state(partition, NULL);
  int64_t *word = calloc(*n + 1, sizeof *word);
  word[*n] = 77;
  CHECK(kith_partition_state(partition, word) == *n && word[*n] == 77);
  return word;
}

/* Restores the state of one partition into another, which has seen other weights before. */
static void check_continues(const char *name) {
  const struct kith_cells *cells = make_cells();
  struct kith_partition *one = NULL, *other = NULL;
  double *weight = calloc((size_t)cells->n, sizeof *weight);
  bool changed;
  size_t n;
  CHECK_OK(kith_partition_create(&one, cells, RANKS, name));
  CHECK_OK(kith_partition_create(&other, cells, RANKS, name));
  CHECK_OK(kith_partition_update(other, NULL, &changed));
  for (int round = 0; round < ROUNDS; ++round) {
    moving_weights(cells, round, weight);
    CHECK_OK(kith_partition_update(one, weight, &changed));
  }
  int64_t *word = state_of(one, &n);
  CHECK_OK(kith_partition_restore(other, word, n));
  CHECK_STATUS(KITH_BAD_FILE, kith_partition_restore(other, word, n + 1));
  memcpy(other->owner, one->owner, (size_t)cells->n * sizeof *one->owner);
  for (int round = ROUNDS; round < 2 * ROUNDS; ++round) {
    moving_weights(cells, round, weight);
    CHECK_OK(kith_partition_update(one, weight, &changed));
    CHECK_OK(kith_partition_update(other, weight, &changed));
    if (memcmp(one->owner, other->owner, (size_t)cells->n * sizeof *one->owner) != 0) {
      fprintf(stderr, "%d-D, %s: the maps of round %d differ\n", NDIM, name, round);
      ++check_failures;
    }
  }
  free(word);
  free(weight);
  kith_partition_destroy(&one);
  kith_partition_destroy(&other);
}

/* Damages one word at a time: each is refused, and the next update works. */
static void check_damage(const char *name) {
  const struct kith_cells *cells = make_cells();
  static const int64_t wrong[] = {-1, INT64_MIN, INT64_MAX, INT64_C(1) << 49, 0x7ff8000000000000};
  struct kith_partition *partition = NULL;
  bool changed;
  size_t n;
  CHECK_OK(kith_partition_create(&partition, cells, RANKS, name));
  int64_t *word = state_of(partition, &n);
  for (size_t k = 0; k < n; ++k)
    for (int w = 0; w < 5; ++w) {
      const int64_t right = word[k];
      word[k] = wrong[w];
      CHECK_STATUS(KITH_BAD_FILE, kith_partition_restore(partition, word, n));
      word[k] = right;
    }
  CHECK_OK(kith_partition_update(partition, NULL, &changed));
  for (int64_t c = 0; c < cells->n; ++c) CHECK(partition->owner[c] >= 0 && partition->owner[c] < RANKS);
  free(word);
  kith_partition_destroy(&partition);
}

static void test_state(void) {
  for (int k = 0; kith_partitioner_all()[k] != NULL; ++k) {
    if (kith_partitioner_all()[k]->needs != NULL) continue;
    check_continues(kith_partitioner_all()[k]->name);
    check_damage(kith_partitioner_all()[k]->name);
  }
  check_continues("diffusion:flow=second-order neighbors=fixed start=morton");
}

int main(void) {
  test_state();
  return check_failed();
}
