/* mfm.h - package `mfm`: meshless finite mass, a Riemann solver on faces that move with the gas (Hopkins 2015, MNRAS 450, 53). Private
 * to its folder.
 *
 * Supports and volumes by number density, rho_i = m_i n_i (density.h); faces A_ij from i to j (faces.h); the contact of the two gases at a
 * face gives P* and S* (riemann.h). Nothing crosses a face that moves with the contact, so masses are fixed:
 *     m_i dv_i/dt = - sum_j P*_ij A_ij                                                    (1)
 *     m_i du_i/dt = - sum_j P*_ij A_ij . (v*_ij - v_i),  v* = (v_i + v_j) / 2 + S* A_ij / |A_ij|    (2)
 * S* taken in the frame of the mean velocity: results do not depend on who watches. In terms of package.h a pair has the force
 * f = -P* A, shares its work evenly, and exchanges f . (v* - (v_i + v_j) / 2). Gas that cools pays from its own pressure: of a heat h_i < 0
 * that a face takes from it at P* > 4 P_i, its partner pays
 *     (1 - 4 P_i / P*) |h_i|                                                              (3)
 * or a cold node beside a hot one, pushed on faster than the face, would fall below 0. Where pressures are within a factor 4 that is nothing.
 *
 * The states at the middle of a pair are reconstructed from linear-exact gradients of rho, P and of the velocity along the face. Of
 * each with the difference D = q_j - q_i and the slope a = grad q_i . (x_j - x_i),
 *     q_i' = q_i + L(a, D) / 2,  L = a within -D and 1.5 D                                 (4)
 * (the limiter of pairs of Hopkins 2015, psi_1 = 1/2, psi_2 = 1/4); density and pressure lose no more than half. Chosen by trial: van Leer's,
 * L between 0 and D, smears Gresho's vortex half as much again and is a tenth better at Sod's tube; L up to 2 D does not survive Noh's problem.
 *
 * Passes: density -> equation of state -> ghosts -> gradients, matrices -> ghosts -> faces -> records -> force [pairs] -> ghosts -> work. */
#ifndef KITH_PHYSICS_MFM_MFM_H
#define KITH_PHYSICS_MFM_MFM_H

#include "physics/density.h"
#include "physics/force.h"
#include "physics/mfm/faces.h"

/* What a pair reads of a node; behind it the face. */
enum {
  MFM_DENSITY = KITH_RECORD_OWN,
  MFM_PRESSURE,
  MFM_BULK,  /* rho c^2 */
  MFM_GAMMA, /* of the material */
  MFM_DENSITY_SLOPE,
  MFM_PRESSURE_SLOPE = MFM_DENSITY_SLOPE + NDIM,
  MFM_VELOCITY_SLOPE = MFM_PRESSURE_SLOPE + NDIM, /* [a][b] = dv_a / dx_b */
  MFM_MEMBERS = MFM_VELOCITY_SLOPE + NDIM * NDIM,
  MFM_AREA = MFM_MEMBERS
};

struct mfm {
  struct mfm_faces faces;
  struct kith_field *velocity_slope, *density_slope, *pressure_slope;
};

/* Gradients of density and pressure, and the matrices of one-point faces, of internal nodes. Ghosts have density and pressure. */
kith_status mfm_gradients(struct kith_package *package, const struct kith_connectivity *connectivity);
/* Fills the records of all nodes, and sums (1) and (2). */
kith_status mfm_pairs(struct kith_package *package);

#endif
