/* tension.h - what is left of a tension between two nodes that are close to each other.
 *
 * Under a negative pressure sums over neighbors draw nodes together in pairs (Swegle, Hicks and Attaway 1995,
 * JCoPh 116, 123). So the negative pressures of a pair are multiplied by
 *     t = max(0, 1 - 7 (1 - s)), s < 1
 * with the distance s in mean node spacings of the denser end: tension fades between nodes that are closer
 * than a spacing, and is gone at 0.86 of it. Forces, and the work that is taken for the heat, are of the same
 * pressures: momentum and energy are conserved. Gas and even lattices never notice.
 *
 * Water of density 1 and sound speed 1.5 under a tension of 0.1, nodes shaken by 0.05 spacings, after 4.4
 * sound crossings (rows tension-3d of `kith validate gates`; in 2-D and 1-D with resolution 24 and 64):
 * smallest distance of two nodes in mean spacings, without and with t
 *                      sph          crk          mfm          magma2       remix
 *     1-D              .75 .99      .76 .99      torn .99     .62 .99      .73 .99
 *     2-D squares      .33 .98      .06 .99      torn .99     .13 .98      .15 1.0
 *         triangles    .48 .78      .37 .98      torn .94     .13 .73      .22 .98
 *     3-D cubes        .50 .96      .62 .99      torn .98     .50 .96      .33 1.0
 *         hcp          .21 .64      .58 .96      torn .86     .20 .59      .30 .94
 * (mfm was torn without its rule for S*, too). On triangles and hcp, where neighbors are 1.07 and 1.12
 * spacings apart and come closer before t is less than 1, nodes of sph and magma2 still move. With 5 instead
 * of 7 squares and cubes have .70 to .84 there; with 10 spinning-square.yaml loses five times the angular
 * momentum with crk. */
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
