/* Equation of state of a stiffened gas (water, metals under pressure): P = (gamma - 1) rho u - gamma P0,
 * c^2 = gamma (P + P0) / rho (Harlow and Amsden 1971, LANL report LA-4700). */
#include <math.h>
#include "physics/eos.h"

struct stiffened {
  double gamma, stiffness;
};
static const struct kith_param params[] = {
    {"gamma", KITH_PARAM_NUMBER, "1.4", "(1, inf)", "ratio of specific heats",
     KITH_INTO(struct stiffened, gamma)},
    {"stiffness", KITH_PARAM_NUMBER, "0", "[0, inf)", "P0", KITH_INTO(struct stiffened, stiffness)},
    {0}};

static void state(const void *settings, kith_index n, const double *density, const double *energy,
                  double *pressure, double *sound_speed) {
  const struct stiffened *p = settings;
  const double g = p->gamma, p0 = p->stiffness;
#pragma omp simd
  for (kith_index i = 0; i < n; ++i) {
    pressure[i] = (g - 1) * density[i] * energy[i] - g * p0;
    sound_speed[i] = sqrt(KITH_MAX(g * (pressure[i] + p0) / density[i], 0.0));
  }
}

static double energy_of(const void *settings, double density, double pressure) {
  const struct stiffened *p = settings;
  return (pressure + p->gamma * p->stiffness) / ((p->gamma - 1) * density);
}

static struct kith_power_law power_law(const void *settings) {
  const struct stiffened *p = settings;
  return (struct kith_power_law){p->gamma, p->stiffness};
}

const struct kith_eos_ops kith_eos_stiffened = {.name = "stiffened",
                                                .doc = "stiffened gas: P = (gamma - 1) rho u - gamma P0",
                                                KITH_SETTINGS(params, stiffened),
                                                .state = state,
                                                .energy = energy_of,
                                                .power_law = power_law,
                                                .energy_positive = true};
