/* Patching after a cull. Ghosts are the last nodes and culling keeps the order, so new numbers never reverse
 * an order: sorted stays sorted, i < j stays i < j, and internal nodes keep their numbers.
 *
 * If no entry is lost (the usual case: only ghosts that nobody needs are culled, and they have no rows), only
 * ghost numbers change, at the tail of each row. Otherwise everything is moved up in place, in one sweep. */
#include "lib/connectivity/internal.h"

static kith_status check_renumber(const struct kith_nodes *nodes, const kith_index *renumber,
                                  kith_index old_count) {
  kith_index next = 0;
  for (kith_index i = 0; i < old_count; ++i) {
    if (renumber[i] < 0 && i >= nodes->n_internal) continue;
    if (renumber[i] != next) KITH_FAIL(INTERNAL, "node %d cannot become node %d", i, renumber[i]);
    ++next;
  }
  if (next != kith_nodes_count(nodes))
    KITH_FAIL(INTERNAL, "%d nodes are renumbered, there are %d", next, kith_nodes_count(nodes));
  return KITH_OK;
}

/* Is any entry of the first n rows culled? Ghosts are the tail of a row. */
static bool loses_entry(const struct kith_rows *rows, const kith_index *renumber, kith_index n_internal) {
  int lost = 0;
#pragma omp parallel for schedule(static) reduction(| : lost) if (rows->n > KITH_FEW)
  for (kith_index i = 0; i < rows->n; ++i)
    for (size_t e = rows->first[i + 1]; e > rows->first[i] && rows->node[e - 1] >= n_internal; --e)
      lost |= renumber[rows->node[e - 1]] < 0;
  return lost != 0;
}

static bool loses_row(const struct kith_rows *rows, const kith_index *renumber, kith_index n_internal) {
  for (kith_index i = n_internal; i < rows->n; ++i)
    if (renumber[i] < 0 && rows->first[i + 1] > rows->first[i]) return true;
  return false;
}

/* New numbers for the ghosts at the tail of each row. */
static void renumber_tails(const struct kith_rows *rows, const kith_index *renumber, kith_index n_internal) {
#pragma omp parallel for schedule(static) if (rows->n > KITH_FEW)
  for (kith_index i = 0; i < rows->n; ++i)
    for (size_t e = rows->first[i + 1]; e > rows->first[i] && rows->node[e - 1] >= n_internal; --e)
      rows->node[e - 1] = renumber[rows->node[e - 1]];
}

/* Rows that hold no entry lose their first[] only. */
static void drop_empty_rows(size_t *first, const kith_index *renumber, kith_index n_internal,
                            kith_index old_count) {
  for (kith_index i = n_internal; i < old_count; ++i)
    if (renumber[i] >= 0) first[renumber[i] + 1] = first[i + 1];
}

/* Moves the kept entries of one row to `to`; returns the place behind them. */
static size_t move_row(kith_index *node, size_t from, size_t stop, size_t to, const kith_index *renumber) {
  for (; from < stop; ++from)
    if (renumber[node[from]] >= 0) node[to++] = renumber[node[from]];
  return to;
}

/* Rows by node: keeps the rows of kept nodes, and in them the kept entries. */
static void move_rows(struct kith_rows *rows, const kith_index *renumber) {
  size_t to = 0, from = 0;
  for (kith_index i = 0; i < rows->n; ++i) {
    const size_t stop = rows->first[i + 1];
    if (renumber[i] >= 0) {
      to = move_row(rows->node, from, stop, to, renumber);
      rows->first[renumber[i] + 1] = to;
    }
    from = stop;
  }
}

/* Pairs whose ends are kept, with their factor and their intersection. Call while pairs.first has the old
 * numbers. */
static void move_pairs(struct kith_connectivity *connectivity, const kith_index *renumber,
                       kith_index old_count) {
  struct kith_pairs *pairs = &connectivity->pairs;
  struct kith_rows *common = connectivity->built.intersection ? &connectivity->intersection : NULL;
  size_t kept = 0, p = 0, common_from = 0, common_to = 0;
  for (kith_index i = 0; i < old_count; ++i) {
    const size_t stop = pairs->first[i + 1];
    for (; p < stop; ++p) {
      const size_t common_stop = common != NULL ? common->first[p + 1] : 0;
      const kith_index j = renumber[pairs->node[p][1]];
      if (renumber[i] >= 0 && j >= 0) {
        pairs->node[kept][0] = renumber[i], pairs->node[kept][1] = j;
        if (pairs->f_couple != NULL) pairs->f_couple[kept] = pairs->f_couple[p];
        if (common != NULL)
          common->first[kept + 1] = common_to =
              move_row(common->node, common_from, common_stop, common_to, renumber);
        ++kept;
      }
      common_from = common_stop;
    }
    if (renumber[i] >= 0) pairs->first[renumber[i] + 1] = kept;
  }
  pairs->n = kept;
  if (common != NULL) common->n = (kith_index)kept;
}

/* The pairs of i are the tail of row i, so their ghosts are the tail of the pairs. */
static void renumber_pairs(const struct kith_connectivity *connectivity, const kith_index *renumber,
                           kith_index n_internal) {
  const struct kith_pairs *pairs = &connectivity->pairs;
#pragma omp parallel for schedule(static) if (connectivity->rows.n > KITH_FEW)
  for (kith_index i = 0; i < connectivity->rows.n; ++i)
    for (size_t p = pairs->first[i + 1]; p > pairs->first[i] && pairs->node[p - 1][1] >= n_internal; --p) {
      pairs->node[p - 1][0] = renumber[i];
      pairs->node[p - 1][1] = renumber[pairs->node[p - 1][1]];
    }
}

static void patch_rows(struct kith_rows *rows, const kith_index *renumber, kith_index n_internal,
                       kith_index new_count) {
  if (loses_row(rows, renumber, n_internal) || loses_entry(rows, renumber, n_internal))
    move_rows(rows, renumber);
  else {
    renumber_tails(rows, renumber, n_internal);
    drop_empty_rows(rows->first, renumber, n_internal, rows->n);
  }
  rows->n = new_count;
}

/* Rows and all that hangs on them. */
static kith_status patch_pairs(struct kith_connectivity *connectivity, const kith_index *renumber,
                               kith_index n_internal, kith_index new_count) {
  struct kith_rows *rows = &connectivity->rows;
  const kith_index old_count = rows->n;
  const bool loses = loses_row(rows, renumber, n_internal) || loses_entry(rows, renumber, n_internal);
  if (loses) {
    move_pairs(connectivity, renumber, old_count);
    move_rows(rows, renumber);
    rows->n = new_count;
    return kith_pairs_of_row(connectivity); /* the numbers of the pairs changed */
  }
  renumber_pairs(connectivity, renumber, n_internal);
  drop_empty_rows(connectivity->pairs.first, renumber, n_internal, old_count);
  if (connectivity->built.intersection) renumber_tails(&connectivity->intersection, renumber, n_internal);
  renumber_tails(rows, renumber, n_internal);
  drop_empty_rows(rows->first, renumber, n_internal, old_count);
  rows->n = new_count;
  return KITH_OK;
}

kith_status kith_connectivity_patch(struct kith_connectivity *connectivity, const struct kith_nodes *nodes,
                                    const kith_index *renumber, kith_index old_count) {
  const kith_index n_internal = nodes->n_internal, new_count = kith_nodes_count(nodes);
  if (connectivity->built.rows) {
    if (connectivity->rows.n != old_count)
      KITH_FAIL(STALE, "the connectivity has %d nodes, the renumbering %d", connectivity->rows.n, old_count);
    KITH_TRY(check_renumber(nodes, renumber, old_count));
    if (connectivity->built.overlap) patch_rows(&connectivity->overlap, renumber, n_internal, new_count);
    if (connectivity->built.pairs)
      KITH_TRY(patch_pairs(connectivity, renumber, n_internal, new_count));
    else
      patch_rows(&connectivity->rows, renumber, n_internal, new_count);
  }
  connectivity->ghosts = nodes->ghosts;
  ++connectivity->generation;
  return KITH_OK;
}
