/* test_packed.c - distance tests, extraction of hits and box tests on packed nodes. Oracle: plain loops. The
 * portable form and the one with AVX-512 masks (where the processor has them) are tested on lattices with
 * exact ties, on random nodes, for 0 to 300 nodes, and at the ends of arrays. */
#include "lib/connectivity/build/packed.c"

#include <stdlib.h>
#include <string.h>
#include "tests/check.h"

enum { MOST = 300 };

static uint64_t seed = 5;

static bool has_masks(void) {
#ifdef __x86_64__
  return __builtin_cpu_supports("avx512f");
#else
  return false;
#endif
}

/* On a lattice differences and squares are exact, so that fused multiply-adds change nothing. */
static double coordinate(bool lattice) {
  return lattice ? floor(7 * check_random(&seed)) : 7 * check_random(&seed);
}

static double radius2(bool lattice) {
  return lattice ? floor(6 * check_random(&seed)) : 6 * check_random(&seed);
}

static double square(double d) {
  return d * d;
}

static void check_distances(kith_index n, bool lattice) {
  struct kith_packed packed = {0};
  const double target = radius2(lattice);
  double x[NDIM];
  uint64_t expected[MOST / 64 + 1] = {0}, hit[2][MOST / 64 + 1];
  kith_index neighbor[MOST], out[2][MOST + 64];
  int count = 0;
  CHECK_OK(kith_packed_reserve(&packed, (size_t)n));
  for (int a = 0; a < NDIM; ++a) x[a] = coordinate(lattice);
  for (kith_index k = 0; k < n; ++k) {
    double d2 = 0;
    packed.node[k] = 3 * k + 1;
    packed.radius2[k] = radius2(lattice);
    for (int a = 0; a < NDIM; ++a)
      packed.coordinate[a][k] = coordinate(lattice), d2 += square(packed.coordinate[a][k] - x[a]);
    if (d2 > packed.radius2[k] && d2 > target) continue;
    expected[k / 64] |= UINT64_C(1) << (k % 64);
    neighbor[count++] = packed.node[k];
  }
  kith_packed_close(&packed, n);
  for (int k = 0; k < MOST + 64; ++k) out[0][k] = out[1][k] = -7;
  CHECK(hits(&packed, x, target, hit[0]) == count);
  extract(packed.node, packed.words, hit[0], out[0]);
#ifdef __x86_64__
  if (has_masks()) {
    CHECK(hits_wide(&packed, x, target, hit[1]) == count);
    extract_wide(packed.node, packed.words, hit[1], out[1]);
  }
#endif
  for (int form = 0; form < (has_masks() ? 2 : 1); ++form) {
    CHECK(memcmp(hit[form], expected, (size_t)packed.words * sizeof *expected) == 0);
    CHECK(memcmp(out[form], neighbor, (size_t)count * sizeof *neighbor) == 0);
    CHECK(out[form][count] == -7); /* the next row begins here */
  }
  kith_packed_clear(&packed);
}

/* A search whose slots are its nodes, in arrays with no room behind the last node. */
static void fill(struct kith_search *search, kith_index n, bool lattice) {
  *search = (struct kith_search){.n = n};
  search->radius2 = malloc(((size_t)n + 1) * sizeof(double));
  for (int a = 0; a < NDIM; ++a) search->coordinate[a] = malloc(((size_t)n + 1) * sizeof(double));
  for (kith_index s = 0; s < n; ++s) {
    search->radius2[s] = radius2(lattice);
    for (int a = 0; a < NDIM; ++a) search->coordinate[a][s] = coordinate(lattice);
  }
}

static bool near_box(const struct kith_search *search, kith_index s, const struct kith_box *box,
                     double target) {
  double d2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double x = search->coordinate[a][s];
    d2 += x < box->lower[a] ? square(box->lower[a] - x) : x > box->upper[a] ? square(x - box->upper[a]) : 0;
  }
  return d2 <= search->radius2[s] || d2 <= target;
}

typedef void adding(struct kith_packed *packed, const struct kith_search *search, struct kith_run run,
                    const struct kith_box *box, double target_radius2);

/* Adds the run twice: the second time behind the nodes that are packed already. */
static void check_adding(adding *add, const struct kith_search *search, struct kith_run run,
                         const struct kith_box *box, double target) {
  struct kith_packed packed = {0};
  kith_index slot[MOST + 1], listed[MOST + 1];
  int count = 0;
  for (kith_index s = run.first; s < run.first + run.count; ++s)
    if (near_box(search, s, box, target)) slot[count++] = s;
  CHECK(kith_box_slots(search, run, box, target, listed) == (size_t)count);
  CHECK(memcmp(listed, slot, (size_t)count * sizeof *slot) == 0);
  CHECK_OK(kith_packed_reserve(&packed, 2 * (size_t)run.count + KITH_PACKED_ROOM));
  for (int time = 0; time < 2; ++time) {
    add(&packed, search, run, box, target);
    CHECK(packed.n == (time + 1) * count);
    for (int k = 0; k < count && packed.n == (time + 1) * count; ++k) {
      const int p = time * count + k;
      CHECK(packed.node[p] == slot[k] && packed.radius2[p] == search->radius2[slot[k]]);
      for (int a = 0; a < NDIM; ++a) CHECK(packed.coordinate[a][p] == search->coordinate[a][slot[k]]);
    }
  }
  kith_packed_clear(&packed);
}

static void check_boxes(kith_index n, bool lattice) {
  struct kith_search search;
  fill(&search, n, lattice);
  for (int round = 0; round < 20; ++round) {
    const kith_index first = (kith_index)(check_random(&seed) * (n + 1));
    const struct kith_run run = {
        first, round % 4 == 0 ? n - first : (kith_index)(check_random(&seed) * (n - first + 1))};
    struct kith_box box;
    for (int a = 0; a < NDIM; ++a)
      box.lower[a] = coordinate(lattice), box.upper[a] = box.lower[a] + round % 3;
    const double target = round % 5 == 0 ? 0 : radius2(lattice);
    check_adding(add_slots, &search, run, &box, target);
#ifdef __x86_64__
    if (has_masks()) check_adding(add_slots_wide, &search, run, &box, target);
#endif
    check_adding(kith_packed_add, &search, run, &box, target);
  }
  free(search.radius2);
  for (int a = 0; a < NDIM; ++a) free(search.coordinate[a]);
}

int main(void) {
  static const kith_index sizes[] = {0, 1, 7, 8, 9, 15, 16, 17, 63, 64, 65, 130, MOST};
  for (size_t k = 0; k < sizeof sizes / sizeof *sizes; ++k)
    for (int lattice = 0; lattice < 2; ++lattice) {
      for (int round = 0; round < 20; ++round) check_distances(sizes[k], lattice);
      check_boxes(sizes[k], lattice);
    }
  return check_failed();
}
