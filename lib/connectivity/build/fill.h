/* fill.h - the second pass over groups: bits become entries where they belong. */
#ifndef KITH_CONNECTIVITY_BUILD_FILL_H
#define KITH_CONNECTIVITY_BUILD_FILL_H

#include "lib/connectivity/build/builder.h"

/* One record: number of candidates; slots of the targets; the candidates, two in a word; their shifts, if
 * there are any; the bits, target by target. */
enum { KITH_RECORD_HEAD = 2 };
static inline size_t kith_record_nodes(size_t n) {
  return (n + 1) / 2;
}
static inline size_t kith_record_shifts(const struct kith_build *build, size_t n) {
  return build->shifts != NULL ? (n + 3) / 4 : 0;
}

/* The rows of the records of a chunk. Their offsets are known. */
void kith_chunk_fill(struct kith_rows *rows, const struct kith_build *build, const struct kith_words *chunk);
/* Rows of idle nodes from those of the active ones. */
kith_status kith_rows_of_idle(struct kith_rows *rows, const struct kith_build *build);

#endif
