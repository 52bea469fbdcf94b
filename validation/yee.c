/* yee: the smooth vortex of Yee, Vinokur and Djomehri (J. Comput. Phys. 162 (2000) 33), in 3-D a column along axis 2. Around the axis
 * through the center, r the distance from it, b the amplitude,
 *
 *   v = b r / (2 pi) exp((1 - r^2) / 2),   T = P / rho = 1 - (gamma - 1) b^2 / (8 gamma pi^2) exp(1 - r^2),   rho = T^(1 / (gamma - 1))
 *
 * v counterclockwise. Steady, and of one entropy: dP/dr = rho v^2 / r. Far away density and pressure are 1. With uniform_velocity and a
 * period > 0 it is carried along and brought back; exp((1 - r^2) / 2) at half a period is how far it is from periodic.
 * Reads gamma[0] > 1, amplitude (T > 0 at the center), center, uniform_velocity, period >= 0. Not in 1-D. */
#include "validation/exact_parameters.h"

#include <math.h>

static double coldness(const struct kith_exact_parameters *p) {
  return (p->gamma[0] - 1) * p->amplitude * p->amplitude / (8 * p->gamma[0] * M_PI * M_PI);
}

static kith_status yee_check(const struct kith_exact_parameters *p) {
  const char *const member = "yee";
  KITH_TRY(kith_exact_require(p->gamma[0] > 1, member, "gamma[0]", p->gamma[0], "above 1"));
  KITH_TRY(kith_exact_require(coldness(p) * M_E < 1, member, "amplitude", p->amplitude,
                              "small enough for gas that is not colder than 0"));
  for (int a = 0; a < NDIM; ++a) {
    KITH_TRY(kith_exact_require(true, member, "center", p->center[a], "finite"));
    KITH_TRY(kith_exact_require(true, member, "uniform_velocity", p->uniform_velocity[a], "finite"));
    KITH_TRY(kith_exact_require(p->period[a] >= 0, member, "period", p->period[a], "at least 0"));
  }
  if (NDIM == 1) KITH_FAIL(BAD_INPUT, "exact solution yee: a vortex needs 2 or 3 dimensions");
  return KITH_OK;
}

static kith_status yee_create(void **self, const struct kith_exact_parameters *p) {
  KITH_TRY(yee_check(p));
  struct kith_exact_parameters *own = NULL;
  KITH_TRY(kith_resize(&own, 0, 1, sizeof *own));
  *own = *p;
  *self = own;
  return KITH_OK;
}

static const double *yee_center(const void *self) {
  return ((const struct kith_exact_parameters *)self)->center;
}

static void yee_state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct kith_exact_parameters *p = self;
  double d[3] = {0}; /* from the axis, wherever it is by now */
  for (int a = 0; a < NDIM; ++a) {
    d[a] = x[a] - p->center[a] - p->uniform_velocity[a] * time;
    if (p->period[a] > 0) d[a] -= p->period[a] * round(d[a] / p->period[a]);
    out->velocity[a] = p->uniform_velocity[a];
  }
  const double r2 = d[0] * d[0] + d[1] * d[1], turn = p->amplitude / (2 * M_PI) * exp((1 - r2) / 2);
  const double temperature = 1 - coldness(p) * exp(1 - r2);
  out->velocity[0] -= turn * d[1];
  out->velocity[NDIM > 1 ? 1 : 0] += turn * d[0];
  out->density = pow(temperature, 1 / (p->gamma[0] - 1));
  out->pressure = out->density * temperature;
  out->energy = kith_exact_energy(p->gamma[0], out->density, out->pressure);
}

const struct kith_exact_ops kith_exact_yee = {
    .name = "yee",
    .doc = "smooth steady vortex; in 3-D a column along axis 2",
    .create = yee_create,
    .destroy = kith_exact_destroy,
    .state = yee_state,
    .center = yee_center,
    .vortex = true,
};
