/* keyed.h - nodes with a key, and how they are sorted: by key, equal keys in the order they came in.
 *
 * The most significant digits first, then each bin on its own, in cache; short or constant bins cost nearly nothing.
 * Other than kith_key_sort it works in memory that its owner keeps from step to step. */
#ifndef KITH_NEIGHBOR_KEYED_H
#define KITH_NEIGHBOR_KEYED_H

#include "lib/core/base.h"

struct kith_keyed {
  uint64_t key;
  kith_index node;
};

/* Sorts item[n]; scratch[n] is overwritten. The same result for any number of threads. O(n). */
kith_status kith_keyed_sort(struct kith_keyed *item, struct kith_keyed *scratch, size_t n);

#endif
