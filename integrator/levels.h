/* levels.h - block time steps by their length: what the levels of a run took, and what they saved.
 *
 * Level l is steps of the base step over 2^l. A tick belongs to the level of the longest step that ends
 * there if none was cut short: to level 0 at the end of a base step, where all nodes are active. Were all
 * nodes active at each tick, there would be
 *   ideal     N ticks / updates times as many updates, with N nodes, and it would take
 *   achieved  ticks times the least seconds of a tick of level 0, over the seconds of all ticks, as long.
 * A run with a global step has fewer steps than there are ticks, as its steps need not be powers of two, and
 * a step costs less than a tick with all nodes, since a pair acts on both ends for the same time. */
#ifndef KITH_INTEGRATOR_LEVELS_H
#define KITH_INTEGRATOR_LEVELS_H

#include "lib/comm/ranks.h"

enum { KITH_LEVELS = 21 }; /* the shortest step is the base step over 2^20, one of its KITH_TICKS */

/* Sums over the base steps of this process. On all ranks but for `updates` and `held`, which are of this
 * rank's nodes. Only doubles; zeros without block time steps. */
struct kith_levels {
  double time; /* length of all base steps */
  double base_steps;
  double whole; /* least seconds of a tick of level 0 */
  struct kith_level {
    double ticks, seconds; /* of ticks of this level */
    double updates;        /* of nodes whose step that ended was of this level, or cut short to it */
    double held;           /* length of all these steps: over `time` the mean number of nodes on this level */
  } level[KITH_LEVELS];
};

/* Adds a tick after this part of the base step, a fraction with a power of two below. */
void kith_levels_add_tick(struct kith_levels *levels, double part, double seconds);
/* Adds a step of a node that took this part of a base step of length dt. */
void kith_levels_add_update(struct kith_levels *levels, double part, double dt);
/* Sums updates and held over ranks. Collective. */
struct kith_levels kith_levels_of_all(const struct kith_levels *levels, struct kith_ranks *ranks);
/* The sum over all levels; its held / time is the number of nodes. */
struct kith_level kith_levels_sum(const struct kith_levels *levels);
/* The number of levels up to the last one that has a tick or an update. */
int kith_levels_used(const struct kith_levels *levels);
/* Of kith_levels_of_all; NaN if there were no ticks. */
double kith_levels_ideal(const struct kith_levels *all);
double kith_levels_achieved(const struct kith_levels *all);

#endif
