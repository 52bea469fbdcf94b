/* setup.h - from a scene to nodes: lattices cut to regions, masses, state, deposited energy.
 *
 * A lattice (lattice.h: cubic, bcc, fcc, hcp) fills a region's box, cut with the domain, with whole cells;
 * sites outside of the region's ball, half-space or expression are left out. A site stands for the volume v =
 * box / all sites, its mass is rho(x) v: the density is exact, and so is the mass of a box of constant
 * density. Nodes of two boxes that touch stand half a layer each from the common face.
 *
 *   equal-mass     v = rho_max / (rho resolution^NDIM), rho the mean density of the region: a node has about
 *                  the same mass in every region. The number of cells is rounded; outside of the densest
 *                  region the longest axis makes up for the rounding of the others (kith_lattice_balance).
 *   equal-spacing  v = resolution^-NDIM in all regions; the mass follows the density
 *
 * A displacement moves a node too, and stretches its volume as it stretches the lattice there.
 * A region's own `spacing` stands instead, and its density does not count for the others. Jitter moves a node
 * after the cut, by a function of seed and id alone; state and mass are taken where it then is. Energy comes
 * from the pressure through the equation of state. Support: H = (neighbors / ball * v)^(1/NDIM), a first
 * guess.
 *
 * BAD_INPUT, with file and line: a region outside of the domain, without a node, or with a site inside
 * another region; density <= 0, pressure < 0, energy < 0 or values that are not finite, with the place; a
 * scene without a node, or beyond 1e9.
 *
 * Regions in equilibrium (a package sums a density of its own, and the pressure from it is not the one that was asked for): the
 * energy waits for that density, so kith_setup_equilibrium is called when the first rates are there. Deposits come after it.
 *
 * Of several ranks each lays out the whole scene, and then keeps its own nodes (kith_model_share): no message, the same ids, but the memory
 * of all nodes on every rank at the start.
 *
 * Nodes are created region by region within their list, id = index: 0 .. n - 1. Use kith_nodes_curve_order
 * after. Serial, a few 1e6 nodes per second (formulas of a region share one parser). */
#ifndef KITH_APP_SETUP_H
#define KITH_APP_SETUP_H

#include "app/scene.h"
#include "physics/hydro.h"

/* Creates the nodes with their lists, registers the hydro fields and fills center, position, velocity, mass, energy,
 * density, support, id. frozen[i] (one byte per internal node, kith_resize memory, owned by the caller, NULL
 * if no region is frozen). */
kith_status kith_setup(struct kith_nodes **nodes, struct kith_hydro *hydro, const struct kith_scene *scene,
                       double neighbors, uint8_t **frozen);

/* Does a region of the scene wait for the density of the package? */
bool kith_setup_waits(const struct kith_scene *scene);
/* Energies of such regions from their pressure and hydro->density, and the deposits of the scene. The rates are to be made again. */
kith_status kith_setup_equilibrium(const struct kith_scene *scene, const struct kith_hydro *hydro);

#endif
