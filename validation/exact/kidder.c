/* kidder: a ball (a column, a layer) of gas that rests at time 0 and is compressed without a shock (R. E.
 * Kidder, Nucl. Fusion 16 (1976) 3). gamma = 1 + 2 / d in d dimensions; each node stays at the same part of
 * the radius, r = R a(t), a = sqrt(1 - t^2 / tau^2), so that all would meet in the center at tau:
 *
 *   velocity -r t / (tau a)^2,   s(R) = 1 + R^2 / (d tau^2 c^2),  c the sound speed in the center at time 0
 *   density  rho s^(d/2) a^-d,   pressure  p s^(d/2 + 1) a^-(d + 2)
 *
 * rho and p those in the center at time 0. What presses is gas farther out, denser and hotter without end: a
 * scene has a part of it, from whose edge a rarefaction runs inwards. */
#include "lib/core/vec.h"
#include "validation/exact/exact_parameters.h"

struct kidder {
  struct kith_exact_gas gas;
  double focus_time;
};
static const struct kith_param params[] = {
    KITH_EXACT_GAMMA,
    KITH_EXACT_DENSITY("in the center at time 0"),
    KITH_EXACT_PRESSURE("(0, inf)", "in the center at time 0"),
    KITH_EXACT_CENTER,
    {"focus_time", KITH_PARAM_NUMBER, NULL, "(0, inf)",
     "tau, the time of collapse; later the solution stays as just before",
     KITH_INTO(struct kidder, focus_time)},
    {0}};

static kith_status check(const void *settings) {
  const double gamma = ((const struct kidder *)settings)->gas.gamma, wanted = 1 + 2.0 / NDIM;
  if (fabs(gamma - wanted) < 1e-9) return KITH_OK;
  KITH_FAIL(BAD_INPUT, "exact solution kidder: gamma is %g, must be %.12g in %d-D", gamma, wanted, NDIM);
}

static void state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct kidder *k = self;
  const struct kith_exact_gas *gas = &k->gas;
  const double part = KITH_MIN(time / k->focus_time, 0.999), a2 = 1 - part * part, a = sqrt(a2);
  const double c2 = gas->gamma * gas->pressure / gas->density, tau2 = k->focus_time * k->focus_time;
  const double s = 1 + kith_distance2(x, gas->center) / (a2 * NDIM * tau2 * c2), dense = pow(s, 0.5 * NDIM);
  *out = kith_exact_moving(gas, gas->density * dense / kith_pow_dim(a),
                           gas->pressure * dense * s / (kith_pow_dim(a) * a2));
  for (int d = 0; d < NDIM; ++d) out->velocity[d] -= (x[d] - gas->center[d]) * part / (k->focus_time * a2);
}

const struct kith_exact_ops kith_exact_kidder = {
    .name = "kidder",
    .doc = "gas that is compressed without a shock, each node at its part of the radius",
    KITH_SETTINGS(params, kidder),
    .derive = kith_exact_derive_gas,
    .check = check,
    .state = state,
    .radial = true,
};
