/* Overlap. Let S(k) be the neighbors j of k with |x_j - x_k| <= R_j (their support holds k), and G(i) those
 * with |x_i - x_k| <= R_i. Then row i is row(i) and the union of S(k) over k in G(i), without i.
 *
 * A union of 60 rows of 60 entries would be 3600 steps a node. Nodes are in curve order, so S(k) fills few
 * 64-bit words of a bitmap over the nodes: S is kept as (word, bits), `spans`, a union is one OR a span, and
 * it comes out sorted. */
#include "lib/connectivity/internal.h"

#include <omp.h>
#include <string.h>

#include "lib/connectivity/excluder.h"

static double reach2(const struct kith_nodes *nodes, kith_index i) {
  return nodes->reach->f64[i] * nodes->reach->f64[i];
}

static double distance2(const struct kith_nodes *nodes, kith_index i, kith_index j) {
  const double *x = nodes->position->f64;
  return kith_distance2(x + (size_t)i * NDIM, x + (size_t)j * NDIM);
}

/* --- spans --- */

/* Spans of S(k); out arrays may be NULL to count. */
static size_t spans_of(const struct kith_build *build, kith_index k, kith_index *word, uint64_t *bits) {
  const struct kith_rows *rows = &build->connectivity->rows;
  size_t n = 0;
  kith_index last = -1;
  for (size_t e = rows->first[k]; e < rows->first[k + 1]; ++e) {
    const kith_index j = rows->node[e];
    if (!(distance2(build->nodes, j, k) <= reach2(build->nodes, j))) continue;
    if (j / 64 != last) {
      last = j / 64;
      if (word != NULL) word[n] = last, bits[n] = 0;
      ++n;
    }
    if (word != NULL) bits[n - 1] |= UINT64_C(1) << (j % 64);
  }
  return n;
}

static kith_status make_spans(const struct kith_build *build) {
  struct kith_connectivity_scratch *scratch = build->connectivity->scratch;
  const kith_index n = build->connectivity->rows.n;
  KITH_TRY(kith_room(&scratch->span_first, &scratch->span_first_capacity, (size_t)n + 1, sizeof(size_t)));
  scratch->span_first[0] = 0;
#pragma omp parallel for schedule(dynamic, 1024) if (n > KITH_FEW)
  for (kith_index k = 0; k < n; ++k) scratch->span_first[k + 1] = spans_of(build, k, NULL, NULL);
  for (kith_index k = 0; k < n; ++k) scratch->span_first[k + 1] += scratch->span_first[k];
  KITH_TRY(kith_room(&scratch->span, &scratch->span_capacity, scratch->span_first[n], sizeof *scratch->span));
  KITH_TRY(kith_room(&scratch->span_bits, &scratch->span_bits_capacity, scratch->span_first[n],
                     sizeof *scratch->span_bits));
#pragma omp parallel for schedule(dynamic, 1024) if (n > KITH_FEW)
  for (kith_index k = 0; k < n; ++k)
    spans_of(build, k, scratch->span + scratch->span_first[k], scratch->span_bits + scratch->span_first[k]);
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
static void unite(const struct kith_build *build, kith_index i, struct set *set) {
  const struct kith_rows *rows = &build->connectivity->rows;
  const struct kith_connectivity_scratch *scratch = build->connectivity->scratch;
  const double mine = reach2(build->nodes, i);
  for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
    const kith_index k = rows->node[e];
    set_or(set, k / 64, UINT64_C(1) << (k % 64));
    if (!(distance2(build->nodes, i, k) <= mine)) continue;
    for (size_t s = scratch->span_first[k]; s < scratch->span_first[k + 1]; ++s)
      set_or(set, scratch->span[s], scratch->span_bits[s]);
  }
  set->bitmap[i / 64] &= ~(UINT64_C(1) << (i % 64));
}

static uint64_t allowed(const struct kith_build *build, kith_index i, kith_index word, uint64_t bits) {
  if (build->excluders == NULL) return bits;
  for (uint64_t rest = bits; rest != 0; rest &= rest - 1) {
    const int k = __builtin_ctzll(rest);
    const kith_index j = 64 * word + k;
    if (kith_excluder_rejects(build->excluders, KITH_BROAD, build->nodes, i, j) ||
        kith_excluder_rejects(build->excluders, KITH_NARROW, build->nodes, i, j))
      bits &= ~(UINT64_C(1) << k);
  }
  return bits;
}

/* Counts the set, writes it to out if that is not NULL, and empties it. */
static size_t drain(const struct kith_build *build, kith_index i, struct set *set, kith_index *out) {
  size_t n = 0;
  for (kith_index t = set->lowest; t <= set->highest; ++t) {
    for (uint64_t rest = set->touched[t]; rest != 0; rest &= rest - 1) {
      const kith_index word = 64 * t + __builtin_ctzll(rest);
      uint64_t bits = allowed(build, i, word, set->bitmap[word]);
      set->bitmap[word] = 0;
      if (out == NULL)
        n += (size_t)__builtin_popcountll(bits);
      else
        for (; bits != 0; bits &= bits - 1) out[n++] = 64 * word + __builtin_ctzll(bits);
    }
    set->touched[t] = 0;
  }
  return n;
}

/* One pass over the first n rows: counts them, or fills them in. */
static void pass(const struct kith_build *build, kith_index n, bool fill) {
  struct kith_rows *overlap = &build->connectivity->overlap;
  const struct kith_worker *workers = build->connectivity->scratch->worker;
#pragma omp parallel for schedule(dynamic, 64) if (n > KITH_FEW)
  for (kith_index i = 0; i < n; ++i) {
    const struct kith_worker *worker = &workers[omp_get_thread_num()];
    struct set set = {worker->bitmap, worker->touched, INT32_MAX, -1};
    unite(build, i, &set);
    const size_t count = drain(build, i, &set, fill ? overlap->node + overlap->first[i] : NULL);
    if (!fill) overlap->first[i + 1] = count;
  }
}

kith_status kith_overlap_build(const struct kith_build *build, kith_index n) {
  struct kith_connectivity *connectivity = build->connectivity;
  const size_t words = ((size_t)connectivity->rows.n + 63) / 64;
  for (int t = 0; t < connectivity->scratch->n_workers; ++t) {
    struct kith_worker *worker = &connectivity->scratch->worker[t];
    KITH_TRY(kith_room(&worker->bitmap, &worker->bitmap_capacity, words, sizeof(uint64_t)));
    KITH_TRY(kith_room(&worker->touched, &worker->touched_capacity, (words + 63) / 64, sizeof(uint64_t)));
  }
  KITH_TRY(make_spans(build));
  KITH_TRY(kith_rows_room(&connectivity->overlap, connectivity->rows.n));
  memset(connectivity->overlap.first, 0, ((size_t)connectivity->rows.n + 1) * sizeof(size_t));
  pass(build, n, false);
  KITH_TRY(kith_rows_sum(&connectivity->overlap));
  pass(build, n, true);
  return KITH_OK;
}
