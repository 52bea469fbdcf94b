/* When two snapshots are the same: as they are stored, and node by node. */
#include "app/study/study.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "lib/io/snapshot.h"
#include "physics/hydro.h"
#include "tests/check.h"

enum { N = 6 };
static char directory[] = "same-test-XXXXXX";

/* What is done to a plain snapshot: nodes stored backwards; `to` as the density of the node with id 2; the id
 * of that node; the time. */
struct change {
  bool backwards;
  double to;
  int64_t id;
  double time;
  int n;
};
static const struct change plain = {false, 102, 2, 0.5, N};

static const char *written(const char *name, struct change change) {
  static char path[2][128];
  static int turn;
  static const char *const names[1] = {"gas"};
  char *out = path[turn++ % 2];
  struct kith_nodes *nodes = NULL;
  struct kith_hydro hydro = {0};
  snprintf(out, sizeof path[0], "%s/%s.hdf", directory, name);
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

/* Differences as they are stored and by nodes; and the field, if there is any. */
static void check(struct change a, struct change b, double stored, double by_nodes, const char *field) {
  struct kith_snapshot_diff same;
  const char *one = written("one", a), *other = written("other", b);
  CHECK_OK(kith_snapshot_diff_files(one, other, false, &same));
  CHECK(stored == 0 || isinf(stored) ? same.difference == stored : same.difference > 0);
  CHECK_OK(kith_snapshot_diff_files(one, other, true, &same));
  CHECK(isinf(by_nodes) ? isinf(same.difference) : fabs(same.difference - by_nodes) <= 1e-15);
  CHECK(strcmp(same.field, field) == 0);
}

int main(void) {
  struct kith_snapshot_diff same;
  char command[160];
  if (mkdtemp(directory) == NULL) return 1;
  struct change b = plain;
  check(plain, b, 0, 0, "");
  b.backwards = true;
  check(plain, b, 1, 0, "");
  b = plain, b.to = 102 + 1.05e-6; /* 105 is the largest density */
  check(plain, b, 1, (b.to - 102) / 105, "Density");
  b = plain, b.to = NAN;
  check(plain, b, INFINITY, INFINITY, "Density");
  check(b, b, 0, 0, "");
  b = plain, b.id = 77;
  check(plain, b, 1, INFINITY, "ParticleIDs");
  b = plain, b.n = N - 1;
  check(plain, b, INFINITY, INFINITY, "ParticleIDs");
  b = plain, b.time = nextafter(plain.time, 1); /* a run in default mode ends a little off */
  check(plain, b, INFINITY, 0, "");
  struct change zero = plain, minus = plain; /* no difference, but not the same bits */
  zero.to = 0, minus.to = -0.0;
  check(zero, minus, 1, 0, "");
  const char *one = written("one", plain);
  CHECK_STATUS(KITH_BAD_FILE, kith_snapshot_diff_files(one, "missing.hdf", true, &same));
  CHECK_STATUS(KITH_BAD_FILE, kith_snapshot_diff_files("/dev/null", one, false, &same));
  snprintf(command, sizeof command, "rm -r %s", directory);
  return check_failed() || system(command) != 0;
}
