/* Rebuild policy `never`: the first lists serve the whole run. The run stops when they could miss a pair. */
#include "lib/connectivity/policies/rebuild.h"

static bool needs_rebuild(const struct kith_rebuild *policy, const struct kith_cover *cover,
                          const struct kith_nodes *nodes) {
  (void)policy, (void)cover, (void)nodes;
  return false;
}

const struct kith_rebuild_ops kith_rebuild_never = {
    .name = "never",
    .doc = "only when there is nothing yet; the run stops when the lists could miss a pair",
    .needs_rebuild = needs_rebuild};
