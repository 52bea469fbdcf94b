/* intersection.h - the common neighbors of each pair, and both ends; optionally only those whose closest
 * point on the segment from i to j lies strictly between the ends. One row for each pair, ascending. */
#ifndef KITH_CONNECTIVITY_INTERSECTION_H
#define KITH_CONNECTIVITY_INTERSECTION_H

#include "lib/connectivity/pairs.h"

/* UNSUPPORTED beyond 2^31 pairs. */
kith_status kith_intersection_build(struct kith_rows *intersection, const struct kith_rows *rows,
                                    const struct kith_pairs *pairs, bool on_segment,
                                    const struct kith_build *build);

#endif
