/* plan_ranks.h - `kith plan --ranks N SCENE`: what each partitioner would make of the scene on N ranks, without any of them (forecast.h): N may
 * be thousands. */
#ifndef KITH_APP_PLAN_RANKS_H
#define KITH_APP_PLAN_RANKS_H

#include "app/forecast.h"

/* Prints the table, for steps of which one process takes `seconds` and makes lists `lists` times. The model was started: its lists are there. */
kith_status kith_plan_ranks(struct kith_model *model, int n_ranks, double seconds, double lists,
                            const struct kith_network *network);

#endif
