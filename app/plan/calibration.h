/* calibration.h - what one process needs for a scene, and what a rank of many tells others in a step.
 *
 *    seconds = steps * evaluations * t_start * growth
 *
 * t_start, the time of one evaluation with its neighbor lists, is measured at the start of the scene itself.
 * Calibration runs give the steps, whose number grows with the resolution, and the growth, which is the mean
 * time of an evaluation along the run over that at its start. They run the whole scene, at lower resolutions
 * unless that takes about a second; steps end where snapshots are due, but nothing is written. Their cost is
 * counted in pair evaluations, so that resolutions and steps do not depend on the machine.
 *
 * A rehearsal is a short run at a lower resolution by a single process that behaves as one of many ranks. It
 * counts the calls, messages and bytes of its exchange, although no other rank answers. */
#ifndef KITH_APP_PLAN_CALIBRATION_H
#define KITH_APP_PLAN_CALIBRATION_H

#include "app/simulation/simulation.h"
#include "app/cli/options.h"

/* Read the scene of `options` with one more setting, key=value, or at another resolution. */
kith_status kith_scene_read_with(struct kith_scene **scene, const struct kith_options *options,
                                 const char *setting);
kith_status kith_scene_read_at(struct kith_scene **scene, const struct kith_options *options,
                               double resolution);

/* Measures the seconds of one evaluation and of the neighbor lists it needs, in a simulation that was
 * started: the least of up to 3 times, as many as half a second allows. If the scene has a window, all nodes
 * are evaluated, and those at rest sleep again afterwards. */
kith_status kith_evaluation_measure(struct kith_simulation *simulation, double *seconds);

/* The part of the updates of a step of all nodes that the present limits of single nodes require. */
double kith_updates_needed(const struct kith_integrator *integrator);

/* Cost is counted in pair evaluations. Each evaluation of the rates costs so many more, however few nodes. */
enum { KITH_EVALUATION_PAIRS = 4000 };
struct kith_calibration {
  double resolution, steps, reached; /* of the calibration run: its steps to the time that it reached */
  double pairs, evaluations;         /* of it: pair evaluations, evaluations of the rates */
  double expected;                   /* steps of the scene itself */
  double growth;
  double needed; /* kith_updates_needed, as a mean over its steps, with block steps as taken; NaN: unknown */
};
/* Runs the scene of `options` to `until`. `guess` has its resolution, and about how many pairs and
 * evaluations that takes. If their cost is within `budget` the scene is run as it is; otherwise at
 * resolutions that grow by a third, up to the largest whose cost is likely within the budget. The expected
 * steps are then the geometric mean of two extrapolations from the last two runs: by a line, and by a power
 * of the resolution. A run is stopped at three times the budget. Fails as the last run does. */
kith_status kith_calibration_run(struct kith_calibration *out, const struct kith_options *options,
                                 const struct kith_calibration *guess, double until, double budget);

/* Per step: evaluations of all nodes, collective calls, checks of the balance, and kith_halo_traffic. */
struct kith_rehearsal {
  double evaluations, collectives, balance_checks;
#define X(name, doc) double name;
  KITH_HALO_TRAFFIC_LIST(X)
#undef X
};
/* Runs 20 steps of the scene at this resolution, fewer if it ends before. Fails as any run does. */
kith_status kith_rehearsal_run(struct kith_rehearsal *out, const struct kith_options *options,
                               double resolution);

#endif
