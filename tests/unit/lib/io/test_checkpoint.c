/* test_checkpoint.c - checkpoints are bitwise identical after reading, the one before is kept, and a file
 * that is damaged in any byte, cut at any length, of another run, written to a full disk or by a killed
 * process is refused or never replaces a good one. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* memfd_create */
#endif
#include <signal.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#include "lib/io/checkpoint.h"
#include "lib/io/child.h"
#include "tests/unit/files.h"

static const char *const names[3] = {"gas", "empty", "wall"};

/* Fields of every type and kind, with -0, NaN and subnormal values; the U8 field does not fill whole
 * words. */
static struct kith_nodes *make_nodes(kith_index gas, kith_index wall, uint64_t seed) {
  static const struct kith_field_spec flag = {"flag", KITH_SCALAR, KITH_U8, KITH_STATE, NULL, ""};
  static const struct kith_field_spec stress = {"stress", KITH_TENSOR, KITH_F64, KITH_STATE, NULL, ""};
  static const struct kith_field_spec scratch = {"scratch", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, ""};
  struct kith_nodes *nodes = NULL;
  struct kith_field *field = NULL;
  CHECK_OK(kith_nodes_create(&nodes, 3, names));
  CHECK_OK(kith_nodes_field(nodes, &flag, &field));
  CHECK_OK(kith_nodes_field(nodes, &stress, &field));
  CHECK_OK(kith_nodes_field(nodes, &scratch, &field));
  if (gas > 0) CHECK_OK(kith_nodes_append(nodes, 0, gas, NULL));
  if (wall > 0) CHECK_OK(kith_nodes_append(nodes, 2, wall, NULL));
  for (int f = 0; f < nodes->n_fields; ++f) {
    field = nodes->fields[f];
    if (field == nodes->list) continue;
    for (kith_index k = 0; k < nodes->n_internal * field->components; ++k) {
      const double r = check_random(&seed);
      if (field->spec.type == KITH_F64)
        field->f64[k] = k == 0 ? -0.0 : k == 1 ? NAN : k == 2 ? 5e-324 : r - 0.5;
      if (field->spec.type == KITH_I64) field->i64[k] = (int64_t)(r * 1e18);
      if (field->spec.type == KITH_U8) field->u8[k] = (uint8_t)(r * 256);
    }
  }
  return nodes;
}

static void save(const char *path, const struct kith_nodes *nodes, double value) {
  const double extra[3] = {value, -0.0, INFINITY};
  const int64_t counters[2] = {INT64_MIN, 7};
  struct kith_checkpoint *c = NULL;
  CHECK_OK(kith_checkpoint_open_new(&c, path, "scene: sod\n"));
  CHECK_OK(kith_checkpoint_put_nodes(c, nodes));
  CHECK_OK(kith_checkpoint_put(c, "extra", KITH_F64, extra, 3));
  CHECK_OK(kith_checkpoint_put(c, "counters", KITH_I64, counters, 2));
  CHECK_OK(kith_checkpoint_put(c, "nothing", KITH_F64, NULL, 0));
  CHECK_OK(kith_checkpoint_commit(&c));
  CHECK(c == NULL);
}

/* Returns the first extra number, or NaN if the file cannot be used. */
static double first_extra(const char *path) {
  struct kith_checkpoint *c = NULL;
  double extra[3] = {NAN};
  if (kith_checkpoint_open(&c, path, NULL) == KITH_OK)
    CHECK_OK(kith_checkpoint_get(c, "extra", KITH_F64, extra, 3));
  kith_checkpoint_close(&c);
  return extra[0];
}

static bool exists(const char *path) {
  return access(path, F_OK) == 0;
}

static void check_equal_nodes(const struct kith_nodes *a, const struct kith_nodes *b) {
  CHECK(a->n_internal == b->n_internal && b->n_ghost == 0);
  for (int l = 0; l < a->n_lists; ++l) {
    CHECK(a->lists[l].first == b->lists[l].first && a->lists[l].count == b->lists[l].count);
    CHECK(strcmp(a->lists[l].name, b->lists[l].name) == 0);
  }
  for (int f = 0; f < a->n_fields; ++f) {
    const struct kith_field *x = a->fields[f], *y = b->fields[f];
    const size_t n = (size_t)a->n_internal * x->components * (x->spec.type == KITH_U8 ? 1 : 8);
    CHECK(x->spec.role == KITH_WORK || n == 0 || memcmp(x->data, y->data, n) == 0);
  }
}

static void round_trip(kith_index gas, kith_index wall, kith_index present) {
  struct kith_nodes *nodes = make_nodes(gas, wall, 5), *other = make_nodes(present, 3, 6);
  struct kith_checkpoint *c = NULL;
  int64_t counters[2] = {0};
  double extra[3] = {0};
  save(path_in("trip"), nodes, 3);
  CHECK_OK(kith_checkpoint_open(&c, path_in("trip"), NULL));
  CHECK(strcmp(kith_checkpoint_scene(c), "scene: sod\n") == 0);
  const uint64_t positions = other->positions, ghosts = other->ghosts;
  CHECK_OK(kith_checkpoint_nodes(c, other, NULL));
  CHECK(other->positions > positions && other->ghosts > ghosts);
  check_equal_nodes(nodes, other);
  for (kith_index i = 0; i < other->n_internal; ++i)
    CHECK(kith_nodes_field_named(other, "scratch")->f64[i] == 0);
  CHECK(kith_checkpoint_length(c, "extra") == 3 && kith_checkpoint_length(c, "nothing") == 0);
  CHECK(kith_checkpoint_length(c, "position") == SIZE_MAX); /* the name of a field is not one of an array */
  CHECK_OK(kith_checkpoint_get(c, "extra", KITH_F64, extra, 3));
  CHECK(extra[0] == 3 && signbit(extra[1]) && isinf(extra[2]));
  CHECK_OK(kith_checkpoint_get(c, "counters", KITH_I64, counters, 2));
  CHECK(counters[0] == INT64_MIN && counters[1] == 7);
  CHECK_OK(kith_checkpoint_get(c, "nothing", KITH_F64, NULL, 0));
  CHECK_STATUS(KITH_BAD_FILE, kith_checkpoint_get(c, "extra", KITH_F64, extra, 2));
  CHECK_STATUS(KITH_BAD_FILE, kith_checkpoint_get(c, "counters", KITH_F64, extra, 2));
  CHECK_STATUS(KITH_BAD_FILE, kith_checkpoint_get(c, "absent", KITH_F64, extra, 1));
  kith_checkpoint_close(&c);
  CHECK(c == NULL);
  kith_nodes_destroy(&nodes);
  kith_nodes_destroy(&other);
}

static void generations(void) {
  struct kith_nodes *nodes = make_nodes(5, 2, 1);
  for (int k = 1; k <= 3; ++k) save(path_in("run"), nodes, k);
  CHECK(first_extra(path_in("run")) == 3);
  CHECK(first_extra(path_in("run.previous")) == 2);
  CHECK(!exists(path_in("run.partial")));
  struct kith_checkpoint *c = NULL;
  CHECK_OK(kith_checkpoint_open_new(&c, path_in("run"), ""));
  CHECK(exists(path_in("run.partial")));
  kith_checkpoint_close(&c);
  CHECK(!exists(path_in("run.partial")) && first_extra(path_in("run")) == 3);
  kith_nodes_destroy(&nodes);
}

/* Checkpoints that do not fit the run are refused before any node changes. */
static void checkpoints_of_other_runs(void) {
  static const struct kith_field_spec more = {"more", KITH_SCALAR, KITH_F64, KITH_STATE, NULL, ""};
  static const char *const renamed[3] = {"gas", "empty", "Wall"};
  struct kith_nodes *nodes = make_nodes(4, 4, 1), *extended = make_nodes(1, 1, 2), *few = NULL,
                    *twisted = NULL;
  struct kith_field *field = NULL;
  struct kith_checkpoint *c = NULL;
  CHECK_OK(kith_nodes_field(extended, &more, &field));
  CHECK_OK(kith_nodes_create(&few, 1, names));
  CHECK_OK(kith_nodes_create(&twisted, 3, renamed));
  save(path_in("four"), nodes, 1);
  CHECK_OK(kith_checkpoint_open(&c, path_in("four"), NULL));
  CHECK_STATUS(KITH_BAD_FILE, kith_checkpoint_nodes(c, extended, NULL));
  CHECK(strstr(kith_failure(), "'more' is missing") != NULL && extended->n_internal == 2);
  CHECK_STATUS(KITH_BAD_INPUT, kith_checkpoint_nodes(c, few, NULL));
  CHECK_STATUS(KITH_BAD_INPUT, kith_checkpoint_nodes(c, twisted, NULL));
  CHECK(strstr(kith_failure(), "'wall', in the scene 'Wall'") != NULL);
  kith_checkpoint_close(&c);
  save(path_in("extended"), extended, 1);
  CHECK_OK(kith_checkpoint_open(&c, path_in("extended"), NULL));
  CHECK_STATUS(KITH_BAD_FILE, kith_checkpoint_nodes(c, nodes, NULL));
  CHECK(strstr(kith_failure(), "'more', which this scene does not use") != NULL && nodes->n_internal == 8);
  kith_checkpoint_close(&c);
  kith_nodes_destroy(&nodes), kith_nodes_destroy(&extended);
  kith_nodes_destroy(&few), kith_nodes_destroy(&twisted);
}

static void misuse(void) {
  struct kith_checkpoint *c = NULL;
  const double x = 1;
  CHECK_STATUS(KITH_BAD_FILE, kith_checkpoint_open(&c, path_in("not-there"), NULL));
  CHECK(c == NULL && strstr(kith_failure(), "No such file") != NULL);
  CHECK_STATUS(KITH_BAD_FILE, kith_checkpoint_open(&c, directory, NULL));
  CHECK_STATUS(KITH_BAD_FILE, kith_checkpoint_open_new(&c, path_in("no/such/place"), ""));
  /* must never be renamed over the device */
  CHECK_STATUS(KITH_BAD_FILE, kith_checkpoint_open_new(&c, "/dev/full", ""));
  CHECK_OK(kith_checkpoint_open_new(&c, path_in("twice"), ""));
  CHECK_OK(kith_checkpoint_put(c, "x", KITH_F64, &x, 1));
  CHECK_STATUS(KITH_INTERNAL, kith_checkpoint_put(c, "", KITH_F64, &x, 1));
  CHECK_STATUS(KITH_BAD_FILE, kith_checkpoint_commit(&c)); /* a failed put is remembered */
  CHECK(c == NULL && !exists(path_in("twice")) && !exists(path_in("twice.partial")));
}

/* Damaged files are in memory, since there are thousands of them. */
static kith_status open_bytes(const unsigned char *bytes, size_t n) {
  char path[64];
  struct kith_checkpoint *c = NULL;
  const int fd = memfd_create("bad", 0);
  CHECK(fd >= 0 && write(fd, bytes, n) == (ssize_t)n);
  snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
  const kith_status status = kith_checkpoint_open(&c, path, NULL);
  CHECK((c == NULL) == (status != KITH_OK));
  CHECK(status == KITH_OK || strncmp(kith_failure(), "/proc/self/fd/", 14) == 0);
  kith_checkpoint_close(&c);
  close(fd);
  return status;
}

/* Tries every length, and a wrong bit in every byte. */
static void damage(void) {
  static unsigned char good[16384], bad[16384];
  struct kith_nodes *nodes = make_nodes(3, 2, 1);
  save(path_in("good"), nodes, 1);
  const size_t n = load(path_in("good"), good, sizeof good);
  CHECK(n > 64 && n < sizeof good);
  CHECK_OK(open_bytes(good, n));
  for (size_t length = 0; length < n; ++length) CHECK_STATUS(KITH_BAD_FILE, open_bytes(good, length));
  for (size_t k = 0; k < n; ++k) {
    memcpy(bad, good, n);
    bad[k] ^= (unsigned char)(1 << k % 8);
    CHECK_STATUS(KITH_BAD_FILE, open_bytes(bad, n));
  }
  memcpy(bad, good, n), bad[n] = 0;
  CHECK_STATUS(KITH_BAD_FILE, open_bytes(bad, n + 1));
  kith_nodes_destroy(&nodes);
}

/* A checkpoint of another dimension is recognized: its checksum is computed here again. */
static void other_dimension(void) {
  unsigned char bytes[16384];
  uint64_t h = UINT64_C(0xcbf29ce484222325), word;
  const uint32_t dimension = NDIM % 3 + 1;
  const size_t n = load(path_in("good"), bytes, sizeof bytes);
  memcpy(bytes + 16, &dimension, sizeof dimension);
  for (size_t k = 0; k + 1 < n / 8; ++k) {
    memcpy(&word, bytes + 8 * k, 8);
    h = (h ^ word) * 1099511628211u;
    h ^= h >> 29;
  }
  memcpy(bytes + n - 8, &h, 8);
  CHECK_STATUS(KITH_BAD_INPUT, open_bytes(bytes, n));
  CHECK(strstr(kith_failure(), "-D checkpoint, this program is") != NULL);
}

/* A full disk at many sizes: a limit of the file size fails as a full disk does, with EFBIG instead of
 * ENOSPC. */
static void full_disk(void) {
  struct kith_nodes *nodes = make_nodes(400, 20, 1);
  struct rlimit old, limit;
  struct stat whole;
  save(path_in("full"), nodes, 1);
  CHECK(stat(path_in("full"), &whole) == 0);
  signal(SIGXFSZ, SIG_IGN);
  getrlimit(RLIMIT_FSIZE, &old);
  for (rlim_t bytes = 0; bytes < (rlim_t)whole.st_size; bytes += 1999) {
    struct kith_checkpoint *c = NULL;
    limit = old, limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
    kith_status status = kith_checkpoint_open_new(&c, path_in("full"), "scene");
    if (status == KITH_OK) {
      kith_checkpoint_put_nodes(c, nodes); /* the commit notices by itself */
      status = kith_checkpoint_commit(&c);
    }
    setrlimit(RLIMIT_FSIZE, &old);
    CHECK(status == KITH_BAD_FILE && strstr(kith_failure(), "full: ") != NULL);
    CHECK(c == NULL && !exists(path_in("full.partial")) && first_extra(path_in("full")) == 1);
  }
  kith_nodes_destroy(&nodes);
}

/* A kill at any time leaves a good checkpoint, and the previous one, if present, is good. */
static void killed_while_writing(void) {
  struct kith_nodes *nodes = make_nodes(2000, 20, 1);
  save(path_in("killed"), nodes, 1);
  for (int k = 0; k < 12; ++k) {
    const pid_t child = fork();
    if (child == 0)
      for (;;) save(path_in("killed"), nodes, 2);
    usleep(500 + 1700 * (useconds_t)k);
    kill(child, SIGKILL);
    kith_child_wait(child);
    const double value = first_extra(path_in("killed"));
    CHECK(value == 1 || value == 2);
    CHECK(!exists(path_in("killed.previous")) || first_extra(path_in("killed.previous")) >= 1);
  }
  save(path_in("killed"), nodes, 3);
  CHECK(first_extra(path_in("killed")) == 3 && first_extra(path_in("killed.previous")) >= 1 &&
        !exists(path_in("killed.partial")));
  kith_nodes_destroy(&nodes);
}

int main(void) {
  static const char *const files[] = {"trip",     "trip.previous", "run",  "run.previous", "four",
                                      "extended", "good",          "full", "killed",       "killed.previous"};
  directory_make();
  round_trip(5, 2, 9);
  round_trip(0, 1, 0);
  round_trip(0, 0, 4);
  generations();
  checkpoints_of_other_runs();
  misuse();
  damage();
  other_dimension();
  full_disk();
  killed_while_writing();
  directory_remove(sizeof files / sizeof *files, files);
  return check_failed();
}
