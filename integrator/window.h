/* window.h - gas that no signal has reached yet is not evaluated (window: follow).
 *
 * After the first evaluation, and after each step, nodes that move or have rates are called disturbed. Nodes
 * within three neighbors of a disturbed one, times the evaluations of a step, are awake, that is active:
 * neighbor lists are built, and passes run, for them. The others sleep. Their neighbors read the values of
 * the first evaluation; their own rates are zero, so kicks and drifts do not change them. A node that is
 * awake stays awake.
 *
 * Causality. A node that moves changes the density of its neighbors, these the gradients of theirs, and these
 * the forces on theirs: a signal travels three neighbors per evaluation. So the state from which the rates of
 * a sleeping node would follow has not changed since the start, when its rates were round-off. A pair of a
 * sleeping and an awake node acts on the latter alone; forces on gas at rest balance, so the impulses that
 * are left out are round-off, too. Only a node that moves gets new neighbors, maybe from afar, or one that a
 * piston comes near: as soon as lists are made, what is near such a node in them wakes, and they are made
 * again. Gas that is not at rest by itself, as that of disordered nodes, is awake from the start, and then
 * the run is bitwise the same as without a window. */
#ifndef KITH_INTEGRATOR_WINDOW_H
#define KITH_INTEGRATOR_WINDOW_H

#include "integrator/integrator.h"

/* Lets all nodes sleep but the disturbed ones and those near them, after the first evaluation. Exchanges
 * values of ghosts between ranks, as does kith_window_follow. */
void kith_window_begin(struct kith_integrator *integrator);
/* Wakes nodes near disturbed ones, after a step. */
void kith_window_follow(struct kith_integrator *integrator);
/* Wakes nodes near ones that move, when lists are made. Returns whether any has woken on any rank: then the
 * lists lack its row. */
bool kith_window_meets(struct kith_integrator *integrator);
/* Returns the share of the nodes of this rank that no signal reaches within dt after the last evaluation:
 * those outside of the box around the disturbed nodes, widened by twice the way of the fastest signal, as
 * shocks are faster than the sound ahead of them. */
double kith_window_at_rest(const struct kith_integrator *integrator, double dt);

#endif
