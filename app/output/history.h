/* history.h - DIR/history.csv, a row for the start and for each step; gnuplot and pandas read it as it is. A
 * restart continues it: but for `seconds` it reads like that of the uninterrupted run. */
#ifndef KITH_APP_OUTPUT_HISTORY_H
#define KITH_APP_OUTPUT_HISTORY_H

#include "app/simulation/simulation.h"
#include "lib/io/csv.h"

/* Columns: name, least dimension that has it, format (REAL: 17 digits), value (an expression of it:
 * integrator, now: totals, all: sums over ranks, d: decomposition, seconds), unit, doc. */
#define KITH_HISTORY_LIST(X)                                                                                 \
  X(step, 1, COUNT, it->step, "", "steps since the start of the scene")                                      \
  X(time, 1, REAL, it->time, "scene", "time at the end of the step")                                         \
  X(dt, 1, REAL, it->dt, "scene", "length of the step")                                                      \
  X(limiter, 1, TEXT, kith_limit_name(it->limiter), "", "what limited dt")                                   \
  X(kinetic, 1, REAL, now->kinetic, "scene", "kinetic energy")                                               \
  X(internal, 1, REAL, now->internal, "scene", "internal energy")                                            \
  X(potential, 1, REAL, now->potential, "scene", "potential energy of external forces")                      \
  X(work, 1, REAL, now->work, "scene",                                                                       \
    "work of moving walls, up to a constant: their velocity times the momentum of the gas (hydro.h)")        \
  X(through_mass, 1, REAL, now->through.mass, "scene", "mass that came in through faces, minus what left")   \
  X(through_energy, 1, REAL, now->through.energy, "scene",                                                   \
    "likewise energy, with what barriers, frozen nodes and mirrors gave (hydro.h)")                          \
  X(total, 1, REAL, kith_totals_energy(now), "scene",                                                        \
    "kinetic + internal + potential - work - through_energy: conserved")                                     \
  X(mass, 1, REAL, now->mass, "scene", "mass of the gas")                                                    \
  X(momentum_x, 1, REAL, now->momentum[0], "scene", "momentum")                                              \
  X(momentum_y, 2, REAL, component(now->momentum, 1), "scene", "")                                           \
  X(momentum_z, 3, REAL, component(now->momentum, 2), "scene", "")                                           \
  X(through_momentum_x, 1, REAL, now->through.momentum[0], "scene", "likewise, of the momentum")             \
  X(through_momentum_y, 2, REAL, component(now->through.momentum, 1), "scene", "")                           \
  X(through_momentum_z, 3, REAL, component(now->through.momentum, 2), "scene", "")                           \
  X(angular_x, 3, REAL, now->angular[0], "scene", "angular momentum about the center (hydro.h)")             \
  X(angular_y, 3, REAL, now->angular[1], "scene", "")                                                        \
  X(angular_z, 2, REAL, now->angular[2], "scene", "")                                                        \
  X(velocity_over_sound, 1, REAL, now->velocity_over_sound, "", "largest |v| / c of a node")                 \
  X(nodes, 1, COUNT, all->nodes, "", "internal nodes")                                                       \
  X(ghosts, 1, COUNT, all->ghosts, "", "ghost nodes")                                                        \
  X(entries, 1, COUNT, all->row_entries, "", "neighbors in the rows of internal nodes")                      \
  X(rebuilds, 1, COUNT, it->ledger.lifecycles, "", "neighbor lists rebuilt, since the start of the run")     \
  X(imbalance, 1, BRIEF, d->last_imbalance, "", "work of the busiest rank over the mean, at the last check") \
  X(repartitions, 1, COUNT, d->repartitions, "", "partitions changed so far")                                \
  X(migrated, 1, COUNT, all->migrated, "", "nodes that changed their rank so far")                           \
  X(seconds, 1, BRIEF, seconds, "s", "wall time since the start of the process")

struct kith_history {
  struct kith_csv_log steps; /* on rank 0 */
  double largest_imbalance;  /* found by a check after the first; 0: none */
  double started;            /* kith_seconds when the process began */
};

/* Opens the table on rank 0. `restarted`: keeps rows up to the simulation's step; BAD_FILE for other
 * columns. */
kith_status kith_history_open(struct kith_history *history, const char *directory,
                              const struct kith_simulation *simulation, bool restarted);
/* Appends the row of the start, or of a step, once it is summarized; on rank 0, which alone knows of a
 * failure. */
kith_status kith_history_row(struct kith_history *history, const struct kith_simulation *simulation);

#endif
