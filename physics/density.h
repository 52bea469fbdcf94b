/* density.h - the first pass of every package: supports, density, gradients of the velocity.
 *
 * Number density n_i = sum_j W(r_ij, H_i), self included (with its weight: kernel.h); the support solves
 *     ball H_i^d n_i = neighbors                                                          (1)
 * by Newton's method in ln H inside a bracket. So supports follow the nodes and not their masses, and the volume of a node is
 * V_i = 1 / n_i = ball H_i^d / neighbors.
 * Density rho_i = m_i n_i, or the sum of masses, sum_j m_j W(r_ij, H_i), if its dependence on H is asked for too:
 *     X_i = H_i / (d n_i Omega_i) drho_i/dH_i,  Omega_i = 1 + H_i / (d n_i) dn_i/dH_i      (2)
 * G_ab = dv_a/dx_b = [sum_j w dv_a dx_c] [sum_j w dx dx]^-1_cb, w = -g(q) (kernel.h): exact for linear fields on any nodes. */
#ifndef KITH_PHYSICS_DENSITY_H
#define KITH_PHYSICS_DENSITY_H

#include "physics/package.h"

enum { KITH_SYMMETRIC_SIZE = NDIM * (NDIM + 1) / 2 };

/* What is wanted beside support, density and expansion (div v); NULL: not. Fields over the nodes, filled for internal nodes,
 * and if the package recomputes for the remote ghosts that they look at. */
struct kith_density_wanted {
  struct kith_field *excess;   /* X; and the density is the sum of masses */
  struct kith_field *shear;    /* symmetric part of G, upper triangle */
  struct kith_field *gradient; /* G, [a][b] */
  struct kith_field *curl;     /* |curl v|; 0 in 1-D */
  struct kith_field
      *compression; /* d(div v)/dt = div a - G_ab G_ba, from the accelerations of the last evaluation */
};

/* Collective: all ranks agree on the status. REACH if a support outgrew its reach: supports are set to what they want at least. DIVERGED names the first node whose support
 * does not converge. Counts pair evaluations, iterations and fallbacks (nodes whose gradient has no inverse: zero) in the package. */
kith_status kith_density(struct kith_package *package, const struct kith_connectivity *connectivity,
                         const struct kith_density_wanted *wanted);

/* Inverse of a symmetric positive matrix (upper triangle), false if it is close to singular. */
KITH_INLINE bool kith_invert_symmetric(const double *m, double *inverse) {
#if NDIM == 1
  if (!(m[0] > 0)) return false;
  inverse[0] = 1 / m[0];
  return true;
#elif NDIM == 2
  const double det = m[0] * m[2] - m[1] * m[1], trace = m[0] + m[2];
  if (!(det > 1e-6 * trace * trace)) return false;
  inverse[0] = m[2] / det, inverse[1] = -m[1] / det, inverse[2] = m[0] / det;
  return true;
#else
  const double c0 = m[3] * m[5] - m[4] * m[4], c1 = m[2] * m[4] - m[1] * m[5], c2 = m[1] * m[4] - m[2] * m[3];
  const double det = m[0] * c0 + m[1] * c1 + m[2] * c2, trace = m[0] + m[3] + m[5];
  if (!(det > 1e-6 * trace * trace * trace)) return false;
  inverse[0] = c0 / det, inverse[1] = c1 / det, inverse[2] = c2 / det;
  inverse[3] = (m[0] * m[5] - m[2] * m[2]) / det, inverse[4] = (m[1] * m[2] - m[0] * m[4]) / det;
  inverse[5] = (m[0] * m[3] - m[1] * m[1]) / det;
  return true;
#endif
}

#endif
