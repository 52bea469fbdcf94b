/* block_steps.h - block time steps: each node advances with a step of its own, and momentum and energy are
 * conserved to round-off.
 *
 * A step of the integrator is a base step. It has KITH_TICKS ticks, and the steps of the nodes are powers of
 * two of them. At a tick at which a node's step ends,
 *   1. nodes are predicted from the state and the rates at their last activity; positions too, for velocities
 *      that have been kicked by one pair for a long step and by others for a short one are not balanced;
 *   2. the nodes whose step ends are active, and choose the next: by their own limits, at most twice the
 *      last, at most `ratio` times that of a neighbor, and so that it ends where steps of its length do;
 *   3. the lifecycle makes ghosts and lists of the active nodes and those that they touch;
 *   4. packages run for active nodes, and the force pass for touched ones too (physics/block_steps.h);
 *   5. a touched node whose step is more than `ratio` times that of an active neighbor, or longer than its
 *      own limits now allow, is woken sooner: its step is cut short.
 *
 * Local ticks. Where active nodes are few and far from all boundaries, only nodes near active ones are
 * predicted and updated in the search, and there are no ghosts; the state is bitwise the same. All nodes are
 * searched anew once candidates that have ceased to be neighbors have cost as much as a new search. With
 * several ranks no tick is local.
 *
 * The end of a base step. All nodes are active, so that the state is at one time: there is output, and a run
 * can restart. Nodes are mirrored then; they are wrapped and migrate at the first tick of the next base step.
 *
 * The length of a base step is that of the longest step that a node wants, but at most 2^levels times that of
 * the shortest, and a whole fraction of the time that is left until the next output. Since the steps of nodes
 * are rounded down to powers of two of it, it is shortened if that saves updates. It is shortened once more
 * if the rates with which it begins allow a node less than its first step over `ratio`: then bodies have just
 * met, and the impulse of half of a long step could only be taken back with a later force. With one level
 * this is leapfrog with a global step.
 *
 * What goes wrong without the limit by `ratio` in 2, and without 5: Saitoh and Makino (2009, ApJ 697, L99),
 * Durier and Dalla Vecchia (2012, MNRAS 419, 465). */
#ifndef KITH_INTEGRATOR_BLOCK_STEPS_H
#define KITH_INTEGRATOR_BLOCK_STEPS_H

#include "integrator/block_lengths.h"

/* Creates the private state (integrator->self) and fields. */
kith_status kith_block_steps_create(struct kith_integrator *integrator, struct kith_block_settings settings);
void kith_block_steps_destroy(struct kith_integrator *integrator);
/* Plans the first base step, after the first rates. Collective, as is kith_block_steps_advance. */
kith_status kith_block_steps_start(struct kith_integrator *integrator);
/* Begins a base step of length dt. */
void kith_block_steps_begin(struct kith_integrator *integrator, double dt);
/* Runs the ticks of the base step. */
kith_status kith_block_steps_advance(struct kith_integrator *integrator);

#endif
