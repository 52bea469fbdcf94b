/* Rebuild policy `always`: new lists at every step. */
#include "lib/connectivity/policies/rebuild.h"

static bool needs_rebuild(const struct kith_rebuild *policy, const struct kith_cover *cover,
                          const struct kith_nodes *nodes) {
  (void)policy, (void)cover, (void)nodes;
  return true;
}

const struct kith_rebuild_ops kith_rebuild_always = {.name = "always",
                                                     .doc = "every step",
                                                     .covers = true,
                                                     .every_step = true,
                                                     .needs_rebuild = needs_rebuild};
