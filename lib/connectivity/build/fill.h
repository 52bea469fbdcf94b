/* fill.h - the second pass over groups: bits become entries where they belong. */
#ifndef KITH_CONNECTIVITY_BUILD_FILL_H
#define KITH_CONNECTIVITY_BUILD_FILL_H

#include "lib/connectivity/build/builder.h"

/* The record of a group, which the first pass leaves for the second. It begins with two words: the number of
 * candidates, with bit 32 set if idle nodes are among them, and the slots of the targets. Arrays follow. */
struct kith_record {
  struct kith_run slots; /* of the targets */
  int words;             /* how many words have a bit for each candidate */
  kith_index *node;      /* the candidates */
  uint16_t *shift;       /* which images they are; only if there are shifts */
  uint64_t *idle;        /* [words] which of them are idle; NULL: none is */
  uint64_t *hit;         /* [targets][words] which of them are neighbors of each target */
};
/* The length of a record in words, up to `hit`. */
static inline size_t kith_record_head(const struct kith_build *build, size_t n, bool idle) {
  return 2 + (n + 1) / 2 + (build->shifts != NULL ? (n + 3) / 4 : 0) + (idle ? (n + 63) / 64 : 0);
}
/* The record whose first two words are word[0] and word[1]. */
static inline struct kith_record kith_record_at(const struct kith_build *build, uint64_t *word) {
  const size_t n = (size_t)(word[0] & 0xffffffffu), words = (n + 63) / 64;
  const bool idle = word[0] >> 32 != 0;
  uint64_t *hit = word + kith_record_head(build, n, idle);
  return (struct kith_record){{(kith_index)(word[1] >> 32), (kith_index)(word[1] & 0xffffffffu)},
                              (int)words,
                              (kith_index *)(word + 2),
                              (uint16_t *)(word + 2 + (n + 1) / 2),
                              idle ? hit - words : NULL,
                              hit};
}

/* Fills the rows of the targets of a chunk from its records, and adds the targets to the rows of idle nodes.
 * Offsets are known. */
void kith_chunk_fill(struct kith_rows *rows, const struct kith_build *build, const struct kith_words *chunk);
/* Before and after all chunks: empties the rows of idle nodes; sorts them. */
kith_status kith_rows_begin_idle(const struct kith_rows *rows, const struct kith_build *build);
void kith_rows_end_idle(struct kith_rows *rows, const struct kith_build *build);

#endif
