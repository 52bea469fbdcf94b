/* map.h - values of nodes on the pixels of a plane.
 *
 *   q(pixel) = sum_i V_i W_i q_i / sum_i V_i W_i,   W = (1 - r^2 / R^2)^3,   R = 2 V^(1/NDIM),
 *
 * V = mass / density, r from the middle of the pixel, in the plane; in a slice of a 3-D scene in space. It is
 * no sum of SPH: a value is not smoothed over more than the nodes beside it. */
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

/* The map of the plane across axis `normal`, at a position (NaN: all nodes, along the line of sight), as far
 * as there are nodes. Not for 1-D. */
struct kith_map kith_map_of(const struct kith_profile_view *nodes, int normal, double at);
/* Draws `of` of the nodes into value[pixels[1]][pixels[0]], NaN where there is none. NO_MEMORY. */
kith_status kith_map_draw(const struct kith_map *map, const struct kith_profile_view *nodes, const double *of,
                          float *value);

#endif
