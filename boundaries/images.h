/* images.h - ghosts across one axis: what periodic and reflecting boundaries share. Internal to this room.
 *
 * `image_of` tells the image n = -1, 1, -2, 2, ... of a boundary (x -> sign * x + shift); false: there is
 * none. Images n > 0 lie beyond the upper face, n < 0 beyond the lower one, two images farther is 2 L
 * farther.
 *
 * Nodes may have left the box: their depth is negative, and the first condition of boundary.h becomes
 *   d <= f R_ghost + (how far internal nodes stick out of that face),
 * so that whatever is within the reach of an internal node is there. All limits are widened by
 * 1e-12 of the coordinates, as lattices put nodes at exactly the reach.
 *
 * Cost: one threaded sweep over all nodes per image that anyone may need. Ghosts of an image and list are in
 * the order of their controls. DIVERGED if a position or reach is not finite, or if more than
 * KITH_MOST_IMAGES images to a side were needed. */
#ifndef KITH_BOUNDARIES_IMAGES_H
#define KITH_BOUNDARIES_IMAGES_H

#include "boundaries/boundary.h"

enum { KITH_MOST_IMAGES = 1000 };

kith_status kith_images_ghosts(const struct kith_boundary *boundary, struct kith_nodes *nodes,
                               double reach_factor,
                               bool (*image_of)(const struct kith_boundary *boundary, int n, double *sign,
                                                double *shift));

/* DIVERGED, naming internal node i and its coordinate. */
kith_status kith_images_lost(const struct kith_boundary *boundary, const struct kith_nodes *nodes,
                             kith_index i);

#endif
