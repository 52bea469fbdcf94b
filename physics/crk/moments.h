/* moments.h - kernels that are corrected so that they reproduce linear functions, and their gradients: what
 * crk and remix share.
 *
 * With x = x_i - x_j, V = m / rho and W the mean of W(|x|, H_i) and W(|x|, H_j), the corrected kernel
 *     W^R_ij = (A_i + C_i . x) W                                                                      (1)
 * interpolates linear functions exactly, sum_j V_j f_j W^R_ij = f_i with i itself included, for the moments
 *     m0 = sum_j V_j W, m1 = sum_j V_j x W, m2 = sum_j V_j x x W:
 *     B = -m2^-1 m1, A = 1 / (m0 + B . m1), C = A B                                                   (2)
 * and so does its gradient, with the gradients of A and C from those of the moments:
 *     dB = -m2^-1 (dm1 + dm2 B), dA = -A^2 (dm0 + 2 dm1 . B + B . dm2 B), dC = dA B + A dB            (3)
 *     grad W^R_ij = (dA + C + dC . x) W + (A + C . x) grad W                                          (4)
 * m2^-1 as in kith_invert_moments: where neighbors lie almost in a line or a plane, it would grow beyond all
 * bounds, and so would displacements across it: gas that leaves a wall got negative energies, whatever the
 * time step. Kernel and gradient are not exact at such nodes. A node without neighbors has A = 1 / m0, C = 0,
 * and is counted as a fallback. */
#ifndef KITH_PHYSICS_CRK_MOMENTS_H
#define KITH_PHYSICS_CRK_MOMENTS_H

#include "physics/passes/density.h"
#include "physics/passes/viscosity.h"

struct crk_moments {
  struct kith_field *omega; /* of density.h: filled by the density pass before */
  /* Filled for internal nodes. A, C, dA + C, dC_b / dx_c: */
  struct kith_field *a, *c, *a_gradient, *c_gradient;
  struct kith_field *change;     /* of the spacing from node to node, |grad ln H| */
  struct kith_field *kernel_sum; /* m0 with the self weight, below 1 at a surface; NULL: not wanted */
  /* The gradient [sum_j V_j g x x]^-1 sum_j V_j g x (f_i - f_j) of a scalar f, where grad W = g x: exact if f
   * is linear. A barrier has the value of i. NULL: not wanted */
  struct kith_field *value, *slope;
};

/* Registers the fields, but for `kernel_sum`, `value` and `slope`. */
kith_status kith_crk_moments_init(struct crk_moments *moments, struct kith_nodes *nodes);

/* Fills the fields of internal nodes from positions, supports, densities and `value` of all nodes and ghosts.
 * Collective. */
kith_status kith_crk_moments_evaluate(struct kith_package *package, const struct crk_moments *moments,
                                      const struct kith_connectivity *connectivity);

/* Fields of a packed particle, which begin where its package puts them. */
enum {
  CRK_A,
  CRK_C,
  CRK_DA = CRK_C + NDIM,  /* dA + C */
  CRK_DC = CRK_DA + NDIM, /* dC_b / dx_c, [b][c] */
  CRK_COEFFICIENTS = CRK_DC + NDIM * NDIM
};
static inline void kith_crk_moments_pack(const struct crk_moments *moments, kith_index i,
                                         double *restrict packed) {
  const size_t at = (size_t)i * NDIM;
  for (int a = 0; a < NDIM; ++a) {
    packed[CRK_C + a] = moments->c->f64[at + a];
    packed[CRK_DA + a] = moments->a_gradient->f64[at + a];
    for (int b = 0; b < NDIM; ++b)
      packed[CRK_DC + a * NDIM + b] = moments->c_gradient->f64[(at + a) * NDIM + b];
  }
  /* A node without moments has the plain kernel. A frozen one gets those of its partner (force.h). */
  packed[CRK_A] = moments->a->f64[i] == 0 ? 1 : moments->a->f64[i];
}

/* Returns g . x; entries of g are `stride` apart. */
KITH_INLINE double crk_dot(const double *restrict g, int stride, const struct kith_viscous_pair *p) {
  return NDIM == 1   ? g[0] * p->x
         : NDIM == 2 ? g[0] * p->x + g[stride] * p->y
                     : g[0] * p->x + g[stride] * p->y + g[2 * stride] * p->z;
}

/* Computes d = grad W^R_ij - grad W^R_ji by (4), for W = w, grad W = g x; i and j: the coefficients. */
KITH_INLINE void crk_gradient(const struct kith_viscous_pair *p, double w, double g, const double *restrict i,
                              const double *restrict j, double *restrict d) {
  const double x[3] = {p->x, p->y, p->z};
  const double ai = i[CRK_A] + crk_dot(i + CRK_C, 1, p), aj = J(CRK_A) - crk_dot(&J(CRK_C), KITH_STRIDE, p);
  for (int a = 0; a < NDIM; ++a) {
    const double ci = i[CRK_DA + a] + crk_dot(i + CRK_DC + a, NDIM, p),
                 cj = J(CRK_DA + a) - crk_dot(&J(CRK_DC + a), NDIM * KITH_STRIDE, p);
    d[a] = (ai + aj) * g * x[a] + (ci - cj) * w;
  }
}

#endif
