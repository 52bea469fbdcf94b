/* Rebuild policy `displacement`: Verlet lists with a skin, rebuilt when they could miss a pair (cover.h). */
#include "lib/connectivity/policies/rebuild.h"

static bool needs_rebuild(const struct kith_rebuild *policy, const struct kith_cover *cover,
                          const struct kith_nodes *nodes) {
  (void)policy;
  return !kith_cover_holds(cover, nodes);
}

const struct kith_rebuild_ops kith_rebuild_displacement = {
    .name = "displacement",
    .doc = "nodes moved, or supports grew, so far that the lists could miss a pair",
    .covers = true,
    .needs_rebuild = needs_rebuild};
