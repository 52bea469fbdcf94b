/* Package `viscosity`: the shear viscosity of the Navier-Stokes equations between pairs, on top of a hydro
 * package. (The artificial viscosity of hydro packages is in physics/passes/viscosity.h.)
 *
 *     f_ij = 4 mu_i mu_j / (mu_i + mu_j) V_i V_j F_ij v_ij
 * is the force on i, with F as in diffusion.h: mu Laplace v where mu is constant (Morris, Fox and Zhu 1997,
 * JCoPh 136, 214, eq. 22, with the harmonic mean). Momentum is conserved; the work of a pair heats both ends
 * alike, never below zero. Forces along x_ij (Cleary 1998, Appl. Math. Modelling 22, 981), which conserve
 * angular momentum too, were tried: the shear wave of inputs/viscous-wave.yaml, 50^2, has an error of 6.4e-5
 * and order 0.5 instead of 1.3e-5 and 2.0, as sums of x_a^2 x_b^2 over a lattice are further from their
 * integrals than those of x_a^2. On shaken nodes (0.2 spacings) it is 0.9e-4 instead of 1.3e-4.
 *
 * At a mirror gas slips along the wall. At a barrier it does not: there the nodes of the barrier count with
 * the reversed velocity of i. Explicit: dt <= C rho h^2 / (10 mu), h = 2 sigma. */
#include "physics/passes/diffusion.h"

struct viscosity_settings {
  double dynamic[2];
};
static const struct kith_param params[] = {{"dynamic", KITH_PARAM_SIDES, NULL, "[0, inf)",
                                            "mu; one number, or [of the first material, of all others]",
                                            KITH_INTO(struct viscosity_settings, dynamic)},
                                           {0}};

KITH_INLINE void viscosity_pair(enum kith_kernel kernel, const void *constant, const double *restrict i,
                                const double *restrict j, double *restrict out) {
  const double flow = kith_diffusion_pair(kernel, *(const double *)constant, i, j);
  double v2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double v = i[KITH_PACKED_V + a] - J(KITH_PACKED_V + a);
    OUT(KITH_FORCE + a) = flow * v;
    v2 += v * v;
  }
  OUT(KITH_HEAT) = OUT(KITH_PARTNER_HEAT) = -0.5 * flow * v2;
  OUT(KITH_SIGNAL) = 0;
}

static double viscosity_of(const struct kith_package *package, kith_index i) {
  return kith_diffusion_of(package->hydro, i,
                           ((const struct viscosity_settings *)package->settings)->dynamic);
}

static void pack(const struct kith_package *package, kith_index i, double *restrict packed) {
  kith_diffusion_pack(package->hydro, i, viscosity_of(package, i), packed);
}

KITH_FORCE_FORM(viscosity_pair, KITH_DIFFUSION_OWN, pack, NULL)

static kith_status evaluate(struct kith_package *package, struct kith_connectivity *connectivity,
                            const struct kith_kick *kick) {
  return kith_diffusion_evaluate(package, connectivity, kick, &viscosity_pair_form);
}

static double longest_step(const struct kith_package *package, kith_index i) {
  return kith_diffusion_step(package, i, viscosity_of(package, i) / package->hydro->density->f64[i]);
}

static struct kith_package_traits traits(const void *settings) {
  (void)settings;
  return (struct kith_package_traits){.viscous = true};
}

const struct kith_package_ops kith_package_viscosity = {
    .name = "viscosity",
    .doc = "Navier-Stokes shear viscosity: neighbors drag each other, the work heats both",
    .self_size = sizeof(double),
    .create = kith_diffusion_create,
    .evaluate = evaluate,
    .longest_step = longest_step,
    .traits = traits,
    KITH_SETTINGS(params, viscosity_settings),
};
