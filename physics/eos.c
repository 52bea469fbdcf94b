/* The family of equations of state; members are in eos/. */
#include "physics/eos.h"
#include "lib/core/family.h"

#define X(name) &kith_eos_##name,
KITH_FAMILY(kith_eos, KITH_EOS_LIST(X))
#undef X

void kith_material_state(const struct kith_material *material, kith_index n, const double *density,
                         const double *energy, double *pressure, double *sound_speed) {
  material->eos->state(material->settings, n, density, energy, pressure, sound_speed);
  for (kith_index i = 0; material->cut && i < n; ++i) {
    const double modulus = density[i] * sound_speed[i] * sound_speed[i];
    if (pressure[i] < -1e-12 * modulus) sound_speed[i] = 0;
    if (pressure[i] < 0) pressure[i] = 0; /* not if it is no number */
  }
}

double kith_material_gamma(const struct kith_material *material, double density, double energy) {
  const struct kith_eos_ops *eos = material->eos;
  if (eos->power_law != NULL) return eos->power_law(material->settings).gamma;
  const double step = 1e-4 * density;
  double p[2], c[2];
  eos->state(material->settings, 1, &density, &energy, p, c);
  const double heat = p[0] / (density * density) * step, rho[] = {density - step, density + step},
               u[] = {energy - heat, energy + heat};
  eos->state(material->settings, 2, rho, u, p, c);
  const double gamma = (rho[1] * c[1] * c[1] - rho[0] * c[0] * c[0]) / (p[1] - p[0]);
  return p[1] > p[0] ? KITH_MIN(KITH_MAX(gamma, 1.0), 20.0) : 1;
}

const char *kith_material_outside(const struct kith_material *material, double density, double energy,
                                  double pressure, double sound_speed) {
  const struct kith_eos_ops *eos = material->eos;
  if (eos->energy_positive && energy < 0) return "its energy is negative";
  /* The last evaluation may have been of a predicted state that the node never reaches: evaluate this one. */
  if (pressure < 0 && sound_speed == 0)
    kith_material_state(material, 1, &density, &energy, &pressure, &sound_speed);
  if (pressure < 0 && sound_speed == 0)
    return "it is torn: its equation of state has no such tension; with tension: cut there is none";
  const bool torn = material->cut && pressure == 0;
  return eos->outside != NULL && !torn ? eos->outside(material->settings, density, energy) : NULL;
}
