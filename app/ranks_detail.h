/* ranks_detail.h - what several ranks had to do, and with each other: for the end of a run, its profile and its report. */
#ifndef KITH_APP_RANKS_DETAIL_H
#define KITH_APP_RANKS_DETAIL_H

#include "app/model.h"

/* Of all ranks. */
struct kith_spread {
  double least, mean, most;
};

#define KITH_RANKS_SPREAD_LIST(X)                                                      \
  X(nodes, "nodes")                                                                    \
  X(row_entries, "row entries")                                                        \
  X(remote_ghosts, "ghosts of other ranks")                                            \
  X(messages_per_step, "messages sent a step")                                         \
  X(bytes_per_step, "bytes sent a step")                                               \
  X(compute_cpu_seconds, "processor seconds of what a rank computes alone, all steps") \
  X(exchange_cpu_seconds, "processor seconds of the other stages, spinning included")

/* Nodes, entries and ghosts: of the last lists. */
struct kith_ranks_detail {
#define X(name, doc) struct kith_spread name;
  KITH_RANKS_SPREAD_LIST(X)
#undef X
  double collectives_per_step;
  double created, culled, kept;  /* ghosts of other ranks, of all lists and ranks */
  double last_kept, last_needed; /* of the last lists: needed is what is in the row of a node */
  double migrated, repartitions;
};

/* `before`, `after`: traffic when the steps began and ended. The profile clocks the processor (kith_profile_clock_cpu), else seconds are zero.
 * compute: of the first thread, in stages in which no rank waits; exchange: in all others of the steps (ranks_detail.c has their names), where a
 * rank that waits may spin: the least is that of the rank which waits least. Collective; one process has no others. */
kith_status kith_ranks_detail(const struct kith_model *model, const struct kith_traffic *before,
                              const struct kith_traffic *after, uint64_t steps,
                              struct kith_ranks_detail *out);
void kith_ranks_detail_print(const struct kith_ranks_detail *detail, FILE *out);

#endif
