/* sweep.h - a pass over all internal nodes that overlaps with the exchange of ghost values.
 *
 * A pass starts the exchange of what it has computed (kith_package_start_refresh). The next sweep then begins
 * with the chunks that have no remote ghost in their rows, waits for the values, and goes on with the others.
 * Each node is summed in the same order as without an exchange, so results do not depend on it. */
#ifndef KITH_PHYSICS_PASSES_SWEEP_H
#define KITH_PHYSICS_PASSES_SWEEP_H

#include "lib/connectivity/traversal.h"
#include "physics/hydro.h"
#include "physics/kernel.h"

struct kith_node_sweep {
  const char *stage;            /* of the profile */
  const struct kith_rows *rows; /* the neighbors that the pass reads */
  kith_chunk_pass chunk;
  void *context;
  int lanes; /* as for kith_traverse */
  size_t width;
  const char *counter; /* of the stage: what count[counted] is; NULL: none */
  int counted;
  /* Called when ghosts begin .. end - 1 have arrived, before they are read. NULL: nothing to do. */
  void (*arrived)(void *context, kith_index begin, kith_index end);
};

/* Scratch of all sweeps over the same nodes: the chunks with a remote ghost in a row, found once for each
 * list of rows. Zero at first; freed by kith_border_clear. */
struct kith_border {
  uint8_t *chunk;
  size_t capacity;
  const kith_index *rows; /* whose chunks these are, and of which generation of ghosts */
  uint64_t ghosts;
};
void kith_border_clear(struct kith_border *border);

/* All internal nodes. An exchange that was started has finished when this returns, whatever it returns.
 * count[4], written: the counters of all chunks. profile may be NULL. */
kith_status kith_node_sweep_run(const struct kith_node_sweep *sweep, const struct kith_hydro *hydro,
                                struct kith_border *border, struct kith_profile *profile, uint64_t count[4]);

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
