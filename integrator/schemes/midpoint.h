/* midpoint.h - the two halves of a midpoint step, for rk2 and cheap-rk2. */
#ifndef KITH_INTEGRATOR_SCHEMES_MIDPOINT_H
#define KITH_INTEGRATOR_SCHEMES_MIDPOINT_H

#include "integrator/step.h"

/* From the state at the start, by the rates at hand: half a step to the middle, positions with the velocity
 * of the start. */
void kith_midpoint_to_middle(struct kith_integrator *integrator, double dt);
/* From the state at the start, by the rates of the middle: the whole step, positions with the velocity of the
 * middle. Positions go on from where the lifecycle may have wrapped or mirrored them, half a step with the
 * velocity of the start from theirs. */
void kith_midpoint_to_end(struct kith_integrator *integrator, double dt);

#endif
