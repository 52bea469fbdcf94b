/* images.h - ghosts across one axis: what boundaries with images share. Private to this folder.
 *
 * Images n > 0 lie beyond the upper face, n < 0 beyond the lower one; n and n + 2 are 2 L apart.
 *
 * Nodes may have left the box; their depth is negative, and the first condition of boundary.h becomes
 *   d <= f R_ghost + (largest distance of an internal node outside of that face),
 * so that everything within the search radius of an internal node is there. All limits are widened by 1e-12
 * of the coordinates, since lattices have nodes at exactly the search radius.
 *
 * Cost: one threaded pass over the nodes to measure them, and one for each image that any node may need.
 * Ghosts of an image and list are in the order of their controls.
 * DIVERGED if a position or search radius is not finite, or if more than KITH_MOST_IMAGES images on a side
 * were needed. */
#ifndef KITH_BOUNDARIES_IMAGES_H
#define KITH_BOUNDARIES_IMAGES_H

#include "boundaries/boundary.h"

enum { KITH_MOST_IMAGES = 1000 };

/* `measure`, `ghosts` and `enforce` of boundary.h, implemented with `image_of` and `put_back`. DIVERGED also
 * if the faces leave no room for nodes. */
void kith_images_measure(struct kith_boundary *boundary, const struct kith_nodes *nodes,
                         double radius_factor);
kith_status kith_images_ghosts(struct kith_boundary *boundary, struct kith_nodes *nodes,
                               double radius_factor);
/* For boundaries that wrap: their images as shifts (lib/nodes/shifts.h) instead of ghosts. */
void kith_images_measure_shifts(struct kith_boundary *boundary, const struct kith_nodes *nodes,
                                double radius_factor);
kith_status kith_images_shifts(struct kith_boundary *boundary, struct kith_nodes *nodes,
                               double radius_factor);
kith_status kith_images_enforce(struct kith_boundary *boundary, struct kith_nodes *nodes);
/* Adds a block of ghosts that are image n along the axis, and counts n in their image numbers (nodes.h). */
kith_status kith_images_add(struct kith_nodes *nodes, const struct kith_ghost_block *block, int axis, int n);

#define KITH_IMAGES                                                                             \
  .measure = kith_images_measure, .ghosts = kith_images_ghosts, .enforce = kith_images_enforce, \
  .image_of = image_of, .put_back = put_back

#endif
