/* ranks.h - the processes (MPI ranks) of one run and their communication. All MPI calls are in ranks.c.
 *
 * NULL stands for a run of one process: every function accepts it and returns what it was given, and MPI is
 * never started. With several ranks every function is collective, but for those that only tell something
 * about this rank, that send messages between some ranks, or of which it is said.
 *
 * Errors. A stage in which only some ranks can fail ends with kith_ranks_agree: all ranks get the failure
 * with the smallest code (of the lowest rank, if several have it) with that rank's message, and return
 * together. What ranks have to know of each other at that point is told in the same call. After a failure
 * that was not agreed on the program ends all ranks (kith_ranks_abort).
 *
 * Maxima, minima and sums of integers do not depend on an order. Sums of doubles do: they are for figures
 * that are shown; those that the state of a run depends on are exact (sum.h). */
#ifndef KITH_COMM_RANKS_H
#define KITH_COMM_RANKS_H

#include <stdlib.h>
#include "lib/core/base.h"

struct kith_profile;
struct kith_ranks; /* opaque */

/* Processes that mpirun, mpiexec or srun started together, this one among them, as they tell in the
 * environment; 1: it was started alone. */
static inline int kith_launched(void) {
  static const char *const sizes[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"};
  for (size_t k = 0; k < sizeof sizes / sizeof *sizes; ++k) {
    const char *size = getenv(sizes[k]);
    if (size != NULL && atoi(size) > 1) return atoi(size);
  }
  return 1;
}
/* Processes that a run may have: 1 in a build without MPI (ranks_alone.c). */
int kith_ranks_most(void);
/* Starts MPI, once per process. *out is NULL if there is only one process. UNSUPPORTED if several were
 * started and MPI knows of one only, cannot be started or does not support threads, or the build is one
 * without MPI. The status is of this rank alone. */
kith_status kith_ranks_create(struct kith_ranks **out);
/* The processes of a communicator (what MPI_Comm_c2f gives), of a program that starts and ends MPI itself. It
 * is duplicated. NULL for one process. NO_MEMORY is of this rank alone, for which the others wait. */
kith_status kith_ranks_create_on(struct kith_ranks **out, int communicator);
/* One rank that plays a run of many, without MPI: its collective calls are counted, and nothing is sent.
 * UNSUPPORTED in a build without MPI. */
kith_status kith_ranks_rehearse(struct kith_ranks **out);
void kith_ranks_destroy(struct kith_ranks **ranks);
/* Ends all ranks. Not collective. */
__attribute__((noreturn)) void kith_ranks_abort(struct kith_ranks *ranks, int code);

int kith_ranks_rank(const struct kith_ranks *ranks); /* 0 .. size - 1; 0 if NULL */
int kith_ranks_size(const struct kith_ranks *ranks); /* 1 if NULL */
int kith_ranks_on_this_machine(const struct kith_ranks *ranks);
/* Cores that the ranks on this machine may use, together: as they were bound. 0 if NULL, or rehearsed. */
int kith_ranks_cores(const struct kith_ranks *ranks);
/* For libraries that communicate by themselves: what MPI_Comm_f2c takes; 0 if NULL. */
int kith_ranks_communicator(const struct kith_ranks *ranks);

/* From now on a rank that waits longer than this for others says so in one line of stderr, once a wait, with
 * the kind of call and the present stage of the profile (borrowed), and waits on: a slow disk or a debugger
 * is no failure. The rank that is waited for is the one that says nothing. 0 seconds: never. Not collective.
 * UNSUPPORTED: no timer. */
kith_status kith_ranks_watch(struct kith_ranks *ranks, double seconds, const struct kith_profile *profile);

/* A part of what ranks tell each other: n words of 8 bytes that become those of all ranks.
 *   MAX    doubles, each the largest; NaN if one is
 *   SUM    integers, each the sum
 *   LEAST  a double, an integer, and words that come along: those of the rank with the smallest double, of
 *          several the one with the smallest integer */
enum kith_combination { KITH_SHARE_MAX, KITH_SHARE_SUM, KITH_SHARE_LEAST };
struct kith_shared {
  enum kith_combination how;
  int n;
  void *data;
};
enum { KITH_SHARED_PARTS = 48, KITH_SHARED_WORDS = 2048 }; /* at most, of one call */
/* One reduction for the status of all ranks, see above, and for all parts; they are undefined if one failed.
 * NULL ranks: nothing changes. */
kith_status kith_ranks_agree(struct kith_ranks *ranks, kith_status status, int n,
                             const struct kith_shared *parts);
/* An agreement in two halves: a rank that is ahead of others need not wait for them. A rank that has failed
 * waits and gets the answer from start. The others get it from finish; whatever else they call here completes
 * it too, and if some rank has failed, nothing is sent or received from then on until finish, or the next
 * agreement, returns the failure. parts: as above, when that is complete; borrowed until then. Finish: OK if
 * nothing was started. */
kith_status kith_ranks_start_agree(struct kith_ranks *ranks, kith_status status, int n,
                                   const struct kith_shared *parts);
kith_status kith_ranks_finish_agree(struct kith_ranks *ranks);
static inline kith_status kith_ranks_allreduce_status(struct kith_ranks *ranks, kith_status status) {
  return kith_ranks_agree(ranks, status, 0, NULL);
}
/* For a failure while others wait for this rank: with several ranks it ends all of them. Not collective. */
kith_status kith_ranks_must(struct kith_ranks *ranks, kith_status status);
/* Is the last failure of this process one that all ranks agreed on? */
bool kith_ranks_status_is_shared(const struct kith_ranks *ranks);

void kith_ranks_max(struct kith_ranks *ranks, double *values, int n);
void kith_ranks_min(struct kith_ranks *ranks, double *values, int n);
void kith_ranks_sum(struct kith_ranks *ranks, double *values, int n);
void kith_ranks_sum_counts(struct kith_ranks *ranks, uint64_t *values, int n);
static inline bool kith_ranks_any(struct kith_ranks *ranks, bool mine) {
  double any = mine;
  kith_ranks_max(ranks, &any, 1);
  return any > 0;
}
/* The data of rank 0 go to all others; below 2 GB. */
void kith_ranks_broadcast(struct kith_ranks *ranks, void *data, size_t bytes);

/* from[r * n .. ] becomes what rank r had in to[me * n .. ]. Among neighbors, of which each names the other:
 * by messages between them, and what `from` has of other ranks stays. NULL: among all, MPI_Alltoall. */
void kith_ranks_tell(struct kith_ranks *ranks, int n_neighbors, const int32_t *neighbor, const int64_t *to,
                     int64_t *from, int n);
/* MPI_Allgatherv: the data of all ranks, one after the other. *all is kith_resize memory owned by the caller;
 * part (may be NULL): [size + 1] where the data of each rank begin, in bytes. UNSUPPORTED if there are more
 * than INT_MAX bytes. The status is agreed on. NULL ranks: a copy. */
kith_status kith_ranks_gather(struct kith_ranks *ranks, const void *mine, size_t bytes, char **all,
                              size_t *part);

/* `bytes` at `data` of rank `from`, at most INT_MAX, to `data` of rank 0. Called by these two only. */
void kith_ranks_send_to_root(struct kith_ranks *ranks, int from, void *data, size_t bytes);

/* Messages between pairs of ranks, started together and completed together. Both sides know the sizes, which
 * are multiples of 8 bytes; empty messages are not sent. */
struct kith_message {
  int rank;
  void *data;
  size_t bytes;
};
/* In two halves, one exchange at a time; the data must not be touched in between. Code that computes
 * meanwhile calls kith_ranks_progress now and then, from the thread that started MPI: most MPI libraries make
 * progress only inside of calls. The status is of this rank alone: INTERNAL if an exchange is pending or
 * there are more messages than ranks, UNSUPPORTED for a message of more than INT_MAX words. */
kith_status kith_ranks_start_exchange(struct kith_ranks *ranks, int n_out, const struct kith_message *out,
                                      int n_in, const struct kith_message *in);
void kith_ranks_progress(struct kith_ranks *ranks);
void kith_ranks_finish_exchange(struct kith_ranks *ranks);
/* Both halves. */
static inline kith_status kith_ranks_exchange(struct kith_ranks *ranks, int n_out,
                                              const struct kith_message *out, int n_in,
                                              const struct kith_message *in) {
  KITH_TRY(kith_ranks_start_exchange(ranks, n_out, out, n_in, in));
  kith_ranks_finish_exchange(ranks);
  return KITH_OK;
}

/* Since the start: messages and bytes that this rank sent in exchanges, and its collective calls. */
struct kith_traffic {
  uint64_t messages, bytes, collectives;
};
struct kith_traffic kith_ranks_traffic(const struct kith_ranks *ranks);

#endif
