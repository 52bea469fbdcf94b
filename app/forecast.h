/* forecast.h - what N ranks would have of a scene, say to each other and take, without any of them.
 *
 * The cells are those of a run (share.h); their work is nodes and row entries at the start, as a run measures it. A partitioner makes its first
 * map and goes on until it changes nothing (at most 20 times). Then
 *   ghosts made   every node, for every rank that it would be sent to: one with a cell at
 *                     d(x, box around the nodes of the cell) <= f max(R, largest R of the cell),   periodic images too,
 *                 and every mirror image that the lists of one process have: what the distributed boundary sends before culling
 *   ghosts kept   every node or image of another rank's node that is in the row of a node of the rank; those made if nothing is culled
 *   messages      of a list: one to every rank that is sent ghosts, and one back that tells which are kept; one for every refresh
 *   bytes         the fields that a new ghost has, a byte back for each, the fields of every refresh
 * Fields and refreshes are taken from the model: its rates are evaluated with an exchange that sends nothing and takes notes.
 *
 * Seconds of a step, of a rank that has the most of everything:
 *   T = c_w W + c_g G + L P (p / b + c_p) + m l + B / b + C l log2 N
 * W nodes and row entries, G ghosts made, m messages, B bytes, C collective calls, l latency, b bandwidth; L lists a step, for each of which
 * every rank gets the places of all (P cells that are not empty, p bytes each) and tests them (c_p seconds each). Every rank has as many threads as this process. */
#ifndef KITH_APP_FORECAST_H
#define KITH_APP_FORECAST_H

#include "app/model.h"
#include "app/options.h"

/* What a ghost of another rank costs, from the search for who needs it to its place in the lists, in row entries: `kith bench --ranks`
 * measures it (validation/scaling.md). */
#define KITH_GHOST_WORK 40.0
/* Of a step. */
struct kith_step_habits {
  double lists;                    /* made */
  double refreshes, refresh_bytes; /* of ghosts that were kept; bytes of a node, in all of them */
  double creation_bytes;           /* of a new ghost */
  double collectives;
  bool culls;
};
/* Notes what rates say. lists: of a step, at most its evaluations. The model has no ranks; it is evaluated once or twice. */
kith_status kith_step_habits(struct kith_model *model, double lists, struct kith_step_habits *out);

/* Seconds. */
struct kith_costs {
  double work; /* of a node or row entry */
  double ghost;
  struct kith_network network;
};

struct kith_forecast {
  double imbalance;                                  /* most work over the mean */
  double work;                                       /* nodes and row entries of the busiest rank */
  double made, most_made, kept, most_peers;          /* ghosts of a rank; ranks that it exchanges with */
  double messages, bytes, most_messages, most_bytes; /* of a rank and step */
  struct {
    double work, ghosts, places, network, step; /* places: telling and testing those of all */
  } seconds;
};

struct kith_outlook; /* opaque */

/* Of a model that was started, without ranks; borrowed. BAD_INPUT: more than 16384 ranks, or ghosts that compute their own values. */
kith_status kith_outlook_create(struct kith_outlook **out, const struct kith_model *model, int n_ranks);
void kith_outlook_destroy(struct kith_outlook **outlook);
int64_t kith_outlook_cells(const struct kith_outlook *outlook);
/* partitioner: as in a scene. */
kith_status kith_outlook_forecast(const struct kith_outlook *outlook, const char *partitioner,
                                  const struct kith_step_habits *habits, const struct kith_costs *costs,
                                  struct kith_forecast *out);

#endif
