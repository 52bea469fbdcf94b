/* yee: the smooth vortex of Yee, Vinokur and Djomehri (J. Comput. Phys. 162 (2000) 33), in 3-D a column along
 * axis 2. Around the axis through the center, r the distance from it, b the amplitude,
 *
 *   v = b r / (2 pi) exp((1 - r^2) / 2),   T = P / rho = 1 - (gamma - 1) b^2 / (8 gamma pi^2) exp(1 - r^2),
 *   rho = T^(1 / (gamma - 1))
 *
 * v counterclockwise. Steady, and of one entropy: dP/dr = rho v^2 / r. Far away density and pressure are 1.
 * With uniform_velocity and a period > 0 it is carried along and brought back; exp((1 - r^2) / 2) at half a
 * period is how far it is from periodic. Not in 1-D. */
#include "validation/exact/exact_parameters.h"

struct yee {
  double gamma, amplitude, uniform_velocity[NDIM], center[NDIM], period[NDIM];
};
static const struct kith_param params[] = {
    KITH_EXACT_GAMMA(yee),
    KITH_EXACT_VELOCITY(yee),
    KITH_EXACT_CENTER(yee),
    KITH_EXACT_PERIOD(yee),
    {"amplitude", KITH_PARAM_NUMBER, "5", "", "strength b", KITH_INTO(struct yee, amplitude)},
    {0}};

static void derive(void *settings, const struct kith_exact_scene *scene) {
  struct yee *y = settings;
  y->gamma = scene->region[0].gamma;
  kith_exact_derive_period(y->period, scene);
}

static double coldness(const struct yee *y) {
  return (y->gamma - 1) * y->amplitude * y->amplitude / (8 * y->gamma * M_PI * M_PI);
}

static kith_status check(const void *settings) {
  const struct yee *y = settings;
  if (coldness(y) * M_E < 1) return KITH_OK;
  KITH_FAIL(BAD_INPUT, "exact solution yee: amplitude is %g, must be small enough for a positive temperature",
            y->amplitude);
}

static const double *center(const void *self) {
  return ((const struct yee *)self)->center;
}

static void state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct yee *y = self;
  double d[3] = {0}; /* from the axis, wherever it is by now */
  for (int a = 0; a < NDIM; ++a) {
    d[a] = kith_exact_carried(x[a], y->center[a], y->uniform_velocity[a], y->period[a], time);
    out->velocity[a] = y->uniform_velocity[a];
  }
  const double r2 = d[0] * d[0] + d[1] * d[1], turn = y->amplitude / (2 * M_PI) * exp((1 - r2) / 2);
  const double temperature = 1 - coldness(y) * exp(1 - r2);
  out->velocity[0] -= turn * d[1];
  out->velocity[NDIM > 1 ? 1 : 0] += turn * d[0];
  out->density = pow(temperature, 1 / (y->gamma - 1));
  out->pressure = out->density * temperature;
  out->energy = kith_exact_energy(y->gamma, out->density, out->pressure);
}

const struct kith_exact_ops kith_exact_yee = {
    .name = "yee",
    .doc = "smooth steady vortex; in 3-D a column along axis 2",
    KITH_SETTINGS(params, yee),
    .derive = derive,
    .check = check,
    .state = state,
    .center = center,
    .vortex = true,
};
