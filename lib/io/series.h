/* series.h - values at points that grow by a sample at a time: one HDF5 file, a group for each set of points.
 *
 *   /NAME/points   [n][3], zeros behind in 1-D and 2-D
 *   /NAME/time, /NAME/step    [samples]
 *   /NAME/COLUMN   [samples][n], [samples][n][3] or [samples][n][9]; NaN where there is no value
 *   attribute shape of /NAME: points along each of up to three edges, the last one varies fastest
 *   attribute description of each column
 *
 * The file is closed between samples, so that it can be read while a run goes on. What a crash in the middle
 * of a sample leaves may be damaged: a run writes a copy (app/output/probes.h). Not collective: one process
 * writes. */
#ifndef KITH_IO_SERIES_H
#define KITH_IO_SERIES_H

#include "lib/core/base.h"

struct kith_series_column {
  const char *name, *doc;
  int components; /* 1, 3 or 9 */
};
struct kith_series {
  const char *name; /* of the group */
  size_t n;
  const double *points; /* [n][3] */
  int shape[3];
  int n_columns;
  const struct kith_series_column *column;
};

/* A new file, which replaces an old one. BAD_FILE with the path. */
kith_status kith_series_create(const char *path, const struct kith_series *series, int count);
/* Goes on with one of them: samples after `step` are dropped. BAD_INPUT if it is not in the file. */
kith_status kith_series_resume(const char *path, const struct kith_series *series, uint64_t step);
/* values[column][n][components]. */
kith_status kith_series_append(const char *path, const struct kith_series *series, double time, uint64_t step,
                               const double *const *values);
/* Column `column` of group `name`, or its "time": sample `sample`, or all (-1). n: samples in the file, each:
 * values of a sample, *values: [samples that were read][each]; NULL or those of an earlier read at the call,
 * owned by the caller, also after a failure. BAD_FILE with the path. */
kith_status kith_series_read(const char *path, const char *name, const char *column, int64_t sample,
                             double **values, size_t *n, size_t *each);

#endif
