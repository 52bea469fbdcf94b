/* mfm.h - package `mfm`: meshless finite mass, a Riemann solver on faces that move with the gas (Hopkins
 * 2015, MNRAS 450, 53). The struct is for tests.
 *
 * Supports and volumes by number density, rho_i = m_i n_i (density.h); faces A_ij from i to j (faces.h); the
 * contact of the two gases at a face gives P* and S* (riemann.h). Nothing crosses a face that moves with the
 * contact, so masses are fixed:
 *     m_i dv_i/dt = - sum_j P*_ij A_ij                                                    (1)
 *     m_i du_i/dt = - sum_j P*_ij A_ij . (v*_ij - v_i),  v* = (v_i + v_j) / 2 + S* A_ij / |A_ij|    (2)
 * S* is relative to the mean velocity, so results are Galilean invariant. In terms of package.h a
 * pair has the force f = -P* A, shares its work evenly, and exchanges f . (v* - (v_i + v_j) / 2). The heat
 * that a face takes from a node is limited by the pressure of the node: of h_i < 0 at P* > 4 P_i, its partner
 * gives
 *     (1 - 4 P_i / P*) |h_i|                                                              (3)
 * without which the energy of a cold node beside a hot one, accelerated beyond the speed of the face, would
 * become negative. It is 0 where pressures are within a factor 4.
 *
 * The states at the middle of a pair are reconstructed from linear-exact gradients of rho, P and of the
 * velocity along the face. Of each with the difference D = q_j - q_i and the slope a = grad q_i . (x_j -
 * x_i),
 *     q_i' = q_i + L(a, D) / 2,  L = a within -D and 1.5 D                                 (4)
 * (the limiter of pairs of Hopkins 2015, psi_1 = 1/2, psi_2 = 1/4); density and pressure lose no more than
 * half. Chosen by experiment: van Leer's, L between 0 and D, has 1.5 times the error in Gresho's vortex and
 * 0.9 times in Sod's tube; with L up to 2 D Noh's problem fails.
 *
 * Passes: density -> equation of state -> ghosts -> gradients, matrices -> ghosts -> faces -> packing ->
 * force [pairs] -> ghosts -> work. */
#ifndef KITH_PHYSICS_MFM_MFM_H
#define KITH_PHYSICS_MFM_MFM_H

#include "physics/mfm/faces.h"
#include "physics/passes/force.h"

struct mfm {
  struct mfm_faces faces;
  struct kith_force_scratch force;
  struct kith_field *velocity_slope, *density_slope, *pressure_slope;
};

/* All faces, closed if they are to be. Supports of ghosts are refreshed (and the matrix); the fields that
 * belong to the faces are refreshed here. Collective. */
kith_status mfm_faces_build(struct mfm_faces *faces, const struct kith_connectivity *connectivity);

#endif
