/* Everything that calls MPI; in a build without it ranks_alone.c takes its place. */
#define _GNU_SOURCE /* cpu_set_t */
#include "lib/comm/ranks.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <mpi.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include "lib/core/profile.h"

/* What ranks tell each other, in words: the number of words, the smallest code of a failure, its rank, the
 * number of failures, then the parts: n, how, and n words each. */
enum { WORDS, CODE, RANK, FAILED, PARTS };
enum { MOST_WORDS = PARTS + 2 * KITH_SHARED_PARTS + KITH_SHARED_WORDS };

struct agreement {
  bool pending;
  kith_status refused; /* the failure that was agreed on, until it is returned to the caller; or OK */
  MPI_Request request;
  int n;
  struct kith_shared parts[KITH_SHARED_PARTS];
  int64_t mine[MOST_WORDS], all[MOST_WORDS];
};

struct kith_ranks {
  MPI_Comm all;
  MPI_Op combine; /* of what ranks agree on */
  int rank, size, beside, cores;
  struct {           /* the failure that all ranks agreed on */
    char line[2048]; /* empty: none */
    int64_t node;    /* as kith_failed_node */
  } agreed;
  struct kith_traffic traffic;
  struct agreement *agreement; /* owned */
  MPI_Request *request;        /* [2 size] of the pending exchange */
  int n_requests;
  bool started_mpi;                   /* and so ends it */
  double watchdog;                    /* seconds; 0: none */
  timer_t timer;                      /* of the watchdog; runs while this rank waits */
  const char *waiting;                /* for what */
  const struct kith_profile *profile; /* that knows in which stage; borrowed */
};

/* ---- waiting ---- */

/* In a thread of its own: the one that MPI knows of waits. */
static void report_waiting(union sigval of) {
  const struct kith_ranks *ranks = of.sival_ptr;
  const char *stage = kith_profile_present(ranks->profile);
  fprintf(stderr, "kith: rank %d has waited %g s for %s%s%s\n", ranks->rank, ranks->watchdog, ranks->waiting,
          stage[0] != '\0' ? " in " : "", stage);
}

kith_status kith_ranks_watch(struct kith_ranks *ranks, double seconds, const struct kith_profile *profile) {
  struct sigevent event = {
      .sigev_notify = SIGEV_THREAD, .sigev_notify_function = report_waiting, .sigev_value.sival_ptr = ranks};
  if (ranks == NULL || ranks->size == 1 || !(seconds > 0)) return KITH_OK;
  if (timer_create(CLOCK_MONOTONIC, &event, &ranks->timer) != 0)
    KITH_FAIL(UNSUPPORTED, "--watchdog: no timer: %s", strerror(errno));
  ranks->watchdog = seconds, ranks->profile = profile;
  return KITH_OK;
}

static void set_timer(struct kith_ranks *ranks, const char *what, double seconds) {
  if (!(ranks->watchdog > 0)) return;
  ranks->waiting = what;
  const struct itimerspec in = {.it_value = {(time_t)seconds, (long)(1e9 * fmod(seconds, 1))}};
  timer_settime(ranks->timer, 0, &in, NULL);
}

/* Around each call in which this rank may wait for another one. */
#define WAIT(ranks, what, call)                \
  do {                                         \
    set_timer(ranks, what, (ranks)->watchdog); \
    call;                                      \
    set_timer(ranks, what, 0);                 \
  } while (0)

static void complete_agreement(struct kith_ranks *ranks);

/* Are there other ranks, and has no failure been agreed on that is still to be returned? */
static bool together(struct kith_ranks *ranks) {
  if (ranks == NULL || ranks->size == 1) return false;
  complete_agreement(ranks);
  return ranks->agreement->refused == KITH_OK;
}

/* Counts a collective call. */
static bool counted(struct kith_ranks *ranks) {
  if (ranks != NULL) ++ranks->traffic.collectives;
  return together(ranks);
}

/* ---- life ---- */

int kith_ranks_most(void) {
  return INT_MAX;
}

/* MPI cannot go on after an error: one line instead of its own ones, and the end of all ranks. */
static void on_error(MPI_Comm *communicator, int *error, ...) {
  char text[MPI_MAX_ERROR_STRING];
  int n, rank;
  MPI_Error_string(*error, text, &n);
  MPI_Comm_rank(*communicator, &rank);
  fprintf(stderr, "kith: rank %d: %s; the last checkpoint, if there is one, goes on with --restart\n", rank,
          text);
  MPI_Abort(*communicator, 1);
}

static kith_status start(struct kith_ranks *ranks) {
  MPI_Errhandler handler;
  int level;
  if (MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &level) != MPI_SUCCESS)
    KITH_FAIL(UNSUPPORTED, "MPI cannot be started");
  ranks->started_mpi = true;
  MPI_Comm_create_errhandler(on_error, &handler);
  MPI_Comm_set_errhandler(MPI_COMM_WORLD, handler); /* those made from it have it too */
  MPI_Errhandler_free(&handler);
  if (level < MPI_THREAD_FUNNELED) KITH_FAIL(UNSUPPORTED, "this MPI library does not support threads");
  return KITH_OK;
}

static void combine_part(int64_t how, int n, const int64_t *in, int64_t *out) {
  double a, b;
  for (int k = 0; k < n; ++k) {
    memcpy(&a, &in[k], sizeof a);
    memcpy(&b, &out[k], sizeof b);
    if (how == KITH_SHARE_SUM) out[k] = (int64_t)((uint64_t)out[k] + (uint64_t)in[k]);
    if (how == KITH_SHARE_MAX && (a > b || isnan(a))) out[k] = in[k];
    if (how != KITH_SHARE_LEAST) continue;
    if (a < b || (a == b && in[1] < out[1])) memcpy(out, in, (size_t)n * sizeof *out);
    return;
  }
}

static void combine(void *from, void *to, int *count, MPI_Datatype *type) {
  const int64_t *in = from;
  int64_t *out = to;
  (void)count, (void)type; /* one, of as many words as its first says */
  if (in[CODE] < out[CODE] || (in[CODE] == out[CODE] && in[RANK] < out[RANK]))
    out[CODE] = in[CODE], out[RANK] = in[RANK];
  out[FAILED] += in[FAILED];
  for (int64_t k = PARTS; k < in[WORDS]; k += 2 + in[k])
    combine_part(in[k + 1], (int)in[k], in + k + 2, out + k + 2);
}

static void join(struct kith_ranks *ranks, MPI_Comm communicator) {
  MPI_Comm beside;
  cpu_set_t cores;
  CPU_ZERO(&cores);
  MPI_Comm_dup(communicator, &ranks->all);
  MPI_Op_create(combine, 1, &ranks->combine);
  MPI_Comm_rank(ranks->all, &ranks->rank);
  MPI_Comm_size(ranks->all, &ranks->size);
  MPI_Comm_split_type(ranks->all, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &beside);
  MPI_Comm_size(beside, &ranks->beside);
  if (sched_getaffinity(0, sizeof cores, &cores) != 0) /* of more cores than a cpu_set_t has: not bound */
    memset(&cores, 0xff, sizeof cores);
  MPI_Allreduce(MPI_IN_PLACE, &cores, (int)sizeof cores, MPI_BYTE, MPI_BOR, beside);
  ranks->cores = CPU_COUNT(&cores);
  MPI_Comm_free(&beside);
  kith_ranks_must(ranks, kith_resize(&ranks->agreement, 0, 1, sizeof *ranks->agreement));
  kith_ranks_must(ranks, kith_resize(&ranks->request, 0, 2 * (size_t)ranks->size, sizeof *ranks->request));
}

kith_status kith_ranks_create(struct kith_ranks **out) {
  *out = NULL;
  const int launched = kith_launched();
  if (launched == 1) return KITH_OK;
  struct kith_ranks *ranks = NULL;
  KITH_TRY(kith_resize(&ranks, 0, 1, sizeof *ranks));
  const kith_status status = start(ranks);
  if (status == KITH_OK) join(ranks, MPI_COMM_WORLD);
  *out = ranks;
  const bool alone = status == KITH_OK && ranks->size == 1;
  if (status != KITH_OK || alone) kith_ranks_destroy(out);
  if (alone)
    KITH_FAIL(
        UNSUPPORTED,
        "%d processes were started, but they do not see each other: does the launcher belong to another MPI "
        "library?",
        launched);
  return status;
}

kith_status kith_ranks_create_on(struct kith_ranks **out, int communicator) {
  const MPI_Comm all = MPI_Comm_f2c(communicator);
  int size;
  *out = NULL;
  MPI_Comm_size(all, &size);
  if (size == 1) return KITH_OK;
  KITH_TRY(kith_resize(out, 0, 1, sizeof **out));
  join(*out, all);
  return KITH_OK;
}

kith_status kith_ranks_rehearse(struct kith_ranks **out) {
  *out = NULL;
  KITH_TRY(kith_resize(out, 0, 1, sizeof **out));
  (*out)->size = (*out)->beside = 1;
  return KITH_OK;
}

void kith_ranks_destroy(struct kith_ranks **ranks) {
  if (*ranks == NULL) return;
  KITH_FREE(&(*ranks)->request, &(*ranks)->agreement);
  if ((*ranks)->watchdog > 0) timer_delete((*ranks)->timer);
  if ((*ranks)->size > 1) MPI_Op_free(&(*ranks)->combine);
  if ((*ranks)->size > 1) MPI_Comm_free(&(*ranks)->all);
  if ((*ranks)->started_mpi) MPI_Finalize();
  kith_free(ranks);
}

void kith_ranks_abort(struct kith_ranks *ranks, int code) {
  if (ranks != NULL && ranks->size > 1) MPI_Abort(ranks->all, code);
  exit(code);
}

int kith_ranks_rank(const struct kith_ranks *ranks) {
  return ranks != NULL ? ranks->rank : 0;
}
int kith_ranks_size(const struct kith_ranks *ranks) {
  return ranks != NULL ? ranks->size : 1;
}
int kith_ranks_on_this_machine(const struct kith_ranks *ranks) {
  return ranks != NULL ? ranks->beside : 1;
}
int kith_ranks_cores(const struct kith_ranks *ranks) {
  return ranks != NULL ? ranks->cores : 0;
}
int kith_ranks_communicator(const struct kith_ranks *ranks) {
  return ranks != NULL && ranks->size > 1 ? MPI_Comm_c2f(ranks->all) : 0;
}

/* Broadcasts the message of the rank that failed, with "rank N: " in front unless it has that already, all
 * ranks failed, or the input is what is wrong, whoever has found it. */
static void tell(struct kith_ranks *ranks, int root, bool alone) {
  char *line = ranks->agreed.line;
  const size_t size = sizeof ranks->agreed.line;
  const bool told = !alone || strncmp(kith_failure(), "rank ", 5) == 0;
  if (ranks->rank == root && told) snprintf(line, size, "%s", kith_failure());
  if (ranks->rank == root && !told) snprintf(line, size, "rank %d: %.2000s", root, kith_failure());
  ranks->agreed.node = kith_failed_node();
  WAIT(ranks, "the message of a failure",
       MPI_Bcast(&ranks->agreed, (int)sizeof ranks->agreed, MPI_BYTE, root, ranks->all));
}

/* Begins to agree; `ahead`: does not wait. */
static void begin_to_agree(struct kith_ranks *ranks, kith_status status, int n,
                           const struct kith_shared *parts, bool ahead) {
  struct agreement *a = ranks->agreement;
  MPI_Datatype whole;
  int words = PARTS;
  for (int p = 0; p < n; words += 2 + parts[p++].n)
    if (p >= KITH_SHARED_PARTS || words + parts[p].n > PARTS + 2 * p + KITH_SHARED_WORDS)
      kith_ranks_must(ranks, kith_fail(KITH_INTERNAL, "too much to agree on"));
  a->mine[WORDS] = words, a->mine[CODE] = status == KITH_OK ? INT_MAX : (int)status;
  a->mine[RANK] = ranks->rank, a->mine[FAILED] = status != KITH_OK;
  for (int p = 0, k = PARTS; p < n; k += 2 + parts[p++].n) {
    a->mine[k] = parts[p].n, a->mine[k + 1] = parts[p].how;
    memcpy(a->mine + k + 2, parts[p].data, (size_t)parts[p].n * sizeof *a->mine);
  }
  if (n > 0) memcpy(a->parts, parts, (size_t)n * sizeof *parts);
  a->n = n, a->pending = true;
  MPI_Type_contiguous(words, MPI_INT64_T, &whole); /* one element, which no library divides */
  MPI_Type_commit(&whole);
  if (ahead)
    MPI_Iallreduce(a->mine, a->all, 1, whole, ranks->combine, ranks->all, &a->request);
  else
    WAIT(ranks, "an agreement", MPI_Allreduce(a->mine, a->all, 1, whole, ranks->combine, ranks->all));
  MPI_Type_free(&whole);
}

/* Takes over what was agreed on. */
static void end_to_agree(struct kith_ranks *ranks) {
  struct agreement *a = ranks->agreement;
  a->pending = false;
  if (a->all[CODE] != INT_MAX) {
    tell(ranks, (int)a->all[RANK], a->all[FAILED] < ranks->size && a->all[CODE] != KITH_BAD_INPUT);
    a->refused = (kith_status)a->all[CODE];
    return;
  }
  for (int p = 0, k = PARTS; p < a->n; k += 2 + a->parts[p++].n)
    memcpy(a->parts[p].data, a->all + k + 2, (size_t)a->parts[p].n * sizeof *a->all);
}

/* Waits for the agreement that was started, if there is one. */
static void complete_agreement(struct kith_ranks *ranks) {
  struct agreement *a = ranks->agreement;
  if (!a->pending) return;
  WAIT(ranks, "an agreement", MPI_Wait(&a->request, MPI_STATUS_IGNORE));
  end_to_agree(ranks);
}

/* The failure that was agreed on; from then on it counts as returned. */
static kith_status answer(struct kith_ranks *ranks) {
  const kith_status refused = ranks->agreement->refused;
  ranks->agreement->refused = KITH_OK;
  if (refused == KITH_OK) return KITH_OK;
  return kith_fail_node(refused, ranks->agreed.node, "%s", ranks->agreed.line);
}

kith_status kith_ranks_agree(struct kith_ranks *ranks, kith_status status, int n,
                             const struct kith_shared *parts) {
  const bool asked = counted(ranks);
  if (ranks == NULL || ranks->size == 1) return status;
  if (asked) {
    begin_to_agree(ranks, status, n, parts, false);
    end_to_agree(ranks);
  }
  return answer(ranks);
}

kith_status kith_ranks_start_agree(struct kith_ranks *ranks, kith_status status, int n,
                                   const struct kith_shared *parts) {
  const bool asked = counted(ranks);
  if (ranks == NULL || ranks->size == 1) return status;
  if (!asked) return answer(ranks);
  begin_to_agree(ranks, status, n, parts, true);
  return status == KITH_OK ? KITH_OK : kith_ranks_finish_agree(ranks);
}

kith_status kith_ranks_finish_agree(struct kith_ranks *ranks) {
  if (ranks == NULL || ranks->size == 1) return KITH_OK;
  complete_agreement(ranks);
  return answer(ranks);
}

kith_status kith_ranks_must(struct kith_ranks *ranks, kith_status status) {
  if (status == KITH_OK || ranks == NULL || ranks->size == 1) return status;
  fprintf(stderr, "kith: rank %d: %s\n", ranks->rank, kith_failure());
  kith_ranks_abort(ranks, 1);
}

bool kith_ranks_status_is_shared(const struct kith_ranks *ranks) {
  return ranks == NULL || ranks->size == 1 ||
         (ranks->agreed.line[0] != '\0' && strcmp(ranks->agreed.line, kith_failure()) == 0);
}

static void reduce(struct kith_ranks *ranks, void *values, int n, MPI_Datatype type, MPI_Op op) {
  if (counted(ranks))
    WAIT(ranks, "a sum or extremum", MPI_Allreduce(MPI_IN_PLACE, values, n, type, op, ranks->all));
}

void kith_ranks_max(struct kith_ranks *ranks, double *values, int n) {
  reduce(ranks, values, n, MPI_DOUBLE, MPI_MAX);
}

void kith_ranks_min(struct kith_ranks *ranks, double *values, int n) {
  reduce(ranks, values, n, MPI_DOUBLE, MPI_MIN);
}

void kith_ranks_sum(struct kith_ranks *ranks, double *values, int n) {
  reduce(ranks, values, n, MPI_DOUBLE, MPI_SUM);
}

void kith_ranks_sum_counts(struct kith_ranks *ranks, uint64_t *values, int n) {
  reduce(ranks, values, n, MPI_UINT64_T, MPI_SUM);
}

void kith_ranks_broadcast(struct kith_ranks *ranks, void *data, size_t bytes) {
  if (counted(ranks)) WAIT(ranks, "a broadcast", MPI_Bcast(data, (int)bytes, MPI_BYTE, 0, ranks->all));
}

void kith_ranks_tell(struct kith_ranks *ranks, int n_neighbors, const int32_t *neighbor, const int64_t *to,
                     int64_t *from, int n) {
  enum { TAG = 2 };
  if (neighbor == NULL && counted(ranks)) {
    WAIT(ranks, "numbers from all to all",
         MPI_Alltoall(to, n, MPI_INT64_T, from, n, MPI_INT64_T, ranks->all));
    return;
  }
  if (ranks == NULL || ranks->size == 1) {
    memcpy(from, to, (size_t)n * sizeof *from);
    return;
  }
  if (!together(ranks)) {
    memset(from, 0, (size_t)ranks->size * (size_t)n * sizeof *from);
    return;
  }
  for (int k = 0; k < n_neighbors; ++k) {
    const int r = neighbor[k];
    MPI_Irecv(from + (size_t)r * (size_t)n, n, MPI_INT64_T, r, TAG, ranks->all, &ranks->request[2 * k]);
    MPI_Isend(to + (size_t)r * (size_t)n, n, MPI_INT64_T, r, TAG, ranks->all, &ranks->request[2 * k + 1]);
  }
  WAIT(ranks, "numbers of neighbors", MPI_Waitall(2 * n_neighbors, ranks->request, MPI_STATUSES_IGNORE));
  ranks->traffic.messages += (uint64_t)n_neighbors;
  ranks->traffic.bytes += (uint64_t)n_neighbors * (uint64_t)n * sizeof *to;
}

void kith_ranks_send_to_root(struct kith_ranks *ranks, int from, void *data, size_t bytes) {
  enum { TAG = 9 };
  if (from == 0 || bytes == 0 || !together(ranks)) return;
  if (ranks->rank == 0)
    WAIT(ranks, "data for rank 0",
         MPI_Recv(data, (int)bytes, MPI_BYTE, from, TAG, ranks->all, MPI_STATUS_IGNORE));
  if (ranks->rank == from)
    WAIT(ranks, "rank 0 to take data", MPI_Send(data, (int)bytes, MPI_BYTE, 0, TAG, ranks->all));
}

kith_status kith_ranks_gather(struct kith_ranks *ranks, const void *mine, size_t bytes, char **all,
                              size_t *part) {
  const int size = kith_ranks_size(ranks);
  size_t *length = NULL, total = 0;
  int *count = NULL, *place; /* MPI counts in int */
  *all = NULL;
  KITH_TRY(kith_ranks_must(ranks, kith_resize(&length, 0, (size_t)size, sizeof *length)));
  length[0] = bytes;
  if (counted(ranks))
    WAIT(ranks, "numbers of all ranks",
         MPI_Allgather(&bytes, sizeof bytes, MPI_BYTE, length, sizeof bytes, MPI_BYTE, ranks->all));
  kith_status status = kith_resize(&count, 0, 2 * (size_t)size, sizeof *count);
  place = count + size;
  for (int r = 0; r < size; ++r) {
    if (status == KITH_OK) count[r] = (int)length[r], place[r] = (int)total;
    if (part != NULL) part[r] = total, part[r + 1] = total + length[r];
    total += length[r];
  }
  if (total > INT_MAX) status = kith_fail(KITH_UNSUPPORTED, "%zu bytes are too many for all ranks", total);
  if (status == KITH_OK) status = kith_resize(all, 0, total, 1);
  status = kith_ranks_allreduce_status(ranks, status);
  if (status == KITH_OK && counted(ranks))
    WAIT(ranks, "data of all ranks",
         MPI_Allgatherv(mine, count[ranks->rank], MPI_BYTE, *all, count, place, MPI_BYTE, ranks->all));
  else if (status == KITH_OK && total > 0)
    memcpy(*all, mine, total);
  KITH_FREE(&length, &count);
  return status;
}

kith_status kith_ranks_start_exchange(struct kith_ranks *ranks, int n_out, const struct kith_message *out,
                                      int n_in, const struct kith_message *in) {
  enum { TAG = 1 };
  if (!together(ranks)) return KITH_OK;
  if (ranks->n_requests > 0) KITH_FAIL(INTERNAL, "an exchange is pending already");
  if (n_out > ranks->size || n_in > ranks->size) KITH_FAIL(INTERNAL, "more messages than ranks");
  for (int k = 0; k < n_out + n_in; ++k) {
    const struct kith_message *m = k < n_in ? &in[k] : &out[k - n_in];
    if (m->bytes == 0) continue;
    if (m->bytes / 8 > INT_MAX) KITH_FAIL(UNSUPPORTED, "a message of %zu bytes", m->bytes);
    const int words = (int)(m->bytes / 8);
    MPI_Request *request = &ranks->request[ranks->n_requests++];
    if (k < n_in) {
      MPI_Irecv(m->data, words, MPI_INT64_T, m->rank, TAG, ranks->all, request);
      continue;
    }
    MPI_Isend(m->data, words, MPI_INT64_T, m->rank, TAG, ranks->all, request);
    ++ranks->traffic.messages;
    ranks->traffic.bytes += m->bytes;
  }
  return KITH_OK;
}

void kith_ranks_progress(struct kith_ranks *ranks) {
  int done = 0;
  if (ranks == NULL || ranks->n_requests == 0) return;
  MPI_Testall(ranks->n_requests, ranks->request, &done, MPI_STATUSES_IGNORE);
  if (done) ranks->n_requests = 0;
}

void kith_ranks_finish_exchange(struct kith_ranks *ranks) {
  if (ranks == NULL || ranks->n_requests == 0) return;
  WAIT(ranks, "values of neighbors", MPI_Waitall(ranks->n_requests, ranks->request, MPI_STATUSES_IGNORE));
  ranks->n_requests = 0;
}

struct kith_traffic kith_ranks_traffic(const struct kith_ranks *ranks) {
  return ranks != NULL ? ranks->traffic : (struct kith_traffic){0};
}
