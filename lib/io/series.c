/* series.c - data sets that grow, through HDF5. HDF5 returns negative handles after a failure, and calls with
 * such a handle fail as well. So no call is checked by itself: HDF5 has failures counted (count_failure). */
#include "lib/io/series.h"

#include <hdf5.h>
#include <string.h>
#include "lib/io/child.h"

enum { FIXED = 2 }; /* columns before those of the series: time, step */

struct column {
  char name[64];
  hid_t type;
  int rank; /* dimensions of a sample: 0 a number, 1 a number for each point, 2 several for each point */
  hsize_t size[3];
};

/* Describes column k of a group. The first of its dimensions, which grows, is that of the samples. */
static struct column column_of(const struct kith_series *series, int k) {
  struct column c = {.name = "time", .type = H5T_NATIVE_DOUBLE, .size = {0, series->n, 0}};
  if (k == 1) strcpy(c.name, "step"), c.type = H5T_NATIVE_UINT64;
  if (k < FIXED) return c;
  const struct kith_series_column *of = &series->column[k - FIXED];
  strncat(strcpy(c.name, ""), of->name, sizeof c.name - 1);
  c.rank = of->components > 1 ? 2 : 1;
  c.size[2] = (hsize_t)of->components;
  return c;
}

/* What is done to a file, in a child process (child.h). */
struct job {
  const char *path;
  const struct kith_series *series;
  bool (*action)(hid_t file, const struct job *job); /* returns false if the file does not have the series */
  int count;                                         /* to create: number of series */
  uint64_t step;  /* to resume: the last to keep; to append: that of the sample */
  double *points; /* to resume: memory to read the points of the file into */
  double time;    /* to append: those of the sample */
  const double *const *values;
};

static herr_t count_failure(hid_t stack, void *failures) {
  (void)stack;
  ++*(int *)failures;
  return 0;
}

static void attribute(hid_t owner, const char *name, hid_t type, hsize_t n, const void *values) {
  const hid_t space = n > 0 ? H5Screate_simple(1, &n, NULL) : H5Screate(H5S_SCALAR);
  const hid_t id = H5Acreate2(owner, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
  H5Awrite(id, type, values);
  H5Aclose(id);
  H5Sclose(space);
}

static void create_column(hid_t group, const struct kith_series *series, int k) {
  struct column c = column_of(series, k);
  const hsize_t most[3] = {H5S_UNLIMITED, c.size[1], c.size[2]},
                chunk[3] = {c.rank > 0 ? 1 : 1024, c.size[1], c.size[2]};
  const hid_t space = H5Screate_simple(1 + c.rank, c.size, most), how = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_chunk(how, 1 + c.rank, chunk);
  H5Pset_obj_track_times(how, false); /* the same samples make the same file */
  const hid_t id = H5Dcreate2(group, c.name, c.type, space, H5P_DEFAULT, how, H5P_DEFAULT);
  if (k >= FIXED) {
    const hid_t text = H5Tcopy(H5T_C_S1);
    H5Tset_size(text, strlen(series->column[k - FIXED].doc) + 1);
    attribute(id, "description", text, 0, series->column[k - FIXED].doc);
    H5Tclose(text);
  }
  H5Dclose(id);
  H5Pclose(how);
  H5Sclose(space);
}

static void create_group(hid_t file, const struct kith_series *series) {
  const hid_t group = H5Gcreate2(file, series->name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  const hsize_t size[2] = {series->n, 3};
  const hid_t space = H5Screate_simple(2, size, NULL), how = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_obj_track_times(how, false);
  const hid_t points = H5Dcreate2(group, "points", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, how, H5P_DEFAULT);
  H5Dwrite(points, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, series->points);
  H5Dclose(points);
  H5Pclose(how);
  H5Sclose(space);
  attribute(group, "shape", H5T_NATIVE_INT, 3, series->shape);
  for (int k = 0; k < FIXED + series->n_columns; ++k) create_column(group, series, k);
  H5Gclose(group);
}

static bool create_groups(hid_t file, const struct job *job) {
  for (int s = 0; s < job->count; ++s) create_group(file, &job->series[s]);
  return true;
}

/* Returns how many samples a column has, or -1 if there is no such column, or it has other points. */
static hssize_t samples_of(hid_t group, const struct column *c) {
  hsize_t size[3] = {0};
  if (H5Lexists(group, c->name, H5P_DEFAULT) <= 0) return -1;
  const hid_t id = H5Dopen2(group, c->name, H5P_DEFAULT), space = H5Dget_space(id);
  const bool fits = H5Sget_simple_extent_ndims(space) == 1 + c->rank;
  if (fits) H5Sget_simple_extent_dims(space, size, NULL);
  H5Sclose(space);
  H5Dclose(id);
  for (int k = 1; k <= c->rank; ++k)
    if (size[k] != c->size[k]) return -1;
  return fits ? (hssize_t)size[0] : -1;
}

/* The step of sample k. */
static uint64_t step_of(hid_t steps, hsize_t k) {
  const hsize_t one = 1;
  const hid_t space = H5Dget_space(steps), number = H5Screate_simple(1, &one, NULL);
  uint64_t step = 0;
  H5Sselect_hyperslab(space, H5S_SELECT_SET, &k, NULL, &one, NULL);
  H5Dread(steps, H5T_NATIVE_UINT64, number, space, H5P_DEFAULT, &step);
  H5Sclose(number);
  H5Sclose(space);
  return step;
}

/* Returns how many of n samples, whose steps ascend, are not later than `step`. Steps are read one by one
 * from the end, since mostly few are later. */
static hsize_t samples_until(hid_t group, hsize_t n, uint64_t step) {
  const hid_t steps = H5Dopen2(group, "step", H5P_DEFAULT);
  while (n > 0 && step_of(steps, n - 1) > step) --n;
  H5Dclose(steps);
  return n;
}

/* Has the group the points of the series, and as many columns? `points`: memory to read its points into. */
static bool is_of(hid_t group, const struct kith_series *series, double *points) {
  const struct column c = {.name = "points", .rank = 1, .size = {series->n, 3}};
  H5G_info_t group_info = {0};
  H5Gget_info(group, &group_info);
  if (group_info.nlinks != (hsize_t)(1 + FIXED + series->n_columns)) return false;
  if (samples_of(group, &c) != (hssize_t)series->n) return false;
  const hid_t id = H5Dopen2(group, "points", H5P_DEFAULT);
  H5Dread(id, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, points);
  H5Dclose(id);
  return memcmp(points, series->points, 3 * series->n * sizeof *points) == 0;
}

/* Removes the samples after job->step from all columns, unless the group has other points or columns. */
static bool resume(hid_t file, const struct job *job) {
  const struct kith_series *series = job->series;
  if (H5Lexists(file, series->name, H5P_DEFAULT) <= 0) return false;
  const hid_t group = H5Gopen2(file, series->name, H5P_DEFAULT);
  struct column c = column_of(series, 1);
  const hssize_t n = samples_of(group, &c);
  const hsize_t kept = n > 0 ? samples_until(group, (hsize_t)n, job->step) : 0;
  bool same = n >= 0 && is_of(group, series, job->points);
  for (int k = 0; k < FIXED + series->n_columns && same; ++k) {
    c = column_of(series, k);
    same = samples_of(group, &c) >= (hssize_t)kept;
    c.size[0] = kept;
    if (!same) continue;
    const hid_t id = H5Dopen2(group, c.name, H5P_DEFAULT);
    H5Dset_extent(id, c.size);
    H5Dclose(id);
  }
  H5Gclose(group);
  return same;
}

static void append_value(hid_t group, const struct kith_series *series, int k, const void *values) {
  struct column c = column_of(series, k);
  const hsize_t from[3] = {(hsize_t)KITH_MAX(samples_of(group, &c), 0)}, one[3] = {1, c.size[1], c.size[2]};
  c.size[0] = from[0] + 1;
  const hid_t id = H5Dopen2(group, c.name, H5P_DEFAULT);
  H5Dset_extent(id, c.size);
  const hid_t space = H5Dget_space(id), sample = H5Screate_simple(1 + c.rank, one, NULL);
  H5Sselect_hyperslab(space, H5S_SELECT_SET, from, NULL, one, NULL);
  H5Dwrite(id, c.type, sample, space, H5P_DEFAULT, values);
  H5Sclose(sample);
  H5Sclose(space);
  H5Dclose(id);
}

static bool append(hid_t file, const struct job *job) {
  const struct kith_series *series = job->series;
  const hid_t group = H5Gopen2(file, series->name, H5P_DEFAULT);
  append_value(group, series, 0, &job->time);
  append_value(group, series, 1, &job->step);
  for (int k = 0; k < series->n_columns; ++k) append_value(group, series, FIXED + k, job->values[k]);
  H5Gclose(group);
  return true;
}

enum outcome { DONE, FAILED, OTHER };

static int work(void *of) {
  const struct job *job = of;
  int failures = 0;
  H5E_auto2_t handler;
  void *data;
  H5Eget_auto2(H5E_DEFAULT, &handler, &data);
  H5Eset_auto2(H5E_DEFAULT, count_failure, &failures);
  const hid_t file = job->action == create_groups
                         ? H5Fcreate(job->path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT)
                         : H5Fopen(job->path, H5F_ACC_RDWR, H5P_DEFAULT);
  const bool same = file < 0 || job->action(file, job);
  if (file >= 0) H5Fclose(file);
  H5Eset_auto2(H5E_DEFAULT, handler, data);
  return failures > 0 || file < 0 ? FAILED : same ? DONE : OTHER;
}

static kith_status with_file(struct job job) {
  const int outcome = kith_child_run(work, &job);
  if (outcome == OTHER) KITH_FAIL(BAD_INPUT, "%s: it has other probes than the scene", job.path);
  if (outcome != DONE) KITH_FAIL(BAD_FILE, "%s: HDF5 cannot write it", job.path);
  return KITH_OK;
}

kith_status kith_series_create(const char *path, const struct kith_series *series, int count) {
  return with_file((struct job){path, series, create_groups, .count = count});
}

kith_status kith_series_resume(const char *path, const struct kith_series *series, uint64_t step) {
  double *points = NULL;
  KITH_TRY(kith_resize(&points, 0, 3 * series->n, sizeof *points));
  const kith_status status = with_file((struct job){path, series, resume, .step = step, .points = points});
  kith_free(&points);
  return status;
}

kith_status kith_series_append(const char *path, const struct kith_series *series, double time, uint64_t step,
                               const double *const *values) {
  return with_file((struct job){path, series, append, .step = step, .time = time, .values = values});
}

static kith_status read_samples(hid_t data, int64_t sample, double **values, size_t *n, size_t *each) {
  const hid_t space = H5Dget_space(data);
  hsize_t size[3] = {0, 1, 1}, from[3] = {0};
  H5Sget_simple_extent_dims(space, size, NULL);
  *n = size[0], *each = size[1] * size[2];
  if (sample >= 0) from[0] = (hsize_t)sample, size[0] = 1;
  const kith_status status = kith_resize(values, 0, size[0] * *each + 1, sizeof **values);
  const hid_t into = H5Screate_simple(3, size, NULL);
  if (status == KITH_OK) {
    H5Sselect_hyperslab(space, H5S_SELECT_SET, from, NULL, size, NULL);
    H5Dread(data, H5T_NATIVE_DOUBLE, into, space, H5P_DEFAULT, *values);
  }
  H5Sclose(into);
  H5Sclose(space);
  return status;
}

kith_status kith_series_read(const char *path, const char *name, const char *column, int64_t sample,
                             double **values, size_t *n, size_t *each) {
  int failures = 0;
  H5E_auto2_t handler;
  void *data;
  char at[128];
  snprintf(at, sizeof at, "%s/%s", name, column);
  H5Eget_auto2(H5E_DEFAULT, &handler, &data);
  H5Eset_auto2(H5E_DEFAULT, count_failure, &failures);
  const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT), set = H5Dopen2(file, at, H5P_DEFAULT);
  const kith_status status = failures == 0 ? read_samples(set, sample, values, n, each) : KITH_OK;
  H5Dclose(set);
  H5Fclose(file);
  H5Eset_auto2(H5E_DEFAULT, handler, data);
  if (status == KITH_OK && failures > 0) KITH_FAIL(BAD_FILE, "%s: cannot read %s", path, at);
  return status;
}
