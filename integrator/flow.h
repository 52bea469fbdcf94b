/* flow.h - gas that comes and goes: how the zones of inflows and outflows (boundaries/flow.h) move, when
 * nodes become gas and gas becomes theirs, and what the gas gets from outside.
 *
 * Inflow: no rates; the state is that at the face, at the start of each step. The node that takes the place
 * of one with id k has id k + the number of nodes at the start: no id comes twice, and none depends on
 * ranks.
 *
 * Outflow: a node goes on with the energy rate of the package, and with a velocity that only follows from
 * within. With the velocity v and the direction n outwards
 *     dv/dt = - c dv/dn,    dv/dn by partners further in,
 * which is what a wave that leaves does (continuity adds dP = rho c dv), and no wave comes back (Thompson
 * 1987, JCoPh 68, 1). Towards a pressure P0 far behind, in a domain of length L, it gets (P - P0) / (4 rho L)
 * in addition (Poinsot and Lele 1992, JCoPh 101, 104). Velocities along the face do not change. That and the
 * energy rate fade between a quarter and half of the zone: nodes at its end lack partners. dv/dn does not:
 * nodes that went on as they are would run into slower ones ahead. (In 1-D those behind a shock do that still
 * if it is much faster than sound ahead of it, as that of toro-3.yaml: the run stops.)
 *
 * Balance. Where a node becomes gas, or no longer is, its mass, momentum and energy are added to those that
 * came through (hydro.h), or taken away. Forces and heats of partners that are no gas are summed by the force
 * pass; kicks add them over time, equation (1) of package.h: exact with compatible energy. */
#ifndef KITH_INTEGRATOR_FLOW_H
#define KITH_INTEGRATOR_FLOW_H

#include "integrator/integrator.h"

/* Nodes come and go, between the kicks of two evaluations; lists are to be rebuilt then. DIVERGED where
 * gas leaves through an inflow, or one is so fast that a step empties its zone. Collective. */
kith_status kith_flow_exchange(struct kith_integrator *integrator);
/* At the end of a step: puts nodes back that are beyond a mirror. In the field of the external force that
 * changes their potential energies, by what they get from outside, `lifted`; and their rates have the force
 * at their new place. */
kith_status kith_flow_mirror(struct kith_integrator *integrator);
/* After an evaluation: the rates of zones, and what the gas gets from all that is no gas. Collective. */
void kith_flow_rates(struct kith_integrator *integrator);
/* Block steps, after the evaluation of a tick: adds what active and touched nodes got. At the end of a base
 * step all is summed up, and what the evaluation opens is the rate until the next tick. Collective there. */
void kith_flow_tick(struct kith_integrator *integrator, const struct kith_block_steps *steps);

#endif
