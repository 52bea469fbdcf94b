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
  struct kith_exact_gas gas; /* without density and pressure */
  double amplitude;
};
static const struct kith_param params[] = {
    KITH_EXACT_GAMMA,
    KITH_EXACT_VELOCITY,
    KITH_EXACT_CENTER,
    KITH_EXACT_PERIOD,
    {"amplitude", KITH_PARAM_NUMBER, "5", "", "strength b of the vortex", KITH_INTO(struct yee, amplitude)},
    {0}};

static double coldness(const struct yee *y) {
  return (y->gas.gamma - 1) * y->amplitude * y->amplitude / (8 * y->gas.gamma * M_PI * M_PI);
}

static kith_status check(const void *settings) {
  const struct yee *y = settings;
  if (coldness(y) * M_E < 1) return KITH_OK;
  KITH_FAIL(BAD_INPUT, "exact solution yee: amplitude is %g, must be small enough for a positive temperature",
            y->amplitude);
}

static void state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct yee *y = self;
  double d[3]; /* from the axis, which may have been carried along */
  kith_exact_offset(&y->gas, x, time, d);
  const double r2 = d[0] * d[0] + d[1] * d[1], turn = y->amplitude / (2 * M_PI) * exp((1 - r2) / 2);
  const double temperature = 1 - coldness(y) * exp(1 - r2);
  const double density = pow(temperature, 1 / (y->gas.gamma - 1));
  *out = kith_exact_turning(&y->gas, density, density * temperature, d, turn);
}

const struct kith_exact_ops kith_exact_yee = {
    .name = "yee",
    .doc = "smooth steady vortex; in 3-D a column along z",
    KITH_SETTINGS(params, yee),
    .derive = kith_exact_derive_gas,
    .check = check,
    .state = state,
    .radial = true,
    .vortex = true,
};
