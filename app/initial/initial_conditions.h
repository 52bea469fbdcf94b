/* initial_conditions.h - from a scene to nodes: lattices cut to regions, masses, state, deposited energy.
 *
 * A lattice (lattice.h) fills the box of a region, cut with the domain, with whole cells. Sites at which the
 * formula `inside` of the region is zero are left out. A site stands for the volume v = box / all sites, and
 * its mass is rho(x) v. So the density is exact, and so is the mass of a box of constant density. At the
 * common face of two boxes that touch, the nodes of each stand half a layer away from it.
 *
 *   equal-mass     v = rho_max / (rho resolution^NDIM), rho the mean density of the region: a node has about
 *                  the same mass in every region. The number of cells is rounded; outside of the densest
 *                  region the longest axis makes up for the rounding of the others (kith_lattice_balance).
 *   equal-spacing  v = resolution^-NDIM in all regions; the mass follows the density
 *
 * A region with a `spacing` of its own has that instead, and its density does not count in rho_max. A
 * displacement moves a node and stretches its volume as it stretches the lattice there. Jitter moves it by a
 * function of seed and id alone. State and mass are those of the place where the node then is. Energy comes
 * from the pressure through the equation of state. The support H = (neighbors / ball * v)^(1/NDIM) is a first
 * guess.
 *
 * BAD_INPUT, with file and line: a region outside of the domain, without a node, or with a site inside
 * another region; impossible values, with the place; a scene of more than 1e9 nodes, or of more than the
 * memory of this computer holds.
 *
 * Behind a face that gas passes is a zone: the lattices of the regions at the face go on there, in whole
 * cells, with the state at the face.
 *
 * Regions in equilibrium: with the density that a package sums, the pressure would not be the one that the
 * scene gives. So their energies are set after the first evaluation, and the deposits are added then.
 *
 * Each rank visits an equal part of the sites of every region, and makes the nodes there. Frozen nodes, which
 * stay where they are, are made by every rank. Ids are 0 .. n - 1, list by list, in the order of regions and
 * sites. They do not depend on the number of ranks, and neither does any value, to the last bit. */
#ifndef KITH_APP_INITIAL_INITIAL_CONDITIONS_H
#define KITH_APP_INITIAL_INITIAL_CONDITIONS_H

#include "app/scene/scene.h"
#include "integrator/integrator.h"
#include "physics/hydro.h"

/* Creates the nodes of this rank with their lists, and fills the hydro fields. Collective; the status is
 * agreed on. `ranks` (NULL: one process) become those of the nodes. *frozen: a byte for each internal node,
 * 1 if it is frozen, in kith_resize memory owned by the caller; NULL if no region is frozen.
 * zone[NDIM][2][NDIM]: for each axis and side what kith_boundary.zone (boundary.h) is if gas passes the
 * face; must be zero before. *total: the number of nodes of all ranks, in which frozen nodes count once. */
kith_status kith_initial_conditions(struct kith_nodes **nodes, struct kith_hydro *hydro,
                                    const struct kith_scene *scene, struct kith_ranks *ranks,
                                    double neighbors, uint8_t **frozen, double (*zone)[2][NDIM],
                                    int64_t *total);

/* Finds the volume of a site in each region, and the number of sites in the boxes of all regions, without
 * creating nodes. */
kith_status kith_initial_conditions_outline(const struct kith_scene *scene, double *site_volume,
                                            double *sites);

/* The state at the face of an inflow, beside x: a kith_flow_state_at (integrator.h) whose context is the
 * scene. */
kith_status kith_initial_conditions_inflow(const void *scene, const struct kith_boundary *boundary, int list,
                                           const double *x, double time, struct kith_flow_state *out);

/* Sets the energies of regions in equilibrium, and adds the deposits of the start. The rates must be
 * evaluated again. */
kith_status kith_initial_conditions_equilibrium(const struct kith_scene *scene, struct kith_hydro *hydro);

#endif
