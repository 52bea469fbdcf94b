/* square: gas of one pressure and one velocity u that is denser inside of a box (a slab, a square, a cube) than outside; an exact
 * solution of Euler's equations, carried along and brought back by a period > 0.
 *
 *   rho = density[0] where |x[a] - center[a] - u[a] t| < side[a] / 2 for all a, else density[1]
 *
 * Reads gamma[0] > 1, density > 0, pressure[0] >= 0, side > 0, center, period >= 0, uniform_velocity. */
#include "validation/exact_parameters.h"

#include <math.h>

static kith_status square_check(const struct kith_exact_parameters *p) {
  const char *const member = "square";
  KITH_TRY(kith_exact_require(p->gamma[0] > 1, member, "gamma[0]", p->gamma[0], "above 1"));
  KITH_TRY(kith_exact_require(p->density[0] > 0, member, "density[0]", p->density[0], "above 0"));
  KITH_TRY(kith_exact_require(p->density[1] > 0, member, "density[1]", p->density[1], "above 0"));
  KITH_TRY(kith_exact_require(p->pressure[0] >= 0, member, "pressure[0]", p->pressure[0], "at least 0"));
  for (int a = 0; a < NDIM; ++a) {
    KITH_TRY(kith_exact_require(p->side[a] > 0, member, "side", p->side[a], "above 0"));
    KITH_TRY(kith_exact_require(true, member, "center", p->center[a], "finite"));
    KITH_TRY(kith_exact_require(p->period[a] >= 0, member, "period", p->period[a], "at least 0"));
    KITH_TRY(kith_exact_require(true, member, "uniform_velocity", p->uniform_velocity[a], "finite"));
  }
  return KITH_OK;
}

static kith_status square_create(void **self, const struct kith_exact_parameters *p) {
  KITH_TRY(square_check(p));
  struct kith_exact_parameters *own = NULL;
  KITH_TRY(kith_resize(&own, 0, 1, sizeof *own));
  *own = *p;
  *self = own;
  return KITH_OK;
}

static void square_state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct kith_exact_parameters *p = self;
  bool inside = true;
  for (int a = 0; a < NDIM; ++a) {
    double d = x[a] - p->center[a] - p->uniform_velocity[a] * time;
    if (p->period[a] > 0) d -= p->period[a] * round(d / p->period[a]);
    inside = inside && fabs(d) < 0.5 * p->side[a];
    out->velocity[a] = p->uniform_velocity[a];
  }
  out->density = p->density[inside ? 0 : 1];
  out->pressure = p->pressure[0];
  out->energy = kith_exact_energy(p->gamma[0], out->density, out->pressure);
}

const struct kith_exact_ops kith_exact_square = {
    .name = "square",
    .doc = "a denser box in gas of the same pressure, at rest or carried along",
    .create = square_create,
    .destroy = kith_exact_destroy,
    .state = square_state,
};
