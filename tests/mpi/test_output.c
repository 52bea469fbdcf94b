/* Run by mpirun: checkpoints and snapshots of nodes that are spread over several ranks, one of which has
 * none. The oracle is the id of a node, from which all its values follow: they are compared when rank 0, or
 * every rank, reads a file back, and a snapshot must have the bytes of one that a single process writes. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "lib/nodes/migrate.h"
#include "lib/io/checkpoint.h"
#include "lib/io/snapshot.h"
#include "tests/check.h"

enum { N = 1237, LISTS = 3 };

static struct kith_ranks *ranks;

static int list_of(int64_t id) {
  return (int)(id % 7 == 0 ? 0 : id % 2 + 1);
}
static double value_of(int64_t id, int component) {
  return 0.1 * (double)id + 1000 * component;
}
static uint8_t mark_of(int64_t id) {
  return (uint8_t)(id % 251);
}
/* Spread over the ranks; the last of several has none. */
static int rank_of(int64_t id) {
  const int size = kith_ranks_size(ranks);
  return size == 1 ? 0 : (int)(id * 31 % 101 % (size - 1));
}

struct world {
  struct kith_nodes *nodes;
  struct kith_field *velocity, *mark, *extra;
};

static void fill(const struct world *w, kith_index i, int64_t id) {
  w->nodes->id->i64[i] = id;
  for (int a = 0; a < NDIM; ++a) {
    w->nodes->position->f64[i * NDIM + a] = value_of(id, a);
    w->velocity->f64[i * NDIM + a] = value_of(id, a + 3);
  }
  w->mark->u8[i] = mark_of(id);
  w->extra->i64[i] = 5 * id;
}

/* Makes the nodes of one rank, of all ranks (-1) or none (-2), in the order of ids 0, step, 2 step, ...
 * modulo N. */
static void make(struct world *w, int rank, int64_t step) {
  static const char *const names[LISTS] = {"rock", "gas", "water"};
  static const struct kith_field_spec velocity = {"velocity", KITH_VELOCITY, KITH_F64,
                                                  KITH_STATE, "Velocities",  "v"};
  static const struct kith_field_spec mark = {"mark", KITH_SCALAR, KITH_U8, KITH_STATE, "Marks", "bytes"};
  static const struct kith_field_spec extra = {"extra", KITH_SCALAR, KITH_I64, KITH_WORK, NULL, "words"};
  CHECK_OK(kith_nodes_create(&w->nodes, LISTS, names));
  CHECK_OK(kith_nodes_field(w->nodes, &velocity, &w->velocity));
  CHECK_OK(kith_nodes_field(w->nodes, &mark, &w->mark));
  CHECK_OK(kith_nodes_field(w->nodes, &extra, &w->extra));
  for (int64_t k = 0; rank > -2 && k < N; ++k) {
    const int64_t id = k * step % N;
    kith_index i;
    if (rank >= 0 && rank_of(id) != rank) continue;
    CHECK_OK(kith_nodes_append(w->nodes, list_of(id), 1, &i));
    fill(w, i, id);
  }
}

static void check_node(const struct kith_nodes *nodes, kith_index i) {
  const int64_t id = nodes->id->i64[i];
  CHECK(nodes->list->u8[i] == list_of(id) && kith_nodes_field_named(nodes, "mark")->u8[i] == mark_of(id));
  for (int a = 0; a < NDIM; ++a)
    CHECK(nodes->position->f64[i * NDIM + a] == value_of(id, a) &&
          kith_nodes_field_named(nodes, "velocity")->f64[i * NDIM + a] == value_of(id, a + 3));
}

/* A checkpoint has nodes in the order of lists, within these of ranks, and within these as they are
 * stored. */
static void check_stored(const struct world *back, int64_t step) {
  kith_index i = 0;
  for (int l = 0; l < LISTS; ++l)
    for (int r = 0; r < kith_ranks_size(ranks); ++r)
      for (int64_t k = 0; k < N; ++k) {
        const int64_t id = k * step % N;
        if (list_of(id) != l || rank_of(id) != r) continue;
        CHECK(i < back->nodes->n_internal && back->nodes->id->i64[i] == id && back->extra->i64[i] == 5 * id);
        check_node(back->nodes, i++);
      }
  CHECK(i == back->nodes->n_internal && i == N);
}

/* Every rank reads a part of the file: an equal share, or the nodes that it had. */
static void read_parts(const char *path, const struct world *w) {
  const size_t size = (size_t)kith_ranks_size(ranks);
  struct kith_checkpoint *c = NULL;
  int64_t *counts = NULL;
  CHECK_OK(kith_nodes_counts(w->nodes, &counts));
  CHECK_OK(kith_checkpoint_open(&c, path, ranks));
  for (int had = 0; had < 2; ++had) {
    struct world part;
    make(&part, -2, 1);
    CHECK_OK(kith_checkpoint_nodes(c, part.nodes, had ? counts : NULL));
    CHECK_OK(kith_checkpoint_get_field(c, part.nodes, part.extra));
    uint64_t sum[2] = {0};
    for (kith_index i = 0; i < part.nodes->n_internal; ++i) {
      const int64_t id = part.nodes->id->i64[i];
      check_node(part.nodes, i);
      CHECK(part.extra->i64[i] == 5 * id && (!had || id == w->nodes->id->i64[i]));
      sum[0] += 1, sum[1] += (uint64_t)(id * id);
    }
    CHECK(had || (size_t)part.nodes->n_internal <= N / size + LISTS);
    kith_ranks_sum_counts(ranks, sum, 2);
    /* each once: the sum of squares of 0 ... N-1 */
    CHECK(sum[0] == N && sum[1] == (uint64_t)(N - 1) * N * (2 * N - 1) / 6);
    kith_nodes_destroy(&part.nodes);
  }
  counts[0] += 1; /* more than there are */
  CHECK_STATUS(KITH_BAD_FILE, kith_checkpoint_nodes(c, w->nodes, counts));
  kith_free(&counts);
  kith_checkpoint_close(&c);
}

/* A wrong byte anywhere in the file is reported on all ranks. */
static void read_damaged(const char *path) {
  struct kith_checkpoint *c = NULL;
  for (long at = 300000; at < 900000; at += 250000) {
    if (kith_ranks_rank(ranks) == 0) {
      FILE *f = fopen(path, "r+b");
      CHECK(f != NULL && fseek(f, at, SEEK_SET) == 0 && fputc(7, f) == 7 && fclose(f) == 0);
    }
    (void)kith_ranks_any(ranks, true); /* waits until it is written */
    CHECK_STATUS(KITH_BAD_FILE, kith_checkpoint_open(&c, path, ranks));
    CHECK(c == NULL && strstr(kith_failure(), "its checksum is wrong") != NULL);
    (void)kith_ranks_any(ranks, true);
    if (kith_ranks_rank(ranks) == 0) {
      FILE *f = fopen(path, "r+b");
      CHECK(f != NULL && fseek(f, at, SEEK_SET) == 0 && fputc(0, f) == 0 && fclose(f) == 0);
    }
    (void)kith_ranks_any(ranks, true);
    CHECK_OK(kith_checkpoint_open(&c, path, ranks));
    kith_checkpoint_close(&c);
  }
}

static void write_and_read(const char *path, const struct world *w, int64_t step) {
  enum { LONG = 100000 }; /* zeros, so that the file has several blocks */
  static double zeros[LONG];
  const bool first = kith_ranks_rank(ranks) == 0;
  struct kith_checkpoint *c = NULL;
  struct world back;
  if (first) CHECK_OK(kith_checkpoint_open_new(&c, path, "scene"));
  CHECK_OK(kith_checkpoint_put_nodes(c, w->nodes));
  CHECK_OK(kith_checkpoint_put_field(c, w->nodes, w->extra));
  if (first) CHECK_OK(kith_checkpoint_put(c, "long", KITH_F64, zeros, LONG));
  if (first) CHECK_OK(kith_checkpoint_commit(&c));
  (void)kith_ranks_any(ranks, true); /* waits until it exists */
  read_parts(path, w);
  read_damaged(path);
  if (!first) return;
  make(&back, -2, 1);
  CHECK_OK(kith_checkpoint_open(&c, path, NULL));
  CHECK_OK(kith_checkpoint_nodes(c, back.nodes, NULL));
  CHECK_OK(kith_checkpoint_get(c, "extra", KITH_I64, back.extra->i64, N));
  kith_checkpoint_close(&c);
  check_stored(&back, step);
  kith_nodes_destroy(&back.nodes);
  unlink(path);
}

/* When writing fails on rank 0, the others learn of it. */
static void failing_checkpoint(const char *path, const struct world *w) {
  struct kith_checkpoint *c = NULL;
  const double x = 0;
  const bool first = kith_ranks_rank(ranks) == 0;
  if (first) {
    CHECK_OK(kith_checkpoint_open_new(&c, path, "scene"));
    CHECK_STATUS(KITH_INTERNAL, kith_checkpoint_put(c, "", KITH_F64, &x, 1));
  }
  CHECK_STATUS(first ? KITH_INTERNAL : KITH_OK, kith_checkpoint_put_nodes(c, w->nodes));
  const kith_status status = kith_checkpoint_put_field(c, w->nodes, w->extra);
  CHECK(status == (first ? KITH_INTERNAL : KITH_OK));
  CHECK_STATUS(KITH_INTERNAL, kith_ranks_allreduce_status(ranks, status));
  if (first) CHECK_STATUS(KITH_BAD_FILE, kith_checkpoint_commit(&c));
  CHECK(access(path, F_OK) != 0);
}

static bool identical_files(const char *one, const char *other) {
  FILE *a = fopen(one, "rb"), *b = fopen(other, "rb");
  int p = 0, q = 0;
  CHECK(a != NULL && b != NULL);
  while (a != NULL && b != NULL && p == q && p != EOF) p = getc(a), q = getc(b);
  if (a != NULL) fclose(a);
  if (b != NULL) fclose(b);
  return p == q;
}

/* Nodes that are shared out by id, and written by all ranks, give the file of a single process that has all
 * nodes in order of their ids. */
static void snapshot_by_id(const char *path, const char *other, const struct world *w) {
  const struct kith_snapshot_info info = {.time = 0.5, .step = 3};
  struct kith_nodes *copy = NULL;
  struct world all;
  CHECK_OK(kith_nodes_by_id(w->nodes, &copy));
  for (kith_index i = 0; i < copy->n_internal; ++i) {
    check_node(copy, i);
    CHECK(i == 0 || copy->list->u8[i] > copy->list->u8[i - 1] || copy->id->i64[i] > copy->id->i64[i - 1]);
  }
  CHECK(copy->n_internal <=
        N / kith_ranks_size(ranks) + 1); /* ids have no gaps: equal ranges have as many nodes */
  CHECK_OK(kith_snapshot_write(path, copy, &info));
  kith_nodes_destroy(&copy);
  if (kith_ranks_rank(ranks) != 0) return;
  make(&all, -1, 1);
  CHECK_OK(kith_snapshot_write(other, all.nodes, &info));
  CHECK(identical_files(path, other));
  kith_nodes_destroy(&all.nodes);
  unlink(path), unlink(other);
}

/* A snapshot without nodes, and one in a directory that does not exist. */
static void empty_and_unwritable(const char *path, const char *nowhere) {
  const struct kith_snapshot_info info = {.time = 0.5};
  struct world w;
  make(&w, -2, 1);
  w.nodes->ranks = ranks;
  CHECK_OK(kith_snapshot_write(path, w.nodes, &info));
  CHECK_STATUS(KITH_BAD_FILE, kith_snapshot_write(nowhere, w.nodes, &info));
  CHECK(kith_ranks_status_is_shared(ranks));
  kith_nodes_destroy(&w.nodes);
  if (kith_ranks_rank(ranks) == 0) unlink(path);
}

int main(void) {
  char directory[64] = "output-test-XXXXXX", path[4][96];
  struct world w;
  CHECK_OK(kith_ranks_create(&ranks));
  if (kith_ranks_rank(ranks) == 0) CHECK(mkdtemp(directory) != NULL);
  kith_ranks_broadcast(ranks, directory, sizeof directory);
  static const char *const names[] = {"a.kith", "a.hdf", "b.hdf", "no/a.hdf"};
  for (int k = 0; k < 4; ++k) snprintf(path[k], sizeof path[k], "%s/%s", directory, names[k]);
  make(&w, kith_ranks_rank(ranks), 11);
  w.nodes->ranks = ranks;
  failing_checkpoint(path[0], &w);
  write_and_read(path[0], &w, 11);
  snapshot_by_id(path[1], path[2], &w);
  empty_and_unwritable(path[1], path[3]);
  kith_nodes_destroy(&w.nodes);
  if (kith_ranks_rank(ranks) == 0) CHECK(rmdir(directory) == 0);
  const int failed = kith_ranks_any(ranks, check_failed() != 0);
  kith_ranks_destroy(&ranks);
  return failed;
}
