/* profile.h - named, nested timers with counters: every stage of the lifecycle and every pass of a package.
 *
 *   kith_profile_begin(p, "connectivity");
 *     kith_profile_begin(p, "rows");  ...  kith_profile_end(p);
 *   kith_profile_end(p);
 *
 * A stage is known by its path ("step/connectivity/rows"). begin and end, about 60 ns each, are called by the
 * first thread, outside of parallel regions; inside one, each thread reports its busy time. A stage that is
 * still open is shown as if it ended now. A NULL profile is allowed where stages and counters are noted or
 * read, but for kith_profile_add, _present and _write_events, and costs nothing. Names are string constants
 * (borrowed) without quotes.
 *
 * Compiled with -DKITH_LIKWID (link with -llikwid) or -DKITH_CALIPER (-lcaliper), each stage is also a region
 * of LIKWID's marker API, on every thread, or of Caliper. */
#ifndef KITH_CORE_PROFILE_H
#define KITH_CORE_PROFILE_H

#include <stdio.h>
#include "lib/core/base.h"

struct kith_profile; /* opaque */

struct kith_stage {
  const char *path; /* "step/connectivity/rows" */
  const char *name; /* last part of the path */
  int depth;        /* 0 for a root */
  int parent;       /* index of the parent stage, -1 for a root */
  uint64_t calls;
  double seconds;      /* wall, children included */
  double self_seconds; /* wall, children left out */
  double imbalance;    /* max over mean of the threads' busy time, 1 is perfect; 0 if not reported */
};

struct kith_counter {
  const char *name; /* "candidates", "pairs", ... */
  const char *path; /* of the stage in which it was counted, "": outside of any */
  double total;
};

/* `trace`: keep every begin and end as an event, for kith_profile_write_events; of a thread at most 2^18,
 * and it is said how many were left out. */
kith_status kith_profile_create(struct kith_profile **out, int threads, bool trace);
void kith_profile_destroy(struct kith_profile **profile);
/* Times of the trace count from `origin` (kith_seconds), before which nothing may have begun. Processes have
 * a common clock in their traces if it is the same moment for all. */
void kith_profile_align(struct kith_profile *profile, double origin);

void kith_profile_begin(struct kith_profile *profile, const char *name);
/* Runs a call as a stage, and assigns what it returns to `status`. */
#define KITH_STAGE(status, profile, name, call) \
  do {                                          \
    kith_profile_begin(profile, name);          \
    (status) = (call);                          \
    kith_profile_end(profile);                  \
  } while (0)
/* A stage that began at `since` (kith_seconds), before there was a profile. */
void kith_profile_begin_since(struct kith_profile *profile, const char *name, double since);
/* Continues a stage that was ended before: its calls are not increased. */
void kith_profile_resume(struct kith_profile *profile, const char *name);
void kith_profile_end(struct kith_profile *profile);
/* Adds a stage by its path, with no calls and no time, unless it is there: one that another process has
 * met. */
kith_status kith_profile_add(struct kith_profile *profile, const char *path);
/* Thread `thread` was busy in the present stage from `start` to `stop` (kith_seconds). Called by that
 * thread. In a trace this is an event of all threads but the first, which shows the stage itself. */
void kith_profile_thread(struct kith_profile *profile, int thread, double start, double stop);
/* Adds to a counter of the present stage. */
void kith_profile_count(struct kith_profile *profile, const char *counter, double amount);

/* Is the profile complete? If not, stages or counters are missing for want of memory. */
bool kith_profile_is_whole(const struct kith_profile *profile);
/* Views, valid until the next begin, add or count: stages in tree order (children behind their parent),
 * counters in the order of their first count. */
int kith_profile_stages(const struct kith_profile *profile, const struct kith_stage **out);
int kith_profile_counters(const struct kith_profile *profile, const struct kith_counter **out);
/* The path of the present stage, "" outside of any. Another thread may ask while this one waits. */
const char *kith_profile_present(const struct kith_profile *profile);
/* The total of a counter in the stage of this path, or in all below it if the path ends with '/'. */
double kith_profile_counted(const struct kith_profile *profile, const char *path, const char *counter);

/* Trace events as those of one process, one row per thread: JSON objects separated by commas. Perfetto and a
 * browser's tracing page open an array of them. */
void kith_profile_write_events(const struct kith_profile *profile, int process, FILE *out);

/* Seconds of a monotonic clock. */
double kith_seconds(void);

#endif
