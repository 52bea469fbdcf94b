/* eos.h - equations of state: one family. A node list (material) has one.
 *
 *   ideal       P = (gamma - 1) rho u                    c^2 = gamma P / rho
 *   isothermal  P = c0^2 rho                             c   = c0           (u is carried along, without effect)
 *   stiffened   P = (gamma - 1) rho u - gamma P0         c^2 = gamma (P + P0) / rho */
#ifndef KITH_PHYSICS_EOS_H
#define KITH_PHYSICS_EOS_H

#include "lib/core/base.h"

struct kith_eos_parameters {
  double gamma;       /* ideal, stiffened: > 1 */
  double sound_speed; /* isothermal: c0 > 0 */
  double stiffness;   /* stiffened: P0 >= 0 */
};

struct kith_eos_ops {
  const char *name, *doc;
  /* pressure[i], sound_speed[i] from density[i], energy[i] for n nodes. c = 0 where c^2 would be negative. */
  void (*state)(const struct kith_eos_parameters *p, kith_index n, const double *density,
                const double *energy, double *pressure, double *sound_speed);
  /* Specific energy that gives this pressure at this density. */
  double (*energy)(const struct kith_eos_parameters *p, double density, double pressure);
  bool energy_positive; /* u < 0 is outside of the physical range */
};

#define KITH_EOS_LIST(X) X(ideal) X(isothermal) X(stiffened)
#define X(name) extern const struct kith_eos_ops kith_eos_##name;
KITH_EOS_LIST(X)
#undef X
const struct kith_eos_ops *kith_eos_find(const char *name); /* NULL if there is none */
const struct kith_eos_ops *const *kith_eos_all(void);       /* ended by NULL */

#endif
