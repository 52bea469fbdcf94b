/* stage_times.h - the stages of all ranks: how long they took on the mean rank, and on the busiest. */
#ifndef KITH_APP_STAGE_TIMES_H
#define KITH_APP_STAGE_TIMES_H

#include "lib/core/profile.h"
#include "lib/core/ranks.h"

/* For the stages that rank 0 has, in its order: seconds, mean and largest of all ranks (0 where a rank lacks a stage). kith_resize memory of
 * the caller, on every rank; NULL with one process. Collective. */
kith_status kith_stage_times(struct kith_ranks *ranks, const struct kith_profile *profile, double **mean,
                             double **most);

#endif
