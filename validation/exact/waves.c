/* acoustic-wave and entropy-wave: along axis 0 of a gas in uniform motion u.
 *
 *   phase = 2 pi (x[0] - origin - (c + u[0]) t) / wavelength,   c^2 = gamma P0 / rho0
 *   rho = rho0 (1 + A sin phase),  v[0] = u[0] + A c sin phase,  P = P0 (1 + gamma A sin phase)
 *
 * is a travelling sound wave of linear theory (any text on gas dynamics): the Euler equations are met up to
 * O(A^2), and the wave steepens over a time of about wavelength / (A c). The amplitude is below 1 / gamma,
 * else the pressure would be negative. With c = 0 in all of these and constant P it is density that is
 * carried along by gas of one velocity and one pressure, an exact solution of Euler's equations. */
#include "validation/exact/exact_parameters.h"

struct wave {
  struct kith_exact_gas gas;
  double amplitude, wavelength, origin;
};
#define IN(member) KITH_INTO(struct wave, member)
static const struct kith_param params[] = {
    KITH_EXACT_GAMMA,
    {"density", KITH_PARAM_NUMBER, NULL, "(0, inf)", "mean", IN(gas.density), .given = true},
    KITH_EXACT_PRESSURE("(0, inf)", "undisturbed"),
    KITH_EXACT_VELOCITY,
    {"amplitude", KITH_PARAM_NUMBER, NULL, "(-1, 1)", "of the density, relative", IN(amplitude),
     .given = true},
    {"wavelength", KITH_PARAM_NUMBER, NULL, "(0, inf)", "along x", IN(wavelength)},
    {"origin", KITH_PARAM_NUMBER, "0", "", "x of phase 0 at the start", IN(origin)},
    {0}};

static void derive_acoustic(void *settings, const struct kith_exact_scene *scene) {
  struct wave *w = settings;
  w->gas.gamma = kith_exact_ideal_gamma(&scene->region[0]);
  for (int a = 1; a < NDIM; ++a) w->gas.uniform_velocity[a] = scene->region[0].velocity[a];
  w->wavelength = scene->upper[0] - scene->lower[0];
}

static void derive_entropy(void *settings, const struct kith_exact_scene *scene) {
  struct wave *w = settings;
  kith_exact_derive_moving(settings, scene);
  w->gas.density = NAN; /* the mean, which the scene does not say */
  w->wavelength = scene->upper[0] - scene->lower[0];
}

static kith_status check_acoustic(const void *settings) {
  const struct wave *w = settings;
  if (fabs(w->amplitude) * w->gas.gamma < 1) return KITH_OK;
  KITH_FAIL(BAD_INPUT, "exact solution acoustic-wave: amplitude is %g, must be between -1/gamma and 1/gamma",
            w->amplitude);
}

static double sine(const struct wave *w, const double *x, double travelled) {
  return w->amplitude * sin(2 * M_PI / w->wavelength * (x[0] - w->origin - travelled));
}

static void acoustic_state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct wave *w = self;
  const struct kith_exact_gas *gas = &w->gas;
  const double sound = sqrt(gas->gamma * gas->pressure / gas->density);
  const double s = sine(w, x, (sound + gas->uniform_velocity[0]) * time);
  *out = kith_exact_moving(gas, gas->density * (1 + s), gas->pressure * (1 + gas->gamma * s));
  out->velocity[0] += sound * s;
}

static void entropy_state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct wave *w = self;
  const double s = sine(w, x, w->gas.uniform_velocity[0] * time);
  *out = kith_exact_moving(&w->gas, w->gas.density * (1 + s), w->gas.pressure);
}

const struct kith_exact_ops kith_exact_acoustic_wave = {
    .name = "acoustic-wave",
    .doc = "travelling sound wave along x (linear theory)",
    KITH_SETTINGS(params, wave),
    .derive = derive_acoustic,
    .check = check_acoustic,
    .state = acoustic_state,
};
const struct kith_exact_ops kith_exact_entropy_wave = {
    .name = "entropy-wave",
    .doc = "a wave of density alone, carried along x",
    KITH_SETTINGS(params, wave),
    .derive = derive_entropy,
    .state = entropy_state,
};
