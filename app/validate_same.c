#include "app/validate_same.h"

#include <float.h>
#include <hdf5.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One field of one file: numbers as doubles, which hold ids up to 2^53. */
struct field {
  hsize_t rows, columns;
  double *value;
};

/* A field's row, and the id that orders it. */
struct named_row {
  double id;
  size_t row;
};

static bool read_field(hid_t particles, const char *name, struct field *field) {
  hsize_t shape[2] = {0, 1};
  const hid_t data = H5Dopen2(particles, name, H5P_DEFAULT), space = H5Dget_space(data);
  bool good = H5Sget_simple_extent_ndims(space) <= 2 && H5Sget_simple_extent_dims(space, shape, NULL) >= 0 &&
              kith_resize(&field->value, 0, shape[0] * shape[1], sizeof *field->value) == KITH_OK;
  good = good && H5Dread(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, field->value) >= 0;
  if (space >= 0) H5Sclose(space);
  if (data >= 0) H5Dclose(data);
  field->rows = shape[0], field->columns = shape[1];
  return good;
}

static int by_id(const void *a, const void *b) {
  const struct named_row *p = a, *q = b;
  return (p->id > q->id) - (p->id < q->id);
}

/* What is compared, and with what order. */
struct comparison {
  hid_t particles[2];
  struct named_row *order[2]; /* owned; NULL: as they are stored */
  size_t n;
  struct kith_same *same;
};

static void worse(struct kith_same *same, double difference, const char *name) {
  if (!(difference > same->difference)) return;
  same->difference = difference;
  snprintf(same->field, sizeof same->field, "%s", name);
}

static double difference_of(const struct comparison *c, const struct field *a, const struct field *b) {
  double largest = 0, difference = 0;
  for (size_t k = 0; k < c->n * a->columns; ++k) {
    const size_t row = k / a->columns, column = k % a->columns;
    const double x = a->value[(c->order[0] != NULL ? c->order[0][row].row : row) * a->columns + column],
                 y = b->value[(c->order[1] != NULL ? c->order[1][row].row : row) * a->columns + column];
    if (isnan(x) != isnan(y)) return INFINITY;
    largest = fmax(largest, fabs(x)), difference = fmax(difference, fabs(x - y));
  }
  return largest > 0 ? difference / largest : difference;
}

static void compare(const struct comparison *c, const char *name) {
  struct field a = {0}, b = {0};
  const bool read = read_field(c->particles[0], name, &a) && read_field(c->particles[1], name, &b);
  if (!read || a.rows != c->n || b.rows != c->n || a.columns != b.columns)
    worse(c->same, INFINITY, name);
  else if (c->order[0] != NULL)
    worse(c->same, difference_of(c, &a, &b), name);
  else if (memcmp(a.value, b.value, c->n * a.columns * sizeof *a.value) != 0)
    worse(c->same, fmax(difference_of(c, &a, &b), DBL_MIN), name);
  kith_free(&a.value);
  kith_free(&b.value);
}

static herr_t next_field(hid_t group, const char *name, const H5L_info_t *info, void *context) {
  (void)group, (void)info;
  compare(context, name);
  return 0;
}

static bool find_order(hid_t particles, struct named_row **order) {
  struct field id = {0};
  const bool good = read_field(particles, "ParticleIDs", &id) &&
                    kith_resize(order, 0, id.rows + 1, sizeof **order) == KITH_OK;
  for (size_t k = 0; good && k < id.rows; ++k) (*order)[k] = (struct named_row){id.value[k], k};
  if (good) qsort(*order, id.rows, sizeof **order, by_id);
  kith_free(&id.value);
  return good;
}

static bool same_ids(const struct comparison *c) {
  for (size_t k = 0; k < c->n; ++k)
    if (c->order[0][k].id != c->order[1][k].id) return false;
  return true;
}

static double time_of(hid_t file) {
  double time = NAN;
  const hid_t attribute = H5Aopen_by_name(file, "Header", "Time", H5P_DEFAULT, H5P_DEFAULT);
  if (attribute < 0) return time;
  H5Aread(attribute, H5T_NATIVE_DOUBLE, &time);
  H5Aclose(attribute);
  return time;
}

static bool compare_all(struct comparison *c, const hid_t file[2], bool by_nodes) {
  struct field id[2] = {{0}, {0}};
  H5G_info_t fields[2];
  bool good = true;
  for (int k = 0; k < 2; ++k) {
    good = good && H5Gget_info(c->particles[k], &fields[k]) >= 0;
    good = good && read_field(c->particles[k], "ParticleIDs", &id[k]);
    kith_free(&id[k].value);
    if (good && by_nodes) good = find_order(c->particles[k], &c->order[k]);
  }
  if (!good) return false;
  c->n = id[0].rows;
  if (id[0].rows != id[1].rows || (by_nodes && !same_ids(c))) worse(c->same, INFINITY, "ParticleIDs");
  if (fields[0].nlinks != fields[1].nlinks) worse(c->same, INFINITY, "fields");
  if (!by_nodes && time_of(file[0]) != time_of(file[1])) worse(c->same, INFINITY, "Time");
  return c->same->difference > 0 ||
         H5Literate(c->particles[0], H5_INDEX_NAME, H5_ITER_INC, NULL, next_field, c) >= 0;
}

/* HDF5 does not speak: we do. */
kith_status kith_same_snapshots(const char *a, const char *b, bool by_nodes, struct kith_same *same) {
  H5E_auto2_t print;
  void *with;
  H5Eget_auto2(H5E_DEFAULT, &print, &with);
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  *same = (struct kith_same){0};
  struct comparison c = {.same = same};
  hid_t file[2];
  for (int k = 0; k < 2; ++k) {
    file[k] = H5Fopen(k == 0 ? a : b, H5F_ACC_RDONLY, H5P_DEFAULT);
    c.particles[k] = H5Gopen2(file[k], "PartType0", H5P_DEFAULT);
  }
  const bool good = compare_all(&c, file, by_nodes);
  for (int k = 0; k < 2; ++k) {
    if (c.particles[k] >= 0) H5Gclose(c.particles[k]);
    if (file[k] >= 0) H5Fclose(file[k]);
    kith_free(&c.order[k]);
  }
  H5Eset_auto2(H5E_DEFAULT, print, with);
  if (!good) KITH_FAIL(BAD_FILE, "%s and %s: not two snapshots that can be read", a, b);
  return KITH_OK;
}
