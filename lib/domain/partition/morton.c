/* morton.c - the curve of interleaved bits (Z-order): jumps between some consecutive cells. */
#include "lib/domain/partition/partition.h"

#include "lib/core/sfc_key.h"

const struct kith_partitioner_ops kith_partitioner_morton = {
    .name = "morton",
    .doc = "cuts of the Morton curve at equal weight",
    KITH_CURVE,
    .first = kith_curve_first_by_key,
    .key_of = kith_sfc_key_of_cell,
};
