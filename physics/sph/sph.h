/* sph.h - package `sph`: density-energy SPH with grad-h terms. Private to its folder.
 *
 * Supports by number density, density by masses, and X and Omega as in density.h. From the Lagrangian, with
 *     psi_i = m_i P_i / rho_i^2  (Hopkins 2013, MNRAS 428, 2840; m_j - X_i = m / Omega if all masses are equal)
 *     m_i dv_i/dt = - sum_j [psi_i (m_j - X_i) grad_i W(H_i) + psi_j (m_i - X_j) grad_i W(H_j) + m_i m_j Pi_ij grad_i W_mean]   (3)
 *     m_i du_i/dt =   sum_j [psi_i (m_j - X_i) v_ij . grad_i W(H_i) + (1/2) m_i m_j Pi_ij v_ij . grad_i W_mean]               (4)
 *     Pi_ij = s_mean (-alpha c_mean mu + beta mu^2) / rho_mean, mu = min(0, v_ij . x_ij / |x_ij|) (Monaghan 1997)   (5)
 * viscosity `limited`: the jump is taken between velocities extrapolated to the middle of the pair,
 *     v_ij - phi (G_i + G_j) x_ij / 2, G the linear-exact velocity gradient, phi van Leer's limiter of the ratio of the two slopes
 *     along x_ij, switched off for pairs closer than eta_c (Frontiere, Raskin and Owen 2017, eqs. 48-50).
 * viscosity `cullen-dehnen`: s follows the compression rate (Cullen and Dehnen 2010, MNRAS 408, 669; in the form of Price et al. 2018,
 *     PASA 35, e031, eqs. 45-48): with A = max(0, -d(div v)/dt) where div v < 0, times (div v)^2 / ((div v)^2 + (curl v)^2), h = 2 sigma,
 *     s_local = min(1, 10 h^2 A / c^2); s rises to it at once and decays to it in the time h / (0.1 v_signal)     (6)
 * Balsara's factor multiplies s (Balsara 1995). conduction a_u: heat m_i m_j a_u v_u (u_i - u_j) / rho_mean |x_ij . grad W_mean| / |x_ij|,
 *     v_u = sqrt(|P_i - P_j| / rho_mean) (Price 2008, JCoPh 227, 10040): none where pressure is even.              (7)
 *
 * Passes: density -> equation of state, switches -> ghosts -> records -> force [pairs] -> ghosts -> work. */
#ifndef KITH_PHYSICS_SPH_SPH_H
#define KITH_PHYSICS_SPH_SPH_H

#include "physics/density.h"
#include "physics/force.h"

/* What a pair reads of a node. */
enum {
  SPH_INVERSE = KITH_RECORD_OWN, /* 1 / H */
  SPH_PSI,                       /* m P / rho^2 */
  SPH_EXCESS,                    /* X */
  SPH_MASS,
  SPH_DENSITY,
  SPH_SOUND,
  SPH_GRADIENT, /* symmetric part of the velocity gradient, upper triangle: x.G.x needs no more */
  SPH_SIMPLE = SPH_GRADIENT + KITH_SYMMETRIC_SIZE, /* members of a record without switches */
  SPH_SWITCH = SPH_SIMPLE,                         /* s */
  SPH_ENERGY,
  SPH_FULL /* all members */
};

struct sph {
  bool full; /* a scene needs switches or conduction: records have all members */
  struct kith_field *excess, *shear, *curl, *compression; /* NULL unless needed, but for excess */
  struct kith_field *strength, *factor;                   /* s of (6), state; s with Balsara's factor */
};

/* What all pairs share. */
struct sph_constants {
  double alpha, beta, conduction;
  double kernel;   /* C of the kernel */
  double spacings; /* H in mean node spacings */
  double limited;  /* 1: the jump is limited */
};

/* Fills the records of all nodes, and sums (3) - (7). */
kith_status sph_pairs(struct kith_package *package, const struct kith_connectivity *connectivity);

#endif
