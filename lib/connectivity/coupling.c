/* coupling.c - shielded coupling: a thin barrier between two nodes cuts their pair, which is then removed
 * from rows, pairs, of_row, f_couple and intersection (there also nodes that an end does not see any more).
 * What is left is as if the search had never found them, so packages need not know. */
#include "lib/connectivity/connectivity.h"

#include <math.h>

const struct kith_pairwise_spec kith_f_couple = {"f_couple", 1, true, "a factor; 0 cuts the pair"};

/* Does k stand between i and j, within `radius` of the segment? */
static bool between(const double *x, kith_index i, kith_index j, kith_index k, double radius) {
  const double *xi = x + (size_t)i * NDIM, *xj = x + (size_t)j * NDIM, *xk = x + (size_t)k * NDIM;
  double along = 0, length2 = 0, distance2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    along += (xk[a] - xi[a]) * (xj[a] - xi[a]);
    length2 += (xj[a] - xi[a]) * (xj[a] - xi[a]);
  }
  if (!(along > 0 && along < length2)) return false;
  for (int a = 0; a < NDIM; ++a) {
    const double d = xi[a] + along / length2 * (xj[a] - xi[a]) - xk[a];
    distance2 += d * d;
  }
  return distance2 < radius * radius;
}

static bool is_cut(const struct kith_connectivity *c, const struct kith_nodes *nodes, const uint8_t *barrier,
                   double thickness, size_t p) {
  const kith_index i = c->pairs.node[p][0], j = c->pairs.node[p][1];
  if (barrier[i] || barrier[j]) return false;
  for (size_t e = c->intersection.first[p]; e < c->intersection.first[p + 1]; ++e) {
    const kith_index k = c->intersection.node[e];
    if (barrier[k] && between(nodes->position->f64, i, j, k, thickness * nodes->support->f64[k])) return true;
  }
  return false;
}

/* Removes the entries of cut pairs. lost[i]: row i has become shorter. */
static void drop_entries(struct kith_connectivity *c, const double *f_couple, uint8_t *lost) {
  struct kith_rows *rows = &c->rows;
#pragma omp parallel for schedule(static) if (rows->n > KITH_FEW)
  for (kith_index i = 0; i < rows->n; ++i)
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e)
      if (f_couple[c->pairs.of_row[e]] == 0) rows->node[e] = -1, lost[i] = 1;
  kith_rows_compact(rows);
}

/* A node of the intersection is kept if both ends still see it, as far as there are rows; the ends belong to
 * it. */
static bool is_common(const struct kith_connectivity *c, const uint8_t *lost, size_t p, kith_index k) {
  const kith_index *end = c->pairs.node[p];
  if (k == end[0] || k == end[1]) return true;
  for (int m = 0; m < 2; ++m)
    if (end[m] < c->rows.n && lost[end[m]] && !kith_rows_hold(&c->rows, end[m], k)) return false;
  return true;
}

/* Removes cut pairs and their intersections, and from the others what an end does not see any more. */
static void drop_pairs(struct kith_connectivity *c, const double *f_couple, const uint8_t *lost) {
  struct kith_rows *common = &c->intersection;
#pragma omp parallel for schedule(dynamic, 1024) if (c->rows.n > KITH_FEW)
  for (size_t p = 0; p < c->pairs.n; ++p) {
    const bool is_cut_off = f_couple[p] == 0;
    for (size_t e = common->first[p]; e < common->first[p + 1]; ++e)
      if (is_cut_off || !is_common(c, lost, p, common->node[e])) common->node[e] = -1;
    if (is_cut_off) c->pairs.node[p][0] = -1;
  }
  kith_rows_compact(common);
  kith_pairs_compact(&c->pairs, c->rows.n, common);
}

/* Removes the pairs whose factor is 0. */
static kith_status decouple(struct kith_connectivity *c, const double *f_couple) {
  uint8_t *lost = NULL;
  KITH_TRY(kith_resize(&lost, 0, (size_t)c->rows.n, 1));
  drop_entries(c, f_couple, lost);
  drop_pairs(c, f_couple, lost);
  kith_free(&lost);
  kith_pairs_carry(&c->pairs);
  return kith_pairs_of_row(&c->pairs, &c->rows);
}

kith_status kith_connectivity_cut_barriers(struct kith_connectivity *c, const struct kith_nodes *nodes,
                                           const struct kith_field *barrier, double thickness, size_t *cut) {
  KITH_TRY(
      kith_connectivity_provides(c, nodes, (struct kith_requirements){.pairs = true, .intersection = true}));
  struct kith_pairwise *factor;
  KITH_TRY(kith_pairwise_prepare(&c->pairs, &kith_f_couple, &factor));
  size_t n = 0;
#pragma omp parallel for schedule(dynamic, 1024) reduction(+ : n) if (c->rows.n > KITH_FEW)
  for (size_t p = 0; p < c->pairs.n; ++p) {
    const bool cuts = is_cut(c, nodes, barrier->u8, thickness, p);
    factor->value[p] = cuts ? 0 : 1, n += cuts;
  }
  if (cut != NULL) *cut = n;
  return n > 0 ? decouple(c, factor->value) : KITH_OK;
}
