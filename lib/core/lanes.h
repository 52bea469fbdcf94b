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

/* Doubles 0 .. 3 of four records, of which double q of all goes to to[q * stride .. q * stride + 3]. On many
 * processors that takes a fraction of the time of four loads that gather one double of each. */
KITH_INLINE void kith_lanes_transpose(const double *a, const double *b, const double *c, const double *d,
                                      double *to, size_t stride) {
  typedef double unaligned __attribute__((vector_size(8 * KITH_LANES), aligned(8)));
  const kith_lanes ra = *(const unaligned *)a, rb = *(const unaligned *)b, rc = *(const unaligned *)c,
                   rd = *(const unaligned *)d;
  const kith_lanes even_ab = __builtin_shufflevector(ra, rb, 0, 4, 2, 6),
                   odd_ab = __builtin_shufflevector(ra, rb, 1, 5, 3, 7),
                   even_cd = __builtin_shufflevector(rc, rd, 0, 4, 2, 6),
                   odd_cd = __builtin_shufflevector(rc, rd, 1, 5, 3, 7);
  *(kith_lanes *)to = __builtin_shufflevector(even_ab, even_cd, 0, 1, 4, 5);
  *(kith_lanes *)(to + stride) = __builtin_shufflevector(odd_ab, odd_cd, 0, 1, 4, 5);
  *(kith_lanes *)(to + 2 * stride) = __builtin_shufflevector(even_ab, even_cd, 2, 3, 6, 7);
  *(kith_lanes *)(to + 3 * stride) = __builtin_shufflevector(odd_ab, odd_cd, 2, 3, 6, 7);
}

/* Lanes that a vector takes when it is loaded. */
enum { KITH_VECTOR_LANES = NDIM == 1 ? 1 : KITH_LANES };

/* The vectors of n nodes: component a of all goes to to[a * stride ..]. Up to the next multiple of four the
 * last one follows, and lanes beyond NDIM hold anything. The field is read up to three doubles beyond the
 * last vector: fields of nodes are allocated so. */
KITH_INLINE void kith_lanes_vectors(const double *restrict field, const kith_index *restrict node, size_t n,
                                    double *restrict to, size_t stride) {
  for (size_t k = 0; k < n; k += KITH_LANES) {
    const double *from[KITH_LANES];
    for (size_t l = 0; l < KITH_LANES; ++l) from[l] = field + (size_t)node[KITH_MIN(k + l, n - 1)] * NDIM;
    if (NDIM > 1)
      kith_lanes_transpose(from[0], from[1], from[2], from[3], to + k, stride);
    else
      for (size_t l = 0; l < KITH_LANES; ++l) to[k + l] = *from[l];
  }
}

#endif
