/* density.h - the first pass of every package: supports, density, gradients of the velocity.
 *
 * Number density n_i = sum_j W(r_ij, H_i), self included (with its weight: kernel.h); the support solves
 *     ball H_i^d n_i = neighbors                                                          (1)
 * by Newton's method in ln H inside a bracket. So supports follow the nodes and not their masses, and the
 * volume of a node is V_i = 1 / n_i = ball H_i^d / neighbors.
 * Density rho_i = m_i n_i, or the sum of masses, sum_j m_j W(r_ij, H_i), if its dependence on H is required
 * too:
 *     X_i = H_i / (d n_i Omega_i) drho_i/dH_i,  Omega_i = 1 + H_i / (d n_i) dn_i/dH_i      (2)
 * G_ab = dv_a/dx_b = [sum_j w dv_a dx_c] [sum_j w dx dx]^-1_cb, w = -g(q) (kernel.h): exact for linear fields
 * on any nodes. */
#ifndef KITH_PHYSICS_PASSES_DENSITY_H
#define KITH_PHYSICS_PASSES_DENSITY_H

#include <math.h>
#include "lib/core/symmetric.h"
#include "physics/passes/sweep.h"

/* What is computed besides support, density and velocity divergence; NULL: it is not. Fields are filled for
 * internal nodes, and if the package recomputes for the remote ghosts that they read. */
struct kith_density_wanted {
  struct kith_field *grad_h_term; /* X; the density is then the sum of masses */
  bool own_masses;                /* with X, but rho = m n, and X as if all masses were that of i */
  struct kith_field *omega;       /* Omega */
  struct kith_field *shear;       /* symmetric part of G, upper triangle */
  struct kith_field *gradient;    /* G, [a][b] */
  struct kith_field *curl;        /* |curl v|; 0 in 1-D */
  /* d(div v)/dt = div a - G_ab G_ba, from the accelerations of the last evaluation */
  struct kith_field *compression;
};

/* Computes supports, densities and what is wanted. Refuses connectivity that is stale, or lacks what the
 * package requires (connectivity.h). Collective: all ranks agree on the status; the failure of another rank
 * is returned by the next sweep (kith_ranks_start_agree), and until then nothing may change that an
 * evaluation does not compute anew. OUTGROWN if a support has to grow beyond its search radius: such supports
 * are set to what to try next, by Newton's method. DIVERGED names the first node whose support does not
 * converge. Nodes whose moments have no inverse get a zero gradient, and are counted as fallbacks. */
kith_status kith_density(struct kith_package *package, const struct kith_connectivity *connectivity,
                         const struct kith_density_wanted *wanted);

/* Returns |curl v| from G; 0 in 1-D. */
KITH_INLINE double kith_curl(const double *g) {
#if NDIM == 1
  (void)g;
  return 0;
#elif NDIM == 2
  return fabs(g[2] - g[1]);
#else
  const double x = g[7] - g[5], y = g[2] - g[6], z = g[3] - g[1];
  return sqrt(x * x + y * y + z * z);
#endif
}

#endif
