/* ranks.h in a build without MPI: one process, and all its ranks are NULL. */
#include <stdlib.h>
#include <string.h>
#include "lib/comm/ranks.h"

/* Most of them have nothing to do. */
#pragma GCC diagnostic ignored "-Wunused-parameter"

int kith_ranks_most(void) {
  return 1;
}
kith_status kith_ranks_create(struct kith_ranks **out) {
  *out = NULL;
  if (kith_launched() == 1) return KITH_OK;
  KITH_FAIL(UNSUPPORTED, "%d processes were started, and this program was built without MPI",
            kith_launched());
}
kith_status kith_ranks_create_on(struct kith_ranks **out, int communicator) {
  *out = NULL;
  KITH_FAIL(UNSUPPORTED, "communicator %d: this library was built without MPI", communicator);
}
kith_status kith_ranks_rehearse(struct kith_ranks **out) {
  *out = NULL;
  KITH_FAIL(UNSUPPORTED, "this program was built without MPI");
}
kith_status kith_ranks_watch(struct kith_ranks *ranks, double seconds, const struct kith_profile *profile) {
  return KITH_OK;
}
void kith_ranks_destroy(struct kith_ranks **ranks) {
  *ranks = NULL;
}
void kith_ranks_abort(struct kith_ranks *ranks, int code) {
  exit(code);
}
int kith_ranks_rank(const struct kith_ranks *ranks) {
  return 0;
}
int kith_ranks_size(const struct kith_ranks *ranks) {
  return 1;
}
int kith_ranks_on_this_machine(const struct kith_ranks *ranks) {
  return 1;
}
int kith_ranks_cores(const struct kith_ranks *ranks) {
  return 0;
}
int kith_ranks_communicator(const struct kith_ranks *ranks) {
  return 0;
}
struct kith_traffic kith_ranks_traffic(const struct kith_ranks *ranks) {
  return (struct kith_traffic){0};
}

kith_status kith_ranks_agree(struct kith_ranks *ranks, kith_status status, int n,
                             const struct kith_shared *parts) {
  return status;
}
kith_status kith_ranks_start_agree(struct kith_ranks *ranks, kith_status status, int n,
                                   const struct kith_shared *parts) {
  return status;
}
kith_status kith_ranks_finish_agree(struct kith_ranks *ranks) {
  return KITH_OK;
}
kith_status kith_ranks_must(struct kith_ranks *ranks, kith_status status) {
  return status;
}
bool kith_ranks_status_is_shared(const struct kith_ranks *ranks) {
  return true;
}
void kith_ranks_max(struct kith_ranks *ranks, double *values, int n) {}
void kith_ranks_min(struct kith_ranks *ranks, double *values, int n) {}
void kith_ranks_sum(struct kith_ranks *ranks, double *values, int n) {}
void kith_ranks_sum_counts(struct kith_ranks *ranks, uint64_t *values, int n) {}
void kith_ranks_broadcast(struct kith_ranks *ranks, void *data, size_t bytes) {}
void kith_ranks_tell(struct kith_ranks *ranks, int n_neighbors, const int32_t *neighbor, const int64_t *to,
                     int64_t *from, int n) {
  memcpy(from, to, (size_t)n * sizeof *from);
}
kith_status kith_ranks_gather(struct kith_ranks *ranks, const void *mine, size_t bytes, char **all,
                              size_t *part) {
  *all = NULL;
  if (part != NULL) part[0] = 0, part[1] = bytes;
  KITH_TRY(kith_resize(all, 0, bytes, 1));
  if (bytes > 0) memcpy(*all, mine, bytes);
  return KITH_OK;
}
void kith_ranks_send_to_root(struct kith_ranks *ranks, int from, void *data, size_t bytes) {}
kith_status kith_ranks_start_exchange(struct kith_ranks *ranks, int n_out, const struct kith_message *out,
                                      int n_in, const struct kith_message *in) {
  return KITH_OK;
}
void kith_ranks_progress(struct kith_ranks *ranks) {}
void kith_ranks_finish_exchange(struct kith_ranks *ranks) {}
