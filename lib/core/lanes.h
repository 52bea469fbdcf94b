/* lanes.h - four doubles side by side, for sums that the compiler does not keep in registers by itself.
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

#endif
