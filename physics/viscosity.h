/* viscosity.h - artificial viscosity, for packages whose pair functions take it: its parameters, and the
 * limited velocity difference that it acts on.
 *
 *     mu_ij = min(0, D_ij) / |x_ij|,  D_ij = v_ij . x_ij, or if limited that of the velocities extrapolated
 *     to the middle of the pair,
 *     D_ij = max(v_ij . x_ij - phi (x_ij.G_i.x_ij + x_ij.G_j.x_ij) / 2, v_ij . x_ij)
 * with G the linear-exact velocity gradient and phi van Leer's limiter of the ratio r of both slopes,
 * 4 r / (1 + r)^2, times 1 - (5 (s - 1))^2 for pairs closer than s = 1 mean node spacings, not below 0
 * (Frontiere, Raskin and Owen 2017, JCoPh 332, 160, eqs. 48-50). mu is 0 for pairs that separate.
 * No loops over pairs: the functions vectorize in the loops of who calls them. */
#ifndef KITH_PHYSICS_VISCOSITY_H
#define KITH_PHYSICS_VISCOSITY_H

#include "lib/core/choices.h"
#include "lib/core/param.h"
#include "lib/core/symmetric.h"
#include "lib/core/vec.h"

/* name, choice in a scene, doc */
#define KITH_VISCOSITY_LIST(X)                                                                     \
  X(NONE, none, "none: for flows without shocks")                                                  \
  X(MONAGHAN, monaghan, "on every approaching pair alike")                                         \
  X(LIMITED, limited,                                                                              \
    "on the velocity difference that limited gradients leave: little in smooth flow; the default") \
  X(CULLEN_DEHNEN, cullen_dehnen,                                                                  \
    "on every approaching pair, with a coefficient that rises ahead of a shock and decays behind it (sph)")
enum kith_viscosity {
#define X(name, word, doc) KITH_VISCOSITY_##name,
  KITH_VISCOSITY_LIST(X)
#undef X
};

/* What a scene sets; the settings of a package have it as their member `viscosity`. */
struct kith_viscosity_settings {
  enum kith_viscosity name;
  double alpha, beta;
};
/* Rows of a parameter table for the settings `type`; choices: "|none|monaghan...", those that it has. */
#define KITH_VISCOSITY_PARAMS(type, choices)                                                                 \
  {"name", KITH_PARAM_CHOICE, "limited", choices, "its form", KITH_INTO(type, viscosity.name)},              \
      {"alpha", KITH_PARAM_NUMBER, "1", "[0, inf)", "linear coefficient", KITH_INTO(type, viscosity.alpha)}, \
  {                                                                                                          \
    "beta", KITH_PARAM_NUMBER, "2", "[0, inf)", "quadratic coefficient", KITH_INTO(type, viscosity.beta)     \
  }

/* What all pairs share. */
struct kith_viscosity_constants {
  double alpha, beta; /* 0 without viscosity */
  double spacings;    /* H in mean node spacings */
  double limited;     /* 1: the velocity difference is limited */
};
static inline struct kith_viscosity_constants kith_viscosity_constants(
    const struct kith_viscosity_settings *settings, double neighbors) {
  const bool viscous = settings->name != KITH_VISCOSITY_NONE;
  return (struct kith_viscosity_constants){.alpha = viscous ? settings->alpha : 0,
                                           .beta = viscous ? settings->beta : 0,
                                           .spacings = pow(neighbors / kith_ball(), 1.0 / NDIM),
                                           .limited = settings->name == KITH_VISCOSITY_LIMITED};
}

/* mu, from vx = v_ij . x_ij, the slopes x_ij.G.x_ij of both ends, the distance over the smaller support. */
KITH_INLINE double kith_viscosity_mu(const struct kith_viscosity_constants *c, double vx, double slope_i,
                                     double slope_j, double q, double inverse_r) {
  const double product = slope_i * slope_j, sum = slope_i + slope_j;
  const double van_leer = product > 0 ? 4 * product / (sum * sum) : 0;
  const double closer = 5 * KITH_MIN(c->spacings * q - 1, 0.0);
  const double phi = van_leer * KITH_MAX(1 - closer * closer, 0.0);
  const double limited = KITH_MAX(vx - 0.5 * phi * sum, vx);
  const double difference = c->limited > 0 ? limited : vx;
  return vx < 0 ? KITH_MIN(difference, 0.0) * inverse_r : 0;
}

/* The signal speed of a pair with this mean sound speed. */
KITH_INLINE double kith_viscosity_signal(const struct kith_viscosity_constants *c, double sound, double mu) {
  return KITH_MAX(c->alpha, 1.0) * sound - c->beta * mu;
}

#endif
