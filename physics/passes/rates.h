/* rates.h - what a node gets from its pairs: sums of the force pass become rates of velocity and energy, and
 * with block steps impulses, to which external forces are added. */
#ifndef KITH_PHYSICS_PASSES_RATES_H
#define KITH_PHYSICS_PASSES_RATES_H

#include "physics/package.h"

/* The sums over the pairs of a node. */
struct kith_pair_sums {
  double force[NDIM], heat, signal;
  double impulse[NDIM + 1], opening[NDIM + 1]; /* with block steps: force, then heat */
  double outside[NDIM + 1];                    /* by what is no gas: force, then power */
  double outside_opening[NDIM + 1];            /* with block steps: the opening part of that */
};

/* Where the sums of a package go, and how. */
struct kith_rates {
  struct kith_package *package;
  const struct kith_kick *kick;
  bool adds;    /* of an added package: its rates are added to those of the packages before */
  bool is_last; /* last package to evaluate: it completes what (1) of package.h needs */
};
struct kith_rates kith_rates_of(struct kith_package *package, const struct kith_kick *kick);

/* Stores the rates of node i: acceleration (with the external force), heating, the signal speed, and what (1)
 * of package.h needs. With block steps also the impulses, by (1) and (2) of block_steps.h; if all pairs have
 * the same weight, `sums` get it here. */
void kith_rates_store(const struct kith_rates *rates, kith_index i, struct kith_pair_sums *sums);

#endif
