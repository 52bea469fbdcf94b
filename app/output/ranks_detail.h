/* ranks_detail.h - what each of several ranks did and exchanged: part of the report.
 *
 * A stage in which ranks exchange data (refresh, ghosts, control, ...) includes the time a rank waits for
 * others: the minimum over the ranks is an upper bound of packing and sending, what the others have more is
 * waiting. */
#ifndef KITH_APP_OUTPUT_RANKS_DETAIL_H
#define KITH_APP_OUTPUT_RANKS_DETAIL_H

#include "app/simulation/simulation.h"

/* Over all ranks. */
struct kith_spread {
  double min, mean, max;
};

/* Members that each rank has a value of: name, value, doc. Nodes, entries and ghosts: of the last neighbor
 * lists. A value is an expression of m (simulation), l (its ledger), before, after (traffic), steps, remote
 * (ghosts of other ranks), kept and needed (of them), compute and exchange (processor seconds). */
#define KITH_RANKS_SPREAD_LIST(X)                                                                    \
  X(nodes, m->nodes->n_internal, "nodes")                                                            \
  X(row_entries, (double)l->last_row_entries, "row entries")                                         \
  X(remote_ghosts, kept, "ghosts of other ranks")                                                    \
  X(messages_per_step, (double)(after->messages - before->messages) / steps, "messages sent a step") \
  X(bytes_per_step, (double)(after->bytes - before->bytes) / steps, "bytes sent a step")             \
  X(compute_cpu_seconds, compute, "processor seconds of stages without communication, all steps")    \
  X(exchange_cpu_seconds, exchange, "processor seconds of the other stages, waiting included")

/* Members that are totals of all ranks: name, kind (SUM: of what each has, SAME: all have it), value, doc. */
#define KITH_RANKS_TOTAL_LIST(X)                                                                             \
  X(collectives_per_step, SAME, (double)(after->collectives - before->collectives) / steps,                  \
    "collective calls a step")                                                                               \
  X(remote_ghosts_created, SUM, (double)remote.created, "ghosts of other ranks created, all neighbor lists") \
  X(remote_ghosts_culled, SUM, (double)remote.culled, "of them culled")                                      \
  X(remote_ghosts_kept, SUM, (double)remote.kept, "of them kept")                                            \
  X(remote_ghosts_last, SUM, kept, "ghosts of other ranks at the end")                                       \
  X(remote_ghosts_last_needed, SUM, needed, "of them strictly needed: in the row of an internal node")       \
  X(nodes_migrated, SUM, d != NULL ? (double)d->migrated : 0, "nodes migrated")                              \
  X(repartitions, SAME, d != NULL ? (double)d->repartitions : 0, "partitions changed")

struct kith_ranks_detail {
#define X(name, value, doc) struct kith_spread name;
  KITH_RANKS_SPREAD_LIST(X)
#undef X
#define X(name, kind, value, doc) double name;
  KITH_RANKS_TOTAL_LIST(X)
#undef X
  int n_stages;
  struct kith_spread *stage; /* [n_stages] seconds of rank 0's stages; 0 where a rank lacks one; owned */
};

/* `before`, `after`: traffic when the steps began and ended. Processor seconds are those of the first thread,
 * if the profile measures them (kith_profile_clock_cpu), else zero. compute: stages in which no rank waits;
 * exchange: all other stages of the steps, where a waiting rank may spin, so the minimum is that of the rank
 * which waits least. Collective; n_stages is 0 with one process. */
kith_status kith_ranks_detail(struct kith_ranks_detail *out, const struct kith_simulation *simulation,
                              const struct kith_traffic *before, const struct kith_traffic *after,
                              uint64_t n_steps);
void kith_ranks_detail_clear(struct kith_ranks_detail *detail);
#endif
