/* progress.h - how far many runs are, and when they will be done. */
#ifndef KITH_APP_PROGRESS_H
#define KITH_APP_PROGRESS_H

#include "app/matrix.h"

/* One line on stderr for a point that is there: "[3/12] sph at 100: density.l1 0.0203, 0.01 CPU-s; about 2 min left". metric: what to
 * show of it; left: seconds, NaN: not known. A new run says so on a terminal. */
void kith_progress_start(int done, int all, const struct kith_job *job, bool quiet);
void kith_progress_point(int done, int all, const struct kith_point *point, int metric, double left,
                         bool quiet);

#endif
