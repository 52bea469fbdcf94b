/* test_sfc_key.c - keys of space-filling curves, against bits that are interleaved one at a time; and the
 * sort by key and tie, against qsort. */
#include "tests/check.h"
#include "lib/core/sfc_key.h"
#include <stdlib.h>

struct record {
  uint64_t key;
  int64_t tie;
  kith_index number;
};

static int compare(const void *a, const void *b) {
  const struct record *p = a, *q = b;
  if (p->key != q->key) return p->key < q->key ? -1 : 1;
  if (p->tie != q->tie) return p->tie < q->tie ? -1 : 1;
  return p->number < q->number ? -1 : p->number > q->number;
}

enum { MOST = 50000 };
static uint64_t key[MOST];
static int64_t tie[MOST];
static struct record record[MOST];
static struct kith_keyed scratch[2 * MOST];
static kith_index order[MOST + 1];

static void check_sort(size_t n, bool ties) {
  for (size_t i = 0; i < n; ++i) record[i] = (struct record){key[i], ties ? tie[i] : 0, (kith_index)i};
  qsort(record, n, sizeof *record, compare);
  order[n] = -7;
  CHECK_OK(kith_sfc_key_sort(n, key, ties ? tie : NULL, scratch, order));
  bool same = order[n] == -7;
  for (size_t i = 0; i < n; ++i) same = same && order[i] == record[i].number;
  CHECK(same);
}

/* Keys below 2^bits (few bits make long runs of equal keys), and ties in -range .. range. */
static void fill(size_t n, int bits, int64_t range, uint64_t seed) {
  for (size_t i = 0; i < n; ++i) {
    const uint64_t high = (uint64_t)(check_random(&seed) * 0x1p53),
                   low = (uint64_t)(check_random(&seed) * 0x1p53);
    const uint64_t word = high << 11 ^ low;
    key[i] = bits == 0 ? 42 : word >> (64 - bits);
    tie[i] = (int64_t)(check_random(&seed) * (double)(2 * range + 1)) - range;
  }
}

static void check_random_keys(void) {
  const size_t sizes[] = {0, 1, 2, 3, 31, 33, 1000, 20000, MOST};
  const int bits[] = {0, 1, 3, 11, 12, 33, 63, 64};
  for (size_t s = 0; s < sizeof sizes / sizeof *sizes; ++s)
    for (size_t b = 0; b < sizeof bits / sizeof *bits; ++b) {
      fill(sizes[s], bits[b], s % 2 == 0 ? 3 : INT64_C(1) << 40, 17 * s + b);
      check_sort(sizes[s], true);
      check_sort(sizes[s], false);
    }
}

static void check_sorted_keys(void) {
  for (size_t i = 0; i < 1000; ++i) key[i] = i / 3, tie[i] = (int64_t)i;
  check_sort(1000, true);
  tie[1] = -5; /* only a tie is out of order */
  check_sort(1000, true);
  key[999] = 0; /* the last key is out of order */
  check_sort(1000, true);
  key[0] = UINT64_MAX;
  tie[4] = INT64_MIN, tie[5] = INT64_MAX;
  check_sort(1000, true);
}

/* The oracle: interleaves bits one at a time. */
static uint64_t slow_key(const uint64_t *c) {
  uint64_t k = 0;
  for (int bit = KITH_SFC_KEY_BITS - 1; bit >= 0; --bit)
    for (int a = 0; a < NDIM; ++a) k = k << 1 | (c[a] >> bit & 1);
  return k;
}

static void check_keys(void) {
  uint64_t seed = 5;
  for (int t = 0; t < 1000; ++t) {
    uint64_t c[NDIM];
    for (int a = 0; a < NDIM; ++a)
      c[a] = (uint64_t)(check_random(&seed) * 0x1p53) >> (53 - KITH_SFC_KEY_BITS);
    CHECK(kith_sfc_key_of_cell(c) == slow_key(c));
  }
  const double top = (double)(UINT64_C(1) << KITH_SFC_KEY_BITS);
  double lower[NDIM], inverse[NDIM], x[NDIM];
  uint64_t all[NDIM], none[NDIM];
  for (int a = 0; a < NDIM; ++a)
    lower[a] = -1, inverse[a] = top / 2, all[a] = (UINT64_C(1) << KITH_SFC_KEY_BITS) - 1, none[a] = 0;
  for (int a = 0; a < NDIM; ++a) x[a] = 1;
  CHECK(kith_sfc_key_of_position(x, lower, inverse) == slow_key(all));
  for (int a = 0; a < NDIM; ++a) x[a] = 1e300;
  CHECK(kith_sfc_key_of_position(x, lower, inverse) == slow_key(all));
  for (int a = 0; a < NDIM; ++a) x[a] = -3;
  CHECK(kith_sfc_key_of_position(x, lower, inverse) == slow_key(none));
  for (int a = 0; a < NDIM; ++a) x[a] = NAN;
  CHECK(kith_sfc_key_of_position(x, lower, inverse) == slow_key(none));
}

int main(void) {
  check_keys();
  check_random_keys();
  check_sorted_keys();
  return check_failed();
}
