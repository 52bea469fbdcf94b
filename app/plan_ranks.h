/* plan_ranks.h - `kith plan --ranks N SCENE`: what each partitioner would make of the scene on N ranks, without any of them.
 *
 * The cells are those of a run (share.h); their work is row entries at the start, as a run measures it. Each partitioner makes its first map and
 * goes on until it changes nothing (at most 20 times). Then, for every node, the ranks that it would be sent to: those with a cell at
 *     d(x, box around the nodes of the cell) <= f max(R, largest R of the cell),   periodic images too,
 * which is what the distributed boundary sends, before culling. Nothing is communicated, so N may be thousands. */
#ifndef KITH_APP_PLAN_RANKS_H
#define KITH_APP_PLAN_RANKS_H

#include "app/model.h"

/* Prints the table. The model was started: its lists are there. */
kith_status kith_plan_ranks(const struct kith_model *model, int n_ranks);

#endif
