/* setup.h - from a scene to nodes: lattices cut to regions, masses, state, deposited energy.
 *
 * Lattices (those that exist in a dimension: 1-D all are the line; 2-D cubic = square, hcp = triangular, bcc = centered square,
 * fcc refused; 3-D all). Along an axis the number of cells is a whole number that fits the region's extent, so that
 * spacing is stretched a little and the lattice continues across a periodic face, and nodes of two regions that touch stand half a
 * spacing from their common face. The density is exact: mass = density * volume / count for each region.
 *   equal-mass     the mass of a node is the same in all regions (to the rounding of counts), spacing follows the density
 *   equal-spacing  the spacing is the same in all regions, mass follows the density
 * resolution = nodes per unit length (V/N)^(-1/NDIM) in the densest region.
 * Regions that overlap, or hold no node, and a scene without a node are BAD_INPUT with file and line.
 * Support: H = (neighbors / ball * m / rho)^(1/NDIM) as a first guess. ids: 0 .. n - 1 in order of creation.
 * Nodes are created region by region within their list; use kith_nodes_curve_order after. */
#ifndef KITH_APP_SETUP_H
#define KITH_APP_SETUP_H

#include "app/scene.h"
#include "physics/hydro.h"

/* Creates the nodes with their lists, registers the hydro fields and fills position, velocity, mass, energy, density,
 * support, id. frozen[i] (one byte per internal node, kith_resize memory, owned by the caller, NULL if no region is frozen). */
kith_status kith_setup(struct kith_nodes **nodes, struct kith_hydro *hydro, const struct kith_scene *scene, double neighbors,
                       uint8_t **frozen);

#endif
