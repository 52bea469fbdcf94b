/* block_lengths.h - block time steps: how long the base step and the steps of nodes are (block_steps.h).
 * Lengths are in ticks. Functions that take no node are collective, but for kith_blocks_want. */
#ifndef KITH_INTEGRATOR_BLOCK_LENGTHS_H
#define KITH_INTEGRATOR_BLOCK_LENGTHS_H

#include "integrator/integrator.h"
#include "physics/block_steps.h"

struct kith_block_settings {
  int levels;    /* base step / shortest step <= 2^levels when the base step begins */
  double ratio;  /* largest ratio of the steps of neighbors: 2 or 4; infinite: no limit, no wake-ups */
  uint64_t seed; /* not 0: seed of random steps and wake-ups, for tests of conservation */
};

struct kith_blocks {
  struct kith_block_steps steps; /* first member: what packages see */
  struct kith_block_settings settings;
  struct kith_field *wanted; /* step by the node's own limits, in ticks; for an idle node its present step */
  struct kith_field *due;    /* the tick of the next activity */
  struct kith_field *position_base, *support_base, *density_base; /* at the node's last activity */
  double *soonest; /* [n / KITH_STRETCH, rounded up]: least `due` of each stretch of nodes */
  size_t soonest_capacity;
  bool even;   /* masses are so even that no node may throw another; false: they are not, or not yet known */
  bool swings; /* with this package light nodes beside heavy ones swing (sph.c) */
  /* For local ticks. `supports` is a box that holds the supports of all nodes. Until the next tick that is
   * not local nodes move at most by `slack`, less the growth of their search radii. `candidates` is the
   * number of candidates per neighbor at the last tick that was not local; `wasted` counts those beyond it
   * since then, as nodes have moved. */
  struct kith_box supports;
  double slack, candidates, wasted;
};

/* Borrowed; only valid for a scheme with block time steps. */
static inline struct kith_blocks *kith_blocks_of(const struct kith_integrator *it) {
  return it->self;
}

/* Plans the next base step, from `time` on, so that it lands on the next output; if that is reached, on one
 * as far away again. `factor` multiplies the limits of the nodes. */
void kith_blocks_plan(struct kith_integrator *it, double time, double factor);
/* Shortens the planned base step if a node would begin it with a step of more than `ratio` times what its
 * rates now allow (block_steps.h). */
void kith_blocks_shorten(struct kith_integrator *it);
/* Sets the steps that active nodes want at a tick inside of a base step. */
void kith_blocks_want(struct kith_integrator *it);
/* Limits the next step of active nodes by their neighbors: at most `ratio` times what any of them wants, and
 * no longer than until a heavy one pushes. */
void kith_blocks_limit_by_neighbors(struct kith_integrator *it);
/* Do all nodes of all ranks have the same last activity, step and next step? Then all pairs have the same
 * weight. Frozen nodes do not matter. */
bool kith_blocks_alike(const struct kith_integrator *it);
/* Wakes node i sooner if its step is longer than its rates now allow. */
void kith_blocks_wake_by_limit(struct kith_integrator *it, kith_index i);
/* Wakes node i sooner, after an evaluation, by its own limit or if its step is too long beside those of
 * active neighbors. */
void kith_blocks_wake(struct kith_integrator *it, kith_index i);

#endif
