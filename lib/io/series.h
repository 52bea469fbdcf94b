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

/* Creates a file with `count` series, which replaces an old one. BAD_FILE with the path. */
kith_status kith_series_create(const char *path, const struct kith_series *series, int count);
/* Prepares a file to be continued after `step`: removes later samples of a series. BAD_INPUT if the file has
 * no such series, with the same points and columns. */
kith_status kith_series_resume(const char *path, const struct kith_series *series, uint64_t step);
/* Appends a sample, values[column][n][components], to a series. */
kith_status kith_series_append(const char *path, const struct kith_series *series, double time, uint64_t step,
                               const double *const *values);
/* Reads a column of the group `name`, or its "time": one sample, or all samples if `sample` is -1. Sets *n to
 * the number of samples in the file, *each to the number of values of a sample, and *values to what was read,
 * [samples][each]. *values must be NULL or from an earlier read, and is owned by the caller, also after a
 * failure. BAD_FILE with the path. */
kith_status kith_series_read(const char *path, const char *name, const char *column, int64_t sample,
                             double **values, size_t *n, size_t *each);

#endif
