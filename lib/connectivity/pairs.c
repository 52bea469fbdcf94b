/* pairs.c - the upper part (j > i) of every row, row by row, which pair each entry of a row is, and pairwise
 * fields. */
#include "lib/connectivity/pairs.h"

#include <string.h>

kith_status kith_pairs_reserve(struct kith_pairs *pairs, kith_index rows, size_t entries) {
  KITH_TRY(kith_reserve(&pairs->first, &pairs->first_capacity, (size_t)rows + 1, sizeof *pairs->first));
  pairs->first[0] = 0;
  return kith_reserve(&pairs->of_row, &pairs->of_row_capacity, entries, sizeof *pairs->of_row);
}

kith_status kith_pairs_reserve_nodes(struct kith_pairs *pairs, bool shifts) {
  if (pairs->n > UINT32_MAX) KITH_FAIL(UNSUPPORTED, "%zu pairs: a process can number 2^32", pairs->n);
  KITH_TRY(kith_reserve(&pairs->node, &pairs->capacity, pairs->n, sizeof *pairs->node));
  if (shifts) return kith_reserve(&pairs->shift, &pairs->shifts_capacity, pairs->n, sizeof *pairs->shift);
  kith_free(&pairs->shift);
  pairs->shifts_capacity = 0;
  return KITH_OK;
}

/* The first pair of the lower entry j of row i: it starts at j. */
static size_t first_pair(const struct kith_rows *rows, const struct kith_pairs *pairs, kith_index j,
                         kith_index i) {
  const size_t stop = rows->first[j + 1], start = stop - (pairs->first[j + 1] - pairs->first[j]);
  return pairs->first[j] + kith_lower_bound(rows->node, start, stop, i) - start;
}

/* Finds the pair of each entry of rows from .. to - 1. An upper entry of row i is the next pair of i. A lower
 * entry j is a pair that starts at j. As i ascends, the pairs of j are met in their order, so a cursor for
 * each j gives them; only those of a j before `from` must be looked up. Of several images of j in row i the
 * shifts are the opposite ones in row j, where they ascend, too: their pairs follow in reverse. */
static void number_entries(const struct kith_rows *rows, struct kith_pairs *pairs, kith_index from,
                           kith_index to) {
  uint32_t *cursor = pairs->cursor;
  for (kith_index i = from; i < to; ++i) {
    const size_t split = rows->first[i + 1] - (pairs->first[i + 1] - pairs->first[i]);
    cursor[i] = (uint32_t)pairs->first[i];
    for (size_t e = rows->first[i], end; e < split; e = end) {
      const kith_index j = rows->node[e];
      for (end = e + 1; end < split && rows->node[end] == j;) ++end;
      const uint32_t first = j >= from ? cursor[j] : (uint32_t)first_pair(rows, pairs, j, i);
      for (size_t k = e; k < end; ++k) pairs->of_row[k] = first + (uint32_t)(end - 1 - k);
      if (j >= from) cursor[j] = first + (uint32_t)(end - e);
    }
    for (size_t e = split, p = pairs->first[i]; e < rows->first[i + 1]; ++e) pairs->of_row[e] = (uint32_t)p++;
  }
}

/* Few parts, so that few entries lie outside of their part; the result does not depend on them. */
enum { PARTS = 16 };

kith_status kith_pairs_of_row(struct kith_pairs *pairs, const struct kith_rows *rows) {
  KITH_TRY(kith_reserve(&pairs->cursor, &pairs->cursor_capacity, (size_t)rows->n, sizeof *pairs->cursor));
#pragma omp parallel for schedule(dynamic, 1) if (rows->n > KITH_FEW)
  for (int s = 0; s < PARTS; ++s)
    number_entries(rows, pairs, kith_part_start(rows->n, s, PARTS), kith_part_start(rows->n, s + 1, PARTS));
  return KITH_OK;
}

kith_status kith_pairs_build(struct kith_pairs *pairs, const struct kith_rows *rows, kith_index starts) {
  pairs->starts = starts;
  if (pairs->fields == NULL) KITH_TRY(kith_resize(&pairs->fields, 0, 1, sizeof *pairs->fields));
  KITH_TRY(kith_pairs_reserve(pairs, rows->n, rows->first[rows->n]));
#pragma omp parallel for schedule(static) if (rows->n > KITH_FEW)
  for (kith_index i = 0; i < rows->n; ++i) /* from the first entry of row i that is above i */
    pairs->first[i + 1] = rows->first[i + 1] - kith_rows_find(rows, i, i, rows->zero);
  for (kith_index i = 0; i < rows->n; ++i) pairs->first[i + 1] += pairs->first[i];
  pairs->n = pairs->first[rows->n];
  KITH_TRY(kith_pairs_reserve_nodes(pairs, rows->shift != NULL));
#pragma omp parallel for schedule(static) if (rows->n > KITH_FEW)
  for (kith_index i = 0; i < rows->n; ++i) {
    const size_t count = pairs->first[i + 1] - pairs->first[i], start = rows->first[i + 1] - count;
    for (size_t k = 0; k < count; ++k) {
      pairs->node[pairs->first[i] + k][0] = i;
      pairs->node[pairs->first[i] + k][1] = rows->node[start + k];
      if (pairs->shift != NULL) pairs->shift[pairs->first[i] + k] = rows->shift[start + k];
    }
  }
  return kith_pairs_of_row(pairs, rows);
}

/* Does the field have values of the present pairs that a patch carries over? */
static bool is_carried(const struct kith_pairs *pairs, const struct kith_pairwise *field) {
  return field->spec.lasts && field->generation == pairs->generation;
}

void kith_pairs_compact(struct kith_pairs *pairs, kith_index n, struct kith_rows *common) {
  struct kith_column column[KITH_MAX_PAIRWISE + 4] = {{pairs->node, sizeof *pairs->node}}, *next = column + 1;
  if (pairs->shift != NULL) *next++ = (struct kith_column){pairs->shift, sizeof *pairs->shift};
  for (int k = 0; k < pairs->fields->n; ++k) {
    const struct kith_pairwise *field = &pairs->fields->field[k];
    if (is_carried(pairs, field))
      *next++ = (struct kith_column){field->value, (size_t)field->spec.components * sizeof *field->value};
  }
  if (common != NULL)
    *next = (struct kith_column){common->first + 1, sizeof(size_t)}; /* where the entries of a pair end */
  pairs->n = kith_compact(pairs->first, n, column);
  if (common != NULL) common->n = (kith_index)pairs->n;
}

void kith_pairs_carry(struct kith_pairs *pairs) {
  for (int k = 0; k < pairs->fields->n; ++k)
    pairs->fields->field[k].generation += is_carried(pairs, &pairs->fields->field[k]);
  ++pairs->generation;
}

void kith_pairs_clear(struct kith_pairs *pairs) {
  for (int k = 0; pairs->fields != NULL && k < pairs->fields->n; ++k)
    kith_free(&pairs->fields->field[k].value);
  KITH_FREE(&pairs->node, &pairs->first, &pairs->of_row, &pairs->cursor, &pairs->shift, &pairs->fields);
  *pairs = (struct kith_pairs){0};
}

size_t kith_pairs_bytes(const struct kith_pairs *pairs) {
  return pairs->capacity * sizeof *pairs->node + pairs->first_capacity * sizeof *pairs->first +
         (pairs->of_row_capacity + pairs->cursor_capacity) * sizeof(uint32_t) +
         pairs->shifts_capacity * sizeof *pairs->shift + (pairs->fields != NULL ? sizeof *pairs->fields : 0);
}

/* --- pairwise fields --- */

struct kith_pairwise *kith_pairwise_named(const struct kith_pairs *pairs, const char *name) {
  for (int k = 0; pairs->fields != NULL && k < pairs->fields->n; ++k)
    if (strcmp(pairs->fields->field[k].spec.name, name) == 0) return &pairs->fields->field[k];
  return NULL;
}

kith_status kith_pairwise_prepare(const struct kith_pairs *pairs, const struct kith_pairwise_spec *spec,
                                  struct kith_pairwise **out) {
  struct kith_pairwise_fields *fields = pairs->fields;
  struct kith_pairwise *field = kith_pairwise_named(pairs, spec->name);
  if (fields == NULL) KITH_FAIL(UNSUPPORTED, "pairwise field '%s': there are no pairs", spec->name);
  if (field == NULL && fields->n == KITH_MAX_PAIRWISE)
    KITH_FAIL(INTERNAL, "more than %d pairwise fields: '%s'", KITH_MAX_PAIRWISE, spec->name);
  if (field == NULL) field = &fields->field[fields->n++], field->spec = *spec;
  if (field->spec.components != spec->components || field->spec.lasts != spec->lasts)
    KITH_FAIL(INTERNAL, "pairwise field '%s' is registered with another specification", spec->name);
  KITH_TRY(kith_reserve(&field->value, &field->capacity, pairs->n * (size_t)spec->components,
                        sizeof *field->value));
  field->generation = pairs->generation;
  *out = field;
  return KITH_OK;
}

kith_status kith_pairwise_fresh(const struct kith_pairs *pairs, const struct kith_pairwise *field) {
  if (field->generation != pairs->generation)
    KITH_FAIL(STALE, "pairwise field '%s' belongs to pairs of generation %llu, there is %llu",
              field->spec.name, (unsigned long long)field->generation, (unsigned long long)pairs->generation);
  return KITH_OK;
}

size_t kith_pairwise_bytes(const struct kith_pairs *pairs) {
  size_t bytes = 0;
  for (int k = 0; pairs->fields != NULL && k < pairs->fields->n; ++k)
    bytes += pairs->fields->field[k].capacity * sizeof(double);
  return bytes;
}
