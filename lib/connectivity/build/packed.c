/* packed.c - the distance test, 64 nodes at a time.
 *
 * The inner loops are written so that the compiler vectorizes them: first one word per node, then the bits
 * are gathered; a single loop that shifts under a condition stays scalar with gcc 12. */
#include "lib/connectivity/build/packed.h"

#ifdef __x86_64__
#include <immintrin.h>
#endif

kith_status kith_packed_reserve(struct kith_packed *packed, size_t n) {
  if (n <= (size_t)packed->capacity) return KITH_OK;
  if (n > INT32_MAX / 2) KITH_FAIL(UNSUPPORTED, "%zu candidates are too many", n);
  const size_t capacity = (n + n / 4 + 63) / 64 * 64, keep = (size_t)packed->n;
  packed->capacity = packed->n = 0;
  KITH_TRY(kith_resize(&packed->node, keep, capacity, sizeof *packed->node));
  KITH_TRY(kith_resize(&packed->shift, keep, capacity, sizeof *packed->shift));
  for (int a = 0; a < NDIM; ++a)
    KITH_TRY(kith_resize(&packed->coordinate[a], keep, capacity, sizeof(double)));
  KITH_TRY(kith_resize(&packed->radius2, keep, capacity, sizeof(double)));
  packed->n = (int)keep;
  packed->capacity = (int)capacity;
  return KITH_OK;
}

void kith_packed_clear(struct kith_packed *packed) {
  KITH_FREE(&packed->node, &packed->shift);
  for (int a = 0; a < NDIM; ++a) kith_free(&packed->coordinate[a]);
  kith_free(&packed->radius2);
  *packed = (struct kith_packed){0};
}

void kith_packed_close(struct kith_packed *packed, int n) {
  packed->n = n;
  packed->words = (n + 63) / 64;
  for (int p = n; p < 64 * packed->words; ++p) {
    for (int a = 0; a < NDIM; ++a) packed->coordinate[a][p] = NAN;
    packed->radius2[p] = 0;
  }
}

KITH_HOT static int hits(const struct kith_packed *packed, const double *x, double target_radius2,
                         uint64_t *restrict hit) {
  const double *c[NDIM], *radius2 = packed->radius2;
  double at[NDIM];
  for (int a = 0; a < NDIM; ++a) c[a] = packed->coordinate[a], at[a] = x[a];
  const int words = packed->words;
  int count = 0;
  for (int w = 0; w < words; ++w) {
    uint64_t within[64], bits = 0;
    for (int k = 0; k < 64; ++k) {
      double d2 = 0;
      for (int a = 0; a < NDIM; ++a) {
        const double d = c[a][64 * w + k] - at[a];
        d2 += d * d;
      }
      const double r2 = radius2[64 * w + k];
      within[k] = d2 <= (r2 > target_radius2 ? r2 : target_radius2);
    }
    for (uint64_t k = 0; k < 64; ++k) bits |= within[k] << k;
    hit[w] = bits;
    count += __builtin_popcountll(bits);
  }
  return count;
}

#ifdef __x86_64__
/* The same with masks, which the compiler does not use by itself. */
__attribute__((target("avx512f"))) static int hits_wide(const struct kith_packed *packed, const double *x,
                                                        double target_radius2, uint64_t *restrict hit) {
  int count = 0;
  for (int w = 0; w < packed->words; ++w) {
    uint64_t bits = 0;
    for (int k = 0; k < 64; k += 8) {
      __m512d d2 = _mm512_setzero_pd(), r2 = _mm512_load_pd(packed->radius2 + 64 * w + k);
      for (int a = 0; a < NDIM; ++a) {
        const __m512d c = _mm512_load_pd(packed->coordinate[a] + 64 * w + k);
        const __m512d d = _mm512_sub_pd(c, _mm512_set1_pd(x[a])), square = _mm512_mul_pd(d, d);
        d2 = a == 0 ? square : _mm512_add_pd(d2, square);
      }
      r2 = _mm512_max_pd(r2, _mm512_set1_pd(target_radius2));
      bits |= (uint64_t)_mm512_cmp_pd_mask(d2, r2, _CMP_LE_OQ) << k;
    }
    hit[w] = bits;
    count += __builtin_popcountll(bits);
  }
  return count;
}
#endif

int kith_packed_hits(const struct kith_packed *packed, const double *x, double radius2, uint64_t *hit) {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx512f")) return hits_wide(packed, x, radius2, hit);
#endif
  return hits(packed, x, radius2, hit);
}

KITH_HOT static void between(const struct kith_packed *packed, const double *x, const double *y,
                             uint64_t *restrict hit) {
  const double *c[NDIM];
  double from[NDIM], to[NDIM];
  for (int a = 0; a < NDIM; ++a) c[a] = packed->coordinate[a], from[a] = x[a], to[a] = y[a];
  const int words = packed->words;
  for (int w = 0; w < words; ++w) {
    uint64_t inside[64], bits = 0;
    for (int k = 0; k < 64; ++k) {
      double ahead = 0, behind = 0;
      for (int a = 0; a < NDIM; ++a) {
        const double z = c[a][64 * w + k];
        ahead += (z - from[a]) * (to[a] - from[a]);
        behind += (z - to[a]) * (from[a] - to[a]);
      }
      inside[k] = (uint64_t)(ahead > 0) & (uint64_t)(behind > 0);
    }
    for (uint64_t k = 0; k < 64; ++k) bits |= inside[k] << k;
    hit[w] &= bits;
  }
}

void kith_packed_between(const struct kith_packed *packed, const double *x, const double *y, uint64_t *hit) {
  between(packed, x, y, hit);
}

static void extract(const kith_index *node, int words, const uint64_t *hit, kith_index *restrict out) {
  for (int w = 0; w < words; ++w)
    for (uint64_t bits = hit[w]; bits != 0; bits &= bits - 1) *out++ = node[64 * w + __builtin_ctzll(bits)];
}

#ifdef __x86_64__
/* The same for 16 candidates at a time. Stores have masks: behind a row is the next one, and what is
 * compressed by a store itself takes a hundred cycles on some processors. */
__attribute__((target("avx512f"))) static void extract_wide(const kith_index *node, int words,
                                                            const uint64_t *hit, kith_index *restrict out) {
  for (int w = 0; w < words; ++w)
    for (int k = 0; k < 64; k += 16) {
      const __mmask16 bits = (__mmask16)(hit[w] >> k);
      const int n = __builtin_popcount(bits);
      const __m512i nodes = _mm512_maskz_loadu_epi32(bits, node + 64 * w + k);
      _mm512_mask_storeu_epi32(out, (__mmask16)((1u << n) - 1), _mm512_maskz_compress_epi32(bits, nodes));
      out += n;
    }
}
#endif

void kith_packed_extract(const kith_index *node, int words, const uint64_t *hit, kith_index *restrict out) {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx512f")) {
    extract_wide(node, words, hit, out);
    return;
  }
#endif
  extract(node, words, hit, out);
}

void kith_packed_extract_shifts(const uint16_t *shift, int words, const uint64_t *hit,
                                uint16_t *restrict out) {
  for (int w = 0; w < words; ++w)
    for (uint64_t bits = hit[w]; bits != 0; bits &= bits - 1) *out++ = shift[64 * w + __builtin_ctzll(bits)];
}

enum { LANES = 16 };

/* within[k] = 1 for those of the first `lanes` slots behind the pointers within range of the box. */
static inline void box_lanes(const double *const *c, const double *radius2, int lanes,
                             const struct kith_box *box, double target_radius2, uint64_t *restrict within) {
  for (int k = 0; k < lanes; ++k) {
    double d2 = 0;
    for (int a = 0; a < NDIM; ++a) {
      const double below = box->lower[a] - c[a][k], above = c[a][k] - box->upper[a];
      const double out = below > above ? below : above;
      const double d = out > 0 ? out : 0;
      d2 += d * d;
    }
    within[k] = d2 <= (radius2[k] > target_radius2 ? radius2[k] : target_radius2);
  }
}

/* box_lanes for `count` slots, of `left` to the end of all slots. Whole blocks vectorize, so slots behind
 * `count` are tested too if there are enough, and not used. */
static inline void test_lanes(const double *const *c, const double *radius2, int count, kith_index left,
                              const struct kith_box *box, double target_radius2, uint64_t *restrict within) {
  if (left >= LANES)
    box_lanes(c, radius2, LANES, box, target_radius2, within);
  else
    box_lanes(c, radius2, count, box, target_radius2, within);
}

KITH_HOT static size_t box_slots(const struct kith_search *search, struct kith_run run,
                                 const struct kith_box *box, double target_radius2,
                                 kith_index *restrict slot) {
  const struct kith_box b = *box;
  const double *radius2 = search->radius2;
  uint64_t within[LANES];
  size_t found = 0;
  for (kith_index s = run.first; s < run.first + run.count; s += LANES) {
    const double *c[NDIM];
    for (int a = 0; a < NDIM; ++a) c[a] = search->coordinate[a] + s;
    const int count = KITH_MIN(LANES, run.first + run.count - s);
    test_lanes(c, radius2 + s, count, search->n - s, &b, target_radius2, within);
    for (int k = 0; k < count; ++k)
      slot[found] = s + k, found += within[k]; /* without a branch that could be mispredicted */
  }
  return found;
}

size_t kith_box_slots(const struct kith_search *search, struct kith_run run, const struct kith_box *box,
                      double target_radius2, kith_index *slot) {
  return box_slots(search, run, box, target_radius2, slot);
}

/* Appends the slots within range: each is written, and overwritten by the next one unless it is within. */
KITH_HOT static void add_slots(struct kith_packed *packed, const struct kith_search *search,
                               struct kith_run run, const struct kith_box *box, double target_radius2) {
  const struct kith_box b = *box;
  kith_index *restrict node = packed->node;
  double *restrict to[NDIM + 1];
  const double *c[NDIM + 1];
  uint64_t within[LANES];
  size_t n = (size_t)packed->n;
  for (int a = 0; a < NDIM; ++a) to[a] = packed->coordinate[a];
  to[NDIM] = packed->radius2;
  for (kith_index s = run.first; s < run.first + run.count; s += LANES) {
    const int count = KITH_MIN(LANES, run.first + run.count - s);
    for (int a = 0; a < NDIM; ++a) c[a] = search->coordinate[a] + s;
    c[NDIM] = search->radius2 + s;
    test_lanes(c, c[NDIM], count, search->n - s, &b, target_radius2, within);
    for (int k = 0; k < count; ++k) {
      node[n] = s + k;
      for (int a = 0; a <= NDIM; ++a) to[a][n] = c[a][k];
      n += within[k];
    }
  }
  packed->n = (int)n;
}

#ifdef __x86_64__
/* The same with masks: the slots within range are compressed and stored together. */
__attribute__((target("avx512f"))) static void add_slots_wide(struct kith_packed *packed,
                                                              const struct kith_search *search,
                                                              struct kith_run run, const struct kith_box *box,
                                                              double target_radius2) {
  const __m512d zero = _mm512_setzero_pd(), target = _mm512_set1_pd(target_radius2);
  const __m512i ascending = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 0, 0, 0, 0, 0, 0, 0, 0);
  int n = packed->n;
  for (kith_index s = run.first; s < run.first + run.count; s += 8) {
    const __mmask8 all = (__mmask8)((1u << KITH_MIN(8, run.first + run.count - s)) - 1);
    const __m512d r2 = _mm512_maskz_loadu_pd(all, search->radius2 + s);
    __m512d d2 = zero, c[NDIM];
    for (int a = 0; a < NDIM; ++a) {
      c[a] = _mm512_maskz_loadu_pd(all, search->coordinate[a] + s);
      const __m512d below = _mm512_sub_pd(_mm512_set1_pd(box->lower[a]), c[a]),
                    above = _mm512_sub_pd(c[a], _mm512_set1_pd(box->upper[a])),
                    d = _mm512_max_pd(_mm512_max_pd(below, above), zero), square = _mm512_mul_pd(d, d);
      d2 = a == 0 ? square : _mm512_add_pd(d2, square);
    }
    const __mmask8 within = _mm512_mask_cmp_pd_mask(all, d2, _mm512_max_pd(r2, target), _CMP_LE_OQ);
    const __m512i slots = _mm512_add_epi32(_mm512_set1_epi32(s), ascending);
    _mm512_storeu_si512(packed->node + n, _mm512_maskz_compress_epi32(within, slots));
    for (int a = 0; a < NDIM; ++a)
      _mm512_storeu_pd(packed->coordinate[a] + n, _mm512_maskz_compress_pd(within, c[a]));
    _mm512_storeu_pd(packed->radius2 + n, _mm512_maskz_compress_pd(within, r2));
    n += __builtin_popcount(within);
  }
  packed->n = n;
}
#endif

void kith_packed_add(struct kith_packed *packed, const struct kith_search *search, struct kith_run run,
                     const struct kith_box *box, double radius2) {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx512f")) {
    add_slots_wide(packed, search, run, box, radius2);
    return;
  }
#endif
  add_slots(packed, search, run, box, radius2);
}
