/* calibration.h - what a run will cost: the time of one evaluation of the rates, and how many there will
 * be.
 *
 *   seconds = steps * evaluations * t_start * growth
 *
 * t_start, the time of one evaluation with its neighbor lists, is measured at the start of the scene
 * itself. steps and growth come from two calibration runs, the whole scene at lower resolutions r1 < r2.
 * steps: on the straight line through both (the number of Courant steps is proportional to the resolution,
 * that of the starting phase is constant). growth: mean time of an evaluation along the run over that at
 * its start; it holds longer support iterations, nodes out of order, and the rebuilds that Verlet lists
 * save. */
#ifndef KITH_APP_PLAN_CALIBRATION_H
#define KITH_APP_PLAN_CALIBRATION_H

#include "app/cli/options.h"
#include "app/simulation/simulation.h"

/* Seconds of one evaluation and the neighbor lists it needs, of a simulation that was started: the least of
 * up to 3, as many as half a second allows, which is disturbed least by other programs. */
kith_status kith_evaluation_measure(struct kith_simulation *simulation, double *seconds);

struct kith_calibration {
  double resolution[2], steps[2]; /* of the two runs */
  double growth;
  double lists; /* neighbor lists built, per step */
};
/* Runs the scene of `options` twice, each run for about `budget` seconds, judged by `cost`, the estimate for
 * the scene itself. DIVERGED if a run fails or takes ten times as long. */
kith_status kith_calibration_run(struct kith_calibration *out, const struct kith_options *options,
                                 double resolution, double until, double cost, double budget);
/* Steps of the scene itself. */
double kith_calibration_steps(const struct kith_calibration *calibration, double resolution);

#endif
