/* bench.h - `kith bench`: node updates per second, stage by stage, beside reference loops of the same sitting.
 *
 * The case: 3-D Sedov, 100^3 nodes (--set resolution=N), every node each step, double, adaptive supports of 60 neighbors, Wendland C2,
 * monaghan and limited viscosity as the scene has it, 10 steps (--steps N) after the first rates, reordered by curve.
 * Rows of the table: energy thermal, rows rebuilt each step; energy compatible; lists that last, for several skins; each on one thread,
 * the first also on all threads. With --ranks N: bench_ranks.h. Absolute figures hold for one machine and one moment; ratios to the reference loops travel. */
#ifndef KITH_APP_BENCH_H
#define KITH_APP_BENCH_H

#include "app/options.h"

enum kith_exit kith_bench(const struct kith_options *options);

#endif
