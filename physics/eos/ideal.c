/* Equation of state of an ideal gas: P = (gamma - 1) rho u, c^2 = gamma P / rho. */
#include <math.h>
#include "physics/eos.h"

struct ideal {
  double gamma;
};
static const struct kith_param params[] = {{"gamma", KITH_PARAM_NUMBER, "1.4", "(1, inf)",
                                            "ratio of specific heats", KITH_INTO(struct ideal, gamma)},
                                           {0}};

static void state(const void *settings, kith_index n, const double *density, const double *energy,
                  double *pressure, double *sound_speed) {
  const struct ideal *p = settings;
  const double g1 = p->gamma - 1, gg1 = p->gamma * g1;
#pragma omp simd
  for (kith_index i = 0; i < n; ++i) {
    pressure[i] = g1 * density[i] * energy[i];
    sound_speed[i] = sqrt(KITH_MAX(gg1 * energy[i], 0.0));
  }
}

static double energy_of(const void *settings, double density, double pressure) {
  return pressure / ((((const struct ideal *)settings)->gamma - 1) * density);
}

static struct kith_power_law power_law(const void *settings) {
  return (struct kith_power_law){((const struct ideal *)settings)->gamma, 0};
}

const struct kith_eos_ops kith_eos_ideal = {.name = "ideal",
                                            .doc = "ideal gas: P = (gamma - 1) rho u",
                                            KITH_SETTINGS(params, ideal),
                                            .state = state,
                                            .energy = energy_of,
                                            .power_law = power_law,
                                            .energy_positive = true};
