/* intersection.c - the common neighbors of pairs.
 *
 * The neighbors of j are found by distance, not from the row of j: so a ghost needs no row, and the test
 * streams: row i and i itself are packed once, and every pair of i tests them all at once. Pairs that need
 * no common nodes get their ends without a test. The row of an idle node holds its active neighbors alone, so
 * the search finds the others; the active ends of its pairs have complete rows and see all that counts. */
#include "lib/connectivity/build/builder.h"

#include <omp.h>

/* Packs image s of k at position p. */
static void pack(struct kith_packed *near, const struct kith_nodes *nodes, int zero, int p, kith_index k,
                 int s) {
  const double search_radius = nodes->search_radius->f64[k];
  near->node[p] = k, near->shift[p] = (uint16_t)s;
  for (int a = 0; a < NDIM; ++a) near->coordinate[a][p] = nodes->position->f64[(size_t)k * NDIM + a];
  for (int a = 0; a < NDIM && s != zero; ++a) near->coordinate[a][p] += nodes->shifts.by[s][a];
  near->radius2[p] = search_radius * search_radius;
}

/* Packs row i with i itself inserted in order. */
static kith_status pack_row(const struct kith_rows *rows, const struct kith_nodes *nodes, kith_index i,
                            struct kith_packed *near) {
  const size_t first = rows->first[i], n = rows->first[i + 1] - first;
  const size_t self = kith_rows_find(rows, i, i, rows->zero) - first;
  near->n = 0;
  KITH_TRY(kith_packed_reserve(near, n + 1));
  for (size_t p = 0; p < n; ++p)
    pack(near, nodes, rows->zero, (int)(p + (p >= self)), rows->node[first + p],
         kith_row_shift(rows, first + p));
  pack(near, nodes, rows->zero, (int)self, i, rows->zero);
  kith_packed_close(near, (int)n + 1);
  return KITH_OK;
}

static uint64_t key_of(kith_index k, int s) {
  return (uint64_t)k << 32 | (uint64_t)s;
}

/* Packs all neighbors of i, which is idle, and i itself, ascending. Those in its row are among them even if
 * rounding hides them from the search. */
static kith_status pack_found(const struct kith_rows *rows, const struct kith_build *build,
                              struct kith_worker *worker, kith_index i) {
  const struct kith_nodes *nodes = build->nodes;
  struct kith_packed *near = &worker->near;
  const size_t first = rows->first[i], in_row = rows->first[i + 1] - first;
  size_t n = 0;
  KITH_TRY(kith_grow(&worker->key, &worker->key_capacity, 0, in_row + 1, sizeof *worker->key));
  worker->key[n++] = key_of(i, rows->zero);
  for (size_t e = first; e < first + in_row; ++e)
    worker->key[n++] = key_of(rows->node[e], kith_row_shift(rows, e));
  for (int s = 0; s < KITH_MAX(nodes->shifts.n, 1); ++s) {
    double x[NDIM];
    kith_index count;
    for (int a = 0; a < NDIM; ++a)
      x[a] = nodes->position->f64[(size_t)i * NDIM + a] - (nodes->shifts.n > 1 ? nodes->shifts.by[s][a] : 0);
    KITH_TRY(kith_search_at(build->search, x, nodes->search_radius->f64[i], KITH_GATHER_SCATTER,
                            &worker->found, &worker->found_capacity, &count));
    KITH_TRY(kith_grow(&worker->key, &worker->key_capacity, n, n + (size_t)count, sizeof *worker->key));
    for (kith_index k = 0; k < count; ++k) worker->key[n++] = key_of(worker->found[k], s);
  }
  KITH_TRY(kith_grow(&worker->key, &worker->key_capacity, n, 2 * n, sizeof *worker->key));
  const uint64_t *key = kith_keys_sort(worker->key, worker->key + n, n);
  near->n = 0;
  KITH_TRY(kith_packed_reserve(near, n));
  int packed = 0;
  for (size_t k = 0; k < n; ++k)
    if (k == 0 || key[k] != key[k - 1])
      pack(near, nodes, rows->zero, packed++, (kith_index)(key[k] >> 32), (int)(key[k] & 0xffff));
  kith_packed_close(near, packed);
  return KITH_OK;
}

/* The position of image s of k, which is there. */
static int position_of(const struct kith_packed *near, kith_index k, int s) {
  size_t p = kith_lower_bound(near->node, 0, (size_t)near->n, k);
  while (near->shift[p] != s) ++p;
  return (int)p;
}

static void set_bit(uint64_t *hit, int position) {
  hit[position / 64] |= UINT64_C(1) << (position % 64);
}

/* Clears the bits of nodes that the chain rejects as partners of the node at this position. */
static void exclude(const struct kith_build *build, const struct kith_packed *near, int position,
                    uint64_t *hit) {
  if (build->excluders == NULL) return;
  for (enum kith_phase phase = KITH_BROAD; phase <= KITH_NARROW; ++phase)
    kith_build_exclude(build, phase, near->node[position], near->shift[position], near, hit);
}

/* Sets the bits of what pair (i, j) has in common; i and j are at positions `self` and `other`. */
static void common(const struct kith_build *build, const struct kith_packed *near, int self, int other,
                   bool on_segment, uint64_t *hit) {
  double x[NDIM], y[NDIM];
  for (int a = 0; a < NDIM; ++a) x[a] = near->coordinate[a][self], y[a] = near->coordinate[a][other];
  kith_packed_hits(near, y, near->radius2[other], hit);
  if (on_segment) kith_packed_between(near, x, y, hit);
  exclude(build, near, other, hit);
  if (build->selected) exclude(build, near, self, hit); /* those that a search has found */
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

static bool any_set(const struct kith_field *field, const kith_index *node, size_t n) {
  bool any = false;
  for (size_t k = 0; k < n && !any; ++k) any = is_set(field, node[k]);
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

/* Packs i and its neighbors, unless its pairs need no common nodes: then *none is set. */
static kith_status pack_near(const struct pass *pass, struct kith_worker *worker, kith_index i, bool *none) {
  const struct kith_rows *rows = pass->rows;
  const struct kith_field *obstacles = pass->spec.obstacles;
  const struct kith_packed *near = &worker->near;
  const bool idle = pass->build->selected && !kith_node_active(pass->build->nodes, i);
  *none = is_set(pass->spec.barriers, i);
  if (!*none && obstacles != NULL && !idle)
    *none = !is_set(obstacles, i) &&
            !any_set(obstacles, rows->node + rows->first[i], rows->first[i + 1] - rows->first[i]);
  if (*none) return KITH_OK;
  KITH_TRY(idle ? pack_found(rows, pass->build, worker, i)
                : pack_row(rows, pass->build->nodes, i, &worker->near));
  if (obstacles != NULL && idle) *none = !any_set(obstacles, near->node, (size_t)near->n);
  return kith_reserve(&worker->hit, &worker->hit_capacity, (size_t)near->words, sizeof(uint64_t));
}

/* Pairs of i: counts (lengths into first[p + 1]) or fills in. */
static kith_status pairs_of(const struct pass *pass, struct kith_worker *worker, kith_index i) {
  const struct kith_pairs *pairs = pass->pairs;
  const struct kith_packed *near = &worker->near;
  const int zero = pass->rows->zero;
  bool none;
  if (pairs->first[i] == pairs->first[i + 1]) return KITH_OK;
  KITH_TRY(pack_near(pass, worker, i, &none));
  const int self = none ? 0 : position_of(near, i, zero);
  for (size_t p = pairs->first[i]; p < pairs->first[i + 1]; ++p) {
    const kith_index j = pairs->node[p][1];
    if (none || is_set(pass->spec.barriers, j)) {
      ends_of(pass, i, p);
      continue;
    }
    common(pass->build, near, self, position_of(near, j, pairs->shift != NULL ? pairs->shift[p] : zero),
           pass->spec.on_segment, worker->hit);
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
