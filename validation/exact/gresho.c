/* gresho: the vortex of Gresho and Chan (Int. J. Numer. Methods Fluids 11 (1990) 621), in 3-D a column along
 * axis 2. Around the axis through the center, with r the distance from it and P0 the pressure there,
 *
 *   r < 0.2   v = 5 r         P = P0 + rho 12.5 r^2
 *   r < 0.4   v = 2 - 5 r     P = P0 + rho (12.5 r^2 + 4 - 20 r + 4 ln(5 r))
 *   beyond    v = 0           P = P0 + rho (4 ln 2 - 2)
 *
 * v counterclockwise. Steady: the pressure holds the gas on its circles, dP/dr = rho v^2 / r; v has kinks at
 * 0.2 and 0.4. With uniform_velocity the vortex is carried along; a period > 0 along an axis brings it back
 * (the box of the scene): the center moves then, and is the parameter's again after whole periods.
 * Not in 1-D. */
#include "validation/exact/exact_parameters.h"

struct gresho {
  double gamma, density, pressure, uniform_velocity[NDIM], center[NDIM], period[NDIM];
};
static const struct kith_param params[] = {KITH_EXACT_GAMMA(gresho),
                                           KITH_EXACT_DENSITY(gresho, "of the gas"),
                                           KITH_EXACT_PRESSURE(gresho, "[0, inf)", "on the axis"),
                                           KITH_EXACT_VELOCITY(gresho),
                                           KITH_EXACT_CENTER(gresho),
                                           KITH_EXACT_PERIOD(gresho),
                                           {0}};

static void derive(void *settings, const struct kith_exact_scene *scene) {
  struct gresho *g = settings;
  g->gamma = scene->region[0].gamma;
  g->density = scene->region[0].density;
  kith_exact_derive_period(g->period, scene);
}

static const double *center(const void *self) {
  return ((const struct gresho *)self)->center;
}

/* Angular velocity v / r, and (P - P0) / rho. */
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
  const struct gresho *g = self;
  double d[3] = {0}, push; /* from the axis, wherever it is by now */
  for (int a = 0; a < NDIM; ++a) {
    d[a] = kith_exact_carried(x[a], g->center[a], g->uniform_velocity[a], g->period[a], time);
    out->velocity[a] = g->uniform_velocity[a];
  }
  const double turn = turning(hypot(d[0], d[1]), &push);
  out->velocity[0] -= turn * d[1];
  out->velocity[NDIM > 1 ? 1 : 0] += turn * d[0];
  out->density = g->density;
  out->pressure = g->pressure + g->density * push;
  out->energy = kith_exact_energy(g->gamma, out->density, out->pressure);
}

const struct kith_exact_ops kith_exact_gresho = {
    .name = "gresho",
    .doc = "steady vortex held by its pressure; in 3-D a column along axis 2",
    KITH_SETTINGS(params, gresho),
    .derive = derive,
    .state = state,
    .center = center,
    .vortex = true,
};
