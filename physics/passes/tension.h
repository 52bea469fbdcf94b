/* tension.h - what is left of a tension between two nodes that are close to each other.
 *
 * Under a negative pressure sums over neighbors draw nodes together in pairs (Swegle, Hicks and Attaway 1995,
 * JCoPh 116, 123). So the negative pressures of a pair are multiplied by
 *     t = max(0, 1 - 7 (1 - s)), s < 1
 * with the distance s in mean node spacings of the denser end: tension fades between nodes that are closer
 * than a spacing, and is gone at 0.86 of it. Forces, and the work that is taken for the heat, are of the same
 * pressures: momentum and energy are conserved. Gas and even lattices never notice.
 *
 * The 7 is chosen by figures: page on methods, Tension. */
#ifndef KITH_PHYSICS_PASSES_TENSION_H
#define KITH_PHYSICS_PASSES_TENSION_H

#include "lib/core/vec.h"

/* Returns min(0, s - 1) of a pair from the larger r / H of both; spacings: H in mean node spacings. */
KITH_INLINE double kith_closer(double spacings, double q) {
  return KITH_MIN(spacings * q - 1, 0.0);
}

/* Returns what is left of a pressure. */
KITH_INLINE double kith_tension(double closer, double pressure) {
  return pressure < 0 ? pressure * KITH_MAX(1 + 7 * closer, 0.0) : pressure;
}

#endif
