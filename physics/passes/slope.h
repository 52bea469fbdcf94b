/* slope.h - the pass for moments of the neighbors, and for the gradient of a scalar that is known after the
 * density pass, as the pressure.
 *
 * Both ends of a pair weigh it alike, by the mean of their supports:
 *     M_i = sum_j w_ij dx dx,  slope_i = M_i^-1 sum_j w_ij dx (f_j - f_i),  dx = x_j - x_i             (1)
 *     w_ij = w(r_ij / H_ij) / H_ij^2,  H_ij = (H_i + H_j) / 2,  w(q) = -W'(q) / q, in 1-D W(q)
 * with M^-1 of kith_invert_moments. The slope is exact for linear functions on any nodes but those at a
 * surface. A barrier has the support and the value of i, and one of volume V counts as V / V_i nodes.
 *
 * Usually M_i has the weights w(r_ij / H_i). Either way the faces A_ij = w_ij (V_i M_i^-1 + V_j M_j^-1) dx
 * close to first order in the change of the spacing. But where it changes by half or more from node to node,
 * in the center of a blast or behind a rarefaction, all faces between two layers of nodes together have 0.5
 * to 1.5 of the area of the plane between the layers, and pressures are wrong by the inverse; with H_ij, of
 * the same nodes, they have 0.8 to 1.1 (Sedov's plane blast, 200 nodes). Errors of mfm became smaller: by a
 * tenth in Sedov's blast, a third in Sod's tube, two fifths in Noh's problem, three quarters in Kidder's
 * capsule. With w or w / H_ij instead of w / H_ij^2, which makes M_i a sum over separations in units of the
 * support, blasts and waves gain more, tubes less, and contacts where the spacing jumps have larger errors;
 * with w, jumps of 30 : 1 stop.
 *
 * With W in place of -W' / q in 2-D and 3-D, the force of an even pressure, -P sum_j A_ij, is not the
 * gradient of any energy: shears of a lattice grow from round-off, whatever the lattice is, and drive the
 * nodes for ever. With -W' / q the faces are those of SPH with a matrix in place of a constant, so to first
 * order the force is the gradient of a kernel sum, as in SPH. It orders nodes and is 0 on the lattices on
 * which that sum is largest (`kith plan` names them); other lattices give way, and then come to rest. On a
 * line nothing shears, and W has the smaller error, by a third at contacts. */
#ifndef KITH_PHYSICS_PASSES_SLOPE_H
#define KITH_PHYSICS_PASSES_SLOPE_H

#include "lib/core/symmetric.h"
#include "physics/passes/sweep.h"

/* Returns w_ij at a distance r; inverse: 1 / H_ij. */
KITH_INLINE double kith_pair_weight(enum kith_kernel kernel, double r, double inverse) {
  double w, g;
  kith_kernel_value(kernel, r * inverse, &w, &g);
  return inverse * inverse * (NDIM == 1 ? w : -g);
}

/* Fills `matrix`, V M^-1 (upper triangle), and `slope` (vector) of internal nodes, of these what is not NULL,
 * from the supports and `value` of all nodes and ghosts. Nodes without neighbors get zeros, and are counted
 * as fallbacks. Collective. */
kith_status kith_slope(struct kith_package *package, const struct kith_connectivity *connectivity,
                       const struct kith_field *value, struct kith_field *matrix, struct kith_field *slope);

#endif
