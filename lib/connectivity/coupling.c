/* coupling.c - the factor of each pair, by what stands between its nodes. A thin barrier there cuts the pair,
 * which is then removed from rows, pairs, of_row, f_couple and intersection (there also nodes that an end
 * does not see any more). What is left is as if the search had never found them: packages need not know. */
#include "lib/connectivity/connectivity.h"

#include <math.h>

const struct kith_pairwise_spec kith_f_couple = {"f_couple", 1, true, "part of force and heat that passes"};

/* Does k stand between i and j, within `radius` of the segment? Not if it is beside an end but for round-off:
 * both ends have to agree. */
static bool between(const double *xi, const double *xj, const double *xk, double radius) {
  double along = 0, length2 = 0, distance2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    along += (xk[a] - xi[a]) * (xj[a] - xi[a]);
    length2 += (xj[a] - xi[a]) * (xj[a] - xi[a]);
  }
  if (!(along > 1e-9 * length2 && along < (1 - 1e-9) * length2)) return false;
  for (int a = 0; a < NDIM; ++a) {
    const double d = xi[a] + along / length2 * (xj[a] - xi[a]) - xk[a];
    distance2 += d * d;
  }
  return distance2 < radius * radius;
}

/* The image of j that shift s means. */
static void locate(const struct kith_nodes *nodes, kith_index j, int s, double x[NDIM]) {
  for (int a = 0; a < NDIM; ++a)
    x[a] = nodes->position->f64[(size_t)j * NDIM + a] + (nodes->shifts.n > 1 ? nodes->shifts.by[s][a] : 0);
}

/* 1 / (1 - D), in parts of 2^-20: sums of these are exact and do not depend on their order. */
static double resistance(double damage) {
  const double r = 1 / (1 - damage);
  return r < 0x1p28 ? rint(r * 0x1p20) * 0x1p-20 : INFINITY;
}

/* f_couple of pair p, by equation (1) of connectivity.h; -1 if a barrier cuts the pair. */
static double factor_of(const struct kith_connectivity *c, const struct kith_nodes *nodes,
                        const struct kith_coupling *by, size_t p) {
  const kith_index i = c->pairs.node[p][0], j = c->pairs.node[p][1];
  const int sj = c->pairs.shift != NULL ? c->pairs.shift[p] : 0;
  double n = 0, sum = 0, xi[NDIM], xj[NDIM], xk[NDIM];
  locate(nodes, i, c->rows.zero, xi), locate(nodes, j, sj, xj);
  if (by->barrier != NULL && (by->barrier[i] || by->barrier[j])) return 1;
  for (size_t e = c->intersection.first[p]; e < c->intersection.first[p + 1]; ++e) {
    const kith_index k = c->intersection.node[e];
    const bool wall = by->barrier != NULL && by->barrier[k];
    if (!wall && by->damage == NULL) continue;
    const int s = kith_row_shift(&c->intersection, e);
    const bool end = (k == i && s == c->rows.zero) || (k == j && s == sj);
    locate(nodes, k, s, xk);
    if (!end && !between(xi, xj, xk, by->thickness * nodes->support->f64[k])) continue;
    if (wall && (by->damage == NULL || by->damage[k] == 1)) return -1;
    n += 1, sum += resistance(by->damage[k]);
  }
  return by->damage != NULL ? n / sum : 1;
}

/* The bit of node k in a set that may hold more nodes than were put in. */
static uint64_t bit_of(kith_index k) {
  return UINT64_C(1) << (k % 64);
}

/* Removes the entries of cut pairs. lost[i]: the nodes that row i loses, by their bits. */
static void drop_entries(struct kith_connectivity *c, const double *f_couple, uint64_t *lost) {
  struct kith_rows *rows = &c->rows;
#pragma omp parallel for schedule(static) if (rows->n > KITH_FEW)
  for (kith_index i = 0; i < rows->n; ++i)
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e)
      if (f_couple[c->pairs.of_row[e]] < 0) lost[i] |= bit_of(rows->node[e]), rows->node[e] = -1;
  kith_rows_compact(rows);
}

/* A node of the intersection is kept if both ends still see it, as far as there are whole rows; the ends
 * belong to it. */
static bool is_common(const struct kith_connectivity *c, const struct kith_nodes *nodes, const uint64_t *lost,
                      size_t p, size_t e) {
  const kith_index *end = c->pairs.node[p], k = c->intersection.node[e];
  const int zero = c->rows.zero, shift[] = {zero, c->pairs.shift != NULL ? c->pairs.shift[p] : 0},
            s = kith_row_shift(&c->intersection, e);
  for (int m = 0; m < 2; ++m)
    if (k == end[m] && s == shift[m]) return true;
  for (int m = 0; m < 2; ++m)
    if (end[m] < c->rows.n && kith_node_active(nodes, end[m]) && (lost[end[m]] & bit_of(k)) != 0 &&
        !kith_rows_hold(&c->rows, end[m], k, zero + s - shift[m]))
      return false;
  return true;
}

/* Removes cut pairs and their intersections, and from the others what an end does not see any more. */
static void drop_pairs(struct kith_connectivity *c, const struct kith_nodes *nodes, const double *f_couple,
                       const uint64_t *lost) {
  struct kith_rows *common = &c->intersection;
#pragma omp parallel for schedule(dynamic, 1024) if (c->rows.n > KITH_FEW)
  for (size_t p = 0; p < c->pairs.n; ++p) {
    const bool is_cut_off = f_couple[p] < 0;
    for (size_t e = common->first[p]; e < common->first[p + 1]; ++e)
      if (is_cut_off || !is_common(c, nodes, lost, p, e)) common->node[e] = -1;
    if (is_cut_off) c->pairs.node[p][0] = -1;
  }
  kith_rows_compact(common);
  kith_pairs_compact(&c->pairs, c->rows.n, common);
}

/* Removes the pairs whose factor is below 0. */
static kith_status decouple(struct kith_connectivity *c, const struct kith_nodes *nodes,
                            const double *f_couple) {
  uint64_t *lost = NULL;
  KITH_TRY(kith_resize(&lost, 0, (size_t)c->rows.n, sizeof *lost));
  drop_entries(c, f_couple, lost);
  drop_pairs(c, nodes, f_couple, lost);
  kith_free(&lost);
  kith_pairs_carry(&c->pairs);
  return kith_pairs_of_row(&c->pairs, &c->rows);
}

kith_status kith_connectivity_couple(struct kith_connectivity *c, const struct kith_nodes *nodes,
                                     const struct kith_coupling *by) {
  KITH_TRY(
      kith_connectivity_provides(c, nodes, (struct kith_requirements){.pairs = true, .intersection = true}));
  struct kith_pairwise *factor;
  KITH_TRY(kith_pairwise_prepare(&c->pairs, &kith_f_couple, &factor));
  bool cuts = false;
#pragma omp parallel for schedule(dynamic, 1024) reduction(|| : cuts) if (c->rows.n > KITH_FEW)
  for (size_t p = 0; p < c->pairs.n; ++p) {
    factor->value[p] = factor_of(c, nodes, by, p);
    cuts = cuts || factor->value[p] < 0;
  }
  if (cuts) KITH_TRY(decouple(c, nodes, factor->value));
  if (by->damage == NULL) factor->generation = 0; /* not fresh: all that are left are 1 */
  return KITH_OK;
}

const double *kith_connectivity_factors(const struct kith_pairs *pairs) {
  const struct kith_pairwise *factor = kith_pairwise_named(pairs, kith_f_couple.name);
  return factor != NULL && factor->generation == pairs->generation ? factor->value : NULL;
}
