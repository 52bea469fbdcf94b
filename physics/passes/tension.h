/* tension.h - what is left of a tension between two nodes that are close to each other.
 *
 * Under a negative pressure sums over neighbors draw nodes together in pairs (Swegle, Hicks and Attaway 1995,
 * JCoPh 116, 123). So the negative pressures of a pair are multiplied by
 *     t = max(0, 1 - 7 (1 - s)), s < 1
 * with the distance s in mean node spacings of the denser end: tension fades between nodes that are closer
 * than a spacing, and is gone at 0.86 of it. Forces, and the work that is taken for the heat, are of the same
 * pressures: momentum and energy are conserved. Gas and even lattices never notice.
 *
 * Water of density 1 and sound speed 1.6 under a tension of 0.1, nodes shaken by 0.05 spacings, after five
 * sound crossings: smallest distance of two nodes in mean spacings, without and with t
 *                      sph          crk          mfm          magma2       remix
 *     1-D              .75 .99      .74 .99      torn .99     .71 .99      .74 .99
 *     2-D squares      .48 .97      .28 .99      torn .99     .31 .98      .29 .99
 *         triangles    .46 .71      .35 .98      torn .94     .30 .59      .33 .98
 *     3-D cubes        .44 .96      .61 .99      torn .97     .45 .96      .30 .99
 *         hcp          .38 .56      .58 .97      torn .84     .45 .56      .31 .95
 * On triangles and hcp, where neighbors are 1.07 and 1.12 spacings apart and come closer before t is less
 * than 1, nodes of sph and magma2 still move. With 5 instead of 7 squares and cubes have .70 to .84 there;
 * with 10 spinning-square.yaml loses five times the angular momentum with crk. */
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
