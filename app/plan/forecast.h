/* forecast.h - what a run will cost, on one process and on many.
 *
 * One process: the time of one evaluation of the rates, and how many there will be.
 *
 *   seconds = steps * evaluations * t_start * growth
 *
 * t_start, the time of one evaluation with its neighbor lists, is measured at the start of the scene itself.
 * steps, which grow with the resolution, and growth, the mean time of an evaluation along the run over that
 * at its start, come from a calibration run: the whole scene at a lower resolution.
 *
 * Many: what N ranks would have of a scene, counted by one process. The cells are those of a run
 * (lib/domain/decomposition.h); their work is nodes and row entries at the start. A partitioner makes its
 * first map and continues until it changes nothing (at most 20 times). The ghosts of a rank are the nodes and
 * images of others in the rows of its nodes: what culling keeps.
 *  A scene that is too large to be laid out here is outlined: its regions and their lattices say how many
 * nodes a cell has, and how far they see; 27 points of a cell, whether another rank does. A lattice is at
 * most half a spacing from the face of a cell, so that ghosts reach to the support less that. Walls make no
 * ghosts that way. */
#ifndef KITH_APP_PLAN_FORECAST_H
#define KITH_APP_PLAN_FORECAST_H

#include "app/simulation/simulation.h"
#include "app/cli/options.h"

/* Seconds of one evaluation and the neighbor lists it needs, of a simulation that was started: the least of
 * up to 3, as many as half a second allows. */
kith_status kith_evaluation_measure(struct kith_simulation *simulation, double *seconds);

struct kith_calibration {
  double resolution, steps; /* of the run */
  double expected;          /* steps of the scene itself */
  double growth;
};
/* Runs the scene of `options` for about `budget` seconds, judged by `cost`, the estimate for the scene
 * itself. DIVERGED if the run fails or takes ten times as long. */
kith_status kith_calibration_run(struct kith_calibration *out, const struct kith_options *options,
                                 double resolution, double until, double cost, double budget);

struct kith_forecast {
  double imbalance;           /* most work over the mean */
  double ghosts, most_ghosts; /* of a rank: mean, most */
  double peers, most_peers;   /* ranks that it exchanges with */
};

/* Of a scene that is outlined, with `neighbors` per node. */
kith_status kith_forecast_outline(const struct kith_scene *scene, double neighbors, int n_ranks,
                                  const char *partitioner, struct kith_forecast *out);

/* Of a started simulation without ranks. BAD_INPUT: more than 16384 ranks, or ghosts: recompute. */
kith_status kith_forecast_ranks(const struct kith_simulation *simulation, int n_ranks,
                                const char *partitioner, struct kith_forecast *out);

#endif
