#include "lib/connectivity/shield.h"

#include <math.h>

#include "lib/connectivity/internal.h"

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

kith_status kith_connectivity_shield(struct kith_connectivity *c, const struct kith_nodes *nodes,
                                     const struct kith_field *barrier, double thickness, size_t *cut) {
  if (!c->built.pairs || !c->built.intersection)
    KITH_FAIL(INTERNAL, "a shield needs pairs and their intersection");
  KITH_TRY(kith_connectivity_couple(c));
  size_t n = 0;
#pragma omp parallel for schedule(dynamic, 1024) reduction(+ : n) if (c->rows.n > KITH_FEW)
  for (size_t p = 0; p < c->pairs.n; ++p)
    if (is_cut(c, nodes, barrier->u8, thickness, p)) c->pairs.f_couple[p] = 0, ++n;
  if (cut != NULL) *cut = n;
  return n > 0 ? kith_connectivity_decouple(c) : KITH_OK;
}

/* Rows without the entries of cut pairs, moved up in place. lost[i]: row i is shorter than it was. */
static void drop_entries(struct kith_connectivity *c, uint8_t *lost) {
  struct kith_rows *rows = &c->rows;
  size_t to = 0, e = 0;
  for (kith_index i = 0; i < rows->n; ++i) {
    const size_t stop = rows->first[i + 1], count = stop - e, from = to;
    for (; e < stop; ++e)
      if (c->pairs.f_couple[c->pairs.of_row[e]] != 0) rows->node[to++] = rows->node[e];
    rows->first[i + 1] = to;
    lost[i] = to - from < count;
  }
}

static bool holds(const struct kith_rows *rows, kith_index i, kith_index j) {
  const size_t e = kith_lower_bound(rows->node, rows->first[i], rows->first[i + 1], j);
  return e < rows->first[i + 1] && rows->node[e] == j;
}

/* Nodes of the intersection that both ends still see, as far as rows tell; the ends are of it. */
static size_t move_common(const struct kith_connectivity *c, const uint8_t *lost, size_t p, size_t e,
                          size_t stop, size_t to) {
  const kith_index i = c->pairs.node[p][0], j = c->pairs.node[p][1];
  for (; e < stop; ++e) {
    const kith_index k = c->intersection.node[e];
    const bool seen = (!lost[i] || holds(&c->rows, i, k)) && (!lost[j] || holds(&c->rows, j, k));
    if (k == i || k == j || seen) c->intersection.node[to++] = k;
  }
  return to;
}

/* Pairs and intersections moved up in place; rows are done. */
static void drop_pairs(struct kith_connectivity *c, const uint8_t *lost) {
  struct kith_pairs *pairs = &c->pairs;
  size_t kept = 0, p = 0, e = 0, to = 0;
  for (kith_index i = 0; i < c->rows.n; ++i) {
    const size_t stop = pairs->first[i + 1];
    for (; p < stop; ++p) {
      const size_t common = c->built.intersection ? c->intersection.first[p + 1] : 0;
      if (pairs->f_couple[p] != 0) {
        if (c->built.intersection) {
          to = move_common(c, lost, p, e, common, to);
          c->intersection.first[kept + 1] = to;
        }
        pairs->node[kept][0] = pairs->node[p][0], pairs->node[kept][1] = pairs->node[p][1];
        pairs->f_couple[kept++] = pairs->f_couple[p];
      }
      e = common;
    }
    pairs->first[i + 1] = kept;
  }
  pairs->n = kept;
  if (c->built.intersection) c->intersection.n = (kith_index)kept;
}

kith_status kith_connectivity_decouple(struct kith_connectivity *c) {
  uint8_t *lost = NULL;
  if (c->pairs.f_couple == NULL) return KITH_OK;
  KITH_TRY(kith_resize(&lost, 0, (size_t)c->rows.n, 1));
  drop_entries(c, lost);
  drop_pairs(c, lost);
  kith_free(&lost);
  ++c->generation;
  return kith_pairs_of_row(c);
}
