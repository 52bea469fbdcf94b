/* test_tree.c - the test of octets against a box, in portable form and with AVX-512 masks (where the
 * processor has them). Oracle: plain loops; on lattices with exact ties, too. */
#include "lib/neighbor/tree.c"

#include "tests/check.h"

enum { OCTETS = 40 };

static uint64_t seed = 9;

static double coordinate(bool lattice) {
  return lattice ? floor(7 * check_random(&seed)) : 7 * check_random(&seed);
}

static double square(double d) {
  return d * d;
}

static unsigned expected(const struct octet *octet, int cells, const struct query *q) {
  unsigned mask = 0;
  for (int k = 0; k < cells; ++k) {
    double d2 = 0;
    for (int a = 0; a < NDIM; ++a) {
      const double lower = octet->lower[a][k], upper = octet->upper[a][k];
      d2 += q->box.upper[a] < lower   ? square(lower - q->box.upper[a])
            : q->box.lower[a] > upper ? square(q->box.lower[a] - upper)
                                      : 0;
    }
    if (d2 <= q->radius2 || d2 <= q->cell * octet->radius2[k]) mask |= 1u << k;
  }
  return mask;
}

static void check_octets(bool lattice) {
  struct octet octet[OCTETS];
  kith_index child[OCTETS + 1] = {0}, octets[OCTETS];
  struct tree tree = {.octet = octet, .child = child};
  struct query q = {.radius2 = check_random(&seed) < 0.3 ? -1 : coordinate(lattice),
                    .cell = check_random(&seed) < 0.3 ? 0 : 1};
  for (int a = 0; a < NDIM; ++a)
    q.box.lower[a] = coordinate(lattice), q.box.upper[a] = q.box.lower[a] + coordinate(lattice) / 3;
  if (lattice)
    for (int a = 0; a < NDIM; ++a) q.box.upper[a] = ceil(q.box.upper[a]);
  for (int o = 0; o < OCTETS; ++o) {
    octets[o] = (7 * o) % OCTETS;
    child[o + 1] = child[o] + 1 + (kith_index)(check_random(&seed) * WIDTH);
    for (int k = 0; k < WIDTH; ++k) {
      octet[o].radius2[k] = coordinate(lattice);
      for (int a = 0; a < NDIM; ++a) {
        octet[o].lower[a][k] = coordinate(lattice);
        octet[o].upper[a][k] = octet[o].lower[a][k] + floor(2 * check_random(&seed));
      }
    }
  }
  for (int n = 0; n <= BATCH; n += 8) {
    unsigned mask[2][BATCH];
    test_octets(&tree, octets, n, &q, mask[0]);
    int forms = 1;
#ifdef __x86_64__
    if (__builtin_cpu_supports("avx512f")) forms = 2, test_octets_wide(&tree, octets, n, &q, mask[1]);
#endif
    for (int form = 0; form < forms; ++form)
      for (int k = 0; k < n; ++k) {
        const kith_index o = octets[k];
        CHECK(mask[form][k] == expected(&octet[o], child[o + 1] - child[o], &q));
      }
  }
}

int main(void) {
  for (int round = 0; round < 200; ++round) check_octets(round % 2);
  return check_failed();
}
