#include "physics/eos.h"

#include "lib/core/family.h"

#include <math.h>

static void ideal_state(const struct kith_eos_parameters *p, kith_index n, const double *density,
                        const double *energy, double *pressure, double *sound_speed) {
  const double g1 = p->gamma - 1, gg1 = p->gamma * g1;
#pragma omp parallel for simd schedule(static)
  for (kith_index i = 0; i < n; ++i) {
    pressure[i] = g1 * density[i] * energy[i];
    sound_speed[i] = sqrt(KITH_MAX(gg1 * energy[i], 0.0));
  }
}

static double ideal_energy(const struct kith_eos_parameters *p, double density, double pressure) {
  return pressure / ((p->gamma - 1) * density);
}

static void isothermal_state(const struct kith_eos_parameters *p, kith_index n, const double *density,
                             const double *energy, double *pressure, double *sound_speed) {
  (void)energy;
  const double c0 = p->sound_speed;
#pragma omp parallel for simd schedule(static)
  for (kith_index i = 0; i < n; ++i) {
    pressure[i] = c0 * c0 * density[i];
    sound_speed[i] = c0;
  }
}

/* Any energy gives the same pressure: zero. */
static double isothermal_energy(const struct kith_eos_parameters *p, double density, double pressure) {
  (void)p, (void)density, (void)pressure;
  return 0;
}

static void stiffened_state(const struct kith_eos_parameters *p, kith_index n, const double *density,
                            const double *energy, double *pressure, double *sound_speed) {
  const double g = p->gamma, p0 = p->stiffness;
#pragma omp parallel for simd schedule(static)
  for (kith_index i = 0; i < n; ++i) {
    pressure[i] = (g - 1) * density[i] * energy[i] - g * p0;
    sound_speed[i] = sqrt(KITH_MAX(g * (pressure[i] + p0) / density[i], 0.0));
  }
}

static double stiffened_energy(const struct kith_eos_parameters *p, double density, double pressure) {
  return (pressure + p->gamma * p->stiffness) / ((p->gamma - 1) * density);
}

const struct kith_eos_ops kith_eos_ideal = {"ideal", "ideal gas: gamma", ideal_state, ideal_energy, true};
const struct kith_eos_ops kith_eos_isothermal = {"isothermal", "isothermal gas: sound_speed",
                                                 isothermal_state, isothermal_energy, false};
const struct kith_eos_ops kith_eos_stiffened = {"stiffened", "stiffened gas: gamma, stiffness",
                                                stiffened_state, stiffened_energy, true};

#define X(name) &kith_eos_##name,
KITH_FAMILY(kith_eos, KITH_EOS_LIST(X))
#undef X
