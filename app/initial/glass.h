/* glass.h - a glass: sites that are nearly at rest among each other, without the directions of a lattice. */
#ifndef KITH_APP_INITIAL_GLASS_H
#define KITH_APP_INITIAL_GLASS_H

#include "lib/core/base.h"

enum {
  KITH_GLASS_SIDE = 10, /* of the periodic cell, in mean spacings */
  KITH_GLASS_SITES = NDIM == 3   ? 1000
                     : NDIM == 2 ? 100
                                 : 10
};

/* The places of the sites in a cell of side 1, the same in each call. Takes a second in 3-D, a fiftieth of it
 * in 2-D, once. */
const double (*kith_glass_sites(void))[NDIM];

#endif
