/* random.h - numbers that depend on their arguments alone: the same on any ranks and threads, and after a
 * restart. */
#ifndef KITH_CORE_RANDOM_H
#define KITH_CORE_RANDOM_H

#include <stdint.h>

/* The finalizer of splitmix64 (Steele, Lea and Flood 2014, OOPSLA). */
static inline uint64_t kith_mixed_bits(uint64_t z) {
  z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
  z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
  return z ^ (z >> 31);
}

/* Uniform in [-1, 1). */
static inline double kith_random(uint64_t seed, int64_t id, int axis) {
  const uint64_t counter = 3 * (uint64_t)id + (uint64_t)axis + 1;
  return (double)(kith_mixed_bits(kith_mixed_bits(seed) + UINT64_C(0x9e3779b97f4a7c15) * counter) >> 11) *
             0x1p-52 -
         1;
}

#endif
