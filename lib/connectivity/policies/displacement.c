/* Rebuild policy `displacement`: Verlet lists with a skin, rebuilt when they could miss a pair (cover.h). */
#include "lib/connectivity/policies/rebuild.h"

const struct kith_rebuild_ops kith_rebuild_displacement = {
    .name = "displacement",
    .doc = "nodes moved, or supports grew, so far that the lists could miss a pair",
    .covers = true};
