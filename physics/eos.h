/* eos.h - equations of state, one family: P(rho, u) and c(rho, u) of a material, and what follows from them.
 * Each node list has one. Each member is a file in eos/, which states its equations. */
#ifndef KITH_PHYSICS_EOS_H
#define KITH_PHYSICS_EOS_H

#include "lib/core/param.h"

/* rho c^2 = gamma (P + stiffness) in all states: assumed by exact solutions and Riemann solvers. */
struct kith_power_law {
  double gamma, stiffness;
};

struct kith_eos_ops {
  const char *name, *doc;
  const struct kith_param *params; /* its own parameters, NULL: none; `settings` below are their values */
  size_t settings_size;
  /* Appends to the settings the contents of the file in its parameter `file`, relative to `folder` unless
   * that is absolute; they stay one block of memory. BAD_INPUT says what is wrong where. NULL: it has no
   * file. */
  kith_status (*load)(void **settings, const char *folder);
  /* Computes pressure[i], sound_speed[i] from density[i], energy[i] for n nodes. c = 0 where c^2 would be
   * negative. At every density and energy, also outside of the range, all values are finite, and the pressure
   * grows with the energy unless barotropic. */
  void (*state)(const void *settings, kith_index n, const double *density, const double *energy,
                double *pressure, double *sound_speed);
  /* Returns the specific energy that gives this pressure at this density, whatever it is. NULL if
   * barotropic. */
  double (*energy)(const void *settings, double density, double pressure);
  struct kith_power_law (*power_law)(const void *settings); /* NULL: no such law */
  /* Returns what is wrong with a state that it does not cover, or NULL. Without this function it covers
   * all. */
  const char *(*outside)(const void *settings, double density, double energy);
  bool energy_positive; /* u < 0 is outside of the physical range */
  bool barotropic;      /* the pressure does not depend on the energy */
};

#define KITH_EOS_LIST(X) X(ideal) X(isothermal) X(stiffened) X(tait) X(mie_grueneisen) X(table)
#define X(name) extern const struct kith_eos_ops kith_eos_##name;
KITH_EOS_LIST(X)
#undef X
KITH_FAMILY_FUNCTIONS(kith_eos);

struct kith_material {
  const struct kith_eos_ops *eos;
  const void *settings; /* of its equation of state; borrowed */
  bool cut;             /* bears no tension: where P would be negative, P and c are 0 */
};

/* Computes pressure and sound speed of n nodes, as `state`, but cuts tension if the material bears none. A
 * tension of 1e-12 of the modulus rho c^2 is round-off of a solid at rest, which keeps its sound speed. */
void kith_material_state(const struct kith_material *material, kith_index n, const double *density,
                         const double *energy, double *pressure, double *sound_speed);
/* Returns the specific energy that gives this pressure at this density; 0 for a barotropic material. */
static inline double kith_material_energy(const struct kith_material *material, double density,
                                          double pressure) {
  return material->eos->barotropic ? 0 : material->eos->energy(material->settings, density, pressure);
}
/* Returns d(rho c^2) / dP along the isentrope: gamma of a power law, else by differences and within 1 to 20.
 * (gamma + 1) / 4 is how the speed of a weak shock grows with the particle velocity, and rho c^2 / gamma is
 * the pressure above that at which the material comes apart. */
double kith_material_gamma(const struct kith_material *material, double density, double energy);
/* Returns what is wrong with a state, or NULL; pressure and sound speed are those of its last evaluation. */
const char *kith_material_outside(const struct kith_material *material, double density, double energy,
                                  double pressure, double sound_speed);

#endif
