/* sweep.h - a pass over all internal nodes that overlaps with the exchange of ghost values.
 *
 * A pass starts the exchange of what it has computed (kith_package_start_refresh). The next sweep then begins
 * with the chunks that have no remote ghost in their rows, waits for the values, and goes on with the others.
 * Each node is summed in the same order as without an exchange, so results do not depend on it. */
#ifndef KITH_PHYSICS_PASSES_SWEEP_H
#define KITH_PHYSICS_PASSES_SWEEP_H

#include "lib/connectivity/traversal.h"
#include "physics/package.h"

/* What chunks count, in count[] of their scratch; added to the counters of the package. */
enum {
  KITH_COUNT_EVALUATIONS,
  KITH_COUNT_ITERATIONS,
  KITH_COUNT_FALLBACKS,
  KITH_COUNT_OUTGROWN,
  KITH_COUNTS
};
_Static_assert(KITH_COUNTS == sizeof((struct kith_scratch){0}.count) / sizeof(uint64_t), "a counter each");

struct kith_node_sweep {
  const char *stage;            /* of the profile */
  const struct kith_rows *rows; /* the neighbors that the pass reads */
  kith_chunk_pass chunk;
  kith_index chunk_size; /* nodes, a multiple of KITH_CHUNK; 0: KITH_CHUNK */
  void *context;
  int lanes; /* as for kith_traverse */
  size_t width;
  bool iterates; /* the stage counts its iterations */
  bool begins;   /* first sweep of an evaluation: an agreement of ranks may stay open until its end */
  bool touched;  /* runs for touched nodes too, not for active ones alone */
  bool whole;    /* the chunk itself skips nodes that take no part (traversal.h) */
  /* Memory traffic, for the counter "bytes" of the stage, as if each array were read or written once: bytes
   * of a node or ghost that its neighbors read; that only the node itself reads and writes; of values of
   * pairs. The rows are added. */
  int shared, own;
  double pairwise;
  /* Called when ghosts begin .. end - 1 have arrived, before they are read. NULL: nothing to do. */
  void (*arrived)(void *context, kith_index begin, kith_index end);
};

/* Runs a sweep over all internal nodes. An exchange that was started has finished when this returns, whatever
 * it returns. count, written: sums over all chunks; may be NULL. */
kith_status kith_package_sweep(struct kith_package *package, const struct kith_node_sweep *sweep,
                               uint64_t count[KITH_COUNTS]);
/* Runs the chunks over n ghosts from `first` on, whose values have arrived. Counts evaluations only. */
kith_status kith_package_sweep_ghosts(struct kith_package *package, const struct kith_node_sweep *sweep,
                                      kith_index first, kith_index n);

/* Compiles FUNCTION(kernel, context, begin, end, scratch) once per kernel, so that the kernel is a constant
 * in its loops; FUNCTION_of[kernel] are the resulting chunk passes. */
#define KITH_KERNEL_CHUNKS(function)                  \
  KITH_KERNEL_LIST_WITH(KITH_KERNEL_CHUNK_, function) \
  static const kith_chunk_pass function##_of[] = {KITH_KERNEL_LIST_WITH(KITH_KERNEL_CHUNK_NAME_, function)};
#define KITH_KERNEL_CHUNK_(function, name, ...)                                           \
  KITH_HOT static void function##_##name(void *context, kith_index begin, kith_index end, \
                                         struct kith_scratch *s) {                        \
    function(KITH_KERNEL_##name, context, begin, end, s);                                 \
  }
#define KITH_KERNEL_CHUNK_NAME_(function, name, ...) function##_##name,

#endif
