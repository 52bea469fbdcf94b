/* forecast.h - predicts, in one process, what each of N ranks would have of a scene, and how long a step
 * would take.
 *
 * The cells are those of a run (lib/domain/decomposition.h). The work of a cell is the number of its nodes
 * and of their row entries at the start. A partitioner makes its first map of cells to ranks, and goes on
 * until it changes nothing, at most 20 times. The ghosts of a rank are the nodes and images of other ranks
 * that are in the rows of its nodes: those that culling keeps. (A run keeps all ghosts if less than a
 * sixteenth of them could surely go, so it may have up to 6 % more.) The ghosts that are made before culling
 * are chosen as halo.h says. If no ghost was culled in the rehearsal (calibration.h), these are the ghosts
 * of a rank.
 *
 * A scene that is too large to be laid out in one process is outlined: its regions and their lattices give
 * the number of nodes in a cell. Which ranks need a node is found at sample points of its cell. Around each
 * point stand the neighbors that a node has in a simulation of the same scene with fewer nodes, with their
 * distances in spacings: the ranks in whose cells they are keep the node as a ghost. A ghost is made, before
 * culling, of a point within the search radius of cells of another rank, or with cells within its own.
 *
 *    t_rank = T (1 - g) w + T g (n + ghosts) / (all nodes and images) + messages latency + bytes / bandwidth
 *    t_step = max over ranks of t_rank + calls collective ceil(log2 N) + balance
 *
 * T is the time of a step on one process, and g the part of it that is spent in stages which treat ghosts as
 * nodes. w is the part that the rank has of all work, and n is as large a part of all nodes. The rehearsal
 * counted the collective calls, and the messages and bytes for each neighbor, peer, ghost and cell. balance
 * is the time to send the work of all cells twice. If there are fewer cores than ranks, and the sum of all
 * t_rank over the number of cores is larger than the largest t_rank, the sum stands instead. Computation
 * during an exchange is not subtracted, and waiting for a slower neighbor is not added. */
#ifndef KITH_APP_PLAN_FORECAST_H
#define KITH_APP_PLAN_FORECAST_H

#include "app/plan/calibration.h"
#include "lib/domain/cells.h"

struct kith_step_cost {
  double seconds;          /* T of the equations above */
  double ghost_stage_part; /* g: the part of T in stages that treat ghosts as nodes */
  double images;           /* ghosts of one process */
  struct kith_rehearsal rehearsal;
  struct kith_machine machine;
};

/* Of a rank, the mean over all ranks where nothing else is said. */
struct kith_forecast {
  double imbalance;                 /* most work over the mean */
  double made, ghosts, most_ghosts; /* ghosts before and after the cull; the most that a rank has after it */
  double peers, most_peers;         /* ranks that it shares ghosts with; the most */
  double messages, bytes;           /* that it sends in a step */
  double seconds, efficiency;       /* of a step; T over seconds and cores */
  double cells;                     /* of the map that each rank has */
};

/* The cells that n_ranks ranks would begin with. The simulation must not have been started, since a run makes
 * its cells before supports converge. */
kith_status kith_forecast_cells(const struct kith_simulation *simulation, int n_ranks,
                                struct kith_cells *cells);

/* Forecasts a scene on n_ranks ranks. `simulation` has been started, on one process, and has lists with all
 * images (none culled). It is that of the scene itself, whose cells are given, or one with fewer nodes: then
 * cells is NULL, and the scene is outlined. BAD_INPUT: more than 16384 ranks, or ghosts: recompute;
 * UNSUPPORTED: a map that would take the partitioner more than a minute. */
kith_status kith_forecast_ranks(const struct kith_scene *scene, const struct kith_simulation *simulation,
                                const struct kith_cells *cells, const struct kith_step_cost *cost,
                                int n_ranks, const char *partitioner, struct kith_forecast *out);

#endif
