/* map.h - values of nodes on the pixels of a plane.
 *
 *   q(pixel) = sum_i V_i W_i q_i / sum_i V_i W_i,   W = (1 - r^2 / R^2)^3,   R = 2 V^(1/NDIM),
 *
 * where V = mass / density, and r is the distance of the node from the middle of the pixel: in the plane,
 * or, in a slice of a 3-D scene, in space. R is at least three quarters of a pixel. W is narrower than a
 * kernel of SPH, so that a value is smoothed over no more than the nodes beside the pixel. */
#ifndef KITH_APP_OUTPUT_PICTURES_MAP_H
#define KITH_APP_OUTPUT_PICTURES_MAP_H

#include "validation/norms.h"

struct kith_map {
  int across[2]; /* axes to the right and upwards */
  int normal; /* axis across which a slice is cut at `at`; -1: all nodes count (2-D; or the line of sight) */
  double at;
  double lower[2], size[2]; /* lower corner; sides of a pixel */
  int pixels[2];
};

/* Lays out the map of the plane across axis `normal` at the coordinate `at`, as large as the nodes of all
 * ranks extend. If `at` is NaN, all nodes along the line of sight count. Collective; not for 1-D. */
struct kith_map kith_map_of(const struct kith_profile_view *nodes, int normal, double at);
/* Draws the values of[i] of nodes into value[pixels[1]][pixels[0]], NaN where no node is near. Collective.
 * NO_MEMORY. */
kith_status kith_map_draw(const struct kith_map *map, const struct kith_profile_view *nodes, const double *of,
                          float *value);

#endif
