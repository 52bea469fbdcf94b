/* kidder: a ball (a column, a layer) of gas that rests at time 0 and is compressed without a shock (R. E.
 * Kidder, Nucl. Fusion 16 (1976) 3), or flies apart into a vacuum. gamma = 1 + 2 / d in d dimensions; each
 * node stays at the same part of the radius, r = R a(t), a = sqrt(1 - t^2 / T). If the gas is compressed,
 * T = tau^2, and all would meet in the center at tau; if it flies apart, T = -tau^2, and tau is given as
 * negative:
 *
 *   velocity -r t / (T a^2),   s(R) = 1 + R^2 / (d T c^2),  c the sound speed in the center at time 0
 *   density  rho s^(d/2) a^-d,   pressure  p s^(d/2 + 1) a^-(d + 2)
 *
 * rho and p those in the center at time 0. What presses is gas farther out, denser and hotter without end: a
 * scene has a part of it, from whose edge a rarefaction runs inwards. Gas that flies apart ends where s = 0,
 * and in the end its parts recede from each other faster than sound. */
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
    {"focus_time", KITH_PARAM_NUMBER, NULL, "",
     "tau, the time of collapse, after which the solution stays as just before; negative: it flies apart",
     KITH_INTO(struct kidder, focus_time), .given = true},
    {0}};

static kith_status check(const void *settings) {
  const struct kidder *k = settings;
  const double wanted = 1 + 2.0 / NDIM;
  if (k->focus_time == 0) KITH_FAIL(BAD_INPUT, "exact solution kidder: focus_time must not be 0");
  if (fabs(k->gas.gamma - wanted) < 1e-9) return KITH_OK;
  KITH_FAIL(BAD_INPUT, "exact solution kidder: gamma is %g, must be %.12g in %d-D", k->gas.gamma, wanted,
            NDIM);
}

static void state(const void *self, const double *position, double time, struct kith_exact_state *out) {
  const struct kidder *k = self;
  const struct kith_exact_gas *gas = &k->gas;
  const double tau = k->focus_time, T = tau * fabs(tau), t = tau > 0 ? KITH_MIN(time, 0.999 * tau) : time;
  double x[3];
  kith_exact_offset(gas, position, time, x);
  const double a2 = 1 - t * t / T, a = sqrt(a2), c2 = gas->gamma * gas->pressure / gas->density;
  const double s = KITH_MAX(0, 1 + kith_dot(x, x) / (a2 * NDIM * T * c2)), dense = pow(s, 0.5 * NDIM);
  *out = kith_exact_moving(gas, gas->density * dense / kith_pow_dim(a),
                           gas->pressure * dense * s / (kith_pow_dim(a) * a2));
  for (int d = 0; d < NDIM; ++d) out->velocity[d] -= x[d] * t / (T * a2);
}

const struct kith_exact_ops kith_exact_kidder = {
    .name = "kidder",
    .doc = "gas that is compressed without a shock or flies apart, each node at its part of the radius",
    KITH_SETTINGS(params, kidder),
    .derive = kith_exact_derive_gas,
    .check = check,
    .state = state,
    .radial = true,
};
