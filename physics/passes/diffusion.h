/* diffusion.h - diffusion between pairs on top of a hydro package: what packages that do this share.
 *
 * With a coefficient k (a conductivity, a viscosity) the flow from j to i per time is
 *     [4 k_i k_j / (k_i + k_j)] V_i V_j F_ij (A_i - A_j),   F_ij = (g_ij(H_i) + g_ij(H_j)) / (2 f) <= 0 (1)
 * where grad_i W = g x_ij and V = m / rho (Brookshaw 1985, Proc. Astron. Soc. Aust. 6, 207). Its sum is div
 * (k grad A) to second order in H on an even distribution of nodes, but for the error of the sum over V_j
 * r_ij^2 F_ij, which should be -d. The constant f makes it so on an ideal lattice (kith_kernel_gradient_sum);
 * without it 7, 4 and 2 % less would flow in 1-D, 2-D and 3-D with the default neighbors of sph. The harmonic
 * mean keeps the flow continuous where k jumps (Cleary and Monaghan 1999, JCoPh 148, 227, section 4).
 * Exchanging i and j changes the sign and nothing else.
 *
 * Explicit schemes. Values that alternate from node to node decay at a rate of about 8 k / (c h^2) with h = 2
 * sigma and the capacity c per volume. leapfrog and verlet, which predict energies with extrapolated rates,
 * are stable up to 4/7 of a decay time a step, others up to 1 or more: the longest step at Courant number 1
 * is c h^2 / (10 k), 0.8 of a decay time. So with explicit schemes no Courant number beyond 0.7 multiplies it
 * (KITH_DIFFUSION_STABLE of package.h): with 0.9, block steps 0.8, the heat of inputs/slabs.yaml grew to 1e66
 * and 1e47, and nothing stopped the run, as its pressure does not depend on it. */
#ifndef KITH_PHYSICS_PASSES_DIFFUSION_H
#define KITH_PHYSICS_PASSES_DIFFUSION_H

#include <math.h>
#include "physics/passes/force.h"

/* The fields of a packed particle; those of the package follow. */
enum {
  KITH_DIFFUSION_INVERSE = KITH_PACKED_OWN,
  KITH_DIFFUSION_VOLUME,
  KITH_DIFFUSION_K,
  KITH_DIFFUSION_OWN
};

static inline void kith_diffusion_pack(const struct kith_hydro *hydro, kith_index i, double k,
                                       double *restrict packed) {
  kith_force_pack(hydro, i, packed);
  packed[KITH_DIFFUSION_INVERSE] = 1 / hydro->nodes->support->f64[i];
  packed[KITH_DIFFUSION_VOLUME] = hydro->mass->f64[i] / hydro->density->f64[i];
  packed[KITH_DIFFUSION_K] = k;
}

/* Returns the factor of A_i - A_j in (1). constant: of the kernel, over f. */
KITH_INLINE double kith_diffusion_pair(enum kith_kernel kernel, double constant, const double *restrict i,
                                       const double *restrict j) {
  double r2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double x = i[KITH_PACKED_X + a] - J(KITH_PACKED_X + a);
    r2 += x * x;
  }
  const double r = sqrt(r2), own = i[KITH_DIFFUSION_INVERSE], other = J(KITH_DIFFUSION_INVERSE),
               k = i[KITH_DIFFUSION_K], kj = J(KITH_DIFFUSION_K);
  const double g = kith_kernel_gradient(kernel, constant, r * own, own) +
                   kith_kernel_gradient(kernel, constant, r * other, other);
  return 2 * (k * kj) / KITH_MAX(k + kj, 1e-300) * (i[KITH_DIFFUSION_VOLUME] * J(KITH_DIFFUSION_VOLUME)) * g;
}

/* Stores the constant of the pairs, which is the private state of the package. */
static inline kith_status kith_diffusion_create(struct kith_package *package) {
  *(double *)package->self =
      kith_kernel_constant(package->kernel) / kith_kernel_gradient_sum(package->kernel, package->neighbors);
  return KITH_OK;
}

/* Runs the force pass over the rows. */
static inline kith_status kith_diffusion_evaluate(struct kith_package *package,
                                                  struct kith_connectivity *connectivity,
                                                  const struct kith_kick *kick,
                                                  const struct kith_force_form *form) {
  return kith_force(package, connectivity, kick,
                    &(struct kith_force_pass){.form = form, .no_slip = true, .constants = package->self});
}

/* Returns the longest step at Courant number 1, with the diffusivity k / c of node i. */
static inline double kith_diffusion_step(const struct kith_package *package, kith_index i,
                                         double diffusivity) {
  const double h = package->hydro->nodes->support->f64[i] / kith_kernel_support(package->kernel);
  return h * h / (10 * diffusivity);
}

/* Returns the value for the material of node i: the first for the first material, the second for all
 * others. */
static inline double kith_diffusion_of(const struct kith_hydro *hydro, kith_index i, const double value[2]) {
  return value[hydro->nodes->list->u8[i] > 0];
}

#endif
