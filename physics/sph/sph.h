/* sph.h - package `sph`: density-energy SPH with grad-h terms. Private to its folder.
 *
 * Number density n_i = sum_j W(r_ij, H_i), self included, density rho_i = m_i n_i, and the support solves
 *     ball H_i^d n_i = neighbors                                                          (1)
 * by Newton's method in ln H inside a bracket. With equal masses this is the usual rho H^d = const; with unequal masses the
 * sums stay smooth where only the mass jumps (Hopkins 2013, MNRAS 428, 2840, density-energy form).
 *     Omega_i = 1 + H_i / (d n_i) dn_i/dH_i = - sum q^2 g / (d sum w)                        (2)
 *     m_i dv_i/dt = - sum_j [psi_i grad_i W(H_i) + psi_j grad_i W(H_j) + m_i m_j Pi_ij grad_i W_mean],
 *         psi = P / (Omega n^2)                                                            (3)
 *     m_i du_i/dt =   sum_j [psi_i v_ij . grad_i W(H_i) + (1/2) m_i m_j Pi_ij v_ij . grad_i W_mean]   (4)
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

/* What a pair reads of a node, together in memory. */
struct sph_record {
  double x[NDIM], v[NDIM];
  double inverse_support; /* 1 / H */
  double psi;             /* m P / rho^2 */
  double excess;          /* X */
  double mass, density, sound_speed;
  double shear[SPH_SHEAR]; /* symmetric part of the velocity gradient, upper triangle: x.G.x needs no more */
};

/* What a pair gives, as a pairwise field and as lanes of scratch: f = force x_ij acts on i, and i gets heat x_ij . v_ji of its work. */
enum { SPH_FORCE, SPH_HEAT, SPH_SIGNAL, SPH_PAIR_VALUES };

struct sph {
  struct kith_field *omega, *gradient, *signal; /* gradient: NULL unless the viscosity is limited */
  struct sph_record *record;                  /* [capacity], internal and ghosts */
  size_t record_capacity;
  struct kith_pairwise pair;
};

/* One pass: what its chunks read. */
struct sph_pass {
  struct kith_package *package;
  struct sph *sph;
  const struct kith_connectivity *connectivity;
  bool work; /* the force pass sums rate and slope of the energy instead of accelerations */
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
