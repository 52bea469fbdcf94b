/* overlap.c - overlap rows by unions of bit sets.
 *
 * Let S(k) be the neighbors j of k with |x_j - x_k| <= R_j (their support holds k), and G(i) those with
 * |x_i - x_k| <= R_i. Then row i is row(i) and the union of S(k) over k in G(i), without i.
 *
 * A union of 60 rows of 60 entries would be 3600 steps for each node. Nodes are in curve order, so S(k) fills
 * few 64-bit words of a bitmap over the nodes: S is kept as (word, bits), a union is one OR for each word,
 * and the row comes out sorted. With images the bitmap is one for each shift after the other, and the words
 * of S(k), seen from i, are moved by those of the shift of k: shifts add up. */
#include "lib/connectivity/build/builder.h"

#include <omp.h>

static double radius2(const struct kith_nodes *nodes, kith_index i) {
  return nodes->search_radius->f64[i] * nodes->search_radius->f64[i];
}

/* --- spans --- */

/* Words of the bitmap of one shift. */
static kith_index words_of(const struct kith_rows *rows) {
  return (rows->n + 63) / 64;
}

/* The word of entry e, as seen from a node displaced by shift `from`. */
static inline kith_index word_of(const struct kith_rows *rows, size_t e, int from) {
  return rows->node[e] / 64 + (kith_row_shift(rows, e) + from - rows->zero) * words_of(rows);
}

/* Writes S(k) as words and their bits; returns how many. word, bits: NULL to count only. */
static size_t spans_of(const struct kith_rows *rows, const struct kith_build *build, kith_index k,
                       kith_index *word, uint64_t *bits) {
  size_t n = 0;
  kith_index last = -1;
  for (size_t e = rows->first[k]; e < rows->first[k + 1]; ++e) {
    const kith_index j = rows->node[e], here = word_of(rows, e, rows->zero);
    if (!(kith_build_distance2(build, k, j, kith_row_shift(rows, e)) <= radius2(build->nodes, j))) continue;
    if (here != last) {
      last = here;
      if (word != NULL) word[n] = last, bits[n] = 0;
      ++n;
    }
    if (word != NULL) bits[n - 1] |= UINT64_C(1) << (j % 64);
  }
  return n;
}

static kith_status make_spans(const struct kith_rows *rows, const struct kith_build *build) {
  struct kith_rows *spans = &build->scratch->spans;
  KITH_TRY(kith_rows_reserve(spans, rows->n));
#pragma omp parallel for schedule(dynamic, 1024) if (rows->n > KITH_FEW)
  for (kith_index k = 0; k < rows->n; ++k) spans->first[k + 1] = spans_of(rows, build, k, NULL, NULL);
  KITH_TRY(kith_rows_sum(spans, -1));
  KITH_TRY(kith_reserve(&build->scratch->bits, &build->scratch->bits_capacity, spans->first[rows->n],
                        sizeof *build->scratch->bits));
#pragma omp parallel for schedule(dynamic, 1024) if (rows->n > KITH_FEW)
  for (kith_index k = 0; k < rows->n; ++k)
    spans_of(rows, build, k, spans->node + spans->first[k], build->scratch->bits + spans->first[k]);
  return KITH_OK;
}

/* --- unions --- */

/* A set of nodes under construction: words lowest * 64 .. highest * 64 + 63 of the bitmap may be in use. */
struct set {
  uint64_t *bitmap, *touched;
  kith_index lowest, highest;
};

static inline void set_or(struct set *set, kith_index word, uint64_t bits) {
  const kith_index t = word / 64;
  set->bitmap[word] |= bits;
  set->touched[t] |= UINT64_C(1) << (word % 64);
  set->lowest = KITH_MIN(set->lowest, t);
  set->highest = KITH_MAX(set->highest, t);
}

/* Row i of the overlap, as a set. */
static void unite(const struct kith_rows *rows, const struct kith_build *build, kith_index i,
                  struct set *set) {
  const struct kith_rows *spans = &build->scratch->spans;
  const uint64_t *bits = build->scratch->bits;
  const double mine = radius2(build->nodes, i);
  for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
    const kith_index k = rows->node[e], by = (kith_row_shift(rows, e) - rows->zero) * words_of(rows);
    set_or(set, word_of(rows, e, rows->zero), UINT64_C(1) << (k % 64));
    if (!(kith_build_distance2(build, i, k, kith_row_shift(rows, e)) <= mine)) continue;
    for (size_t s = spans->first[k]; s < spans->first[k + 1]; ++s) set_or(set, spans->node[s] + by, bits[s]);
  }
  set->bitmap[rows->zero * words_of(rows) + i / 64] &= ~(UINT64_C(1) << (i % 64));
}

static uint64_t allowed(const struct kith_build *build, kith_index i, kith_index word, int shift,
                        uint64_t bits) {
  if (build->excluders == NULL) return bits;
  kith_index node[64];
  uint16_t shifts[64];
  const struct kith_packed these = {.n = 64, .words = 1, .node = node, .shift = shifts};
  for (int k = 0; k < 64; ++k) node[k] = 64 * word + k, shifts[k] = (uint16_t)shift;
  kith_build_exclude(build, KITH_BROAD, i, kith_build_zero(build), &these, &bits);
  kith_build_exclude(build, KITH_NARROW, i, kith_build_zero(build), &these, &bits);
  return bits;
}

/* Counts the set, writes it to row i of the overlap if `fill`, and empties it. */
static size_t drain(const struct kith_build *build, const struct kith_rows *rows, kith_index i,
                    struct set *set, const struct kith_rows *overlap, bool fill) {
  const kith_index words = words_of(rows);
  const size_t first = fill ? overlap->first[i] : 0; /* which is being counted else */
  size_t n = 0;
  for (kith_index t = set->lowest; t <= set->highest; ++t) {
    for (uint64_t rest = set->touched[t]; rest != 0; rest &= rest - 1) {
      const kith_index at = 64 * t + __builtin_ctzll(rest), word = at % words;
      uint64_t bits = allowed(build, i, word, at / words, set->bitmap[at]);
      set->bitmap[at] = 0;
      if (!fill) n += (size_t)__builtin_popcountll(bits);
      for (; fill && bits != 0; bits &= bits - 1) {
        if (overlap->shift != NULL) overlap->shift[first + n] = (uint16_t)(at / words);
        overlap->node[first + n++] = 64 * word + __builtin_ctzll(bits);
      }
    }
    set->touched[t] = 0;
  }
  if (fill && overlap->shift != NULL) kith_entries_sort(overlap->node + first, overlap->shift + first, n);
  return n;
}

/* One pass over the rows: counts them, or fills them in. */
static void pass(struct kith_rows *overlap, const struct kith_rows *rows, const struct kith_build *build,
                 bool fill) {
#pragma omp parallel for schedule(dynamic, 64) if (overlap->n > KITH_FEW)
  for (kith_index i = 0; i < overlap->n; ++i) {
    const struct kith_worker *worker = &build->scratch->worker[omp_get_thread_num()];
    struct set set = {worker->bitmap, worker->touched, INT32_MAX, -1};
    unite(rows, build, i, &set);
    const size_t count = drain(build, rows, i, &set, overlap, fill);
    if (!fill) overlap->first[i + 1] = count;
  }
}

kith_status kith_overlap_build(struct kith_rows *overlap, const struct kith_rows *rows, kith_index n,
                               const struct kith_build *build) {
  const size_t words = (size_t)words_of(rows) * (size_t)(build->shifts != NULL ? build->shifts->n : 1);
  for (int t = 0; t < build->scratch->threads; ++t) {
    struct kith_worker *worker = &build->scratch->worker[t];
    KITH_TRY(kith_reserve(&worker->bitmap, &worker->bitmap_capacity, words, sizeof(uint64_t)));
    KITH_TRY(kith_reserve(&worker->touched, &worker->touched_capacity, (words + 63) / 64, sizeof(uint64_t)));
  }
  KITH_TRY(make_spans(rows, build));
  KITH_TRY(kith_rows_reserve(overlap, n));
  pass(overlap, rows, build, false);
  KITH_TRY(kith_rows_sum(overlap, kith_rows_zero(rows)));
  pass(overlap, rows, build, true);
  return KITH_OK;
}
