/* traversal.c - chunks of nodes shared out among threads. */
#include "lib/connectivity/traversal.h"

#include <omp.h>
#include <string.h>

#include "lib/core/lanes.h"

/* Calls the pass for each run of nodes of the chunk that take part. */
static void run_chunk(const struct kith_part *part, kith_index begin, kith_index end, kith_chunk_pass pass,
                      void *context, struct kith_scratch *scratch) {
  if (part == NULL || part->activity == NULL) {
    pass(context, begin, end, scratch);
    return;
  }
  if (part->least > KITH_IDLE && kith_all_idle(part->activity, begin, end)) return;
  while (begin < end) {
    while (begin < end && part->activity[begin] < part->least) ++begin;
    kith_index stop = begin;
    while (stop < end && part->activity[stop] >= part->least) ++stop;
    if (stop > begin) pass(context, begin, stop, scratch);
    begin = stop;
  }
}

kith_status kith_traverse_part(kith_index n, const struct kith_part *part, kith_chunk_pass pass,
                               void *context, int lanes, size_t width, uint64_t *count,
                               struct kith_profile *profile) {
  const kith_index chunks = (n + KITH_CHUNK - 1) / KITH_CHUNK;
  bool failed = false;
  uint64_t total[4] = {0};
  width = (width + 7) / 8 * 8 + 8;
#pragma omp parallel reduction(|| : failed) reduction(+ : total[:4])
  {
    const double start = kith_seconds();
    struct kith_scratch scratch = {.width = width};
    failed = kith_resize(&scratch.lane, 0, width * (size_t)lanes, sizeof(double)) != KITH_OK;
#pragma omp for schedule(dynamic) nowait
    for (kith_index c = 0; c < chunks; ++c) {
      if (failed || (part != NULL && part->chunk != NULL && part->chunk[c] != part->wanted)) continue;
      run_chunk(part, c * KITH_CHUNK, KITH_MIN(n, (c + 1) * KITH_CHUNK), pass, context, &scratch);
      if (part != NULL && omp_get_thread_num() == 0) kith_ranks_progress(part->ranks);
    }
    for (int k = 0; k < 4; ++k) total[k] += scratch.count[k];
    kith_free(&scratch.lane);
    kith_profile_thread(profile, omp_get_thread_num(), start, kith_seconds());
  }
  if (count != NULL) memcpy(count, total, sizeof total);
  if (failed) KITH_FAIL(NO_MEMORY, "no memory for a pass over rows of %zu", width);
  return KITH_OK;
}

kith_status kith_traverse(kith_index n, kith_chunk_pass pass, void *context, int lanes, size_t width,
                          uint64_t *count, struct kith_profile *profile) {
  return kith_traverse_part(n, NULL, pass, context, lanes, width, count, profile);
}
