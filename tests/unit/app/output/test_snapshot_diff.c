/* test_snapshot_diff.c - the comparison of two snapshots, as they are stored and node by node, on snapshots
 * with known differences. */
#include "app/study/study.h"

#include <string.h>
#include "lib/io/snapshot.h"
#include "physics/hydro.h"
#include "tests/unit/files.h"

enum { N = 6 };

/* Changes to a plain snapshot: nodes stored in reverse order; the density `to` of the node with id 2; the id
 * of that node; the time; the number of nodes. */
struct change {
  bool backwards;
  double to;
  int64_t id;
  double time;
  int n;
};
static const struct change plain = {false, 102, 2, 0.5, N};

static const char *written(const char *name, struct change change) {
  static const char *const names[1] = {"gas"};
  const char *const out = path_in(name);
  struct kith_nodes *nodes = NULL;
  struct kith_hydro hydro = {0};
  CHECK_OK(kith_nodes_create(&nodes, 1, names));
  CHECK_OK(kith_hydro_init(&hydro, nodes));
  CHECK_OK(kith_nodes_append(nodes, 0, change.n, NULL));
  for (int k = 0; k < change.n; ++k) {
    const int i = change.backwards ? change.n - 1 - k : k;
    nodes->id->i64[k] = i == 2 ? change.id : i;
    nodes->position->f64[(size_t)k * NDIM] = i;
    hydro.density->f64[k] = i == 2 ? change.to : 100 + i;
  }
  const struct kith_snapshot_info info = {.time = change.time, .box = {.lower = {0}, .upper = {N}}};
  CHECK_OK(kith_snapshot_write(out, nodes, &info));
  kith_nodes_destroy(&nodes);
  return out;
}

/* Checks the difference as stored and by nodes, and the name of the field with the largest difference. */
static void check(struct change a, struct change b, double stored, double by_nodes, const char *field) {
  struct kith_snapshot_diff diff;
  const char *one = written("one.hdf", a), *other = written("other.hdf", b);
  CHECK_OK(kith_snapshot_diff_files(one, other, false, &diff));
  CHECK(diff.reordered == (a.backwards != b.backwards));
  CHECK(stored == 0 || isinf(stored) ? diff.difference == stored : diff.difference > 0);
  CHECK_OK(kith_snapshot_diff_files(one, other, true, &diff));
  CHECK(isinf(by_nodes) ? isinf(diff.difference) : fabs(diff.difference - by_nodes) <= 1e-15);
  CHECK(strcmp(diff.field, field) == 0);
}

int main(void) {
  struct kith_snapshot_diff diff;
  static const char *const files[] = {"one.hdf", "other.hdf"};
  directory_make();
  struct change b = plain;
  check(plain, b, 0, 0, "");
  b.backwards = true;
  check(plain, b, 1, 0, "");
  b.to = 102 + 1.05e-6; /* 105 is the largest density; the difference is by id, not by place */
  check(plain, b, 1, (b.to - 102) / 105, "Density");
  CHECK_OK(kith_snapshot_diff_files(path_in("one.hdf"), path_in("other.hdf"), false, &diff));
  CHECK(fabs(diff.difference - (b.to - 102) / 105) <= 1e-15 && strcmp(diff.field, "Density") == 0);
  b.backwards = false;
  check(plain, b, 1, (b.to - 102) / 105, "Density");
  b = plain, b.to = NAN;
  check(plain, b, INFINITY, INFINITY, "Density");
  check(b, b, 0, 0, "");
  b = plain, b.id = 77;
  check(plain, b, 1, INFINITY, "ParticleIDs");
  b = plain, b.n = N - 1;
  check(plain, b, INFINITY, INFINITY, "ParticleIDs");
  /* a default run may end at a time that is rounded differently */
  b = plain, b.time = nextafter(plain.time, 1);
  check(plain, b, INFINITY, 0, "");
  struct change zero = plain, minus = plain; /* no difference in value, but in bits */
  zero.to = 0, minus.to = -0.0;
  check(zero, minus, 1, 0, "");
  const char *one = written("one.hdf", plain);
  CHECK_STATUS(KITH_BAD_FILE, kith_snapshot_diff_files(one, "missing.hdf", true, &diff));
  CHECK_STATUS(KITH_BAD_FILE, kith_snapshot_diff_files("/dev/null", one, false, &diff));
  directory_remove(sizeof files / sizeof *files, files);
  return check_failed();
}
