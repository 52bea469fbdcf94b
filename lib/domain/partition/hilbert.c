/* hilbert.c - the Hilbert curve: consecutive cells share a face, so pieces are rounder than Morton's.
 *
 * J. Skilling, "Programming the Hilbert curve", AIP Conference Proceedings 707, 381 (2004). */
#include "lib/domain/partition/partition.h"

#include "lib/core/sfc_key.h"

static uint64_t hilbert_key(const uint64_t *k) {
  uint64_t x[NDIM];
  for (int a = 0; a < NDIM; ++a) x[a] = k[a];
  if (NDIM == 1) return x[0];
  const uint64_t top = UINT64_C(1) << (KITH_SFC_KEY_BITS - 1);
  for (uint64_t bit = top; bit > 1; bit >>= 1) /* undo the rotations of each level */
    for (int a = 0; a < NDIM; ++a) {
      const uint64_t below = bit - 1, differ = (x[0] ^ x[a]) & below;
      x[0] ^= x[a] & bit ? below : differ;
      x[a] ^= x[a] & bit ? 0 : differ;
    }
  for (int a = 1; a < NDIM; ++a) x[a] ^= x[a - 1]; /* Gray code */
  uint64_t flip = 0;
  for (uint64_t bit = top; bit > 1; bit >>= 1) flip ^= x[NDIM - 1] & bit ? bit - 1 : 0;
  for (int a = 0; a < NDIM; ++a) x[a] ^= flip;
  return kith_sfc_key_of_cell(x);
}

const struct kith_partitioner_ops kith_partitioner_hilbert = {
    .name = "hilbert",
    .doc = "cuts of the Hilbert curve at equal weight",
    KITH_CURVE,
    .first = kith_curve_first_by_key,
    .key_of = hilbert_key,
};
