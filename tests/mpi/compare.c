/* compare A B TOLERANCE: compares all fields of two snapshots, node by node in order of their ids. The
 * difference of a field is the largest over its nodes, divided by the largest value in A. Prints the field
 * that differs most, and fails if it differs by more than the tolerance. With "bytes" in place of TOLERANCE,
 * the files must be identical. */
#include <hdf5.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct snapshot {
  hid_t file, particles;
  hsize_t n;
  size_t *by_id; /* indices of nodes in order of their ids */
  long long *id;
};

static const long long *ids_to_sort;

static int by_id(const void *a, const void *b) {
  const long long p = ids_to_sort[*(const size_t *)a], q = ids_to_sort[*(const size_t *)b];
  return (p > q) - (p < q);
}

static int open_snapshot(struct snapshot *s, const char *path) {
  s->file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  if (s->file < 0) return fprintf(stderr, "%s: cannot be opened\n", path), 0;
  s->particles = H5Gopen2(s->file, "PartType0", H5P_DEFAULT);
  const hid_t ids = H5Dopen2(s->particles, "ParticleIDs", H5P_DEFAULT), space = H5Dget_space(ids);
  H5Sget_simple_extent_dims(space, &s->n, NULL);
  s->id = malloc(s->n * sizeof *s->id + 1);
  s->by_id = malloc(s->n * sizeof *s->by_id + 1);
  H5Dread(ids, H5T_NATIVE_LLONG, H5S_ALL, H5S_ALL, H5P_DEFAULT, s->id);
  for (size_t k = 0; k < s->n; ++k) s->by_id[k] = k;
  ids_to_sort = s->id;
  qsort(s->by_id, s->n, sizeof *s->by_id, by_id);
  H5Sclose(space), H5Dclose(ids);
  return 1;
}

static double *read_field(const struct snapshot *s, const char *name, size_t *columns) {
  hsize_t shape[2] = {0, 1};
  const hid_t data = H5Dopen2(s->particles, name, H5P_DEFAULT);
  if (data < 0) return NULL;
  const hid_t space = H5Dget_space(data);
  H5Sget_simple_extent_dims(space, shape, NULL);
  double *value = malloc(shape[0] * shape[1] * sizeof *value + 1);
  H5Dread(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, value);
  H5Sclose(space), H5Dclose(data);
  *columns = shape[1];
  return value;
}

static void close_snapshot(struct snapshot *s) {
  free(s->id), free(s->by_id);
  H5Gclose(s->particles), H5Fclose(s->file);
}

/* Infinite if one of them has no such field, or a value is NaN in only one of them. */
static double difference(const struct snapshot *a, const struct snapshot *b, const char *name) {
  size_t columns = 0, other = 0;
  double *x = read_field(a, name, &columns), *y = read_field(b, name, &other), most = 0, worst = 0;
  const bool both = x != NULL && y != NULL && columns == other;
  if (!both) worst = INFINITY;
  for (size_t k = 0; both && k < a->n; ++k)
    for (size_t c = 0; c < columns; ++c) {
      const double p = x[a->by_id[k] * columns + c], q = y[b->by_id[k] * columns + c];
      if (isnan(p) != isnan(q)) worst = INFINITY;
      most = fmax(most, fabs(p)), worst = fmax(worst, fabs(p - q));
    }
  free(x), free(y);
  return most > 0 ? worst / most : worst;
}

struct worst {
  const struct snapshot *a, *b;
  double difference;
  char field[64];
};

static herr_t compare_field(hid_t group, const char *name, const H5L_info_t *info, void *context) {
  struct worst *w = context;
  (void)group, (void)info;
  const double d = difference(w->a, w->b, name);
  if (d > w->difference || w->field[0] == '\0') snprintf(w->field, sizeof w->field, "%s", name);
  w->difference = fmax(w->difference, d);
  return 0;
}

static int identical_files(const char *one_path, const char *other_path) {
  FILE *a = fopen(one_path, "rb"), *b = fopen(other_path, "rb");
  long at = 0;
  int p = 0, q = 0;
  if (a == NULL || b == NULL) return fprintf(stderr, "%s, %s: cannot be read\n", one_path, other_path), 0;
  for (; p == q && p != EOF; ++at) p = getc(a), q = getc(b);
  if (p != q) fprintf(stderr, "%s and %s differ at byte %ld\n", one_path, other_path, at);
  fclose(a), fclose(b);
  return p == q;
}

int main(int argc, char **argv) {
  struct snapshot a, b;
  if (argc != 4) return 2;
  if (strcmp(argv[3], "bytes") == 0) return !identical_files(argv[1], argv[2]);
  if (!open_snapshot(&a, argv[1]) || !open_snapshot(&b, argv[2])) return 2;
  if (a.n != b.n)
    return fprintf(stderr, "%llu nodes and %llu\n", (unsigned long long)a.n, (unsigned long long)b.n), 1;
  for (size_t k = 0; k < a.n; ++k)
    if (a.id[a.by_id[k]] != b.id[b.by_id[k]]) return fprintf(stderr, "the ids differ\n"), 1;
  struct worst w = {&a, &b, 0, ""};
  H5Literate(a.particles, H5_INDEX_NAME, H5_ITER_INC, NULL, compare_field, &w);
  H5Literate(b.particles, H5_INDEX_NAME, H5_ITER_INC, NULL, compare_field, &w); /* fields that only B has */
  printf("%.3g %s\n", w.difference, w.field);
  close_snapshot(&a), close_snapshot(&b);
  return !(w.difference <= atof(argv[3]));
}
