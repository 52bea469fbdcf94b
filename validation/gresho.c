/* gresho: the vortex of Gresho and Chan (Int. J. Numer. Methods Fluids 11 (1990) 621), in 3-D a column along axis 2. Around
 * the axis through the center, with r the distance from it and P0 the pressure there,
 *
 *   r < 0.2   v = 5 r         P = P0 + rho 12.5 r^2
 *   r < 0.4   v = 2 - 5 r     P = P0 + rho (12.5 r^2 + 4 - 20 r + 4 ln(5 r))
 *   beyond    v = 0           P = P0 + rho (4 ln 2 - 2)
 *
 * v counterclockwise. Steady: the pressure holds the gas on its circles, dP/dr = rho v^2 / r; v has kinks at 0.2 and 0.4.
 * With uniform_velocity the vortex is carried along; a period > 0 along an axis brings it back (the box of the scene): the
 * center moves then, and is the parameter's again after whole periods.
 * Reads gamma[0] > 1, density[0] > 0, pressure[0] = P0 >= 0, center, uniform_velocity, period >= 0. Not in 1-D. */
#include "validation/exact_parameters.h"

#include <math.h>

struct gresho {
  double gamma, density, pressure, center[NDIM], velocity[NDIM], period[NDIM];
};

static kith_status gresho_check(const struct kith_exact_parameters *p) {
  const char *const member = "gresho";
  KITH_TRY(kith_exact_require(p->gamma[0] > 1, member, "gamma[0]", p->gamma[0], "above 1"));
  KITH_TRY(kith_exact_require(p->density[0] > 0, member, "density[0]", p->density[0], "above 0"));
  KITH_TRY(kith_exact_require(p->pressure[0] >= 0, member, "pressure[0]", p->pressure[0], "at least 0"));
  for (int a = 0; a < NDIM; ++a) {
    const double u = p->uniform_velocity[a], period = p->period[a];
    KITH_TRY(kith_exact_require(true, member, "center", p->center[a], "finite"));
    KITH_TRY(kith_exact_require(true, member, "uniform_velocity", u, "finite"));
    KITH_TRY(kith_exact_require(period >= 0, member, "period", period, "at least 0"));
  }
  if (NDIM == 1) KITH_FAIL(BAD_INPUT, "exact solution gresho: a vortex needs 2 or 3 dimensions");
  return KITH_OK;
}

static kith_status gresho_create(void **self, const struct kith_exact_parameters *p) {
  KITH_TRY(gresho_check(p));
  struct gresho *g = NULL;
  KITH_TRY(kith_resize(&g, 0, 1, sizeof *g));
  *g = (struct gresho){.gamma = p->gamma[0], .density = p->density[0], .pressure = p->pressure[0]};
  for (int a = 0; a < NDIM; ++a) {
    g->center[a] = p->center[a];
    g->velocity[a] = p->uniform_velocity[a];
    g->period[a] = p->period[a];
  }
  *self = g;
  return KITH_OK;
}

static const double *gresho_center(const void *self) {
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

static void gresho_state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct gresho *g = self;
  double d[3] = {0}, push; /* from the axis, wherever it is by now */
  for (int a = 0; a < NDIM; ++a) {
    d[a] = x[a] - g->center[a] - g->velocity[a] * time;
    if (g->period[a] > 0) d[a] -= g->period[a] * round(d[a] / g->period[a]);
    out->velocity[a] = g->velocity[a];
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
    .create = gresho_create,
    .destroy = kith_exact_destroy,
    .state = gresho_state,
    .center = gresho_center,
    .vortex = true,
};
