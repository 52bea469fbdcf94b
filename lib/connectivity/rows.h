/* rows.h - compressed rows (CSR): entries of row i are node[first[i]] .. node[first[i + 1] - 1].
 *
 * An entry may be an image of its node (lib/nodes/shifts.h), shift[e] as seen from node i. Entries ascend in
 * node, then in shift. Seen from the other end the shift is 2 zero - shift[e].
 *
 * They are built in two passes: kith_rows_reserve; the first counts, the length of row i into first[i + 1];
 * kith_rows_sum makes offsets of the lengths; the second fills in. */
#ifndef KITH_CONNECTIVITY_ROWS_H
#define KITH_CONNECTIVITY_ROWS_H

#include "lib/core/base.h"

struct kith_rows {
  kith_index n;
  size_t *first;    /* [n + 1] */
  kith_index *node; /* [first[n]] */
  uint16_t *shift;  /* [first[n]]; NULL: no entry is displaced */
  int zero;         /* the number of the zero shift */
  uint8_t *wanted;  /* [ghosts] 1: a row of an internal node holds it; NULL: not known */
  size_t rows_capacity, entries_capacity, shifts_capacity, wanted_bytes;
};

/* Memory for n rows; first[0] = 0. */
kith_status kith_rows_reserve(struct kith_rows *rows, kith_index n);
/* first[i + 1] holds the length of row i: sums them up and reserves memory for the entries. zero: the number
 * of the zero shift of entries that have shifts, or -1. */
kith_status kith_rows_sum(struct kith_rows *rows, int zero);
static inline int kith_rows_zero(const struct kith_rows *rows) {
  return rows->shift != NULL ? rows->zero : -1;
}
static inline int kith_row_shift(const struct kith_rows *rows, size_t e) {
  return rows->shift != NULL ? rows->shift[e] : 0;
}
/* The shifts of entries first .. first + n - 1 if any of these is displaced, else NULL: most rows hold no
 * image, and need no shifts. shift: NULL, or the shifts of all entries. */
static inline const uint16_t *kith_shifts_at(const uint16_t *shift, int zero, size_t first, size_t n) {
  uint16_t any = 0;
  if (shift == NULL) return NULL;
  for (size_t k = first; k < first + n; ++k) any |= (uint16_t)(shift[k] ^ zero);
  return any != 0 ? shift + first : NULL;
}
void kith_rows_clear(struct kith_rows *rows);
size_t kith_rows_bytes(const struct kith_rows *rows);
/* The end of the stretch of rows (KITH_STRETCH) that begins at `begin`; `begin` if all rows in it are
 * empty. */
static inline kith_index kith_rows_stretch_end(const struct kith_rows *rows, kith_index begin) {
  const kith_index stop = KITH_MIN(begin + KITH_STRETCH, rows->n);
  return rows->first[stop] > rows->first[begin] ? stop : begin;
}
/* The length of the longest row. */
size_t kith_rows_longest(const struct kith_rows *rows);

/* The entry of sorted row i that is this image of j, or the entry before which it would be inserted. */
static inline size_t kith_rows_find(const struct kith_rows *rows, kith_index i, kith_index j, int shift) {
  size_t e = kith_lower_bound(rows->node, rows->first[i], rows->first[i + 1], j);
  while (rows->shift != NULL && e < rows->first[i + 1] && rows->node[e] == j && rows->shift[e] < shift) ++e;
  return e;
}
/* Does sorted row i hold this image of j? */
static inline bool kith_rows_hold(const struct kith_rows *rows, kith_index i, kith_index j, int shift) {
  const size_t e = kith_rows_find(rows, i, j, shift);
  return e < rows->first[i + 1] && rows->node[e] == j && kith_row_shift(rows, e) == shift;
}
/* Sorts entries in place, by node and then by shift; fast if most are in order. shift: may be NULL. */
void kith_entries_sort(kith_index *node, uint16_t *shift, size_t n);
/* Sorts keys, fast if they are few ascending sequences; returns the array of the two that has the result. */
uint64_t *kith_keys_sort(uint64_t *key, uint64_t *spare, size_t n);

/* An array with a value for each entry of some rows. */
struct kith_column {
  void *values;
  size_t size; /* of a value */
};
/* Drops the entries whose first column, an index, is below 0, in place; order is kept. The columns end with
 * {0}. Returns how many entries are left. Parallel over fixed shares of the rows. */
size_t kith_compact(size_t *first, kith_index n, const struct kith_column *column);
void kith_rows_compact(struct kith_rows *rows);

#endif
