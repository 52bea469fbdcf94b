/* sum.h - exact sums of doubles: independent of the order of the terms, rounded once at the end.
 *
 * A double is a 53-bit integer times a power of 2, so that an integer of 67 digits of 32 bits holds any sum
 * of doubles (a long accumulator: Kulisch 1981; digits in 64-bit words with space for carries: Neal 2015,
 * arXiv 1505.05571). Integers are added here, so the result is bitwise identical for any order of the terms,
 * any number of threads and any number of ranks.
 *
 *   error     kith_sum_value is the double nearest to the exact sum (ties to even): |error| <= 2^-53 |sum|,
 *             for any number of terms below 2^47 and any cancellation. Subnormal sums are exact. The sum of
 *             no terms, or of terms that cancel, is +0.
 *   not finite  infinite if there are infinite terms of one sign or the sum exceeds the largest double; NaN
 *               if there is a NaN, or infinite terms of both signs.
 *   cost      2 to 3 ns a term, of terms of similar size together less than 1; 568 bytes. */
#ifndef KITH_COMM_SUM_H
#define KITH_COMM_SUM_H

#include <string.h>
#include "lib/core/base.h"
#include "lib/comm/ranks.h"

/* Digit k counts 2^(32 k - 1075); after the digits, the numbers of terms that were NaN, +infinite and
 * -infinite. */
enum {
  KITH_SUM_DIGITS = 67,
  KITH_SUM_NAN = KITH_SUM_DIGITS,
  KITH_SUM_INFINITE,
  KITH_SUM_NEGATIVE,
  KITH_SUM_WORDS
};
enum { KITH_SUM_MOST = 2000 }; /* terms, of at most 2^52 in a word, before carries must be propagated */

/* An empty sum is all zeros. Private. */
struct kith_sum {
  int64_t word[KITH_SUM_WORDS];
  int terms; /* since the last carry */
};

void kith_sum_carry(struct kith_sum *sum);
/* A term that is not finite. */
void kith_sum_odd(struct kith_sum *sum, double term);

static inline void kith_sum_add(struct kith_sum *sum, double term) {
  uint64_t bits;
  memcpy(&bits, &term, sizeof bits);
  const unsigned exponent = (unsigned)(bits >> 52) & 0x7ff;
  if (__builtin_expect(exponent == 0x7ff, 0)) {
    kith_sum_odd(sum, term);
    return;
  }
  const uint64_t fraction = bits & ((UINT64_C(1) << 52) - 1);
  const int64_t whole = (int64_t)(exponent > 0 ? fraction | UINT64_C(1) << 52 : fraction << 1);
  const int64_t sign = (int64_t)bits >> 63, signed_whole = (whole ^ sign) - sign; /* sign is 0 or -1 */
  int64_t *word = sum->word + (exponent >> 5);
  /* The lower 32 bits, and the rest rounded down. */
  word[0] += (uint32_t)signed_whole << (exponent & 31);
  word[1] += signed_whole >> (32 - (exponent & 31));
  if (++sum->terms == KITH_SUM_MOST) kith_sum_carry(sum);
}

/* n terms, n <= KITH_SUM_TOGETHER. */
enum { KITH_SUM_TOGETHER = 256 };
void kith_sum_add_all(struct kith_sum *sum, const double *term, int n);

void kith_sum_join(struct kith_sum *to, const struct kith_sum *from);
/* The sum as a part of what ranks agree on. */
struct kith_shared kith_sum_shared(struct kith_sum *sum);
/* Each of n sums over all ranks. Collective. */
void kith_sum_ranks(struct kith_ranks *ranks, struct kith_sum *sums, int n);
double kith_sum_value(const struct kith_sum *sum);

#endif
