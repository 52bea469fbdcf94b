/* forecast.h - what N ranks would have of a scene, counted by one process, and how long a step would take.
 *
 * The cells are those of a run (lib/domain/decomposition.h); their work is nodes and row entries at the
 * start. A partitioner makes its first map and continues until it changes nothing (at most 20 times). The
 * ghosts of a rank are the nodes and images of others in the rows of its nodes: what culling keeps. (A run
 * keeps all ghosts where less than a sixteenth of them could surely go: it may have up to 6 % more.) Those
 * that are made before are chosen as halo.h says; they are the ghosts where a rehearsal culls none.
 *  A scene that is too large to be laid out here is outlined: its regions and their lattices say how many
 * nodes a cell has. The neighbors of nodes of the same scene with fewer nodes, in spacings, stand around
 * points of its cells, and say which ranks need them; ghosts made before culling are points within reach of
 * cells of a rank, or within the reach of these.
 *
 *    t_rank = T (1 - g) w + T g (n + ghosts) / (all nodes and images) + messages latency + bytes / bandwidth
 *    t_step = max over ranks of t_rank + calls collective ceil(log2 N) + balance
 *
 * T is a step of one process, g the part of it that stages take which treat ghosts as nodes, w the part of
 * the rank in all work, n as large a part of all nodes; calls, and messages and bytes for each neighbor,
 * peer, ghost and cell are what a rehearsal counted; balance: two times the work of all cells at the
 * bandwidth. With fewer cores than ranks the sum of all t_rank over the cores counts, where that is more.
 * Exchange during computation is not subtracted, waiting for a slower neighbor is not added. */
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

struct kith_forecast {
  double imbalance;                 /* most work over the mean */
  double made, ghosts, most_ghosts; /* of a rank: mean before the cull, mean, most */
  double peers, most_peers;         /* ranks that it shares ghosts with */
  double messages, bytes;           /* that it sends in a step, mean */
  double seconds, efficiency;       /* of a step; T over seconds and cores */
  double cells;                     /* of the map that each rank has */
};

/* The cells of n_ranks ranks, by a simulation that is not started: supports converge afterwards. */
kith_status kith_forecast_cells(const struct kith_simulation *simulation, int n_ranks,
                                struct kith_cells *cells);

/* Forecasts a scene on n_ranks ranks. `simulation`, started, without ranks and with all images (none culled),
 * is that of the scene itself, which has these cells, or (cells NULL) has fewer nodes: the scene is outlined.
 * BAD_INPUT: more than 16384 ranks, or ghosts: recompute; UNSUPPORTED: a map that would take the partitioner
 * more than a minute. */
kith_status kith_forecast_ranks(const struct kith_scene *scene, const struct kith_simulation *simulation,
                                const struct kith_cells *cells, const struct kith_step_cost *cost,
                                int n_ranks, const char *partitioner, struct kith_forecast *out);

#endif
