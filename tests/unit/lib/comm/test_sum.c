/* test_sum.c - sums that do not depend on the order of terms. Oracles: exact sums of 128-bit integers,
 * rounded once; sums known by hand; and the same terms in other orders and partial sums. All must be equal to
 * the last bit, except the comparison with long double in close_to_long_double. */
#include "lib/comm/sum.h"
#include <float.h>
#include <stdlib.h>
#include "tests/check.h"

static double sum_of(const double *term, int n) {
  struct kith_sum sum = {0};
  for (int k = 0; k < n; ++k) kith_sum_add(&sum, term[k]);
  return kith_sum_value(&sum);
}

/* Sums in up to three parts, then joins them. */
static double sum_of_parts(const double *term, int n, uint64_t *state) {
  struct kith_sum part[3] = {0}, sum = {0};
  const int used = 1 + (int)(3 * check_random(state));
  for (int k = 0; k < n; ++k) kith_sum_add(&part[(int)(used * check_random(state))], term[k]);
  for (int k = 2; k >= 0; --k) kith_sum_join(&sum, &part[k]);
  return kith_sum_value(&sum);
}

/* Adds several terms in one call. */
static double sum_of_batches(const double *term, int n, uint64_t *state) {
  struct kith_sum sum = {0};
  for (int k = 0, here; k < n; k += here) {
    here = (int)(KITH_SUM_TOGETHER * check_random(state)) + 1;
    here = KITH_MIN(here, n - k);
    kith_sum_add_all(&sum, term + k, here);
  }
  return kith_sum_value(&sum);
}

static void shuffle(double *term, int n, uint64_t *state) {
  for (int k = n - 1; k > 0; --k) {
    const int j = (int)((k + 1) * check_random(state));
    const double swap = term[k];
    term[k] = term[j], term[j] = swap;
  }
}

static bool identical(double a, double b) {
  return memcmp(&a, &b, sizeof a) == 0 || (isnan(a) && isnan(b));
}

static void identical_in_any_order(double *term, int n, uint64_t *state) {
  const double first = sum_of(term, n);
  for (int k = 0; k < 5; ++k) {
    shuffle(term, n, state);
    CHECK(identical(sum_of(term, n), first) && identical(sum_of_parts(term, n, state), first));
    CHECK(identical(sum_of_batches(term, n, state), first));
  }
}

/* Compares with exact sums: terms are 53-bit integers of both signs times 2^(0..span), whose sum fits into
 * 128 bits and is rounded once, by the compiler. The sizes lie around those at which the sum propagates
 * carries. `shift` multiplies all terms by 2^shift. */
static void exact_sums(int n, int span, int shift) {
  double *term = calloc((size_t)n, sizeof *term);
  uint64_t state = (uint64_t)(n + span);
  __int128 wanted = 0;
  for (int k = 0; k < n; ++k) {
    const int64_t whole = (int64_t)(check_random(&state) * 0x1p53) * (check_random(&state) < 0.5 ? 1 : -1);
    const int up = (int)(span * check_random(&state));
    wanted += (__int128)whole * ((__int128)1 << up);
    term[k] = ldexp((double)whole, up + shift);
  }
  CHECK(identical(sum_of(term, n), ldexp((double)wanted, shift) + 0.0));
  identical_in_any_order(term, n, &state);
  free(term);
}

/* All terms have one sign and all mantissa bits set, so that the words of the sum fill as fast as
 * possible. */
static void full_words(int n) {
  const int64_t whole = (INT64_C(1) << 53) - 1;
  for (int exponent = -40; exponent < 40; ++exponent) {
    struct kith_sum up = {0}, down = {0};
    for (int k = 0; k < n; ++k) {
      kith_sum_add(&up, ldexp((double)whole, exponent));
      kith_sum_add(&down, -ldexp((double)whole, exponent));
    }
    const double wanted = ldexp((double)((__int128)whole * n), exponent);
    CHECK(kith_sum_value(&up) == wanted && kith_sum_value(&down) == -wanted);
    kith_sum_join(&up, &down);
    CHECK(identical(kith_sum_value(&up), 0.0));
  }
}

/* Terms of all exponents, also subnormal. After all have cancelled, the one that is left must be returned to
 * the last bit. */
static void any_bits(void) {
  enum { N = 5000 };
  static double term[2 * N + 1];
  uint64_t state = 11;
  for (int k = 0; k < N; ++k) {
    const int exponent = (int)(2098 * check_random(&state)) - 1074;
    term[k] = ldexp(2 * check_random(&state) - 1, exponent);
  }
  identical_in_any_order(term, N / 2, &state);
  static const double rest[] = {1, -1e-300, 0x1p-1074, -0x1.8p-1060, DBL_MAX, -DBL_MIN, 0x1.fffffffffffffp-1};
  for (size_t k = 0; k < sizeof rest / sizeof *rest; ++k) {
    for (int i = 0; i < N; ++i) term[N + i] = -term[i];
    CHECK(identical(sum_of(term, 2 * N), 0.0));
    term[2 * N] = rest[k];
    CHECK(identical(sum_of(term, 2 * N + 1), rest[k]));
    identical_in_any_order(term, 2 * N + 1, &state);
    for (int i = 0; i < N; ++i)
      term[i] = ldexp(2 * check_random(&state) - 1, (int)(2098 * check_random(&state)) - 1074);
  }
}

#define TERMS(...) \
  sum_of((const double[]){__VA_ARGS__}, (int)(sizeof((double[]){__VA_ARGS__}) / sizeof(double)))

static void rounding(void) {
  CHECK(TERMS(1, 0x1p-53) == 1);                                 /* a tie rounds to even */
  CHECK(TERMS(1, 0x1p-53, 0x1p-1074) == 1 + DBL_EPSILON);        /* above the tie */
  CHECK(TERMS(1, 0x1p-53, -0x1p-1074) == 1);                     /* below it */
  CHECK(TERMS(1 + DBL_EPSILON, 0x1p-53) == 1 + 2 * DBL_EPSILON); /* a tie that rounds up */
  CHECK(TERMS(-1, -0x1p-53, -0x1p-1074) == -1 - DBL_EPSILON);
  CHECK(TERMS(0x1p-1074, 0x1p-1074) == 0x1p-1073 && TERMS(DBL_MIN, -0x1p-1074) == DBL_MIN - 0x1p-1074);
  CHECK(TERMS(1e16, 1, -1e16) == 1 && TERMS(1e308, 1, -1e308, 1e-308) == 1);
  CHECK(identical(TERMS(0.0, -0.0), 0.0) && identical(TERMS(-0.0), 0.0) && identical(TERMS(3, -3), 0.0));
  struct kith_sum none = {0};
  CHECK(identical(kith_sum_value(&none), 0.0));
}

static void not_finite(void) {
  CHECK(TERMS(1, INFINITY, 2) == INFINITY && TERMS(-INFINITY, -INFINITY, 1e300) == -INFINITY);
  CHECK(isnan(TERMS(INFINITY, -INFINITY)) && isnan(TERMS(1, NAN, 2)) && isnan(TERMS(INFINITY, NAN)));
  CHECK(TERMS(DBL_MAX, DBL_MAX) == INFINITY && TERMS(-DBL_MAX, -DBL_MAX) == -INFINITY);
  CHECK(TERMS(DBL_MAX, DBL_MAX, -DBL_MAX) == DBL_MAX); /* partial sums may exceed DBL_MAX */
  uint64_t state = 5;
  double odd[] = {1, INFINITY, -2, 3, INFINITY}, worse[] = {1, INFINITY, -2, NAN, -INFINITY};
  identical_in_any_order(odd, 5, &state);
  identical_in_any_order(worse, 5, &state);
}

/* Tolerance: one rounding of the sum (2^-52), and the n roundings of the long double sum that is the
 * reference. */
static void close_to_long_double(void) {
  enum { N = 20000 };
  struct kith_sum sum = {0};
  uint64_t state = 7;
  long double wanted = 0;
  for (int k = 0; k < N; ++k) {
    const double term = check_random(&state);
    kith_sum_add(&sum, term);
    wanted += (long double)term;
  }
  CHECK_CLOSE(kith_sum_value(&sum), (double)wanted, (double)wanted * (0x1p-52 + N * (double)LDBL_EPSILON));
}

int main(void) {
  static const int sizes[] = {1, 2, 3, 1999, 2000, 2001, 4000, 10007};
  for (int k = 0; k < 8; ++k)
    for (int span = 1; span < 60; span += 19) {
      exact_sums(sizes[k], span, -30);
      exact_sums(sizes[k], span, -1074); /* some terms are subnormal */
    }
  full_words(6001);
  any_bits();
  rounding();
  not_finite();
  close_to_long_double();
  struct kith_sum two[2] = {0};
  kith_sum_add(&two[1], 2.5);
  kith_sum_ranks(NULL, two, 2); /* one process: unchanged */
  CHECK(kith_sum_value(&two[0]) == 0 && kith_sum_value(&two[1]) == 2.5);
  return check_failed();
}
