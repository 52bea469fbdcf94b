/* sweep.h - the walk over the cells of a spacetree. */
#ifndef KITH_NEIGHBOR_SWEEP_H
#define KITH_NEIGHBOR_SWEEP_H

#include "lib/neighbor/search.h"

/* As kith_search_sweep, of a search whose private state is that of cells.h. UNSUPPORTED if a search radius is
 * too large for any cell. */
kith_status kith_spacetree_sweep(const struct kith_search *search, const struct kith_sweep *sweep,
                                 void *context);

#endif
