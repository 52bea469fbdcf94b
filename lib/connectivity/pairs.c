/* Pairs: the upper part (j > i) of every row, row by row. */
#include "lib/connectivity/internal.h"

/* First entry of row i that is above i. */
static size_t upper_part(const struct kith_rows *rows, kith_index i) {
  return kith_lower_bound(rows->node, rows->first[i], rows->first[i + 1], i);
}

static kith_status number_pairs(const struct kith_rows *rows, struct kith_pairs *pairs) {
  KITH_TRY(kith_room(&pairs->first, &pairs->first_capacity, (size_t)rows->n + 1, sizeof *pairs->first));
  pairs->first[0] = 0;
#pragma omp parallel for schedule(static) if (rows->n > KITH_FEW)
  for (kith_index i = 0; i < rows->n; ++i) pairs->first[i + 1] = rows->first[i + 1] - upper_part(rows, i);
  for (kith_index i = 0; i < rows->n; ++i) pairs->first[i + 1] += pairs->first[i];
  pairs->n = pairs->first[rows->n];
  if (pairs->n > UINT32_MAX) KITH_FAIL(UNSUPPORTED, "%zu pairs: a process can number 2^32", pairs->n);
  return KITH_OK;
}

/* Rows from..to. An upper entry of row i is the next pair of i. A lower entry j is a pair of row j: as i
 * ascends, it meets the pairs of j in order, so a cursor for each j gives them; only where j lies before
 * `from` it must be looked up. */
static void number_entries(const struct kith_rows *rows, struct kith_pairs *pairs, uint32_t *cursor,
                           kith_index from, kith_index to) {
  for (kith_index i = from; i < to; ++i) {
    const size_t split = rows->first[i + 1] - (pairs->first[i + 1] - pairs->first[i]);
    size_t e = rows->first[i];
    for (; e < split && rows->node[e] < from; ++e) {
      const kith_index j = rows->node[e];
      const size_t stop = rows->first[j + 1], start = stop - (pairs->first[j + 1] - pairs->first[j]);
      pairs->of_row[e] = (uint32_t)(pairs->first[j] + kith_lower_bound(rows->node, start, stop, i) - start);
    }
    for (; e < split; ++e) pairs->of_row[e] = cursor[rows->node[e]]++;
    for (size_t p = pairs->first[i]; e < rows->first[i + 1]; ++e) pairs->of_row[e] = (uint32_t)p++;
    cursor[i] = (uint32_t)pairs->first[i];
  }
}

/* Shares of the nodes: few, so that few entries point out of their share; the result does not depend on them.
 */
enum { SHARES = 16 };

kith_status kith_pairs_of_row(struct kith_connectivity *connectivity) {
  const struct kith_rows *rows = &connectivity->rows;
  struct kith_pairs *pairs = &connectivity->pairs;
  struct kith_connectivity_scratch *scratch = connectivity->scratch;
  KITH_TRY(kith_room(&pairs->of_row, &pairs->of_row_capacity, rows->first[rows->n], sizeof *pairs->of_row));
  KITH_TRY(kith_room(&scratch->cursor, &scratch->cursor_capacity, (size_t)rows->n, sizeof *scratch->cursor));
#pragma omp parallel for schedule(dynamic, 1) if (rows->n > KITH_FEW)
  for (int s = 0; s < SHARES; ++s)
    number_entries(rows, pairs, scratch->cursor, (kith_index)((int64_t)rows->n * s / SHARES),
                   (kith_index)((int64_t)rows->n * (s + 1) / SHARES));
  return KITH_OK;
}

kith_status kith_pairs_build(const struct kith_build *build) {
  const struct kith_rows *rows = &build->connectivity->rows;
  struct kith_pairs *pairs = &build->connectivity->pairs;
  KITH_TRY(number_pairs(rows, pairs));
  pairs->canonical = false;
  pairs->starts = build->nodes->n_internal;
  KITH_TRY(kith_room(&pairs->node, &pairs->capacity, pairs->n, sizeof *pairs->node));
#pragma omp parallel for schedule(static) if (rows->n > KITH_FEW)
  for (kith_index i = 0; i < rows->n; ++i) {
    const size_t count = pairs->first[i + 1] - pairs->first[i], start = rows->first[i + 1] - count;
    for (size_t k = 0; k < count; ++k) {
      pairs->node[pairs->first[i] + k][0] = i;
      pairs->node[pairs->first[i] + k][1] = rows->node[start + k];
    }
  }
  return kith_pairs_of_row(build->connectivity);
}
