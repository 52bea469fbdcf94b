/* fill.c - entries from bits; rows of idle nodes. */
#include "lib/connectivity/build/fill.h"

#include <omp.h>
#include <string.h>

/* Fills in the shifts of the row that begins at entry e, and sorts the row: its nodes ascend only among
 * entries of one shift. Mostly there is one shift, that of the first and of the last word, and nothing to
 * sort. */
static void fill_shifts(const struct kith_rows *rows, const struct kith_build *build, size_t e,
                        const struct kith_record *record, const uint64_t *hit) {
  const uint16_t *shift = record->shift;
  size_t n = 0;
  for (int w = 0; w < record->words; ++w) n += (size_t)__builtin_popcountll(hit[w]);
  if (record->words > 0 && shift[0] == shift[64 * (record->words - 1)]) {
    for (size_t k = e; k < e + n; ++k) rows->shift[k] = shift[0];
    return;
  }
  kith_packed_extract_shifts(shift, record->words, hit, rows->shift + e);
  if (build->unsorted) return;
  uint64_t *key = build->scratch->worker[omp_get_thread_num()].key;
  for (size_t k = 0; k < n; ++k) key[k] = (uint64_t)rows->node[e + k] << 16 | rows->shift[e + k];
  key = kith_keys_sort(key, key + n, n);
  for (size_t k = 0; k < n; ++k) {
    rows->node[e + k] = (kith_index)(key[k] >> 16);
    rows->shift[e + k] = (uint16_t)(key[k] & 0xffff);
  }
}

/* Adds target i to the rows of the idle nodes that are in its own row. */
static void fill_idle(const struct kith_rows *rows, const struct kith_build *build, kith_index i,
                      const struct kith_record *record, const uint64_t *hit) {
  const bool alone = omp_get_num_threads() == 1;
  for (int w = 0; w < record->words; ++w)
    for (uint64_t bits = hit[w] & record->idle[w]; bits != 0; bits &= bits - 1) {
      const int k = 64 * w + __builtin_ctzll(bits);
      const kith_index node = record->node[k];
      kith_index at, *mine = &build->scratch->filled[node];
      if (alone)
        at = (*mine)++;
      else
#pragma omp atomic capture
        at = (*mine)++;
      const size_t e = rows->first[node] + (size_t)at;
      rows->node[e] = i;
      if (rows->shift != NULL) rows->shift[e] = (uint16_t)(2 * rows->zero - record->shift[k]);
    }
}

void kith_chunk_fill(struct kith_rows *rows, const struct kith_build *build, const struct kith_words *chunk) {
  const kith_index *of_slot = build->targets->search->node;
  const bool all = kith_build_all_targets(build);
  for (uint64_t *word = chunk->word; word < chunk->word + chunk->n;) {
    const struct kith_record record = kith_record_at(build, word);
    uint64_t *hit = record.hit;
    for (kith_index slot = record.slots.first; slot < record.slots.first + record.slots.count; ++slot) {
      const kith_index i = of_slot[slot];
      if (!all && !kith_build_is_target(build, i)) continue;
      const size_t e = rows->first[all ? i : kith_build_row(build, i)];
      kith_packed_extract(record.node, record.words, hit, rows->node + e);
      if (rows->shift != NULL) fill_shifts(rows, build, e, &record, hit);
      if (record.idle != NULL) fill_idle(rows, build, i, &record, hit);
      hit += record.words;
    }
    word = hit; /* the next record follows the bits of the last target */
  }
}

kith_status kith_rows_begin_idle(const struct kith_rows *rows, const struct kith_build *build) {
  struct kith_builder *scratch = build->scratch;
  KITH_TRY(
      kith_reserve(&scratch->filled, &scratch->filled_capacity, (size_t)rows->n, sizeof *scratch->filled));
  for (kith_index from = 0; from < rows->n; from += KITH_STRETCH)
    memset(scratch->filled + from, 0,
           (size_t)(kith_rows_stretch_end(rows, from) - from) * sizeof *scratch->filled);
  return KITH_OK;
}

/* Entries came in the order in which threads reached them: nearly sorted. */
void kith_rows_end_idle(struct kith_rows *rows, const struct kith_build *build) {
  const kith_index *filled = build->scratch->filled;
  rows->n = build->nodes->n_internal;
#pragma omp parallel for schedule(dynamic, 8) if (rows->n > KITH_FEW)
  for (kith_index from = 0; from < rows->n; from += KITH_STRETCH) {
    const kith_index stop = kith_rows_stretch_end(rows, from);
    for (kith_index i = from; i < stop; ++i)
      if (filled[i] > 1)
        kith_entries_sort(rows->node + rows->first[i],
                          rows->shift != NULL ? rows->shift + rows->first[i] : NULL, (size_t)filled[i]);
  }
}
