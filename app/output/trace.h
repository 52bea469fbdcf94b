/* trace.h - the trace of all ranks in one file: a rank is a process of it, with its threads. */
#ifndef KITH_APP_OUTPUT_TRACE_H
#define KITH_APP_OUTPUT_TRACE_H

#include "lib/core/profile.h"
#include "lib/comm/ranks.h"

/* Written by rank 0, which asks the others for their events one by one. Their clocks were aligned
 * (kith_profile_align). Collective; all learn of a failure. */
kith_status kith_trace_write(struct kith_ranks *ranks, const struct kith_profile *profile, const char *path);

#endif
