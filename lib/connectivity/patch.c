/* patch.c - renumbering after a cull. Ghosts are the last nodes and culling keeps the order, so new numbers
 * never reverse an order: sorted stays sorted, i < j stays i < j, and internal nodes keep their numbers.
 *
 * Only numbers behind the first culled ghost change, at the tail of each row. If entries are lost (not in the
 * usual case: only ghosts that nobody needs are culled, and they have no rows), the rest is moved up. */
#include "lib/connectivity/connectivity.h"

/* What changes. Old numbers of nodes are those before the cull. */
struct cull {
  const kith_index *renumber; /* [old_count] */
  kith_index n_internal, old_count;
  kith_index changed; /* the first node whose number changes */
};

static kith_status check(const struct cull *cull, const struct kith_nodes *nodes) {
  kith_index next = cull->n_internal, wrong = cull->old_count;
#pragma omp parallel for schedule(static) reduction(min : wrong) if (cull->n_internal > KITH_FEW)
  for (kith_index i = 0; i < cull->n_internal; ++i)
    if (cull->renumber[i] != i) wrong = KITH_MIN(wrong, i);
  for (kith_index i = cull->n_internal; i < cull->old_count; ++i)
    if (cull->renumber[i] >= 0 && cull->renumber[i] != next++) wrong = KITH_MIN(wrong, i);
  if (wrong < cull->old_count)
    KITH_FAIL(INTERNAL, "node %d cannot become node %d", wrong, cull->renumber[wrong]);
  if (next != kith_nodes_count(nodes))
    KITH_FAIL(INTERNAL, "%d nodes are renumbered, there are %d", next, kith_nodes_count(nodes));
  return KITH_OK;
}

/* New numbers for the tail of each row, -1 for culled ones, and for all entries of the rows of
 * culled nodes (of_nodes). Is any entry lost? */
static bool renumber_rows(const struct kith_rows *rows, const struct cull *cull, bool of_nodes) {
  kith_index least = 0;
#pragma omp parallel for schedule(static) reduction(min : least) if (rows->n > KITH_FEW)
  for (kith_index i = 0; i < rows->n; ++i) {
    const bool gone = of_nodes && cull->renumber[i] < 0;
    for (size_t e = rows->first[i + 1]; e > rows->first[i]; --e) {
      kith_index *node = &rows->node[e - 1];
      if (*node < cull->changed && !gone) break;
      *node = gone ? -1 : cull->renumber[*node];
      least = KITH_MIN(least, *node);
    }
  }
  return least < 0;
}

/* The pairs of i are the tail of row i, so their ghosts are the tail of the pairs. Lost pairs: (-1, any). */
static void renumber_pairs(const struct kith_pairs *pairs, kith_index n, const struct cull *cull) {
#pragma omp parallel for schedule(static) if (n > KITH_FEW)
  for (kith_index i = 0; i < n; ++i)
    for (size_t p = pairs->first[i + 1]; p > pairs->first[i] && pairs->node[p - 1][1] >= cull->changed; --p) {
      kith_index *node = pairs->node[p - 1];
      node[1] = cull->renumber[node[1]];
      node[0] = node[1] < 0 ? -1 : cull->renumber[i];
    }
}

/* Nodes of the intersection of lost pairs become -1. */
static void drop_common(const struct kith_pairs *pairs, const struct kith_rows *common) {
#pragma omp parallel for schedule(static) if (pairs->n > KITH_FEW)
  for (size_t p = 0; p < pairs->n; ++p)
    for (size_t e = common->first[p]; pairs->node[p][0] < 0 && e < common->first[p + 1]; ++e)
      common->node[e] = -1;
}

/* --- rows with their pairs --- */

/* Rows of culled nodes are empty by now, and only their offset goes. */
static void drop_offsets(size_t *first, kith_index n, const struct cull *cull) {
  for (kith_index i = cull->n_internal; i < n; ++i)
    if (cull->renumber[i] >= 0) first[cull->renumber[i] + 1] = first[i + 1];
}

/* Rows, the pairs of the first n of them, and the common neighbors of these; pairs and common may be NULL. */
static kith_status patch(struct kith_rows *rows, struct kith_pairs *pairs, kith_index n,
                         struct kith_rows *common, const struct cull *cull, kith_index new_rows) {
  const bool lost = renumber_rows(rows, cull, true);
  if (pairs != NULL) renumber_pairs(pairs, n, cull);
  /* Pairs of an idle node may have ghosts in common that are in no row. */
  const bool lost_common = common != NULL && renumber_rows(common, cull, false);
  if (common != NULL && lost) drop_common(pairs, common);
  if (common != NULL && (lost || lost_common)) kith_rows_compact(common);
  if (lost) {
    if (pairs != NULL) kith_pairs_compact(pairs, n, common);
    kith_rows_compact(rows);
  }
  if (pairs != NULL) drop_offsets(pairs->first, n, cull);
  drop_offsets(rows->first, rows->n, cull);
  rows->n = new_rows;
  if (pairs != NULL) kith_pairs_carry(pairs);
  if (pairs == NULL || !lost) return KITH_OK;
  struct kith_rows with_pairs = *rows;
  with_pairs.n = KITH_MIN(n, new_rows);
  return kith_pairs_of_row(pairs, &with_pairs); /* the numbers of the pairs changed */
}

kith_status kith_connectivity_patch(struct kith_connectivity *c, const struct kith_nodes *nodes,
                                    const kith_index *renumber, kith_index old_count) {
  struct cull cull = {renumber, nodes->n_internal, old_count, nodes->n_internal};
  const struct kith_requirements *built = &c->built;
  const kith_index stored = built->ghost_rows ? kith_nodes_count(nodes) : nodes->n_internal;
  if (c->canonical) KITH_FAIL(UNSUPPORTED, "a connectivity in canonical order cannot be patched");
  if (built->rows) {
    if (c->n != old_count)
      KITH_FAIL(STALE, "the connectivity has %d nodes, the renumbering %d", c->n, old_count);
    KITH_TRY(check(&cull, nodes));
    while (cull.changed < old_count && renumber[cull.changed] == cull.changed) ++cull.changed;
    if (built->overlap)
      KITH_TRY(patch(&c->overlap, built->overlap_pairs ? &c->overlap_pairs : NULL, c->n_internal, NULL, &cull,
                     stored));
    KITH_TRY(patch(&c->rows, built->pairs ? &c->pairs : NULL, c->rows.n,
                   built->intersection ? &c->intersection : NULL, &cull, stored));
  }
  kith_free(&c->rows.wanted); /* by the old numbers */
  c->n = kith_nodes_count(nodes);
  c->ghosts = nodes->ghosts;
  return KITH_OK;
}
