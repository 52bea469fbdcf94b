/* traversal.c - chunks of nodes shared out among threads. */
#include "lib/connectivity/traversal.h"

#include <omp.h>
#include <string.h>

/* Calls the pass for each run of nodes of the chunk that take part. */
static void run_chunk(const struct kith_part *part, kith_index begin, kith_index end, kith_chunk_pass pass,
                      void *context, struct kith_scratch *scratch) {
  if (part->activity != NULL && kith_all_zero(part->activity, begin, end)) return;
  if (part->activity == NULL || part->whole) {
    pass(context, begin, end, scratch);
    return;
  }
  while (begin < end) {
    while (begin < end && part->activity[begin] < part->least) ++begin;
    kith_index stop = begin;
    while (stop < end && part->activity[stop] >= part->least) ++stop;
    if (stop > begin) pass(context, begin, stop, scratch);
    begin = stop;
  }
}

/* Is this one of the chunks that are run? */
static bool is_wanted(const struct kith_part *part, kith_index begin, kith_index end) {
  uint8_t most = 0;
  if (part->chunk == NULL) return true;
  for (kith_index c = begin / KITH_CHUNK; c < (end + KITH_CHUNK - 1) / KITH_CHUNK; ++c)
    most = KITH_MAX(most, part->chunk[c]);
  return most == part->wanted;
}

kith_status kith_traverse_part(kith_index n, const struct kith_part *part, kith_chunk_pass pass,
                               void *context, int lanes, size_t width, uint64_t *count,
                               struct kith_profile *profile) {
  const kith_index size = part->size > 0 ? part->size : KITH_CHUNK;
  const kith_index chunks = (n + size - 1) / size;
  bool failed = false;
  uint64_t total[4] = {0};
  width = (width + 7) / 8 * 8 + 8;
#pragma omp parallel reduction(|| : failed) reduction(+ : total[:4])
  {
    const double start = kith_seconds();
    struct kith_scratch scratch = {.width = width};
    failed = kith_resize(&scratch.lane, 0, width * (size_t)lanes, sizeof(double)) != KITH_OK;
    /* A thread takes several chunks at a time, because the neighbors of one are in the cache for the next;
     * but one at a time where only some nodes are active, because these may all be close together. */
    const kith_index run = part->activity == NULL ? KITH_MAX(1, chunks / (64 * omp_get_num_threads())) : 1;
#pragma omp for schedule(dynamic, run) nowait
    for (kith_index c = 0; c < chunks; ++c) {
      const kith_index begin = part->first + c * size, end = KITH_MIN(part->first + n, begin + size);
      if (failed || !is_wanted(part, begin, end)) continue;
      run_chunk(part, begin, end, pass, context, &scratch);
      if (omp_get_thread_num() == 0) kith_ranks_progress(part->ranks);
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
                          struct kith_profile *profile) {
  return kith_traverse_part(n, &(struct kith_part){0}, pass, context, lanes, width, NULL, profile);
}
