/* Rebuild policy `always`: new lists at every step. */
#include "lib/connectivity/policies/rebuild.h"

const struct kith_rebuild_ops kith_rebuild_always = {
    .name = "always", .doc = "every step", .covers = true, .every_step = true};
