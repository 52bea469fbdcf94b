/* acoustic-wave: a travelling sound wave along axis 0 of a gas in uniform motion u.
 *
 *   phase = 2 pi (x[0] - origin - (c + u[0]) t) / wavelength,   c^2 = gamma P0 / rho0
 *   rho = rho0 (1 + A sin phase),  v[0] = u[0] + A c sin phase,  P = P0 (1 + gamma A sin phase)
 *
 * Linear theory (any text on gas dynamics): the Euler equations are met up to O(A^2), and the wave steepens
 * over a time of about wavelength / (A c). The amplitude is below 1 / gamma, else the pressure
 * would be negative. */
#include "validation/exact/exact_parameters.h"

struct acoustic_wave {
  struct kith_exact_gas gas;
  double amplitude, wavelength, origin;
};
static const struct kith_param params[] = {
    KITH_EXACT_GAMMA,
    KITH_EXACT_DENSITY("undisturbed"),
    KITH_EXACT_PRESSURE("(0, inf)", "undisturbed"),
    KITH_EXACT_VELOCITY,
    {"amplitude", KITH_PARAM_NUMBER, NULL, "(-1, 1)", "of the density, relative",
     KITH_INTO(struct acoustic_wave, amplitude)},
    {"wavelength", KITH_PARAM_NUMBER, NULL, "(0, inf)", "along x",
     KITH_INTO(struct acoustic_wave, wavelength), .unit = "length"},
    {"origin", KITH_PARAM_NUMBER, "0", "", "x of phase 0 at the start",
     KITH_INTO(struct acoustic_wave, origin), .unit = "length"},
    {0}};

static void derive(void *settings, const struct kith_exact_scene *scene) {
  struct acoustic_wave *w = settings;
  w->gas.gamma = scene->region[0].gamma;
  w->wavelength = scene->upper[0] - scene->lower[0];
}

static kith_status check(const void *settings) {
  const struct acoustic_wave *w = settings;
  if (fabs(w->amplitude) * w->gas.gamma < 1) return KITH_OK;
  KITH_FAIL(BAD_INPUT, "exact solution acoustic-wave: amplitude is %g, must be between -1/gamma and 1/gamma",
            w->amplitude);
}

static void state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct acoustic_wave *w = self;
  const struct kith_exact_gas *gas = &w->gas;
  const double sound = sqrt(gas->gamma * gas->pressure / gas->density), wavenumber = 2 * M_PI / w->wavelength;
  const double travelled = (sound + gas->uniform_velocity[0]) * time;
  const double s = w->amplitude * sin(wavenumber * (x[0] - w->origin - travelled));
  *out = kith_exact_moving(gas, gas->density * (1 + s), gas->pressure * (1 + gas->gamma * s));
  out->velocity[0] += sound * s;
}

const struct kith_exact_ops kith_exact_acoustic_wave = {
    .name = "acoustic-wave",
    .doc = "travelling sound wave along axis 0 (linear theory)",
    KITH_SETTINGS(params, acoustic_wave),
    .derive = derive,
    .check = check,
    .state = state,
};
