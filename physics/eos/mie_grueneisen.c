/* Equation of state of Mie and Grueneisen about the Hugoniot of a solid whose shocks run with u_s = c0 + s
 * u_p (Rice, McQueen and Walsh 1958, Solid State Phys. 6, 1), with Gamma rho constant, x = 1 - rho0 / rho:
 *
 *   P = P_H + Gamma0 rho0 (u - u_H)
 *   compressed   P_H = rho0 c0^2 x / (1 - s x)^2,  u_H = P_H x / (2 rho0);  x < 1 / s, where P_H has its pole
 *   expanded     P_H = c0^2 (rho - rho0),          u_H = 0
 *   c^2 = dP/drho + P / rho^2 Gamma0 rho0
 *
 * The energy is 0 at rho0 and P = 0, and may be negative. In tension c^2 falls to 0: there it tears.
 *
 * Chosen before Tillotson's: three constants that are tabulated for every metal, and planar shocks are known
 * exactly, whatever their strength. It knows no melting and no vapor. */
#include <math.h>
#include "physics/eos.h"

struct mie_grueneisen {
  double density, sound_speed, slope, gamma;
};
#define IN(member) KITH_INTO(struct mie_grueneisen, member)
static const struct kith_param params[] = {
    {"density", KITH_PARAM_NUMBER, "1", "(0, inf)", "rho0", IN(density)},
    {"sound_speed", KITH_PARAM_NUMBER, "1", "(0, inf)", "c0, at rho0", IN(sound_speed)},
    {"slope", KITH_PARAM_NUMBER, "1.5", "[1, inf)",
     "s in shock speed = c0 + s times the speed of the material behind it", IN(slope)},
    {"gamma", KITH_PARAM_NUMBER, "2", "(0, inf)", "Grueneisen's Gamma0, at rho0", IN(gamma)},
    {0}};
#undef IN

/* Returns P_H - Gamma0 rho0 u_H; *slope: its derivative by rho. Constant from 0.999 of the pole on. */
static double reference(const struct mie_grueneisen *p, double density, double *slope) {
  const double c2 = p->sound_speed * p->sound_speed, x = 1 - p->density / density;
  *slope = c2;
  if (x <= 0) return c2 * (density - p->density);
  const double within = KITH_MIN(x, 0.999 / p->slope), pole = 1 / (1 - p->slope * within);
  const double h = p->density * c2 * within * pole * pole,
               dh = p->density * c2 * (1 + p->slope * within) * pole * pole * pole;
  *slope = (dh - 0.5 * p->gamma * (dh * within + h)) * p->density / (density * density);
  return h * (1 - 0.5 * p->gamma * within);
}

static void state(const void *settings, kith_index n, const double *density, const double *energy,
                  double *pressure, double *sound_speed) {
  const struct mie_grueneisen *p = settings;
  const double thermal = p->gamma * p->density;
  for (kith_index i = 0; i < n; ++i) {
    double slope;
    pressure[i] = reference(p, density[i], &slope) + thermal * energy[i];
    sound_speed[i] = sqrt(KITH_MAX(slope + thermal * pressure[i] / (density[i] * density[i]), 0.0));
  }
}

static double energy_of(const void *settings, double density, double pressure) {
  const struct mie_grueneisen *p = settings;
  double slope;
  return (pressure - reference(p, density, &slope)) / (p->gamma * p->density);
}

static const char *outside(const void *settings, double density, double energy) {
  (void)energy;
  const struct mie_grueneisen *p = settings;
  return p->slope * (1 - p->density / density) < 0.999
             ? NULL
             : "it is compressed beyond what the Hugoniot of its material allows";
}

const struct kith_eos_ops kith_eos_mie_grueneisen = {
    .name = "mie-grueneisen",
    .doc = "solid whose shock speed is linear in the particle velocity",
    KITH_SETTINGS(params, mie_grueneisen),
    .state = state,
    .energy = energy_of,
    .outside = outside};
