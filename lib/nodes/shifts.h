/* shifts.h - periodic images that are no ghosts: a displacement by whole lengths of the box.
 *
 * Whoever refers to a node, such as an entry of a row, may refer to one of its images: shift s means the node
 * at x + by[s]. Shifts are numbered: all combinations of -most .. most lengths along each axis, the first
 * axis fastest, so that s + t - zero is the sum of two (while it is within the limits) and 2 zero - s the
 * opposite of s. */
#ifndef KITH_NODES_SHIFTS_H
#define KITH_NODES_SHIFTS_H

#include "lib/core/base.h"

struct kith_shifts {
  bool wanted;         /* periodic boundaries may use shifts; if not, they make ghosts */
  int n, zero;         /* how many shifts; the number of the zero shift. Without a periodic axis 1 and 0 */
  int most[NDIM];      /* images -most .. most along an axis */
  double length[NDIM]; /* of the box along an axis; 0: no image */
  double (*by)[NDIM];  /* [n] the displacement; not to be read if n is 1 */
  int64_t *image;      /* [n] the number of the image (nodes.h); not to be read if n is 1 */
  size_t by_capacity, image_capacity;
};

enum { KITH_MOST_SHIFTS = 1 << 16 }; /* an entry has 16 bits for it */

/* Adds images -most .. most along an axis. DIVERGED if these are more than KITH_MOST_SHIFTS together. */
kith_status kith_shifts_add(struct kith_shifts *shifts, int axis, int most, double length);
/* Drops all shifts but the zero one; the memory is kept. */
void kith_shifts_drop(struct kith_shifts *shifts);
void kith_shifts_clear(struct kith_shifts *shifts);
size_t kith_shifts_bytes(const struct kith_shifts *shifts);

#endif
