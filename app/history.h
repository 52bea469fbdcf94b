/* history.h - DIR/history.csv: one row a step, a header line first, readable by gnuplot and pandas as it is.
 *
 *   step,time,dt,limiter,kinetic,internal,potential,work,total,momentum_x[,momentum_y[,momentum_z]],
 *   [angular_x,angular_y,][angular_z,]velocity_over_sound,      (angular_z in 2-D and 3-D, the others in 3-D)
 *   nodes,ghosts,entries,rebuilds,seconds                       (in one line)
 *
 * potential, work: hydro.h; total = kinetic + internal + potential - work. Doubles have 17 digits. Each row is flushed when it is added. A restart continues the file: rows beyond the
 * step it starts from, and a row that was cut by a kill, are removed, so that it reads like that of the
 * uninterrupted run. */
#ifndef KITH_APP_HISTORY_H
#define KITH_APP_HISTORY_H

#include "lib/core/base.h"

struct kith_history; /* opaque */

struct kith_history_row {
  uint64_t step;
  double time, dt;
  const char *limiter; /* what limited dt: a word without a comma; NULL: none */
  double kinetic, internal, potential, work, momentum[NDIM];
  double angular[3], velocity_over_sound; /* hydro.h */
  int64_t nodes, ghosts;
  int64_t entries;  /* pairs or row entries of the connectivity */
  int64_t rebuilds; /* since the start of the run */
  double seconds;   /* wall, since the start of the process */
};

/* A new file; a present one is replaced. */
kith_status kith_history_open(struct kith_history **out, const char *path);
/* Continues behind the row of `step`. A file that is not there is begun; BAD_FILE if it is no history of this
 * dimension. */
kith_status kith_history_continue(struct kith_history **out, const char *path, uint64_t step);
/* Drops the rows behind `step` of another file that has a title and then rows that begin with a step. None: nothing to do. */
kith_status kith_history_cut(const char *path, uint64_t step);
kith_status kith_history_add(struct kith_history *history, const struct kith_history_row *row);
/* BAD_FILE if the last of it could not be written. Frees *history in any case; accepts a pointer to NULL. */
kith_status kith_history_close(struct kith_history **history);

#endif
