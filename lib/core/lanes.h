/* lanes.h - four doubles side by side, for sums that the compiler does not keep in registers by itself, and
 * for the values of four nodes that are loaded together.
 *
 * Arrays handed to these functions are 32-byte aligned and padded to a multiple of KITH_LANES with values
 * that add nothing. The order of a sum is fixed by the length alone. */
#ifndef KITH_CORE_LANES_H
#define KITH_CORE_LANES_H

#include "lib/core/base.h"

enum { KITH_LANES = 4 };
typedef double kith_lanes __attribute__((vector_size(8 * KITH_LANES)));

static inline size_t kith_lanes_padded(size_t n) {
  return (n + KITH_LANES - 1) / KITH_LANES * KITH_LANES;
}

KITH_INLINE double kith_lanes_total(const kith_lanes *s) {
  return ((*s)[0] + (*s)[1]) + ((*s)[2] + (*s)[3]);
}

/* Loads four doubles from each of four records and transposes them: to[q] gets double q of each record. On
 * many processors that takes a fraction of the time of four loads that gather one double of each. */
KITH_INLINE void kith_lanes_transpose(const double *const from[KITH_LANES], kith_lanes to[KITH_LANES]) {
  typedef double unaligned __attribute__((vector_size(8 * KITH_LANES), aligned(8)));
  const kith_lanes a = *(const unaligned *)from[0], b = *(const unaligned *)from[1],
                   c = *(const unaligned *)from[2], d = *(const unaligned *)from[3];
  const kith_lanes even_ab = __builtin_shufflevector(a, b, 0, 4, 2, 6),
                   odd_ab = __builtin_shufflevector(a, b, 1, 5, 3, 7),
                   even_cd = __builtin_shufflevector(c, d, 0, 4, 2, 6),
                   odd_cd = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  to[0] = __builtin_shufflevector(even_ab, even_cd, 0, 1, 4, 5);
  to[1] = __builtin_shufflevector(odd_ab, odd_cd, 0, 1, 4, 5);
  to[2] = __builtin_shufflevector(even_ab, even_cd, 2, 3, 6, 7);
  to[3] = __builtin_shufflevector(odd_ab, odd_cd, 2, 3, 6, 7);
}

/* Entries k .. k + 3 of node[n]. Where fewer than four are left the last one is repeated, and the four are in
 * `room`. */
KITH_INLINE const kith_index *kith_lanes_entries(const kith_index *restrict node, size_t k, size_t n,
                                                 kith_index room[KITH_LANES]) {
  if (k + KITH_LANES <= n) return node + k;
  for (size_t l = 0; l < KITH_LANES; ++l) room[l] = node[KITH_MIN(k + l, n - 1)];
  return room;
}

/* How many components kith_lanes_vector writes. */
enum { KITH_VECTOR_LANES = NDIM == 1 ? 1 : KITH_LANES };

/* Component a of the vectors of four nodes goes to to[a]; lanes beyond NDIM hold anything. The field is read
 * up to two doubles beyond the last vector: fields of nodes are allocated so. */
KITH_INLINE void kith_lanes_vector(const double *restrict field, const kith_index *four,
                                   kith_lanes to[KITH_VECTOR_LANES]) {
  const double *from[KITH_LANES];
  for (size_t l = 0; l < KITH_LANES; ++l) from[l] = field + (size_t)four[l] * NDIM;
  if (NDIM > 1)
    kith_lanes_transpose(from, to);
  else
    for (size_t l = 0; l < KITH_LANES; ++l) to[0][l] = *from[l];
}

/* x_j - x_i of the n nodes j in `node`: component a goes to to[a * stride ..], |x_j - x_i|^2 to r2. Both are
 * filled up to a multiple of four with the values of the last node. If shift is not NULL, the k-th node is
 * displaced by by[shift[k]]. */
KITH_INLINE void kith_lanes_separations(const double *restrict x, kith_index i,
                                        const kith_index *restrict node, const uint16_t *restrict shift,
                                        double (*by)[NDIM], size_t n, double *restrict to, size_t stride,
                                        double *restrict r2) {
  const double *restrict xi = x + (size_t)i * NDIM;
  for (size_t k = 0; k < n; k += KITH_LANES) {
    kith_index room[KITH_LANES];
    kith_lanes d[KITH_VECTOR_LANES], sum = {0};
    kith_lanes_vector(x, kith_lanes_entries(node, k, n, room), d);
    for (int a = 0; a < NDIM; ++a) {
      kith_lanes moved = {0};
      for (size_t l = 0; shift != NULL && l < KITH_LANES; ++l)
        moved[l] = by[shift[KITH_MIN(k + l, n - 1)]][a];
      if (shift != NULL) d[a] += moved;
      d[a] -= xi[a];
      sum += d[a] * d[a];
      *(kith_lanes *)(to + (size_t)a * stride + k) = d[a];
    }
    *(kith_lanes *)(r2 + k) = sum;
  }
}

#endif
