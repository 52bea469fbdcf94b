/* Intersection. The neighbors of j are told by distance, not by the row of j: so a ghost needs no row, and
 * the test streams: row i and i itself are packed once, and every pair of i tests them all at once. */
#include "lib/connectivity/internal.h"

#include <omp.h>

#include "lib/connectivity/excluder.h"

/* Packs row i, and i in its place; *self is that place. */
static kith_status pack_row(const struct kith_build *build, kith_index i, struct kith_packed *near,
                            int *self) {
  const struct kith_rows *rows = &build->connectivity->rows;
  const size_t first = rows->first[i], n = rows->first[i + 1] - first;
  const size_t before = kith_lower_bound(rows->node, first, first + n, i) - first;
  KITH_TRY(kith_packed_reserve(near, n + 1));
  *self = (int)before;
  for (size_t p = 0; p <= n; ++p) {
    const kith_index k = p == before ? i : rows->node[first + p - (p > before)];
    const double reach = build->nodes->reach->f64[k];
    near->node[p] = k;
    for (int a = 0; a < NDIM; ++a) near->coordinate[a][p] = build->nodes->position->f64[(size_t)k * NDIM + a];
    near->radius2[p] = reach * reach;
  }
  kith_packed_close(near, (int)n + 1);
  return KITH_OK;
}

static void exclude(const struct kith_build *build, kith_index j, const struct kith_packed *near,
                    uint64_t *hit) {
  for (int w = 0; w < near->words; ++w)
    for (uint64_t bits = hit[w]; bits != 0; bits &= bits - 1) {
      const int k = __builtin_ctzll(bits);
      const kith_index node = near->node[64 * w + k];
      if (kith_excluder_rejects(build->excluders, KITH_BROAD, build->nodes, j, node) ||
          kith_excluder_rejects(build->excluders, KITH_NARROW, build->nodes, j, node))
        hit[w] &= ~(UINT64_C(1) << k);
    }
}

static void set_bit(uint64_t *hit, int place) {
  hit[place / 64] |= UINT64_C(1) << (place % 64);
}

/* The bits of pair (i, j), i and j at places `self` and `other`. */
static void common(const struct kith_build *build, const struct kith_packed *near, int self, int other,
                   bool on_segment, uint64_t *hit) {
  double x[NDIM], y[NDIM];
  for (int a = 0; a < NDIM; ++a) x[a] = near->coordinate[a][self], y[a] = near->coordinate[a][other];
  kith_packed_hits(near, y, near->radius2[other], hit);
  if (on_segment) kith_packed_between(near, x, y, hit);
  if (build->excluders != NULL) exclude(build, near->node[other], near, hit);
  set_bit(hit, self);
  set_bit(hit, other);
}

/* Pairs of i: counts (lengths into first[p + 1]) or fills. */
static kith_status pairs_of(const struct kith_build *build, struct kith_worker *worker, kith_index i,
                            bool fill) {
  const struct kith_connectivity *connectivity = build->connectivity;
  const struct kith_pairs *pairs = &connectivity->pairs;
  const struct kith_rows *out = &connectivity->intersection;
  struct kith_packed *near = &worker->near;
  int self;
  if (pairs->first[i] == pairs->first[i + 1]) return KITH_OK;
  KITH_TRY(pack_row(build, i, near, &self));
  KITH_TRY(kith_room(&worker->hit, &worker->hit_capacity, (size_t)near->words, sizeof(uint64_t)));
  int other = self;
  for (size_t p = pairs->first[i]; p < pairs->first[i + 1]; ++p) {
    common(build, near, self, ++other, connectivity->built.on_segment,
           worker->hit); /* pairs of i follow i in the row */
    if (fill)
      kith_packed_extract(near->node, near->words, worker->hit, out->node + out->first[p]);
    else {
      size_t n = 0;
      for (int w = 0; w < near->words; ++w) n += (size_t)__builtin_popcountll(worker->hit[w]);
      out->first[p + 1] = n;
    }
  }
  return KITH_OK;
}

static kith_status pass(const struct kith_build *build, bool fill) {
  struct kith_worker *worker = build->connectivity->scratch->worker;
  kith_status status = KITH_OK;
#pragma omp parallel for schedule(dynamic, 64) if (build->connectivity->rows.n > KITH_FEW)
  for (kith_index i = 0; i < build->connectivity->rows.n; ++i) {
    const kith_status mine = pairs_of(build, &worker[omp_get_thread_num()], i, fill);
    if (mine != KITH_OK) {
#pragma omp critical(kith_intersection)
      status = mine;
    }
  }
  if (status != KITH_OK)
    return kith_fail(status, "the intersections could not be built: %s", kith_status_text(status));
  return KITH_OK;
}

kith_status kith_intersection_build(const struct kith_build *build) {
  struct kith_rows *out = &build->connectivity->intersection;
  const size_t n = build->connectivity->pairs.n;
  if (n > INT32_MAX) KITH_FAIL(UNSUPPORTED, "intersections of %zu pairs: there can be 2^31", n);
  KITH_TRY(kith_rows_room(out, (kith_index)n));
  out->first[0] = 0;
  KITH_TRY(pass(build, false));
  KITH_TRY(kith_rows_sum(out));
  return pass(build, true);
}
