/* fill.h - the second pass over groups: bits become entries where they belong. */
#ifndef KITH_CONNECTIVITY_BUILD_FILL_H
#define KITH_CONNECTIVITY_BUILD_FILL_H

#include "lib/connectivity/build/builder.h"

/* One record: number of candidates, and in bit 32 whether idle nodes are among them; slots of the targets;
 * the candidates, two in a word; their shifts, if there are any; the bits of the idle ones, if there are any;
 * the bits, target by target. */
enum { KITH_RECORD_HEAD = 2 };
static inline size_t kith_record_nodes(size_t n) {
  return (n + 1) / 2;
}
static inline size_t kith_record_shifts(const struct kith_build *build, size_t n) {
  return build->shifts != NULL ? (n + 3) / 4 : 0;
}

/* The rows of the records of a chunk, and their targets into rows of idle nodes. Offsets are known. */
void kith_chunk_fill(struct kith_rows *rows, const struct kith_build *build, const struct kith_words *chunk);
/* Before and after all chunks: rows of idle nodes have no entries yet; they ascend. */
kith_status kith_rows_begin_idle(const struct kith_rows *rows, const struct kith_build *build);
void kith_rows_end_idle(struct kith_rows *rows, const struct kith_build *build);

#endif
