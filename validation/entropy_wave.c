/* entropy-wave: density that is carried along by gas of one velocity u and one pressure; an exact solution of Euler's equations.
 *
 *   rho = rho0 (1 + A sin(2 pi (x[0] - origin - u[0] t) / wavelength))
 *
 * Reads gamma[0] > 1, density[0] > 0, pressure[0] >= 0, |amplitude| < 1, wavelength > 0, origin, uniform_velocity. */
#include "validation/exact_parameters.h"

#include <math.h>

static kith_status entropy_wave_check(const struct kith_exact_parameters *p) {
  const char *const member = "entropy-wave";
  KITH_TRY(kith_exact_require(p->gamma[0] > 1, member, "gamma[0]", p->gamma[0], "above 1"));
  KITH_TRY(kith_exact_require(p->density[0] > 0, member, "density[0]", p->density[0], "above 0"));
  KITH_TRY(kith_exact_require(p->pressure[0] >= 0, member, "pressure[0]", p->pressure[0], "at least 0"));
  KITH_TRY(kith_exact_require(p->wavelength > 0, member, "wavelength", p->wavelength, "above 0"));
  KITH_TRY(kith_exact_require(fabs(p->amplitude) < 1, member, "amplitude", p->amplitude, "between -1 and 1"));
  KITH_TRY(kith_exact_require(true, member, "origin", p->origin, "finite"));
  for (int a = 0; a < NDIM; ++a)
    KITH_TRY(kith_exact_require(true, member, "uniform_velocity", p->uniform_velocity[a], "finite"));
  return KITH_OK;
}

static kith_status entropy_wave_create(void **self, const struct kith_exact_parameters *p) {
  KITH_TRY(entropy_wave_check(p));
  struct kith_exact_parameters *own = NULL;
  KITH_TRY(kith_resize(&own, 0, 1, sizeof *own));
  *own = *p;
  *self = own;
  return KITH_OK;
}

static void entropy_wave_state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct kith_exact_parameters *p = self;
  const double phase = 2 * M_PI * (x[0] - p->origin - p->uniform_velocity[0] * time) / p->wavelength;
  for (int a = 0; a < NDIM; ++a) out->velocity[a] = p->uniform_velocity[a];
  out->density = p->density[0] * (1 + p->amplitude * sin(phase));
  out->pressure = p->pressure[0];
  out->energy = kith_exact_energy(p->gamma[0], out->density, out->pressure);
}

const struct kith_exact_ops kith_exact_entropy_wave = {
    .name = "entropy-wave",
    .doc = "a wave of density alone, carried along axis 0",
    .create = entropy_wave_create,
    .destroy = kith_exact_destroy,
    .state = entropy_wave_state,
};
