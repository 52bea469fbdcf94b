/* gresho: the vortex of Gresho and Chan (Int. J. Numer. Methods Fluids 11 (1990) 621), in 3-D a column along
 * axis 2. Around the axis through the center, with r the distance from it and P0 the pressure there,
 *
 *   r < 0.2   v = 5 r         P = P0 + rho 12.5 r^2
 *   r < 0.4   v = 2 - 5 r     P = P0 + rho (12.5 r^2 + 4 - 20 r + 4 ln(5 r))
 *   beyond    v = 0           P = P0 + rho (4 ln 2 - 2)
 *
 * v counterclockwise. Steady: the pressure holds the gas on its circles, dP/dr = rho v^2 / r. With
 * uniform_velocity the vortex is carried along; a period > 0 along an axis brings it back (the box of the
 * scene). Not in 1-D. */
#include "validation/exact/exact_parameters.h"

static const struct kith_param params[] = {KITH_EXACT_GAMMA,
                                           KITH_EXACT_DENSITY("of the gas"),
                                           {"pressure", KITH_PARAM_NUMBER, NULL, "[0, inf)", "on the axis",
                                            KITH_INTO(struct kith_exact_gas, pressure), .given = true},
                                           KITH_EXACT_VELOCITY,
                                           KITH_EXACT_CENTER,
                                           KITH_EXACT_PERIOD,
                                           {0}};

static void derive(void *settings, const struct kith_exact_scene *scene) {
  kith_exact_derive_gas(settings, scene);
  ((struct kith_exact_gas *)settings)->pressure = NAN; /* that on the axis, which the scene does not say */
}

/* Returns the angular velocity v / r; *push: (P - P0) / rho. */
static double turning(double r, double *push) {
  if (r < 0.2) {
    *push = 12.5 * r * r;
    return 5;
  }
  if (r < 0.4) {
    *push = 12.5 * r * r + 4 - 20 * r + 4 * log(5 * r);
    return 2 / r - 5;
  }
  *push = 4 * M_LN2 - 2;
  return 0;
}

static void state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct kith_exact_gas *gas = self;
  double d[3], push; /* from the axis, which may have been carried along */
  kith_exact_offset(gas, x, time, d);
  const double turn = turning(hypot(d[0], d[1]), &push);
  *out = kith_exact_turning(gas, gas->density, gas->pressure + gas->density * push, d, turn);
}

const struct kith_exact_ops kith_exact_gresho = {
    .name = "gresho",
    .doc = "steady vortex held by its pressure; in 3-D a column along z",
    KITH_SETTINGS(params, kith_exact_gas),
    .derive = derive,
    .state = state,
    .radial = true,
    .vortex = true,
};
