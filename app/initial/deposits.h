/* deposits.h - energies that the scene adds to the gas, at the start or later: blasts.
 *
 * Node i at distance r_i from the center gets the part w_i m_i / sum_j w_j m_j of the energy:
 *   point    w = 1 for the nearest node, or nodes, where several are nearest within round-off
 *   ball     w = 1 for r <= radius
 *   kernel   w = M4(2 r / radius), the cubic spline 1 - 3/2 q^2 + 3/4 q^3 (q < 1), (2 - q)^3 / 4 (q < 2)
 *            (Monaghan and Lattanzio 1985)
 * Distances take the nearest image across periodic faces. */
#ifndef KITH_APP_INITIAL_DEPOSITS_H
#define KITH_APP_INITIAL_DEPOSITS_H

#include "app/scene/scene.h"
#include "physics/hydro.h"

/* Adds the deposits of this time to the energies of nodes, and, after the start, to the energy that came
 * from outside. Sums do not depend on the order of nodes. BAD_INPUT if a ball or kernel has no node.
 * Collective. */
kith_status kith_deposits_add(const struct kith_scene *scene, struct kith_hydro *hydro, double time);
/* The time of the next deposit after `time`; INFINITY: there is none. */
double kith_deposits_next(const struct kith_scene *scene, double time);

#endif
