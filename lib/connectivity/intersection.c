/* intersection.c - the common neighbors of pairs.
 *
 * The neighbors of j are found by distance, not from the row of j: so a ghost needs no row, and the test
 * streams: row i and i itself are packed once, and every pair of i tests them all at once. Pairs that need
 * no common nodes get their ends without a test. */
#include "lib/connectivity/build/builder.h"

#include <omp.h>

/* Packs row i with i itself inserted in order, at position *self. */
static kith_status pack_row(const struct kith_rows *rows, const struct kith_nodes *nodes, kith_index i,
                            struct kith_packed *near, int *self) {
  const size_t first = rows->first[i], n = rows->first[i + 1] - first;
  const size_t before = kith_rows_find(rows, i, i, rows->zero) - first;
  near->n = 0;
  KITH_TRY(kith_packed_reserve(near, n + 1));
  *self = (int)before;
  for (size_t p = 0; p <= n; ++p) {
    const size_t e = first + p - (p > before);
    const kith_index k = p == before ? i : rows->node[e];
    const int s = p == before ? rows->zero : kith_row_shift(rows, e);
    const double search_radius = nodes->search_radius->f64[k];
    near->node[p] = k, near->shift[p] = (uint16_t)s;
    for (int a = 0; a < NDIM; ++a) near->coordinate[a][p] = nodes->position->f64[(size_t)k * NDIM + a];
    for (int a = 0; a < NDIM && s != rows->zero; ++a) near->coordinate[a][p] += nodes->shifts.by[s][a];
    near->radius2[p] = search_radius * search_radius;
  }
  kith_packed_close(near, (int)n + 1);
  return KITH_OK;
}

static void set_bit(uint64_t *hit, int position) {
  hit[position / 64] |= UINT64_C(1) << (position % 64);
}

/* Sets the bits of what pair (i, j) has in common; i and j are at positions `self` and `other`. */
static void common(const struct kith_build *build, const struct kith_packed *near, int self, int other,
                   bool on_segment, uint64_t *hit) {
  double x[NDIM], y[NDIM];
  for (int a = 0; a < NDIM; ++a) x[a] = near->coordinate[a][self], y[a] = near->coordinate[a][other];
  kith_packed_hits(near, y, near->radius2[other], hit);
  if (on_segment) kith_packed_between(near, x, y, hit);
  if (build->excluders != NULL) {
    kith_build_exclude(build, KITH_BROAD, near->node[other], near->shift[other], near, hit);
    kith_build_exclude(build, KITH_NARROW, near->node[other], near->shift[other], near, hit);
  }
  set_bit(hit, self);
  set_bit(hit, other);
}

/* What one pass over the pairs reads and writes. */
struct pass {
  const struct kith_build *build;
  const struct kith_rows *rows;
  const struct kith_pairs *pairs;
  struct kith_rows *out;
  struct kith_intersection_spec spec;
  bool fill;
};

/* Is it one of the nodes where the field is not 0? */
static bool is_set(const struct kith_field *field, kith_index k) {
  return field != NULL && (field->spec.type == KITH_U8 ? field->u8[k] != 0 : field->f64[k] != 0);
}

/* May pairs of i need their common nodes? */
static bool need_common_nodes(const struct pass *pass, kith_index i) {
  const struct kith_field *obstacles = pass->spec.obstacles;
  if (is_set(pass->spec.barriers, i)) return false;
  bool any = obstacles == NULL || is_set(obstacles, i);
  for (size_t e = pass->rows->first[i]; e < pass->rows->first[i + 1] && !any; ++e)
    any = is_set(obstacles, pass->rows->node[e]);
  return any;
}

/* Counts or fills in pair p of i, which has its ends alone. */
static void ends_of(const struct pass *pass, kith_index i, size_t p) {
  const struct kith_rows *out = pass->out;
  if (!pass->fill) {
    out->first[p + 1] = 2;
    return;
  }
  const size_t e = out->first[p];
  out->node[e] = i, out->node[e + 1] = pass->pairs->node[p][1];
  if (out->shift == NULL) return;
  const uint16_t zero = (uint16_t)pass->rows->zero;
  out->shift[e] = zero, out->shift[e + 1] = pass->pairs->shift != NULL ? pass->pairs->shift[p] : zero;
}

/* Pairs of i: counts (lengths into first[p + 1]) or fills in. */
static kith_status pairs_of(const struct pass *pass, struct kith_worker *worker, kith_index i) {
  const struct kith_pairs *pairs = pass->pairs;
  struct kith_packed *near = &worker->near;
  int self;
  if (pairs->first[i] == pairs->first[i + 1]) return KITH_OK;
  if (!need_common_nodes(pass, i)) {
    for (size_t p = pairs->first[i]; p < pairs->first[i + 1]; ++p) ends_of(pass, i, p);
    return KITH_OK;
  }
  KITH_TRY(pack_row(pass->rows, pass->build->nodes, i, near, &self));
  KITH_TRY(kith_reserve(&worker->hit, &worker->hit_capacity, (size_t)near->words, sizeof(uint64_t)));
  int other = self; /* the partners of i follow i in the row */
  for (size_t p = pairs->first[i]; p < pairs->first[i + 1]; ++p) {
    ++other;
    if (is_set(pass->spec.barriers, pairs->node[p][1])) {
      ends_of(pass, i, p);
      continue;
    }
    common(pass->build, near, self, other, pass->spec.on_segment, worker->hit);
    if (pass->fill) {
      const size_t e = pass->out->first[p];
      kith_packed_extract(near->node, near->words, worker->hit, pass->out->node + e);
      if (pass->out->shift != NULL)
        kith_packed_extract_shifts(near->shift, near->words, worker->hit, pass->out->shift + e);
    } else {
      size_t n = 0;
      for (int w = 0; w < near->words; ++w) n += (size_t)__builtin_popcountll(worker->hit[w]);
      pass->out->first[p + 1] = n;
    }
  }
  return KITH_OK;
}

static kith_status run(const struct pass *pass) {
  int status = KITH_OK;
#pragma omp parallel for schedule(dynamic, 64) reduction(max : status) if (pass->rows->n > KITH_FEW)
  for (kith_index i = 0; i < pass->rows->n; ++i) {
    const int mine = (int)pairs_of(pass, &pass->build->scratch->worker[omp_get_thread_num()], i);
    status = KITH_MAX(status, mine);
  }
  if (status == KITH_OK) return KITH_OK;
  return kith_fail((kith_status)status, "the intersections could not be built: %s",
                   kith_status_text((kith_status)status));
}

kith_status kith_intersection_build(struct kith_rows *intersection, const struct kith_rows *rows,
                                    const struct kith_pairs *pairs, struct kith_intersection_spec spec,
                                    const struct kith_build *build) {
  struct pass pass = {build, rows, pairs, intersection, spec, false};
  if (pairs->n > INT32_MAX) KITH_FAIL(UNSUPPORTED, "intersections of %zu pairs: there can be 2^31", pairs->n);
  KITH_TRY(kith_rows_reserve(intersection, (kith_index)pairs->n));
  KITH_TRY(run(&pass));
  KITH_TRY(kith_rows_sum(intersection, kith_rows_zero(rows)));
  pass.fill = true;
  return run(&pass);
}
