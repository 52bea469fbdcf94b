/* stage_times.h - the stages of all ranks: how long they took on the quickest rank, on the mean one, and on the busiest.
 *
 * A stage in which ranks exchange (refresh, ghosts, control, ...) holds the time that a rank waits for others: the least of all ranks is
 * at most what packing and sending take, what the others have more is waiting. */
#ifndef KITH_APP_STAGE_TIMES_H
#define KITH_APP_STAGE_TIMES_H

#include <stdio.h>
#include "lib/core/profile.h"
#include "lib/core/ranks.h"

/* Seconds of the stages that rank 0 has, in its order; 0 where a rank lacks a stage. Owned. */
struct kith_stage_times {
  int n;
  double *least, *mean, *most; /* [n] */
};

/* Empty with one process. Collective. */
kith_status kith_stage_times(struct kith_ranks *ranks, const struct kith_profile *profile,
                             struct kith_stage_times *out);
void kith_stage_times_clear(struct kith_stage_times *times);
/* Table of rank 0's stages: calls, least, mean and most seconds, most over mean, share of the root by the mean. */
void kith_stage_times_print(const struct kith_stage_times *times, const struct kith_profile *profile,
                            FILE *out);

#endif
