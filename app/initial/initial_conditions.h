/* initial_conditions.h - from a scene to nodes: lattices cut to regions, masses, state, deposited energy.
 *
 * A lattice (lattice.h) fills a region's box, cut with the domain, with whole cells;
 * sites outside of the region's expression are left out. A site stands for the volume v = box / all sites,
 * its mass is rho(x) v: the density is exact, and so is the mass of a box of constant density. Nodes of two
 * boxes that touch stand half a layer each from the common face.
 *
 *   equal-mass     v = rho_max / (rho resolution^NDIM), rho the mean density of the region: a node has about
 *                  the same mass in every region. The number of cells is rounded; outside of the densest
 *                  region the longest axis makes up for the rounding of the others (kith_lattice_balance).
 *   equal-spacing  v = resolution^-NDIM in all regions; the mass follows the density
 *
 * A region's own `spacing` stands instead, and its density does not count for the others. A displacement
 * moves a node and stretches its volume as it stretches the lattice there; jitter moves it by a function of
 * seed and id alone; state and mass are taken where it then is. Energy comes from the pressure through the
 * equation of state. Support: H = (neighbors / ball * v)^(1/NDIM), a first guess.
 *
 * BAD_INPUT, with file and line: a region outside of the domain, without a node, or with a site inside
 * another region; impossible values, with the place; a scene beyond 1e9 nodes, or beyond the memory of this
 * computer.
 *
 * Zones behind faces that gas passes: the lattices of the regions at the face go on, in whole cells, with the
 * state at the face.
 *
 * Regions in equilibrium: with the density that a package sums the pressure would not be the one that the
 * scene gives. Their energy is set after the first evaluation, and then the deposits are added.
 *
 * Each rank visits an equal part of the sites of every region, and makes the nodes there; frozen
 * nodes, which stay where they are, it makes all. Ids are 0 .. n - 1, list by list, in the order of regions
 * and sites, for any number of ranks, and so are all values to the last bit: sums are exact. */
#ifndef KITH_APP_INITIAL_INITIAL_CONDITIONS_H
#define KITH_APP_INITIAL_INITIAL_CONDITIONS_H

#include "app/scene/scene.h"
#include "integrator/integrator.h"
#include "physics/hydro.h"

/* Creates the nodes of this rank with their lists and fills the hydro fields; *total: of all ranks, frozen
 * ones once. Collective; the status is agreed on. ranks (NULL: one process) become those of the nodes.
 * frozen[i]: one byte per internal node, kith_resize memory owned by the caller, NULL if no region is frozen.
 * zone[NDIM][2][NDIM]: of faces that gas passes, by axis and side, kith_boundary.zone (boundary.h); must be
 * zero before. */
kith_status kith_initial_conditions(struct kith_nodes **nodes, struct kith_hydro *hydro,
                                    const struct kith_scene *scene, struct kith_ranks *ranks,
                                    double neighbors, uint8_t **frozen, double (*zone)[2][NDIM],
                                    int64_t *total);

/* Finds what would be laid out: site_volume[n_regions], and the number of sites in all boxes of regions. */
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
