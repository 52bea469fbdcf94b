/* decaying-wave: waves along axis 0 that diffusion lets decay, in gas at rest whose pressure does not depend
 * on its energy (isothermal) or hardly changes with it (small amplitudes).
 *
 *   v[1] = B sin(phase) exp(-nu k^2 t),   phase = k (x[0] - origin),   k = 2 pi / wavelength
 *   u = u0 + A sin(phase) exp(-chi k^2 t) + B^2 / 4 (1 - exp(-b t))
 *       + nu k^2 B^2 / 2 cos(2 phase) (exp(-b t) - exp(-a t)) / (a - b),   a = 4 chi k^2,   b = 2 nu k^2
 *
 * solve dv/dt = nu d^2v/dx^2 and du/dt = chi d^2u/dx^2 + nu (dv/dx)^2 (Carslaw and Jaeger 1959, Conduction of
 * Heat in Solids, section 2.2; Landau and Lifshitz 1987, Fluid Mechanics, section 24). A shear wave needs a
 * second axis. */
#include "validation/exact/exact_parameters.h"

struct decaying_wave {
  struct kith_exact_gas gas;
  double energy, energy_amplitude, diffusivity, velocity_amplitude, viscosity, wavelength, origin;
};
#define IN(member) KITH_INTO(struct decaying_wave, member)
static const struct kith_param params[] = {
    KITH_EXACT_DENSITY("of the gas"),
    KITH_EXACT_PRESSURE("[0, inf)", "of the gas"),
    {"energy", KITH_PARAM_NUMBER, "0", "[0, inf)", "mean, per unit mass", IN(energy)},
    {"energy_amplitude", KITH_PARAM_NUMBER, "0", "", "amplitude A of the energy", IN(energy_amplitude)},
    {"diffusivity", KITH_PARAM_NUMBER, "0", "[0, inf)", "thermal, chi = k / (rho c_v)", IN(diffusivity)},
    {"velocity_amplitude", KITH_PARAM_NUMBER, "0", "", "amplitude B of the velocity", IN(velocity_amplitude)},
    {"viscosity", KITH_PARAM_NUMBER, "0", "[0, inf)", "kinematic, nu = mu / rho", IN(viscosity)},
    {"wavelength", KITH_PARAM_NUMBER, NULL, "(0, inf)", "along x", IN(wavelength)},
    {"origin", KITH_PARAM_NUMBER, "0", "", "x of phase 0", IN(origin)},
    {0}};

static void derive(void *settings, const struct kith_exact_scene *scene) {
  struct decaying_wave *w = settings;
  w->gas.density = scene->region[0].density;
  w->gas.pressure = scene->region[0].pressure;
  w->wavelength = scene->upper[0] - scene->lower[0];
}

static void state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct decaying_wave *w = self;
  const double k = 2 * M_PI / w->wavelength, wave = sin(k * (x[0] - w->origin));
  *out = (struct kith_exact_state){.density = w->gas.density, .pressure = w->gas.pressure};
  out->energy = w->energy + w->energy_amplitude * wave * exp(-w->diffusivity * k * k * time);
  if (NDIM == 1) return;
  const double a = 4 * w->diffusivity * k * k, b = 2 * w->viscosity * k * k, c = fabs(a - b);
  const double lag = exp(-KITH_MIN(a, b) * time) * (c > 0 ? -expm1(-c * time) / c : time);
  out->velocity[NDIM > 1] = w->velocity_amplitude * wave * exp(-0.5 * b * time);
  out->energy += 0.25 * w->velocity_amplitude * w->velocity_amplitude *
                 (b * (1 - 2 * wave * wave) * lag - expm1(-b * time));
}

const struct kith_exact_ops kith_exact_decaying_wave = {
    .name = "decaying-wave",
    .doc = "waves of heat and of shear that conduction and viscosity let decay",
    KITH_SETTINGS(params, decaying_wave),
    .derive = derive,
    .state = state,
    .transverse = true,
    .not_ideal = true,
};
