/* morton.c - the curve of interleaved bits (Z-order): jumps between some consecutive cells. */
#include "lib/domain/partition/partition.h"

#include "lib/core/sfc_key.h"

static kith_status morton_first(struct kith_partition *partition, int32_t *owner) {
  return kith_curve_first_by_key(partition, kith_sfc_key_of_cell, owner);
}

const struct kith_partitioner_ops kith_partitioner_morton = {
    .name = "morton",
    .doc = "cuts of the Morton curve at equal weight",
    KITH_CURVE,
    .first = morton_first,
};
