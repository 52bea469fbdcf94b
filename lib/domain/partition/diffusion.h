/* diffusion.h - the private state of `diffusion`, which `hybrid` has too. */
#ifndef KITH_DOMAIN_PARTITION_DIFFUSION_H
#define KITH_DOMAIN_PARTITION_DIFFUSION_H

#include "lib/domain/partition/partition.h"

/* Zero: the defaults. */
struct kith_diffusion {
  enum kith_diffusion_flow { KITH_SCHORNBAUM, KITH_WILLEBEEK, KITH_SECOND_ORDER } flow;
  bool fixed;     /* no new neighbor ranks */
  bool restart;   /* the next update begins with the start map */
  bool on_morton; /* start map: morton, not cart */
  int64_t n_allowed;
  uint64_t *allowed; /* [n_allowed] neighbors p, q in the start map, as p n_ranks + q, ascending; owned */
};

#endif
