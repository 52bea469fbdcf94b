/* Equation of state of Tait and of Murnaghan: P = P0 + rho0 c0^2 / n ((rho / rho0)^n - 1), water with n = 7
 * (Cole 1948, Underwater Explosions), solids with n the derivative of their bulk modulus (Murnaghan 1944,
 * Proc. Natl. Acad. Sci. 30, 244). c = c0 (rho / rho0)^((n - 1) / 2). The energy has no effect. */
#include <math.h>
#include "physics/eos.h"

struct tait {
  double density, sound_speed, exponent, pressure;
};
#define IN(member) KITH_INTO(struct tait, member)
static const struct kith_param params[] = {
    {"density", KITH_PARAM_NUMBER, "1", "(0, inf)", "rho0", IN(density)},
    {"sound_speed", KITH_PARAM_NUMBER, "1", "(0, inf)", "c0, at rho0", IN(sound_speed)},
    {"exponent", KITH_PARAM_NUMBER, "7", "[1, inf)", "n: the bulk modulus grows by n times the pressure",
     IN(exponent)},
    {"pressure", KITH_PARAM_NUMBER, "0", "", "P0, at rho0", IN(pressure)},
    {0}};
#undef IN

static void state(const void *settings, kith_index n, const double *density, const double *energy,
                  double *pressure, double *sound_speed) {
  (void)energy;
  const struct tait *p = settings;
  const double c2 = p->sound_speed * p->sound_speed;
  for (kith_index i = 0; i < n; ++i) {
    const double ratio = density[i] / p->density, power = pow(ratio, p->exponent);
    pressure[i] = p->pressure + p->density * c2 / p->exponent * (power - 1);
    sound_speed[i] = sqrt(c2 * power / ratio);
  }
}

static struct kith_power_law power_law(const void *settings) {
  const struct tait *p = settings;
  return (struct kith_power_law){p->exponent,
                                 p->density * p->sound_speed * p->sound_speed / p->exponent - p->pressure};
}

const struct kith_eos_ops kith_eos_tait = {
    .name = "tait",
    .doc = "liquid or solid: P = P0 + rho0 c0^2 / n ((rho / rho0)^n - 1)",
    KITH_SETTINGS(params, tait),
    .state = state,
    .power_law = power_law,
    .barotropic = true};
