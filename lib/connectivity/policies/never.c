/* Rebuild policy `never`: the first lists serve the whole run. The run stops when they could miss a pair. */
#include "lib/connectivity/policies/rebuild.h"

const struct kith_rebuild_ops kith_rebuild_never = {
    .name = "never", .doc = "only when there is nothing yet; the run stops when the lists could miss a pair"};
