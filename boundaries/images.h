/* images.h - ghosts across one axis: what periodic and reflecting boundaries share. Internal to this room.
 *
 * `image_of` gives image n = -1, 1, -2, 2, ... of a boundary (x -> sign * x + shift); false: there is none.
 * Images n > 0 lie beyond the upper face, n < 0 beyond the lower one, two images farther is 2 L farther.
 *
 * Nodes may have left the box; their depth is negative, and the first condition of boundary.h becomes
 *   d <= f R_ghost + (largest distance of an internal node outside of that face),
 * so that everything within the search radius of an internal node is there. All limits are widened by 1e-12
 * of the coordinates, since lattices have nodes at exactly the search radius.
 *
 * Cost: one threaded pass over all nodes per image that any node may need. Ghosts of an image and list are in
 * the order of their controls. DIVERGED if a position or search radius is not finite, or if more than
 * KITH_MOST_IMAGES images on a side were needed. */
#ifndef KITH_BOUNDARIES_IMAGES_H
#define KITH_BOUNDARIES_IMAGES_H

#include "boundaries/boundary.h"

enum { KITH_MOST_IMAGES = 1000 };

kith_status kith_images_ghosts(const struct kith_boundary *boundary, struct kith_nodes *nodes,
                               double radius_factor,
                               bool (*image_of)(const struct kith_boundary *boundary, int n, double *sign,
                                                double *shift));

/* `violated` and `enforce` of boundary.h for members with faces. put_back moves internal node i, which
 * is outside. DIVERGED also if the faces leave no room for nodes. */
typedef void kith_put_back(const struct kith_boundary *boundary, struct kith_nodes *nodes, kith_index i,
                           double *moved_by);
bool kith_images_violated(const struct kith_boundary *boundary, const struct kith_nodes *nodes);
kith_status kith_images_enforce(const struct kith_boundary *boundary, struct kith_nodes *nodes,
                                kith_put_back *put_back, double *moved_by);

#endif
