/* keyed.h - nodes with a key, and their stable sort: by key, equal keys in their original order.
 *
 * A radix sort: the most significant digits first, then each bin on its own, in cache; short or constant bins
 * cost nearly nothing. The memory is the caller's. */
#ifndef KITH_CORE_KEYED_H
#define KITH_CORE_KEYED_H

#include "lib/core/base.h"

struct kith_keyed {
  uint64_t key;
  kith_index node;
};

/* Room for n items in both arrays, which have *capacity; the first `keep` of item[0] survive. */
kith_status kith_keyed_grow(struct kith_keyed *item[2], size_t *capacity, size_t keep, size_t n);

/* Sorts item[n]; scratch[n] is overwritten. The same result for any number of threads. O(n). */
kith_status kith_keyed_sort(struct kith_keyed *item, struct kith_keyed *scratch, size_t n);

/* Merges in[k] into item[n], both sorted by key, then node, and drops the items whose node is -1; item needs
 * room for what is left, scratch for the same. O(n + k). */
void kith_keyed_merge(struct kith_keyed *item, kith_index n, const struct kith_keyed *in, kith_index k,
                      struct kith_keyed *scratch);

#endif
