/* storage.h - a part of `kith bench`: storages of neighbor lists (lib/connectivity/storage) on the nodes of a
 * simulation that has run, with a half, once and twice its neighbors. Prints its table. */
#ifndef KITH_APP_BENCH_STORAGE_H
#define KITH_APP_BENCH_STORAGE_H

#include "app/simulation/simulation.h"

kith_status kith_bench_storage(struct kith_simulation *simulation);

#endif
