/* snapshot_diff.c - reads fields as doubles, which hold ids up to 2^53, and compares them in the order of
 * ids. */
#include "app/study/snapshot_diff.h"

#include <float.h>
#include <hdf5.h>
#include <hdf5_hl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct field {
  hsize_t shape[2];
  double *value;
};

/* An id, and the row where it is stored. */
struct located {
  double id;
  size_t row;
};

struct comparison {
  hid_t file[2], particles[2];
  struct located *order[2]; /* owned; by id, or as they are stored */
  size_t n;
  bool by_nodes;
  struct kith_snapshot_diff *same;
};

static bool read_field(hid_t particles, const char *name, struct field *field) {
  int rank;
  field->shape[0] = 0, field->shape[1] = 1;
  return H5LTget_dataset_ndims(particles, name, &rank) >= 0 && rank <= 2 &&
         H5LTget_dataset_info(particles, name, field->shape, NULL, NULL) >= 0 &&
         kith_resize(&field->value, 0, field->shape[0] * field->shape[1], sizeof *field->value) == KITH_OK &&
         H5LTread_dataset_double(particles, name, field->value) >= 0;
}

static void note(struct comparison *c, double difference, const char *name) {
  if (!(difference > c->same->difference)) return;
  c->same->difference = difference;
  snprintf(c->same->field, sizeof c->same->field, "%s", name);
}

static double difference_of(const struct comparison *c, const struct field *a, const struct field *b) {
  const size_t columns = a->shape[1];
  double largest = 0, difference = 0;
  for (size_t k = 0; k < c->n * columns; ++k) {
    const double x = a->value[c->order[0][k / columns].row * columns + k % columns],
                 y = b->value[c->order[1][k / columns].row * columns + k % columns];
    if (isnan(x) != isnan(y)) return INFINITY;
    largest = fmax(largest, fabs(x)), difference = fmax(difference, fabs(x - y));
  }
  return largest > 0 ? difference / largest : difference;
}

static herr_t compare_field(hid_t group, const char *name, const H5L_info_t *info, void *context) {
  struct comparison *c = context;
  struct field a = {0}, b = {0};
  (void)group, (void)info;
  if (!read_field(c->particles[0], name, &a) || !read_field(c->particles[1], name, &b) ||
      a.shape[0] != c->n || b.shape[0] != c->n || a.shape[1] != b.shape[1])
    note(c, INFINITY, name);
  else if (c->by_nodes)
    note(c, difference_of(c, &a, &b), name);
  else if (memcmp(a.value, b.value, c->n * a.shape[1] * sizeof *a.value) != 0)
    note(c, fmax(difference_of(c, &a, &b), DBL_MIN), name);
  kith_free(&a.value);
  kith_free(&b.value);
  return 0;
}

static int by_id(const void *a, const void *b) {
  const double x = ((const struct located *)a)->id, y = ((const struct located *)b)->id;
  return (x > y) - (x < y);
}

/* The order of side k; *n: its nodes. */
static bool find_order(struct comparison *c, int k, size_t *n) {
  struct field id = {0};
  const bool good = read_field(c->particles[k], "ParticleIDs", &id) &&
                    kith_resize(&c->order[k], 0, id.shape[0] + 1, sizeof *c->order[k]) == KITH_OK;
  *n = id.shape[0];
  for (size_t row = 0; good && row < *n; ++row) c->order[k][row] = (struct located){id.value[row], row};
  if (good && c->by_nodes) qsort(c->order[k], *n, sizeof *c->order[k], by_id);
  kith_free(&id.value);
  return good;
}

static double time_of(hid_t file) {
  double time = NAN;
  H5LTget_attribute_double(file, "Header", "Time", &time);
  return time;
}

static bool compare(struct comparison *c) {
  H5G_info_t fields[2];
  size_t n;
  if (!find_order(c, 0, &c->n) || !find_order(c, 1, &n) || H5Gget_info(c->particles[0], &fields[0]) < 0 ||
      H5Gget_info(c->particles[1], &fields[1]) < 0)
    return false;
  bool same = n == c->n;
  for (size_t k = 0; same && k < n; ++k) same = !c->by_nodes || c->order[0][k].id == c->order[1][k].id;
  if (!same) note(c, INFINITY, "ParticleIDs");
  if (fields[0].nlinks != fields[1].nlinks) note(c, INFINITY, "fields");
  if (!c->by_nodes && time_of(c->file[0]) != time_of(c->file[1])) note(c, INFINITY, "Time");
  return c->same->difference > 0 ||
         H5Literate(c->particles[0], H5_INDEX_NAME, H5_ITER_INC, NULL, compare_field, c) >= 0;
}

kith_status kith_snapshot_diff_files(const char *a, const char *b, bool by_nodes,
                                     struct kith_snapshot_diff *same) {
  struct comparison c = {.by_nodes = by_nodes, .same = same};
  H5E_auto2_t print;
  void *with;
  *same = (struct kith_snapshot_diff){0};
  H5Eget_auto2(H5E_DEFAULT, &print, &with);
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL); /* HDF5 prints nothing: the caller has the message */
  for (int k = 0; k < 2; ++k) {
    c.file[k] = H5Fopen(k == 0 ? a : b, H5F_ACC_RDONLY, H5P_DEFAULT);
    c.particles[k] = H5Gopen2(c.file[k], "PartType0", H5P_DEFAULT);
  }
  const bool good = compare(&c);
  for (int k = 0; k < 2; ++k) {
    if (c.particles[k] >= 0) H5Gclose(c.particles[k]);
    if (c.file[k] >= 0) H5Fclose(c.file[k]);
    kith_free(&c.order[k]);
  }
  H5Eset_auto2(H5E_DEFAULT, print, with);
  if (!good) KITH_FAIL(BAD_FILE, "%s and %s: not two snapshots that can be read", a, b);
  return KITH_OK;
}
