/* step.h - a step of the integration: its length, the lists, the scheme, what is checked after it. */
#ifndef KITH_INTEGRATOR_STEP_H
#define KITH_INTEGRATOR_STEP_H

#include "integrator/integrator.h"

/* A step that the state limits is at most this much longer than the last. */
#define KITH_GROWTH 1.25

/* First rates: solves the supports from their guesses. Call once before the first step of a new run. */
kith_status kith_integrator_start(struct kith_integrator *integrator);
/* Rebuilds the lists of a restarted run, bitwise identical. Fields, time, step, dt, the kick's time and the
 * time-step limit are restored by the caller. */
kith_status kith_integrator_resume(struct kith_integrator *integrator);
/* One step, not beyond `until`. DIVERGED if the state leaves the physical range or the step collapses; STALE
 * where the lists may miss pairs and no policy rebuilds them. */
kith_status kith_integrator_step(struct kith_integrator *integrator, double until);

/* The rates of the state, by lists that are rebuilt first if a policy wants it. */
kith_status kith_integrator_rates(struct kith_integrator *integrator);
/* The same by the lists at hand, of which ghosts get their values: for schemes. Inside a step lists are
 * rebuilt only where the motion since they were made is more than their search radii cover, or where a face
 * has moved. */
kith_status kith_integrator_evaluate(struct kith_integrator *integrator);

#endif
