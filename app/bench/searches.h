/* searches.h - a part of `kith bench`: neighbor searches (lib/neighbor) on clouds of nodes whose supports
 * differ by 1, 10 and 1000 from place to place, with about 60 neighbors everywhere, and by 10 in one place.
 * Prints its table. */
#ifndef KITH_APP_BENCH_SEARCHES_H
#define KITH_APP_BENCH_SEARCHES_H

#include "lib/core/base.h"

/* Clouds of about n nodes. */
kith_status kith_bench_searches(kith_index n);

#endif
