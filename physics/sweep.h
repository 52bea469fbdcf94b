/* sweep.h - a pass over all nodes, while values of remote ghosts are on their way.
 *
 * Values are posted as soon as the pass before has made them (kith_package_post). The next sweep then begins with the chunks that have
 * no remote ghost in their rows, awaits the values, and goes on with the others. Each node is summed as ever: no bit depends on it. */
#ifndef KITH_PHYSICS_SWEEP_H
#define KITH_PHYSICS_SWEEP_H

#include "lib/connectivity/traversal.h"
#include "physics/package.h"

struct kith_sweep {
  const char *stage;            /* of the profile */
  const struct kith_rows *rows; /* whom the pass looks at */
  kith_chunk_pass chunk;
  void *context;
  int lanes; /* as for kith_traverse */
  size_t width;
  const char *counter; /* of the stage: what count[counted] is; NULL: none */
  int counted;
  /* Makes of arrived ghosts begin .. end - 1 what the pass reads of them. NULL: nothing. */
  void (*arrived)(void *context, kith_index begin, kith_index end);
};

/* All internal nodes. Values that were posted have arrived when it returns, whatever it returns. */
kith_status kith_package_sweep(struct kith_package *package, const struct kith_sweep *sweep,
                               uint64_t count[4]);

#endif
