/* eos.h - equations of state, one family: P(rho, u) and c(rho, u) of a material, and what follows from them.
 * A node list has one. Each member is a file in eos/, which states its equations. */
#ifndef KITH_PHYSICS_EOS_H
#define KITH_PHYSICS_EOS_H

#include "lib/core/param.h"

struct kith_eos_ops {
  const char *name, *doc;
  const struct kith_param *params; /* its own parameters, NULL: none; `settings` below are their values */
  size_t settings_size;
  /* pressure[i], sound_speed[i] from density[i], energy[i] for n nodes. c = 0 where c^2 would be negative. */
  void (*state)(const void *settings, kith_index n, const double *density, const double *energy,
                double *pressure, double *sound_speed);
  /* Specific energy that gives this pressure at this density. */
  double (*energy)(const void *settings, double density, double pressure);
  /* gamma of rho c^2 = gamma P + constant along an isentrope. Packages with a Riemann solver (mfm) require
   * it, and refuse a member without, NULL: (gamma + 1) / 2 is the slope of the shock speed over the particle
   * velocity, and rho c^2 / gamma the pressure above vacuum. */
  double (*effective_gamma)(const void *settings);
  bool energy_positive; /* u < 0 is outside of the physical range */
  bool gamma_law;       /* P = (gamma - 1) rho u: what exact solutions for an ideal gas assume */
};

#define KITH_EOS_LIST(X) X(ideal) X(isothermal) X(stiffened)
#define X(name) extern const struct kith_eos_ops kith_eos_##name;
KITH_EOS_LIST(X)
#undef X
KITH_FAMILY_FUNCTIONS(kith_eos);

#endif
