/* acoustic-wave: a travelling sound wave along axis 0 of a gas in uniform motion u.
 *
 *   phase = 2 pi (x[0] - origin - (c + u[0]) t) / wavelength,   c^2 = gamma P0 / rho0
 *   rho = rho0 (1 + A sin phase),  v[0] = u[0] + A c sin phase,  P = P0 (1 + gamma A sin phase)
 *
 * Linear theory (any text on gas dynamics): the Euler equations are met up to O(A^2), and the wave steepens
 * over a time of about wavelength / (A c). Reads gamma[0] > 1, density[0] > 0, pressure[0] > 0, wavelength >
 * 0, |amplitude| < 1 / gamma (else the pressure would be negative), origin, uniform_velocity. */
#include "validation/exact_parameters.h"

#include <math.h>

struct acoustic_wave {
  double gamma, density, pressure, amplitude, wavenumber, origin, sound, velocity[NDIM];
};

static kith_status acoustic_check(const struct kith_exact_parameters *p) {
  const char *const member = "acoustic-wave";
  KITH_TRY(kith_exact_require(p->gamma[0] > 1, member, "gamma[0]", p->gamma[0], "above 1"));
  KITH_TRY(kith_exact_require(p->density[0] > 0, member, "density[0]", p->density[0], "above 0"));
  KITH_TRY(kith_exact_require(p->pressure[0] > 0, member, "pressure[0]", p->pressure[0], "above 0"));
  KITH_TRY(kith_exact_require(p->wavelength > 0, member, "wavelength", p->wavelength, "above 0"));
  KITH_TRY(kith_exact_require(fabs(p->amplitude) * p->gamma[0] < 1, member, "amplitude", p->amplitude,
                              "between -1/gamma and 1/gamma"));
  KITH_TRY(kith_exact_require(true, member, "origin", p->origin, "finite"));
  for (int a = 0; a < NDIM; ++a)
    KITH_TRY(kith_exact_require(true, member, "uniform_velocity", p->uniform_velocity[a], "finite"));
  return KITH_OK;
}

static kith_status acoustic_create(void **self, const struct kith_exact_parameters *p) {
  KITH_TRY(acoustic_check(p));
  struct acoustic_wave *wave = NULL;
  KITH_TRY(kith_resize(&wave, 0, 1, sizeof *wave));
  *wave = (struct acoustic_wave){.gamma = p->gamma[0],
                                 .density = p->density[0],
                                 .pressure = p->pressure[0],
                                 .amplitude = p->amplitude,
                                 .wavenumber = 2 * M_PI / p->wavelength,
                                 .origin = p->origin,
                                 .sound = sqrt(p->gamma[0] * p->pressure[0] / p->density[0])};
  for (int a = 0; a < NDIM; ++a) wave->velocity[a] = p->uniform_velocity[a];
  *self = wave;
  return KITH_OK;
}

static void acoustic_state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct acoustic_wave *wave = self;
  const double travelled = (wave->sound + wave->velocity[0]) * time;
  const double s = wave->amplitude * sin(wave->wavenumber * (x[0] - wave->origin - travelled));
  for (int a = 0; a < NDIM; ++a) out->velocity[a] = wave->velocity[a];
  out->velocity[0] += wave->sound * s;
  out->density = wave->density * (1 + s);
  out->pressure = wave->pressure * (1 + wave->gamma * s);
  out->energy = kith_exact_energy(wave->gamma, out->density, out->pressure);
}

const struct kith_exact_ops kith_exact_acoustic_wave = {
    .name = "acoustic-wave",
    .doc = "travelling sound wave along axis 0 (linear theory)",
    .create = acoustic_create,
    .destroy = kith_exact_destroy,
    .state = acoustic_state,
};
