/* sfc_key.h - positions on a space-filling curve: Morton keys with 52, 31, 21 bits per axis in 1-D, 2-D, 3-D.
 *
 * Keys are not unique (nodes may share a cell of the finest level): sort by key, then by global id. */
#ifndef KITH_CORE_SFC_KEY_H
#define KITH_CORE_SFC_KEY_H

#include "lib/core/keyed.h"

enum { KITH_SFC_KEY_BITS = NDIM == 1 ? 52 : 63 / NDIM }; /* 1-D: the bits of a double's fraction */

/* Spreads the low KITH_SFC_KEY_BITS bits of v, leaving NDIM - 1 zeros between them. */
static inline uint64_t kith_sfc_key_spread(uint64_t v) {
#if NDIM == 1
  return v;
#elif NDIM == 2
  v &= 0x7fffffffu;
  v = (v | v << 16) & 0x0000ffff0000ffffu;
  v = (v | v << 8) & 0x00ff00ff00ff00ffu;
  v = (v | v << 4) & 0x0f0f0f0f0f0f0f0fu;
  v = (v | v << 2) & 0x3333333333333333u;
  return (v | v << 1) & 0x5555555555555555u;
#else
  v &= 0x1fffffu;
  v = (v | v << 32) & 0x001f00000000ffffu;
  v = (v | v << 16) & 0x001f0000ff0000ffu;
  v = (v | v << 8) & 0x100f00f00f00f00fu;
  v = (v | v << 4) & 0x10c30c30c30c30c3u;
  return (v | v << 2) & 0x1249249249249249u;
#endif
}

/* Key of cell coordinates c[NDIM], each below 2^KITH_SFC_KEY_BITS; axis 0 is the most significant of each
 * level. */
static inline uint64_t kith_sfc_key_of_cell(const uint64_t *c) {
  uint64_t key = 0;
  for (int a = 0; a < NDIM; ++a) key |= kith_sfc_key_spread(c[a]) << (NDIM - 1 - a);
  return key;
}

/* Key of x in a box from `lower` with cells of 1 / inverse_cell[a]; positions outside are clamped to the edge
 * cells. */
static inline uint64_t kith_sfc_key_of_position(const double *x, const double *lower,
                                                const double *inverse_cell) {
  uint64_t c[NDIM];
  const double top = (double)((UINT64_C(1) << KITH_SFC_KEY_BITS) - 1);
  for (int a = 0; a < NDIM; ++a) {
    const double s = (x[a] - lower[a]) * inverse_cell[a];
    c[a] = s > 0 ? (uint64_t)(s < top ? s : top) : 0;
  }
  return kith_sfc_key_of_cell(c);
}

/* Keys of x[n][NDIM] in the box lower .. upper, by threads; an axis without length has one cell. */
void kith_sfc_keys(const double *x, kith_index n, const double *lower, const double *upper, uint64_t *key);

/* Sorts `n` items by key, ties by tie[item] (NULL: by item number); order[n] is written, scratch[2 n]
 * overwritten. Radix sort, O(n). */
kith_status kith_sfc_key_sort(size_t n, const uint64_t *key, const int64_t *tie, struct kith_keyed *scratch,
                              kith_index *order);

#endif
