/* pilot.h - what a run will cost: the time of one evaluation, and how often, from short runs with fewer nodes.
 *
 *   seconds = steps * evaluations * (rates + rebuilds * lifecycle) * growth
 *
 * rates and lifecycle are timed at the start of the scene itself. The other three come from two pilots, the scene at lower resolutions r1 < r2:
 * steps, on the straight line through both: Courant's steps are as many as nodes along a way, and those of the start are always as many; rebuilds, lifecycles per evaluation where lists last; growth, the mean time of an evaluation
 * along the run over that at its start (supports that take longer to find, nodes that are no longer in order). */
#ifndef KITH_APP_PILOT_H
#define KITH_APP_PILOT_H

#include "app/model.h"
#include "app/options.h"

/* Seconds; the least of up to three, which other programs disturbed least. */
struct kith_times {
  double rates;     /* one evaluation, with the lists that the policy makes for it */
  double lifecycle; /* lists made again, where they last; 0 where each evaluation makes its own */
  int evaluations;  /* that were timed */
};
/* Of a model that was started. */
kith_status kith_times_measure(struct kith_model *model, struct kith_times *out);

struct kith_pilot {
  double resolution[2], steps[2]; /* of the pilots */
  double rebuilds, growth;
};
/* Runs both pilots, each `budget` seconds or less by `cost`, the guess for the scene itself. DIVERGED if that cannot be had, or a pilot fails. */
kith_status kith_pilot_run(struct kith_pilot *out, const struct kith_options *options, double resolution,
                           double until, double cost, double budget);
/* Steps of the scene itself. */
double kith_pilot_steps(const struct kith_pilot *pilot, double resolution);

#endif
