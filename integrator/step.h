/* step.h - a step of the integration: its length, the lists, the scheme, what is checked after it. */
#ifndef KITH_INTEGRATOR_STEP_H
#define KITH_INTEGRATOR_STEP_H

#include "integrator/integrator.h"

/* Largest ratio of a step to the last one, except for fixed steps and base steps. */
#define KITH_GROWTH 1.25

/* Evaluates the first rates: solves the supports from their guesses. Call before the first step of a new run,
 * and between steps when the state has been changed, for nothing of an earlier evaluation is used then. */
kith_status kith_integrator_start(struct kith_integrator *integrator);
/* Rebuilds the lists of a restarted run, bitwise identical. Fields, time, step, dt, the kick's time and the
 * time-step limit are restored by the caller. first: the totals at the start of the run. */
kith_status kith_integrator_resume(struct kith_integrator *integrator, const struct kith_totals *first);
/* Takes one step, not beyond `until`. DIVERGED if the state leaves the physical range or the step collapses;
 * STALE where the lists may miss pairs and no policy rebuilds them. */
kith_status kith_integrator_step(struct kith_integrator *integrator, double until);

/* Evaluates the rates, after a rebuild of the lists if a policy wants it. */
kith_status kith_integrator_rates(struct kith_integrator *integrator);
/* Evaluates the rates with the lists at hand, after refreshing ghosts: for schemes. Inside of a step lists
 * are rebuilt only where nodes have moved further than the search radii cover, or a face has moved. */
kith_status kith_integrator_evaluate(struct kith_integrator *integrator);

#endif
