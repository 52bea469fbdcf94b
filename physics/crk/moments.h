/* moments.h - the corrected kernel of package `crk`: which factors make interpolation exact for linear fields
 * (Frontiere, Raskin and Owen 2017, JCoPh 332, 160).
 *
 * With x = x_i - x_j, V_j = ball H_j^d / neighbors and W the mean of W(|x|, H_i) and W(|x|, H_j), the
 * corrected kernel
 *     W^R_ij = (A_i + C_i . x) W                                                                      (1)
 * interpolates linear functions exactly, sum_j V_j f_j W^R_ij = f_i with i itself included, for the moments
 *     m0 = sum_j V_j W, m1 = sum_j V_j x W, m2 = sum_j V_j x x W:
 *     B = -m2^-1 m1, A = 1 / (m0 + B . m1), C = A B                                                   (2)
 * and so does its gradient, with the gradients of A and C from those of the moments:
 *     dB = -m2^-1 (dm1 + dm2 B), dA = -A^2 (dm0 + 2 dm1 . B + B . dm2 B), dC = dA B + A dB            (3)
 *     grad W^R_ij = (dA + C + dC . x) W + (A + C . x) grad W                                          (4)
 * A node whose m2 has no inverse keeps A = 1 / m0, C = 0, and is counted as a fallback. */
#ifndef KITH_PHYSICS_CRK_MOMENTS_H
#define KITH_PHYSICS_CRK_MOMENTS_H

#include "physics/package.h"

/* Fields over the nodes: A [], C [NDIM], dA + C [NDIM], dC_b / dx_c [NDIM][NDIM]. */
struct crk_moments {
  struct kith_field *a, *c, *a_gradient, *c_gradient;
};

/* V_j W(r, H_j) = crk_volume w(r / H_j): the volume cancels that of the kernel. */
static inline double crk_volume(const struct kith_package *package) {
  return kith_kernel_constant(package->kernel) * kith_ball() / package->neighbors;
}

/* (2), (3) of internal nodes, from positions and supports of all nodes and ghosts. */
kith_status crk_moments(struct kith_package *package, const struct kith_connectivity *connectivity,
                        const struct crk_moments *moments);

#endif
