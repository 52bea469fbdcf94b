/* ranks.h - the processes of one run, and what they say to each other. All of MPI is in ranks.c.
 *
 * A communicator is handed down like any object. NULL is a run of one process: every function accepts it, gives back
 * what it was given, and MPI is never started. With more than one, every function is collective: all ranks call it, in the
 * same order. Only those that tell something of this rank, hand_in and abort are not.
 *
 * Errors. A stage that only some ranks can fail in ends with kith_ranks_agree: all get the failure of the smallest code
 * (of the lowest rank, if several have it) with that rank's message, and leave together. What fails where nobody asks (no
 * memory between two exchanges) ends all ranks by kith_ranks_abort, which the program calls when a failure was not agreed on.
 *
 * Sums of doubles are added in the order of ranks: the same bits on every rank and in every run, but not for
 * another number of ranks: those that a run goes on from are exact (lib/core/sum.h). Maxima, minima and whole numbers have no order. */
#ifndef KITH_CORE_RANKS_H
#define KITH_CORE_RANKS_H

#include "lib/core/base.h"

struct kith_ranks; /* opaque */

/* How many processes were started with this one (by mpirun, mpiexec, srun), as far as the environment tells. */
int kith_ranks_launched(void);
/* Starts MPI. *out is NULL if there is one process only. Once per process. UNSUPPORTED if MPI knows of fewer than were started. */
kith_status kith_ranks_create(struct kith_ranks **out);
/* Ends MPI, when all ranks have come here. Accepts a pointer to NULL. */
void kith_ranks_destroy(struct kith_ranks **ranks);
/* Ends all ranks, now. */
__attribute__((noreturn)) void kith_ranks_abort(struct kith_ranks *ranks, int code);

int kith_ranks_rank(const struct kith_ranks *ranks); /* 0 .. size - 1; 0 if NULL */
int kith_ranks_size(const struct kith_ranks *ranks); /* 1 if NULL */
/* Ranks on this machine: they share its cores. */
int kith_ranks_beside(const struct kith_ranks *ranks);
/* The communicator, as the number that MPI_Comm_f2c takes: for libraries that talk by themselves. 0 if NULL. */
int kith_ranks_communicator(const struct kith_ranks *ranks);

/* The status of all: see above. */
kith_status kith_ranks_agree(struct kith_ranks *ranks, kith_status status);
/* Is the last failure of this process one that all know of? */
bool kith_ranks_agreed(const struct kith_ranks *ranks);

bool kith_ranks_any(struct kith_ranks *ranks, bool mine);
void kith_ranks_max(struct kith_ranks *ranks, double *values, int n);
void kith_ranks_min(struct kith_ranks *ranks, double *values, int n);
void kith_ranks_sum(struct kith_ranks *ranks, double *values, int n);
void kith_ranks_sum_counts(struct kith_ranks *ranks, uint64_t *values, int n);
/* The rank with the smallest value, of those the one with the smallest tie. */
int kith_ranks_least(struct kith_ranks *ranks, double value, int64_t tie);
void kith_ranks_broadcast(struct kith_ranks *ranks, int root, void *data, size_t bytes);

/* from[r * n ..] is what rank r had in to[me * n ..]. */
void kith_ranks_all_to_all(struct kith_ranks *ranks, const int64_t *to, int64_t *from, int n);
/* What all ranks have, one behind the other. *all is kith_resize memory of the caller; part (may be NULL): [size + 1] where each rank's
 * begins, in bytes. All agree on the status. NULL ranks: a copy. */
kith_status kith_ranks_gather(struct kith_ranks *ranks, const void *mine, size_t bytes, char **all,
                              size_t *part);

/* `bytes` of rank `from`, at most INT_MAX, come to `data` of rank 0. Of the two of them only; nothing to do if from is 0. */
void kith_ranks_hand_in(struct kith_ranks *ranks, int from, void *data, size_t bytes);

/* Messages between two ranks each, posted together and waited for together. Both sides know the sizes, which are multiples of 8 bytes;
 * empty ones are not sent. */
struct kith_message {
  int rank;
  void *data;
  size_t bytes;
};
kith_status kith_ranks_exchange(struct kith_ranks *ranks, int n_out, const struct kith_message *out, int n_in,
                                const struct kith_message *in);
/* The same in two halves, one exchange at a time; their data are not to be touched between them. Who computes meanwhile calls progress
 * now and then, from the thread that started MPI: most of MPI works only while it is called. */
kith_status kith_ranks_post(struct kith_ranks *ranks, int n_out, const struct kith_message *out, int n_in,
                            const struct kith_message *in);
void kith_ranks_progress(struct kith_ranks *ranks);
void kith_ranks_finish(struct kith_ranks *ranks);

/* Sent by this rank since the start: messages and bytes of exchanges; collective calls. */
struct kith_traffic {
  uint64_t messages, bytes, collectives;
};
struct kith_traffic kith_ranks_traffic(const struct kith_ranks *ranks);

#endif
