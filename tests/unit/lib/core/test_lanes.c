/* Lanes: transposition of four records, and vectors of a row in any number, beside plain indexing; halves. */
#include "lib/core/lanes.h"

#include <math.h>
#include "tests/check.h"

static void transposes(void) {
  static const int order[] = {3, 0, 2, 1};
  double record[4][4];
  const double *from[4];
  kith_lanes to[4];
  for (int k = 0; k < 16; ++k) record[k / 4][k % 4] = 10 * (k / 4) + k % 4;
  for (int l = 0; l < 4; ++l) from[l] = record[order[l]];
  kith_lanes_transpose(from, to);
  for (int q = 0; q < 4; ++q)
    for (int l = 0; l < 4; ++l) CHECK(to[q][l] == record[order[l]][q]);
}

/* Rows of 0 to 9 nodes, the last node of the field among them: it is allocated as fields of nodes are. */
static void separations(void) {
  enum { NODES = 7, STRIDE = 16 };
  static const kith_index row[] = {6, 0, 3, 3, 5, 1, 6, 2, 6};
  double *field = NULL, *to = NULL;
  CHECK_OK(kith_resize(&field, 0, NODES + 1, NDIM * sizeof *field));
  for (int k = 0; k < NODES * NDIM; ++k) field[k] = 100 + k;
  CHECK_OK(kith_resize(&to, 0, (NDIM + 1) * STRIDE, sizeof *to));
  for (size_t n = 0; n <= sizeof row / sizeof *row; ++n) {
    kith_lanes_separations(field, 4, row, NULL, NULL, n, to, STRIDE, to + NDIM * STRIDE);
    for (size_t k = 0; k < kith_lanes_padded(n); ++k) {
      const double apart = NDIM * (row[KITH_MIN(k, n - 1)] - 4); /* on each axis */
      for (int a = 0; a < NDIM; ++a) CHECK(to[a * STRIDE + k] == apart);
      CHECK(to[NDIM * STRIDE + k] == NDIM * apart * apart);
    }
  }
  kith_free(&field);
  kith_free(&to);
}

/* Numbers of 21 bits come back, others to 2^-21; signs, and factors of two, change nothing else. */
static void halves(void) {
  enum { STRIDE = 3 };
  static const double exact[] = {0, 1, -0.375, 0x1.fffffp-3, -0x1p-1022, 0x1p1023, -3};
  static const int power[] = {-900, -1, 1, 900};
  double room[4], apart[3 * STRIDE + 1];
  kith_halve(exact, 7, room);
  for (int k = 0; k < 4; ++k) apart[k * STRIDE] = room[k];
  for (int k = 0; k < 7; ++k)
    CHECK(kith_half(room, 1, k) == exact[k] && kith_half(apart, STRIDE, k) == exact[k]);
  double worst = 0;
  for (int k = 0; k < 1000; ++k) {
    const double x = 1 + k * 0.0012345678912345;
    room[0] = kith_halves(x, -x);
    const double first = kith_half(room, 1, 0);
    CHECK(kith_half(room, 1, 1) == -first);
    for (int p = 0; p < 4; ++p) {
      room[1] = kith_halves(0, ldexp(x, power[p]));
      CHECK(kith_half(room, 1, 3) == ldexp(first, power[p]));
    }
    worst = fmax(worst, fabs(first - x) / x);
  }
  CHECK(worst > 0x1p-23 && worst <= 0x1p-21);
}

int main(void) {
  transposes();
  separations();
  halves();
  return check_failed();
}
