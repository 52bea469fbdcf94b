/* crk.h - package `crk`: conservative reproducing kernels (Frontiere, Raskin and Owen 2017, JCoPh 332, 160). Private to its folder.
 *
 * Volumes V_i = ball H_i^d / neighbors (density.h), density m_i / V_i: exact where masses jump on an even lattice. With x = x_i - x_j and
 * W the mean of W(|x|, H_i) and W(|x|, H_j), the corrected kernel
 *     W^R_ij = (A_i + C_i . x) W                                                                      (1)
 * interpolates linear functions exactly, sum_j V_j f_j W^R_ij = f_i, i itself included, by the moments
 *     m0 = sum_j V_j W, m1 = sum_j V_j x W, m2 = sum_j V_j x x W:  B = -m2^-1 m1, A = 1 / (m0 + B . m1), C = A B;   (2)
 * and so does its gradient, with those of A and C from the gradients of the moments:
 *     dB = -m2^-1 (dm1 + dm2 B), dA = -A^2 (dm0 + 2 dm1 . B + B . dm2 B), dC = dA B + A dB            (3)
 *     grad W^R_ij = (dA + C + dC . x) W + (A + C . x) grad W                                         (4)
 * A node whose m2 has no inverse keeps A = 1 / m0, C = 0, and is counted as a fallback.
 * Forces are those of the antisymmetric part: they conserve momentum, and not angular momentum, for they are not central.
 *     m_i dv_i/dt = - sum_j (1/2) V_i V_j (P_i + P_j + Q_ij) D,  D = grad W^R_ij - grad W^R_ji       (5)
 *     Q_ij = 2 rho_i rho_j / (rho_i + rho_j) (-alpha c_mean mu + beta mu^2), mu = min(0, jump / |x|), the jump v_ij . x limited as in slope.h (6)
 * The work f . (v_j - v_i) of a pair is shared evenly, but for the pressures: who gains takes of the partner's, as the paper has it, and
 * who pays does so from its own, so that no cold node pays for a hot one. With t the cosine between f and v_j - v_i,
 *     e_ij = 1/2 + t (P_j - P_i) / (2 (P_i + P_j + Q_ij))                                            (7)
 *
 * Passes: density -> equation of state -> ghosts -> moments -> ghosts -> records -> force [pairs] -> ghosts -> work. */
#ifndef KITH_PHYSICS_CRK_CRK_H
#define KITH_PHYSICS_CRK_CRK_H

#include "physics/density.h"
#include "physics/force.h"

/* What a pair reads of a node. */
enum {
  CRK_INVERSE = KITH_RECORD_OWN, /* 1 / H */
  CRK_PRESSURE,
  CRK_DENSITY,
  CRK_SOUND,
  CRK_VOLUME,
  CRK_A,
  CRK_C,
  CRK_DA = CRK_C + NDIM,            /* dA + C */
  CRK_DC = CRK_DA + NDIM,           /* dC_b / dx_c, [b][c] */
  CRK_SHEAR = CRK_DC + NDIM * NDIM, /* symmetric part of the velocity gradient, upper triangle */
  CRK_MEMBERS = CRK_SHEAR + KITH_SYMMETRIC_SIZE
};

struct crk {
  struct kith_field *scale, *slope, *scale_gradient, *slope_gradient; /* A, C, dA + C, dC */
  struct kith_field *shear; /* NULL unless the viscosity is limited */
};

/* V_j W(r, H_j) = volume w(r / H_j): the volume cancels that of the kernel. */
static inline double crk_volume(const struct kith_package *package) {
  return kith_kernel_constant(package->kernel) * kith_ball() / package->neighbors;
}

/* (2), (3) of internal nodes, from positions and supports of all. */
kith_status crk_moments(struct kith_package *package, const struct kith_connectivity *connectivity);

/* Fills the records of all nodes, and sums (5) - (7). */
kith_status crk_pairs(struct kith_package *package, const struct kith_connectivity *connectivity);

#endif
