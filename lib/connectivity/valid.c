/* valid.c - all invariants of a connectivity that do not depend on the present positions; and by a sweep
 * whether rows are complete. Serial: these are checks, not stages. */
#include <math.h>
#include "lib/connectivity/connectivity.h"

/* Do offsets ascend, and the entries of each row, and are these nodes? */
static kith_status valid_csr(const struct kith_rows *rows, const char *what, kith_index count) {
  if (rows->first[0] != 0) KITH_FAIL(INTERNAL, "%s: the first row starts at %zu", what, rows->first[0]);
  for (kith_index i = 0; i < rows->n; ++i) {
    if (rows->first[i + 1] < rows->first[i] || rows->first[i + 1] > rows->entries_capacity)
      KITH_FAIL(INTERNAL, "%s: row %d ends at %zu", what, i, rows->first[i + 1]);
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
      const kith_index j = rows->node[e];
      if (j < 0 || j >= count) KITH_FAIL(INTERNAL, "%s: row %d holds %d of %d nodes", what, i, j, count);
      if (e > rows->first[i] &&
          (j < rows->node[e - 1] ||
           (j == rows->node[e - 1] && kith_row_shift(rows, e) <= kith_row_shift(rows, e - 1))))
        KITH_FAIL(INTERNAL, "%s: row %d is not ascending at %d", what, i, j);
    }
  }
  return KITH_OK;
}

/* Rows of the nodes 0 .. stored - 1: no self, symmetric where stored. */
static kith_status valid_rows(const struct kith_rows *rows, const char *what, kith_index count,
                              kith_index stored) {
  if (rows->n != stored) KITH_FAIL(INTERNAL, "%s: %d rows for %d nodes", what, rows->n, stored);
  KITH_TRY(valid_csr(rows, what, count));
  for (kith_index i = 0; i < stored; ++i)
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
      const kith_index j = rows->node[e];
      const int s = kith_row_shift(rows, e);
      if (j == i && s == rows->zero) KITH_FAIL(INTERNAL, "%s: row %d holds itself", what, i);
      if (j < stored && !kith_rows_hold(rows, j, i, 2 * rows->zero - s))
        KITH_FAIL(INTERNAL, "%s: row %d holds %d, but not the other way round", what, i, j);
    }
  return KITH_OK;
}

/* Walks the rows and the pairs side by side. */
static kith_status valid_pairs(const struct kith_rows *rows, const struct kith_pairs *pairs,
                               const char *what) {
  size_t p = 0;
  for (kith_index i = 0; i < rows->n; ++i) {
    if (pairs->first[i] != p)
      KITH_FAIL(INTERNAL, "%s: those of node %d start at %zu, not %zu", what, i, pairs->first[i], p);
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
      const kith_index j = rows->node[e], low = KITH_MIN(i, j), high = KITH_MAX(i, j);
      const size_t q = pairs->of_row[e];
      const int s = kith_row_shift(rows, e), other = 2 * rows->zero - s;
      const bool upper = j > i || (j == i && s > rows->zero);
      if (q >= pairs->n || pairs->node[q][0] != low || pairs->node[q][1] != high ||
          (pairs->shift != NULL && pairs->shift[q] != (upper ? s : other)))
        KITH_FAIL(INTERNAL, "%s: entry %d of row %d is not pair %zu", what, j, i, q);
      if (upper && q != p++) KITH_FAIL(INTERNAL, "%s: (%d, %d) is number %zu, out of order", what, i, j, q);
    }
  }
  if (pairs->first[rows->n] != p || pairs->n != p)
    KITH_FAIL(INTERNAL, "%s: there are %zu, the rows hold %zu", what, pairs->n, p);
  for (int k = 0; k < pairs->fields->n; ++k) {
    const struct kith_pairwise *field = &pairs->fields->field[k];
    const size_t m = (size_t)field->spec.components;
    if (!field->spec.lasts || field->generation != pairs->generation) continue;
    for (size_t q = 0; q < pairs->n * m; ++q)
      if (!isfinite(field->value[q]))
        KITH_FAIL(INTERNAL, "%s: %s of pair %zu is %g", what, field->spec.name, q / m, field->value[q]);
  }
  return KITH_OK;
}

/* In canonical order: entries of internal nodes are of pairs of their ends, where the first end has its
 * pairs, and a pair is of as many entries as it has internal ends; a displaced one is of one entry. */
static kith_status valid_canonical(const struct kith_rows *rows, const struct kith_pairs *pairs,
                                   const char *what, kith_index n) {
  size_t entries = rows->first[n];
  for (kith_index i = 0; i < n; ++i)
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
      const kith_index j = rows->node[e];
      const size_t p = pairs->of_row[e];
      const int s = kith_row_shift(rows, e);
      if (p >= pairs->n) KITH_FAIL(INTERNAL, "%s: entry %d of row %d is of no pair", what, j, i);
      const kith_index *end = pairs->node[p];
      const bool own = end[0] == i && end[1] == j, other = end[0] == j && end[1] == i && s == rows->zero;
      if (!(own || other) || (pairs->shift != NULL && pairs->shift[p] != s))
        KITH_FAIL(INTERNAL, "%s: entry %d of row %d is not pair %zu", what, j, i, p);
      if (p < pairs->first[end[0]] || p >= pairs->first[end[0] + 1])
        KITH_FAIL(INTERNAL, "%s: pair %zu is not where those of node %d are", what, p, end[0]);
    }
  for (size_t p = 0; p < pairs->n; ++p) {
    const bool displaced = pairs->shift != NULL && pairs->shift[p] != rows->zero;
    entries -= displaced ? 1 : (size_t)(pairs->node[p][0] < n) + (size_t)(pairs->node[p][1] < n);
  }
  if (entries != 0) KITH_FAIL(INTERNAL, "%s: they have not as many ends as there are entries", what);
  return KITH_OK;
}

static kith_status valid_overlap(const struct kith_rows *overlap, const struct kith_rows *rows) {
  for (kith_index i = 0; i < rows->n; ++i)
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e)
      if (!kith_rows_hold(overlap, i, rows->node[e], kith_row_shift(rows, e)))
        KITH_FAIL(INTERNAL, "overlap: row %d lacks its neighbor %d", i, rows->node[e]);
  return KITH_OK;
}

/* Both ends, and otherwise only common neighbors (as far as rows tell: an idle node has no whole row). */
static kith_status valid_intersection(const struct kith_connectivity *connectivity,
                                      const struct kith_nodes *nodes, kith_index count, kith_index stored) {
  const struct kith_rows *common = &connectivity->intersection, *rows = &connectivity->rows;
  if ((size_t)common->n != connectivity->pairs.n)
    KITH_FAIL(INTERNAL, "intersection: %d rows for %zu pairs", common->n, connectivity->pairs.n);
  KITH_TRY(valid_csr(common, "intersection", count));
  for (kith_index p = 0; p < common->n; ++p) {
    const kith_index i = connectivity->pairs.node[p][0], j = connectivity->pairs.node[p][1];
    const int zero = rows->zero, sj = connectivity->pairs.shift != NULL ? connectivity->pairs.shift[p] : 0;
    if (!kith_rows_hold(common, p, i, zero) || !kith_rows_hold(common, p, j, sj))
      KITH_FAIL(INTERNAL, "intersection: pair (%d, %d) lacks an end", i, j);
    for (size_t e = common->first[p]; e < common->first[p + 1]; ++e) {
      const kith_index k = common->node[e];
      const int s = kith_row_shift(common, e);
      if ((k == i && s == zero) || (k == j && s == sj)) continue;
      if ((kith_node_active(nodes, i) && !kith_rows_hold(rows, i, k, s)) ||
          (j < stored && kith_node_active(nodes, j) && !kith_rows_hold(rows, j, k, zero + s - sj)))
        KITH_FAIL(INTERNAL, "intersection: %d is no common neighbor of (%d, %d)", k, i, j);
    }
  }
  return KITH_OK;
}

kith_status kith_connectivity_valid(const struct kith_connectivity *c, const struct kith_nodes *nodes) {
  const kith_index count = kith_nodes_count(nodes);
  const kith_index stored = c->built.ghost_rows ? count : nodes->n_internal;
  KITH_TRY(kith_connectivity_fresh(c, nodes));
  if (c->canonical && c->built.overlap_pairs)
    KITH_TRY(valid_canonical(&c->overlap, &c->overlap_pairs, "overlap pairs", c->n_internal));
  if (c->canonical)
    return c->built.pairs ? valid_canonical(&c->rows, &c->pairs, "pairs", c->n_internal) : KITH_OK;
  if (c->built.rows) KITH_TRY(valid_rows(&c->rows, "rows", count, stored));
  if (c->built.pairs) KITH_TRY(valid_pairs(&c->rows, &c->pairs, "pairs"));
  if (c->built.overlap) {
    KITH_TRY(valid_rows(&c->overlap, "overlap", count, stored));
    KITH_TRY(valid_overlap(&c->overlap, &c->rows));
  }
  if (c->built.overlap_pairs) {
    struct kith_rows internal = c->overlap;
    internal.n = nodes->n_internal;
    KITH_TRY(valid_pairs(&internal, &c->overlap_pairs, "overlap pairs"));
  }
  return c->built.intersection ? valid_intersection(c, nodes, count, stored) : KITH_OK;
}

/* What a sweep has found, by slot. mark: 1 for a node that was touched first, then 2 when it was a target,
 * then 3 when it was touched last. */
struct census {
  const struct kith_search *search;
  const struct kith_rows *rows;
  bool excluded;
  uint8_t *mark;
  size_t *least, *most; /* interactions without and with those that rounding may decide */
};

static bool has_row(const struct census *c, kith_index i) {
  return i < c->search->n_internal && i < c->rows->n && kith_node_active(c->search->nodes, i);
}

static kith_status advance(struct census *c, const struct kith_run *run, int n, uint8_t from) {
  for (int r = 0; r < n; ++r)
    for (kith_index p = run[r].first; p < run[r].first + run[r].count; ++p)
      if (c->mark[p]++ != from)
        KITH_FAIL(INTERNAL, "sweep: node %d is touched or a target more than once, or not at all",
                  c->search->node[p]);
  return KITH_OK;
}

static kith_status census_first(void *context, const struct kith_run *run, int n) {
  return advance(context, run, n, 0);
}

static kith_status census_meet(struct census *c, kith_index p, kith_index q) {
  const kith_index i = c->search->node[p], j = c->search->node[q];
  double d2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double d = c->search->coordinate[a][p] - c->search->coordinate[a][q];
    d2 += d * d;
  }
  const double radius2 = KITH_MAX(c->search->radius2[p], c->search->radius2[q]);
  const bool hit = d2 <= radius2 * (1 - 1e-12);
  c->least[p] += hit, c->most[p] += d2 <= radius2 * (1 + 1e-12);
  if (hit && !c->excluded && has_row(c, i) && !kith_rows_hold(c->rows, i, j, c->rows->zero))
    KITH_FAIL(INTERNAL, "rows: that of %d lacks %d, which a sweep finds", i, j);
  return KITH_OK;
}

/* f(target, other), and at once f(other, target) where the cells of the other do not know the target. */
static kith_status census_cell(void *context, const struct kith_cell *cell) {
  struct census *c = context;
  for (kith_index t = 0; t < cell->targets; ++t) {
    const kith_index p = cell->target[t];
    KITH_TRY(advance(c, &(struct kith_run){p, 1}, 1, 1));
    for (int r = 0; r < cell->n_active; ++r)
      for (kith_index q = cell->active[r].first; q < cell->active[r].first + cell->active[r].count; ++q) {
        if (q == p) continue;
        KITH_TRY(census_meet(c, p, q));
        if (r < cell->n_coarser) KITH_TRY(census_meet(c, q, p));
      }
  }
  return KITH_OK;
}

static kith_status census_last(void *context, const struct kith_run *run, int n) {
  const struct census *c = context;
  KITH_TRY(advance(context, run, n, 2));
  for (int r = 0; r < n; ++r)
    for (kith_index p = run[r].first; p < run[r].first + run[r].count; ++p) {
      const kith_index i = c->search->node[p];
      if (!has_row(c, i)) continue;
      size_t length = 0; /* without images, of which a sweep knows nothing */
      for (size_t e = c->rows->first[i]; e < c->rows->first[i + 1]; ++e)
        length += kith_row_shift(c->rows, e) == c->rows->zero;
      if (length > c->most[p] || (!c->excluded && length < c->least[p]))
        KITH_FAIL(INTERNAL, "rows: that of %d has %zu nodes, a sweep finds %zu to %zu", i, length,
                  c->least[p], c->most[p]);
    }
  return KITH_OK;
}

kith_status kith_connectivity_complete(const struct kith_connectivity *connectivity,
                                       const struct kith_search *search, bool excluded) {
  static const struct kith_sweep events = {census_first, census_cell, census_last};
  struct census c = {.search = search, .rows = &connectivity->rows, .excluded = excluded};
  const size_t n = (size_t)search->n;
  kith_status status = kith_resize(&c.mark, 0, n, 1);
  if (status == KITH_OK) status = kith_resize(&c.least, 0, 2 * n, sizeof *c.least);
  c.most = c.least + n;
  if (status == KITH_OK) status = kith_search_sweep(search, &events, &c);
  for (size_t p = 0; p < n && status == KITH_OK; ++p)
    if (c.mark[p] != 3) status = kith_fail(KITH_INTERNAL, "sweep: node %d is in no cell", search->node[p]);
  KITH_FREE(&c.mark, &c.least);
  return status;
}
