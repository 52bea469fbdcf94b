/* Package `conduction`: heat conduction between pairs, on top of a hydro package.
 *
 *     m_i du_i/dt = sum_j 4 k_i k_j / (k_i + k_j) V_i V_j (T_i - T_j) F_ij,   T = u / c_v
 * with F as in diffusion.h (Cleary and Monaghan 1999, JCoPh 148, 227, eq. 27). Heat flows from hot to cold in
 * each pair, and what one end gets the other loses. A mirror, an open side and a barrier conduct nothing.
 * Explicit: dt <= C rho c_v h^2 / (10 k), h = 2 sigma; scheme `implicit` takes larger Courant numbers C. */
#include "physics/passes/diffusion.h"

struct conduction_settings {
  double conductivity[2], specific_heat[2];
};
static const struct kith_param params[] = {
    {"conductivity", KITH_PARAM_SIDES, NULL, "[0, inf)",
     "conductivity k; one number, or [of the first material, of all others]",
     KITH_INTO(struct conduction_settings, conductivity)},
    {"specific_heat", KITH_PARAM_SIDES, "1", "(0, inf)", "c_v in T = u / c_v; one number or two, as k",
     KITH_INTO(struct conduction_settings, specific_heat)},
    {0}};

enum { TEMPERATURE = KITH_DIFFUSION_OWN, PACKED };

KITH_INLINE void conduction_pair(enum kith_kernel kernel, const void *constant, const double *restrict i,
                                 const double *restrict j, double *restrict out) {
  const double q =
      kith_diffusion_pair(kernel, *(const double *)constant, i, j) * (i[TEMPERATURE] - J(TEMPERATURE));
  for (int a = 0; a < NDIM; ++a) OUT(KITH_FORCE + a) = 0;
  OUT(KITH_HEAT) = q;
  OUT(KITH_PARTNER_HEAT) = -q;
  OUT(KITH_SIGNAL) = 0;
}

static void pack(const struct kith_package *package, kith_index i, double *restrict packed) {
  const struct conduction_settings *settings = package->settings;
  const struct kith_hydro *hydro = package->hydro;
  kith_diffusion_pack(hydro, i, kith_diffusion_of(hydro, i, settings->conductivity), packed);
  packed[TEMPERATURE] = hydro->energy->f64[i] / kith_diffusion_of(hydro, i, settings->specific_heat);
}

KITH_FORCE_FORM(conduction_pair, PACKED, pack, NULL)

static kith_status evaluate(struct kith_package *package, struct kith_connectivity *connectivity,
                            const struct kith_kick *kick) {
  return kith_diffusion_evaluate(package, connectivity, kick, &conduction_pair_form);
}

static double longest_step(const struct kith_package *package, kith_index i) {
  const struct conduction_settings *settings = package->settings;
  const struct kith_hydro *hydro = package->hydro;
  const double capacity = hydro->density->f64[i] * kith_diffusion_of(hydro, i, settings->specific_heat);
  return kith_diffusion_step(package, i, kith_diffusion_of(hydro, i, settings->conductivity) / capacity);
}

const struct kith_package_ops kith_package_conduction = {
    .name = "conduction",
    .doc = "heat conduction: heat flows from hot to cold in each pair",
    .self_size = sizeof(double),
    .create = kith_diffusion_create,
    .evaluate = evaluate,
    .longest_step = longest_step,
    KITH_SETTINGS(params, conduction_settings),
};
