/* block_lengths.h - block time steps: how long the base step and the steps of nodes are (block_steps.h).
 * Lengths are ticks. Functions without a node are collective. */
#ifndef KITH_INTEGRATOR_BLOCK_LENGTHS_H
#define KITH_INTEGRATOR_BLOCK_LENGTHS_H

#include "integrator/integrator.h"
#include "physics/block_steps.h"

struct kith_block_settings {
  int levels;    /* base step / shortest step <= 2^levels when it begins */
  double ratio;  /* of the steps of neighbors, at most: 2 or 4; infinite: no limit, no wake-ups */
  uint64_t seed; /* not 0: steps and wake-ups are chosen at random, for tests of conservation */
};

struct kith_blocks {
  struct kith_block_steps steps; /* what packages see: first */
  struct kith_block_settings settings;
  struct kith_field *wanted; /* ticks: by the node's own limits; d if it is not active */
  struct kith_field *due;    /* the tick of the next activity */
  struct kith_field *position_base, *support_base, *density_base; /* at the last activity */
  double *soonest; /* [n / KITH_STRETCH, rounded up]: the least `due` of each stretch of nodes */
  size_t soonest_capacity;
  double planned; /* length of the next base step */
  bool even;      /* no node is heavy for another; false: one is, or it is not known yet */
  bool swings;    /* light nodes beside heavy ones do, with this package */
  /* For ticks that are local. The supports of all nodes lie in a box, and nodes do not move farther than
   * `slack`, less what their search radii grow, until they are taken in again. Candidates for each neighbor
   * when all nodes were, and how many more there have been since, because nodes have moved. */
  struct kith_box supports;
  double slack, candidates, wasted;
};

/* View. */
static inline struct kith_blocks *kith_blocks_of(const struct kith_integrator *it) {
  return it->self;
}

/* The next base step, from `time` on: it lands on the next output, after that on one as far away again. */
void kith_blocks_plan(struct kith_integrator *it, double time, double factor);
/* The steps that active nodes want at tick n, inside of a base step. */
void kith_blocks_want(struct kith_integrator *it);
/* By the neighbors: at most `ratio` times what any of them wants, and no longer than until a heavy one
 * pushes. */
void kith_blocks_limit_by_neighbors(struct kith_integrator *it);
/* Have all nodes of all ranks the same steps? Then all pairs have the same weight. Frozen ones have any. */
bool kith_blocks_alike(const struct kith_integrator *it);
/* A step that is longer than the rates of node i now allow is cut short. */
void kith_blocks_wake_by_limit(struct kith_integrator *it, kith_index i);
/* The same after an evaluation, and for what the steps of active neighbors do. */
void kith_blocks_wake(struct kith_integrator *it, kith_index i);

#endif
