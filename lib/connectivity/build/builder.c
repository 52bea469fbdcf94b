/* builder.c - scratch memory of builders; excluders applied to candidates. */
#include "lib/connectivity/build/builder.h"

#include <omp.h>

kith_status kith_builder_reserve(struct kith_builder *scratch) {
  const int threads = omp_get_max_threads();
  if (threads <= scratch->threads) return KITH_OK;
  KITH_TRY(kith_resize(&scratch->worker, (size_t)scratch->threads, (size_t)threads, sizeof *scratch->worker));
  scratch->threads = threads;
  return KITH_OK;
}

void kith_builder_clear(struct kith_builder *scratch) {
  for (int t = 0; t < scratch->threads; ++t) {
    struct kith_worker *w = &scratch->worker[t];
    kith_runs_clear(&w->runs);
    kith_packed_clear(&w->near);
    KITH_FREE(&w->key, &w->hit, &w->idle, &w->bitmap, &w->touched, &w->found);
  }
  kith_free(&scratch->worker);
  for (int k = 0; k < KITH_ROW_CHUNKS; ++k) kith_free(&scratch->chunk[k].own);
  kith_rows_clear(&scratch->spans);
  KITH_FREE(&scratch->bits, &scratch->filled);
  *scratch = (struct kith_builder){0};
}

size_t kith_builder_bytes(const struct kith_builder *scratch) {
  size_t bytes = kith_rows_bytes(&scratch->spans), words = scratch->bits_capacity;
  for (int t = 0; t < scratch->threads; ++t) {
    const struct kith_worker *w = &scratch->worker[t];
    bytes += sizeof *w + (size_t)w->runs.capacity * sizeof(struct kith_run) +
             w->found_capacity * sizeof *w->found +
             (size_t)w->near.capacity *
                 (sizeof *w->near.node + sizeof *w->near.shift + (NDIM + 1) * sizeof(double));
    words += w->key_capacity + w->hit_capacity + w->idle_capacity + w->bitmap_capacity + w->touched_capacity;
  }
  return bytes + scratch->filled_capacity * sizeof *scratch->filled + words * sizeof(uint64_t);
}

int kith_build_exclude(const struct kith_build *build, enum kith_phase phase, kith_index i, int from,
                       const struct kith_packed *near, uint64_t *hit) {
  struct kith_candidate candidate = {build->targets, build->sources, .i = i,
                                     .shift = build->sources->nodes->shifts.zero};
  int count = 0;
  for (int w = 0; w < near->words; ++w) {
    for (uint64_t bits = hit[w]; bits != 0; bits &= bits - 1) {
      const int k = __builtin_ctzll(bits);
      candidate.j = near->node[64 * w + k];
      if (build->shifts != NULL) candidate.shift = build->shifts->zero + near->shift[64 * w + k] - from;
      if (kith_excluder_rejects(build->excluders, phase, &candidate)) hit[w] &= ~(UINT64_C(1) << k);
    }
    count += __builtin_popcountll(hit[w]);
  }
  return count;
}
