/* sph.h - package `sph`: density-energy SPH with grad-h terms. Private to its folder.
 *
 * Number density n_i = sum_j W(r_ij, H_i), self included (with its weight: kernel.h), density rho_i = sum_j m_j W(r_ij, H_i), and
 * the support solves
 *     ball H_i^d n_i = neighbors                                                          (1)
 * by Newton's method in ln H inside a bracket. So supports follow the nodes and not their masses. From the Lagrangian, with
 *     X_i = H_i / (d n_i Omega_i) drho_i/dH_i,  Omega_i = 1 + H_i / (d n_i) dn_i/dH_i      (2)
 *     psi_i = m_i P_i / rho_i^2  (Hopkins 2013, MNRAS 428, 2840; m_j - X_i = m / Omega if all masses are equal)
 *     m_i dv_i/dt = - sum_j [psi_i (m_j - X_i) grad_i W(H_i) + psi_j (m_i - X_j) grad_i W(H_j) + m_i m_j Pi_ij grad_i W_mean]   (3)
 *     m_i du_i/dt =   sum_j [psi_i (m_j - X_i) v_ij . grad_i W(H_i) + (1/2) m_i m_j Pi_ij v_ij . grad_i W_mean]               (4)
 *     Pi_ij = (-alpha c_mean mu + beta mu^2) / rho_mean, mu = min(0, v_ij . x_ij / |x_ij|) (Monaghan 1997)   (5)
 * viscosity `limited`: the jump is taken between velocities extrapolated to the middle of the pair,
 *     v_ij - phi (G_i + G_j) x_ij / 2, G the linear-exact velocity gradient, phi van Leer's limiter of the ratio of the two slopes
 *     along x_ij, switched off for pairs closer than eta_c (Frontiere, Raskin and Owen 2017, eqs. 48-50).
 *
 * Passes: density (support, gradients) -> equation of state -> ghosts -> records -> force [pairs] -> ghosts -> work. */
#ifndef KITH_PHYSICS_SPH_SPH_H
#define KITH_PHYSICS_SPH_SPH_H

#include "lib/connectivity/traversal.h"
#include "physics/package.h"

enum { SPH_SHEAR = NDIM * (NDIM + 1) / 2 };

/* What a pair reads of a node, together in memory: a record of doubles, at these places. */
enum {
  SPH_X = 0,
  SPH_V = NDIM,
  SPH_INVERSE = 2 * NDIM, /* 1 / H */
  SPH_PSI,                /* m P / rho^2 */
  SPH_EXCESS,             /* X */
  SPH_MASS,
  SPH_DENSITY,
  SPH_SOUND,
  SPH_GRADIENT, /* symmetric part of the velocity gradient, upper triangle: x.G.x needs no more */
  SPH_RECORD = (SPH_GRADIENT + SPH_SHEAR + 1) / 2 * 2 /* doubles in a record: an even number */
};

/* What a pair gives, as a pairwise field and as lanes of scratch: f = force x_ij acts on i, and i gets heat x_ij . v_ji of its work. */
enum { SPH_FORCE, SPH_HEAT, SPH_SIGNAL, SPH_PAIR_VALUES };

struct sph {
  struct kith_field *excess, *shear, *signal; /* shear: NULL unless the viscosity is limited */
  double *record;                             /* [capacity][SPH_RECORD], internal nodes and ghosts */
  size_t record_capacity;
  struct kith_pairwise pair;
};

/* One pass: what its chunks read. */
struct sph_pass {
  struct kith_package *package;
  struct sph *sph;
  const struct kith_connectivity *connectivity;
  double constant, spacings; /* of the kernel; H in mean node spacings */
  bool equal_masses;         /* of all nodes */
  bool work;                 /* the force pass sums rate and slope of the energy instead of accelerations */
};

/* (1), (2), density, expansion, velocity gradient. REACH if a support outgrew its reach. */
kith_status sph_density(struct sph_pass *pass);
/* Fills the records of all nodes. */
kith_status sph_pack(struct sph_pass *pass);
/* (3) - (5) into accelerations, signal speeds and, if thermal, energy rates. */
kith_status sph_force(struct sph_pass *pass);
/* Compatible energy: rate and slope from the forces of the same pairs. */
kith_status sph_work(struct sph_pass *pass);

#endif
