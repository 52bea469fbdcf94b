/* trace.h - the trace of all ranks in one file: a rank is a process of it, with its threads. */
#ifndef KITH_APP_OUTPUT_TRACE_H
#define KITH_APP_OUTPUT_TRACE_H

#include "lib/core/profile.h"
#include "lib/comm/ranks.h"

/* A JSON array of the events of all ranks, one after the other: each appends its own to the file, which must
 * be visible to all. Their clocks were aligned (kith_profile_align). The file appears whole or not at all.
 * Collective; all learn of a failure. */
kith_status kith_trace_write(struct kith_ranks *ranks, const struct kith_profile *profile, const char *path);

#endif
