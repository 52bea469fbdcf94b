/* keyed.h - nodes with a key, and their stable sort: by key, equal keys in their original order.
 *
 * A radix sort: the most significant digits first, then each bin on its own, in cache; short or constant bins
 * cost nearly nothing. The memory is the caller's. */
#ifndef KITH_CORE_KEYED_H
#define KITH_CORE_KEYED_H

#include <string.h>
#include "lib/core/base.h"

struct kith_keyed {
  uint64_t key;
  kith_index node;
};

/* Makes room for n items in both arrays, which have room for *capacity each. Their contents are lost if they
 * grow. */
kith_status kith_keyed_grow(struct kith_keyed *item[2], size_t *capacity, size_t n);

/* Sorts item[n]; scratch[n] is overwritten. The same result for any number of threads. O(n). */
kith_status kith_keyed_sort(struct kith_keyed *item, struct kith_keyed *scratch, size_t n);

/* item[n] is sorted by key and then by node, but m items in it have been marked by node -1. Replaces these by
 * the items in[m], so that all are in order again. `in` gets sorted. O(n + m log m). */
void kith_keyed_replace(struct kith_keyed *item, kith_index n, struct kith_keyed *in, kith_index m);

/* The first of entries first .. end - 1 of an array whose key is at least `key`, or `end`. Entries of `size`
 * bytes begin with their key, and ascend. */
static inline kith_index kith_key_bound(const void *entries, size_t size, kith_index first, kith_index end,
                                        uint64_t key) {
  while (first < end) {
    const kith_index half = first + (end - first) / 2;
    uint64_t here;
    memcpy(&here, (const char *)entries + (size_t)half * size, sizeof here);
    if (here < key)
      first = half + 1;
    else
      end = half;
  }
  return first;
}

#endif
