/* Carries, sums over ranks and the rounding of exact sums. */
#include "lib/comm/sum.h"

#include <math.h>

/* All digits but the last, which has the sign, become 0 .. 2^32 - 1. */
void kith_sum_carry(struct kith_sum *sum) {
  for (int k = 0; k + 1 < KITH_SUM_DIGITS; ++k) {
    const int64_t carry = sum->word[k] >> 32;
    sum->word[k] &= 0xffffffff;
    sum->word[k + 1] += carry;
  }
  sum->terms = 0;
}

void kith_sum_odd(struct kith_sum *sum, double term) {
  sum->word[isnan(term) ? KITH_SUM_NAN : term > 0 ? KITH_SUM_INFINITE : KITH_SUM_NEGATIVE] += 1;
}

/* Cuts every term into three parts, multiples of 2^(e - 44), 2^(e - 90) and 2^(e - 136) where 2^e <= most <
 * 2^(e + 1), so that up to 256 parts of a kind add up without rounding in any order; left[k] is what is below
 * all of them, mostly nothing (Rump, Ogita, Oishi 2008, SIAM J. Sci. Comput. 31, 189: the extraction). Is
 * anything left? */
KITH_HOT static bool cut_terms(const double *restrict term, int n, double most, double *restrict part,
                               double *restrict left) {
  const double large = ldexp(1.5, ilogb(most) + 8), middle = ldexp(large, -46), small = ldexp(large, -92);
  double high = 0, low = 0, least = 0;
  int any = 0;
#pragma omp simd reduction(+ : high, low, least) reduction(| : any)
  for (int k = 0; k < n; ++k) {
    const double a = (term[k] + large) - large, rest = term[k] - a;
    const double b = (rest + middle) - middle, below = rest - b;
    const double c = (below + small) - small;
    high += a, low += b, least += c;
    left[k] = below - c;
    any |= left[k] != 0;
  }
  part[0] = high, part[1] = low, part[2] = least;
  return any != 0;
}

KITH_HOT static double largest_term(const double *restrict term, int n) {
  double most = 0;
#pragma omp simd reduction(max : most)
  for (int k = 0; k < n; ++k) { /* what is not a number is larger than all */
    const double size = term[k] == term[k] ? fabs(term[k]) : INFINITY;
    most = size > most ? size : most;
  }
  return most;
}

void kith_sum_add_all(struct kith_sum *sum, const double *term, int n) {
  const double most = largest_term(term, n);
  double part[3], left[KITH_SUM_TOGETHER];
  if (most == 0) return;
  if (!(most > 0x1p-800 && most < 0x1p900)) { /* parts would not be exact */
    for (int k = 0; k < n; ++k) kith_sum_add(sum, term[k]);
    return;
  }
  const bool any = cut_terms(term, n, most, part, left);
  for (int k = 0; k < 3; ++k) kith_sum_add(sum, part[k]);
  for (int k = 0; any && k < n; ++k)
    if (left[k] != 0) kith_sum_add(sum, left[k]);
}

void kith_sum_join(struct kith_sum *to, const struct kith_sum *from) {
  struct kith_sum carried = *from;
  kith_sum_carry(&carried);
  for (int k = 0; k < KITH_SUM_WORDS; ++k) to->word[k] += carried.word[k];
  kith_sum_carry(to);
}

/* Digits below 2^32 of up to 2^31 ranks add up to less than 2^63. */
struct kith_shared kith_sum_shared(struct kith_sum *sum) {
  kith_sum_carry(sum);
  return (struct kith_shared){KITH_SHARE_SUM, KITH_SUM_WORDS, sum->word};
}

void kith_sum_ranks(struct kith_ranks *ranks, struct kith_sum *sums, int n) {
  enum { MANY = KITH_SHARED_WORDS / KITH_SUM_WORDS };
  struct kith_shared parts[MANY];
  for (int from = 0; ranks != NULL && from < n; from += MANY) {
    const int here = KITH_MIN(n - from, MANY);
    for (int s = 0; s < here; ++s) parts[s] = kith_sum_shared(&sums[from + s]);
    kith_ranks_agree(ranks, KITH_OK, here, parts);
    for (int s = 0; s < here; ++s) kith_sum_carry(&sums[from + s]);
  }
}

/* The value of non-negative digits. The three highest digits have at least 65 significant bits, which the
 * conversion to double rounds to 53, ties to even; all lower digits are represented by one sticky bit. A
 * result with fewer bits (a subnormal number) is exact. */
static double round_once(const int64_t *digit) {
  int top = KITH_SUM_DIGITS - 1;
  while (top > 0 && digit[top] == 0) --top;
  unsigned __int128 bits = 0;
  for (int k = top; k > top - 3; --k) bits = bits << 32 | (k >= 0 ? (uint64_t)digit[k] : 0);
  bool more = false;
  for (int k = top - 3; k >= 0; --k) more = more || digit[k] != 0;
  return ldexp((double)(bits | more), 32 * (top - 2) - 1075);
}

double kith_sum_value(const struct kith_sum *sum) {
  struct kith_sum s = *sum;
  if (s.word[KITH_SUM_NAN] > 0 || (s.word[KITH_SUM_INFINITE] > 0 && s.word[KITH_SUM_NEGATIVE] > 0))
    return NAN;
  if (s.word[KITH_SUM_INFINITE] > 0) return INFINITY;
  if (s.word[KITH_SUM_NEGATIVE] > 0) return -INFINITY;
  kith_sum_carry(&s);
  const bool negative = s.word[KITH_SUM_DIGITS - 1] < 0;
  for (int k = 0; negative && k < KITH_SUM_DIGITS; ++k) s.word[k] = -s.word[k];
  if (negative) kith_sum_carry(&s);
  return negative ? -round_once(s.word) : round_once(s.word);
}
