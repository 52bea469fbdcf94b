/* plan_ranks.h - `kith plan --ranks N`. */
#ifndef KITH_APP_PLAN_RANKS_H
#define KITH_APP_PLAN_RANKS_H

#include "app/plan/plan_parts.h"

/* Prints what each partitioner would make of the scene on the ranks of the options, which may be thousands
 * (forecast.h); of a large scene only the partitioner that the scene chooses. */
kith_status kith_plan_ranks(struct kith_plan *plan, const struct kith_options *options);

#endif
