/* entropy-wave: density that is carried along by gas of one velocity u and one pressure; an exact solution of
 * Euler's equations.
 *
 *   rho = rho0 (1 + A sin(2 pi (x[0] - origin - u[0] t) / wavelength)) */
#include "validation/exact/exact_parameters.h"

struct entropy_wave {
  struct kith_exact_gas gas;
  double amplitude, wavelength, origin;
};
static const struct kith_param params[] = {
    KITH_EXACT_GAMMA,
    KITH_EXACT_DENSITY("mean"),
    KITH_EXACT_PRESSURE("[0, inf)", "of the gas"),
    KITH_EXACT_VELOCITY,
    {"amplitude", KITH_PARAM_NUMBER, NULL, "(-1, 1)", "of the density, relative",
     KITH_INTO(struct entropy_wave, amplitude)},
    {"wavelength", KITH_PARAM_NUMBER, NULL, "(0, inf)", "along x", KITH_INTO(struct entropy_wave, wavelength),
     .unit = "length"},
    {"origin", KITH_PARAM_NUMBER, "0", "", "x of phase 0 at the start",
     KITH_INTO(struct entropy_wave, origin), .unit = "length"},
    {0}};

static void derive(void *settings, const struct kith_exact_scene *scene) {
  struct entropy_wave *w = settings;
  kith_exact_derive_moving(settings, scene);
  w->gas.density = NAN; /* the mean is not said */
  w->wavelength = scene->upper[0] - scene->lower[0];
}

static void state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct entropy_wave *w = self;
  const double phase = 2 * M_PI * (x[0] - w->origin - w->gas.uniform_velocity[0] * time) / w->wavelength;
  *out = kith_exact_moving(&w->gas, w->gas.density * (1 + w->amplitude * sin(phase)), w->gas.pressure);
}

const struct kith_exact_ops kith_exact_entropy_wave = {
    .name = "entropy-wave",
    .doc = "a wave of density alone, carried along axis 0",
    KITH_SETTINGS(params, entropy_wave),
    .derive = derive,
    .state = state,
};
