/* probes.h - fields at points that are no nodes, into DIR/probes.h5 (series.h) while a run goes on.
 *
 * At a point x, value f and gradient g of each field are those of the least squares
 *     sum_j V_j W(|x_j - x|, H_j) (f_j - f - g . (x_j - x))^2 = min                                (1)
 * over the nodes j in whose support x lies: interpolation with linearly corrected kernels (the CRK of
 * Frontiere, Raskin and Owen 2017 with the gradient as a second unknown), exact for linear fields. Where
 * there are too few nodes for a gradient, or these lie on a line or in a plane, the value is
 * sum V W f / sum V W and the gradient NaN; beyond all supports, and behind the face of a piston, both are.
 *
 * Points are targets and nodes are sources of a neighbor list (list.h). Nodes have no images here, points
 * have: the image of a point sees the nodes as the point sees their images, so that no ghost is needed, which
 * may have been culled. Frozen nodes count, barriers do not. All sums are exact: samples are bitwise
 * identical for any number of threads, and of ranks if the nodes are. */
#ifndef KITH_APP_OUTPUT_PROBES_H
#define KITH_APP_OUTPUT_PROBES_H

#include "app/simulation/simulation.h"

struct kith_probes; /* opaque; NULL: a scene without probes, which all functions accept */

/* Opens the file; a restarted run continues the one that is there, if there is one. */
kith_status kith_probes_create(struct kith_probes **out, struct kith_simulation *simulation,
                               const char *directory, bool restarted);
/* Samples the probes whose turn it is; `last`: all that were not sampled at this step. Collective. */
kith_status kith_probes_sample(struct kith_probes *probes, bool last);
/* Makes DIR/probes.h5 what was sampled: samples go to DIR/probes.h5.partial, so that a crash leaves the file
 * as it was published last, and so does a failure. */
kith_status kith_probes_publish(struct kith_probes *probes);
/* Publishes what was sampled, if anything was, and frees all. */
kith_status kith_probes_destroy(struct kith_probes **probes);

#endif
