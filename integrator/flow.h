/* flow.h - inflow and outflow: how their zones (boundaries/flow.h) move, when nodes become gas or gas becomes
 * part of a zone, and what the gas gets from outside.
 *
 * Inflow: nodes in the zone have no rates; at the start of each step they get the state at the face; a node
 * that has passed the face gets the state at the time when it passed. The node that takes the place of one
 * with id k has id k + the number of nodes at the start: no id comes twice, and none depends on ranks.
 *
 * Outflow: waves leave, and little comes back (Thompson 1987, JCoPh 68, 1). Deep in the zone the velocity v
 * of a node in the direction n outwards depends only on nodes further in, as what they do comes with the
 * speed W of a wave in the gas of the node,
 *     dv/dt = - W dv/dn
 * (continuity adds dP = rho W dv). Where a partner closes in, at a speed w, W is that of the shock which this
 * makes in gas at rest, else the sound speed c (Toro 2009, Riemann Solvers, section 3.1):
 *     W = a w + sqrt(a^2 w^2 + c^2),  a = (gamma + 1) / 4,  gamma of kith_material_gamma.
 * With c alone the zone would be a wall for strong shocks. At the face the acceleration is that of pairs, and
 * goes over to this one within a quarter of the zone: where it changed at once, shocks that passed the face
 * left a velocity that was up to 13 % too high. The components tangential to the face, and the energy rate of
 * the package, fade out between a quarter and half of the zone, as nodes at its end lack partners; there the
 * heat of compression fades in,
 *     du/dt = - P / rho dv/dn
 * with the mean pressure of both nodes where a partner closes in, as across a shock. With a pressure P0 far
 * behind and a domain of length L, (P - P0) / (4 rho L) is added (Poinsot and Lele 1992, JCoPh 101, 104),
 * which fades out likewise. dv/dt does not fade: nodes with a constant velocity would run into slower ones.
 * What kicks change in the kinetic energy of a zone is not taken from its heat, as it is no work of pairs.
 *
 * Balance. When a node becomes gas or leaves it, its mass, momentum and energy are added to `through` of
 * hydro.h or subtracted. The force pass sums forces and heats by partners that are no gas; kicks add them
 * over time by (1) of package.h, which is exact with compatible energy. */
#ifndef KITH_INTEGRATOR_FLOW_H
#define KITH_INTEGRATOR_FLOW_H

#include "integrator/integrator.h"

/* Lets nodes enter and leave, between the kicks of two evaluations; if any does, lists are to be rebuilt.
 * DIVERGED where gas leaves through an inflow, or an inflow is so fast that a step empties its zone.
 * Collective. */
kith_status kith_flow_exchange(struct kith_integrator *integrator);
/* Puts nodes beyond a mirror back, at the end of a step. An external force changes their potential energies
 * by that, which counts as energy from outside, `lifted`; their rates get the force at the new place.
 * DIVERGED where a node is far outside. Not collective: ranks agree on status and `lifted` after the step. */
kith_status kith_flow_mirror(struct kith_integrator *integrator);
/* Sets the rates of zones after an evaluation, and sums what the gas gets from all that is no gas. Does
 * nothing if nodes have no flags, or with block steps (kith_flow_tick). Collective. */
void kith_flow_rates(struct kith_integrator *integrator);
/* With block steps, after the evaluation of a tick: adds what active and touched nodes got from outside. At
 * the end of a base step sums over ranks; what the evaluation opens is the rate until the next tick.
 * Collective there. */
void kith_flow_tick(struct kith_integrator *integrator, const struct kith_block_steps *steps);

#endif
