/* bench_ranks.h - `kith bench --ranks N [SCENE]`: what ranks cost, predicted and measured.
 *
 * The scene (default: Sedov, 3-D; sizes by --set resolution=R) runs on 1, 2, 4 .. N ranks of one thread
 * each, as processes of their own; the least time of three runs is taken. Strong scaling: the same nodes on
 * all; weak: as many nodes per rank as the scene has on N. The scaling model (app/plan/forecast.h) predicts
 * ghosts, bytes, messages and imbalance from the scene alone, and seconds with costs of this session:
 *   compute = c_w W + c_g G             W nodes and row entries, G remote ghosts created, of the busiest rank
 *   step    = compute + c_l n + c_b B   n nodes of a rank, B bytes that it sends
 * c_w and c_l are measured by the strong run on 1 rank, c_g and c_b by that on 2, as processor time
 * (ranks_detail.h): other programs hardly disturb it, and it means the same when ranks outnumber the cores.
 * Measured are compute, likewise, and the wall time of a step where every rank has a core. Tables go to the
 * screen, and as markdown to DIR/scaling.md (-o DIR, default out/bench-ranks). */
#ifndef KITH_APP_BENCH_BENCH_RANKS_H
#define KITH_APP_BENCH_BENCH_RANKS_H

#include "app/cli/options.h"

enum kith_exit kith_bench_ranks(const struct kith_options *options);

#endif
