/* Block time steps by their length: sums over ticks and ranks. */
#include "integrator/levels.h"

#include <math.h>

void kith_levels_add_tick(struct kith_levels *levels, double part, double seconds) {
  int level = 0;
  while (level < KITH_LEVELS - 1 && part != floor(part)) part *= 2, ++level;
  if (level == 0) levels->whole = levels->level[0].ticks > 0 ? KITH_MIN(levels->whole, seconds) : seconds;
  levels->level[level].ticks += 1, levels->level[level].seconds += seconds;
}

void kith_levels_add_update(struct kith_levels *levels, double part, double dt) {
  struct kith_level *level = &levels->level[KITH_MIN(KITH_MAX(-ilogb(part), 0), KITH_LEVELS - 1)];
  level->updates += 1, level->held += part * dt;
}

struct kith_levels kith_levels_of_all(const struct kith_levels *levels, struct kith_ranks *ranks) {
  struct kith_levels all = *levels;
  double sum[2 * KITH_LEVELS];
  for (int l = 0; l < KITH_LEVELS; ++l) sum[2 * l] = all.level[l].updates, sum[2 * l + 1] = all.level[l].held;
  kith_ranks_sum(ranks, sum, 2 * KITH_LEVELS);
  for (int l = 0; l < KITH_LEVELS; ++l) all.level[l].updates = sum[2 * l], all.level[l].held = sum[2 * l + 1];
  return all;
}

struct kith_level kith_levels_sum(const struct kith_levels *levels) {
  struct kith_level sum = {0};
  for (const struct kith_level *l = levels->level; l < levels->level + KITH_LEVELS; ++l) {
    sum.ticks += l->ticks, sum.seconds += l->seconds;
    sum.updates += l->updates, sum.held += l->held;
  }
  return sum;
}

int kith_levels_used(const struct kith_levels *levels) {
  int n = KITH_LEVELS;
  while (n > 0 && levels->level[n - 1].ticks == 0 && levels->level[n - 1].updates == 0) --n;
  return n;
}

double kith_levels_ideal(const struct kith_levels *all) {
  const struct kith_level sum = kith_levels_sum(all);
  return sum.ticks > 0 ? sum.held / all->time * sum.ticks / sum.updates : NAN;
}

double kith_levels_achieved(const struct kith_levels *all) {
  const struct kith_level sum = kith_levels_sum(all);
  return sum.ticks > 0 ? all->whole * sum.ticks / sum.seconds : NAN;
}
