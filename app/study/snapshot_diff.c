/* snapshot_diff.c - reads fields as doubles, which hold ids up to 2^53. Compares them in the order of ids, or
 * bitwise if both files have the same order. */
#define _GNU_SOURCE /* qsort_r */
#include "app/study/study.h"

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

struct comparison {
  struct side {
    hid_t file, particles;
    struct field id;
    size_t *order; /* owned; rows sorted by id */
  } side[2];
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
  for (size_t k = 0; k < a->shape[0] * columns; ++k) {
    const double x = a->value[c->side[0].order[k / columns] * columns + k % columns],
                 y = b->value[c->side[1].order[k / columns] * columns + k % columns];
    if (isnan(x) != isnan(y)) return INFINITY;
    largest = fmax(largest, fabs(x)), difference = fmax(difference, fabs(x - y));
  }
  return largest > 0 ? difference / largest : difference;
}

static herr_t compare_field(hid_t group, const char *name, const H5L_info_t *info, void *context) {
  struct comparison *c = context;
  struct field a = {0}, b = {0};
  (void)info;
  if (!read_field(group, name, &a) || !read_field(c->side[1].particles, name, &b) ||
      a.shape[0] != c->side[0].id.shape[0] || memcmp(a.shape, b.shape, sizeof a.shape) != 0)
    note(c, INFINITY, name);
  else if (c->by_nodes || c->same->reordered)
    note(c, difference_of(c, &a, &b), name);
  else if (memcmp(a.value, b.value, a.shape[0] * a.shape[1] * sizeof *a.value) != 0)
    note(c, fmax(difference_of(c, &a, &b), DBL_MIN), name);
  KITH_FREE(&a.value, &b.value);
  return 0;
}

static int compare_ids(const void *a, const void *b, void *ids) {
  const double *id = ids, x = id[*(const size_t *)a], y = id[*(const size_t *)b];
  return (x > y) - (x < y);
}

static bool open_side(struct side *s, const char *path) {
  s->file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  s->particles = H5Gopen2(s->file, "PartType0", H5P_DEFAULT);
  if (!read_field(s->particles, "ParticleIDs", &s->id) ||
      kith_resize(&s->order, 0, s->id.shape[0] + 1, sizeof *s->order) != KITH_OK)
    return false;
  for (size_t k = 0; k < s->id.shape[0]; ++k) s->order[k] = k;
  qsort_r(s->order, s->id.shape[0], sizeof *s->order, compare_ids, s->id.value);
  return true;
}

static void close_side(struct side *s) {
  if (s->particles >= 0) H5Gclose(s->particles);
  if (s->file >= 0) H5Fclose(s->file);
  KITH_FREE(&s->id.value, &s->order);
}

static bool compare(struct comparison *c) {
  const struct side *a = &c->side[0], *b = &c->side[1];
  double time[2] = {NAN, NAN};
  H5G_info_t fields[2];
  if (H5Gget_info(a->particles, &fields[0]) < 0 || H5Gget_info(b->particles, &fields[1]) < 0) return false;
  bool same = a->id.shape[0] == b->id.shape[0], moved = false;
  for (size_t k = 0; same && k < a->id.shape[0]; ++k) {
    same = a->id.value[a->order[k]] == b->id.value[b->order[k]];
    moved = moved || a->id.value[k] != b->id.value[k];
  }
  c->same->reordered = same && moved;
  for (int k = 0; k < 2; ++k) H5LTget_attribute_double(c->side[k].file, "Header", "Time", &time[k]);
  if (!same) note(c, INFINITY, "ParticleIDs");
  if (fields[0].nlinks != fields[1].nlinks) note(c, INFINITY, "fields");
  if (!c->by_nodes && time[0] != time[1]) note(c, INFINITY, "Time");
  if (!c->by_nodes && c->same->reordered) note(c, DBL_MIN, "ParticleIDs");
  return isinf(c->same->difference) ||
         H5Literate(a->particles, H5_INDEX_NAME, H5_ITER_INC, NULL, compare_field, c) >= 0;
}

kith_status kith_snapshot_diff_files(const char *a, const char *b, bool by_nodes,
                                     struct kith_snapshot_diff *same) {
  struct comparison c = {.by_nodes = by_nodes, .same = same};
  H5E_auto2_t print;
  void *with;
  *same = (struct kith_snapshot_diff){0};
  H5Eget_auto2(H5E_DEFAULT, &print, &with);
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL); /* HDF5 prints nothing: the caller has the message */
  const bool first = open_side(&c.side[0], a), second = open_side(&c.side[1], b),
             good = first && second && compare(&c);
  for (int k = 0; k < 2; ++k) close_side(&c.side[k]);
  H5Eset_auto2(H5E_DEFAULT, print, with);
  if (!good) KITH_FAIL(BAD_FILE, "%s and %s: not two snapshots that can be read", a, b);
  return KITH_OK;
}
