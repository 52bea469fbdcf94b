/* fill.h - the second pass over groups: bits become entries where they belong. */
#ifndef KITH_CONNECTIVITY_BUILD_FILL_H
#define KITH_CONNECTIVITY_BUILD_FILL_H

#include "lib/connectivity/build/builder.h"

/* The record of a group, in 64-bit words: number of candidates, and in bit 32 whether idle nodes are among
 * them; slots of the targets; the candidates, two in a word; their shifts, four in a word, if there are any;
 * which candidates are idle, if any are; and for each target, which candidates are its neighbors. */
enum { KITH_RECORD_HEAD = 2 };
static inline size_t kith_record_nodes(size_t n) {
  return (n + 1) / 2;
}
static inline size_t kith_record_shifts(const struct kith_build *build, size_t n) {
  return build->shifts != NULL ? (n + 3) / 4 : 0;
}

/* Fills the rows of the targets of a chunk from its records, and adds the targets to the rows of idle nodes.
 * Offsets are known. */
void kith_chunk_fill(struct kith_rows *rows, const struct kith_build *build, const struct kith_words *chunk);
/* Before and after all chunks: empties the rows of idle nodes; sorts them. */
kith_status kith_rows_begin_idle(const struct kith_rows *rows, const struct kith_build *build);
void kith_rows_end_idle(struct kith_rows *rows, const struct kith_build *build);

#endif
