/* test_symmetric.c - inverses of symmetric matrices: regular, flat and empty ones. */
#include "lib/core/symmetric.h"
#include "tests/check.h"

/* The inverse of a diagonal matrix is that of `like`, in any units. */
static void check_moments(const double *diagonal, const double *like) {
  static const double units[] = {1, 1e-150, 1e150};
  for (int k = 0; k < 3; ++k) {
    double m[KITH_SYMMETRIC_SIZE] = {0}, inverse[KITH_SYMMETRIC_SIZE];
    for (int a = 0; a < NDIM; ++a) m[kith_symmetric_at(a, a)] = units[k] * diagonal[a];
    CHECK(kith_invert_moments(m, inverse));
    for (int a = 0; a < NDIM; ++a)
      for (int b = a; b < NDIM; ++b)
        CHECK_CLOSE(units[k] * inverse[kith_symmetric_at(a, b)], a == b ? 1 / like[a] : 0, 1e-14 / like[a]);
  }
}

/* A rotated matrix times its inverse is 1. */
static void check_regular(void) {
  const double c = 0.6, s = 0.8, low = 0.5, high = 1;
  double m[KITH_SYMMETRIC_SIZE] = {high}, inverse[KITH_SYMMETRIC_SIZE];
  if (NDIM > 1) {
    m[kith_symmetric_at(0, 0)] = c * c * low + s * s * high;
    m[kith_symmetric_at(0, NDIM - 1)] = c * s * (high - low);
    m[kith_symmetric_at(NDIM - 1, NDIM - 1)] = s * s * low + c * c * high;
    if (NDIM == 3) m[kith_symmetric_at(1, 1)] = 0.75;
  }
  CHECK(kith_invert_moments(m, inverse));
  for (int a = 0; a < NDIM; ++a)
    for (int b = 0; b < NDIM; ++b) {
      double sum = 0;
      for (int k = 0; k < NDIM; ++k) sum += m[kith_symmetric_at(a, k)] * inverse[kith_symmetric_at(k, b)];
      CHECK_CLOSE(sum, a == b ? 1 : 0, 1e-14);
    }
}

int main(void) {
  const double one[] = {1, 1, 1}, even[] = {1, 0.6, 0.6}, line[] = {1, 0, 0}, plane[] = {1, 1, 0},
               none[KITH_SYMMETRIC_SIZE] = {0};
  double inverse[KITH_SYMMETRIC_SIZE];
  check_moments(one, one);
  check_moments(even, even);
  check_moments(line, one);
  check_moments(plane, one);
  check_regular();
  CHECK(!kith_invert_moments(none, inverse));
  for (int k = 0; k < KITH_SYMMETRIC_SIZE; ++k) CHECK(inverse[k] == 0);
  return check_failed();
}
