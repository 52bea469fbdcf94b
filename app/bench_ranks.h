/* bench_ranks.h - `kith bench --ranks N [SCENE]`: what distribution costs, predicted and measured.
 *
 * The scene (default: Sedov, 3-D; sizes by --set resolution=R) runs on 1, 2, 4 .. N ranks of one thread each, as processes of their own. Strong: the
 * same nodes on all; weak: as many nodes a rank as the scene has on N. Each run is made three times, and the least time taken.
 * Predicted is by forecast.h, which runs no ranks: ghosts, bytes, messages, imbalance from the scene alone; seconds from costs of this sitting:
 *   compute = c_w W + c_g G             W nodes and row entries, G ghosts made of the busiest rank
 *   step    = compute + c_l n + c_b B   n nodes of a rank, B bytes that it sends
 * c_w and c_l are measured by the strong run on 1 rank, c_g and c_b by that on 2, as processor time (ranks_detail.h), which other programs hardly disturb and which means
 * the same when ranks outnumber the cores: compute of the busiest rank, the rest of the rank that waits least.
 * Measured are compute, likewise, and the wall time of a step where every rank has a core.
 * Tables go to the screen, and as markdown to DIR/scaling.md (-o DIR, default out/bench-ranks). */
#ifndef KITH_APP_BENCH_RANKS_H
#define KITH_APP_BENCH_RANKS_H

#include "app/options.h"

enum kith_exit kith_bench_ranks(const struct kith_options *options);

#endif
