/* window.h - gas that no signal has reached yet stays as it was laid out (window: follow).
 *
 * After the first evaluation, and after each step, nodes that move or have rates are the disturbed ones.
 * Those within three neighbors of a disturbed one, for each evaluation of a step, are awake, that is active:
 * neighbor lists are built, and passes run, for them. The others sleep. Neighbors read them with what the
 * first evaluation made of them; their own rates are zero, so that kicks and drifts leave them as they are.
 * Who is awake stays so.
 *
 * Causality. A node that moves changes the density of its neighbors, that the gradients of theirs, and these
 * the forces on theirs: an evaluation carries a signal three neighbors far. So what a sleeper would be
 * evaluated from has not changed since the start, when its rates were round-off. Pairs of a sleeper and a
 * node that is awake act on the latter alone; forces on gas at rest balance, so the impulses that are left
 * out are round-off, too. Gas that is not at rest by itself, disordered nodes for one, is awake from the
 * start, and then the run has the bits of one without a window. */
#ifndef KITH_INTEGRATOR_WINDOW_H
#define KITH_INTEGRATOR_WINDOW_H

#include "integrator/integrator.h"

/* After the first evaluation: all but the disturbed nodes and those near them fall asleep. Ranks exchange
 * values of ghosts, as in the following. */
void kith_window_begin(struct kith_integrator *integrator);
/* After a step: nodes near disturbed ones wake up. */
void kith_window_follow(struct kith_integrator *integrator);
/* The share of the nodes of this rank that are at rest, by the last evaluation. */
double kith_window_at_rest(const struct kith_integrator *integrator);

#endif
