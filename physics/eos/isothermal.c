/* Equation of state of an isothermal gas: P = c0^2 rho, c = c0. The energy has no effect. */
#include "physics/eos.h"

struct isothermal {
  double sound_speed;
};
static const struct kith_param params[] = {
    {"sound_speed", KITH_PARAM_NUMBER, "1", "(0, inf)", "c0", KITH_INTO(struct isothermal, sound_speed)},
    {0}};

static void state(const void *settings, kith_index n, const double *density, const double *energy,
                  double *pressure, double *sound_speed) {
  (void)energy;
  const double c0 = ((const struct isothermal *)settings)->sound_speed;
#pragma omp simd
  for (kith_index i = 0; i < n; ++i) {
    pressure[i] = c0 * c0 * density[i];
    sound_speed[i] = c0;
  }
}

static struct kith_power_law power_law(const void *settings) {
  (void)settings;
  return (struct kith_power_law){1, 0};
}

const struct kith_eos_ops kith_eos_isothermal = {.name = "isothermal",
                                                 .doc = "isothermal gas: P = c0^2 rho",
                                                 KITH_SETTINGS(params, isothermal),
                                                 .state = state,
                                                 .power_law = power_law,
                                                 .barotropic = true};
