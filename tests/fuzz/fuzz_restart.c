/* Fuzzing of checkpoints: a file that is damaged or made up is either refused with one line, or restored
 * completely.
 *
 * fuzz-restart [N [SEED]] changes a good file N times (20000) by a fixed generator. Half of the inputs get
 * the right checksum again, so that the checks after that of the checksum are tested too. With clang
 * -fsanitize=fuzzer -DKITH_LIBFUZZER libFuzzer makes the inputs. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* memfd_create */
#endif
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>
#include "lib/io/checkpoint.h"
#include "tests/check.h"

enum { MOST = 1 << 16 };

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
static int opened, restored; /* numbers of inputs that passed each stage */

static struct kith_nodes *make(kith_index gas, kith_index wall) {
  static const char *const names[2] = {"gas", "wall"};
  static const struct kith_field_spec flag = {"flag", KITH_SCALAR, KITH_U8, KITH_STATE, NULL, ""};
  struct kith_nodes *nodes = NULL;
  struct kith_field *field = NULL;
  if (kith_nodes_create(&nodes, 2, names) != KITH_OK || kith_nodes_field(nodes, &flag, &field) != KITH_OK ||
      kith_nodes_append(nodes, 0, gas, NULL) != KITH_OK || kith_nodes_append(nodes, 1, wall, NULL) != KITH_OK)
    abort();
  return nodes;
}

/* Reads the file as a restart does. If it is accepted, the nodes must be those of their lists. */
static void restart(const char *path) {
  struct kith_nodes *nodes = make(2, 1);
  struct kith_checkpoint *c = NULL;
  if (kith_checkpoint_open(&c, path, NULL) == KITH_OK) {
    ++opened;
    if (strlen(kith_checkpoint_scene(c)) > MOST) abort();
    if (kith_checkpoint_nodes(c, nodes, NULL) == KITH_OK) {
      ++restored;
      if (nodes->lists[0].count + nodes->lists[1].count != nodes->n_internal) abort();
      for (kith_index i = 0; i < nodes->n_internal; ++i)
        if (nodes->list->u8[i] != (i >= nodes->lists[1].first)) abort();
    }
    const size_t n = kith_checkpoint_length(c, "extra");
    double *extra = n <= MOST ? calloc(n + 1, sizeof *extra) : NULL;
    if (extra != NULL) (void)kith_checkpoint_get(c, "extra", KITH_F64, extra, n);
    free(extra);
  } else if (c != NULL || kith_failure()[0] == '\0' || strchr(kith_failure(), '\n') != NULL) {
    abort();
  }
  kith_checkpoint_close(&c);
  kith_nodes_destroy(&nodes);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  char path[64];
  const int fd = memfd_create("restart", 0);
  if (fd < 0 || write(fd, data, size) != (ssize_t)size) abort();
  snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
  restart(path);
  close(fd);
  return 0;
}

#ifndef KITH_LIBFUZZER
static uint64_t word(const uint8_t *p) {
  uint64_t w;
  memcpy(&w, p, sizeof w);
  return w;
}

/* Writes the right checksum. */
static void seal(uint8_t *data, size_t size) {
  uint64_t h = UINT64_C(0xcbf29ce484222325);
  for (size_t k = 0; k + 8 < size; k += 8) {
    h = (h ^ word(data + k)) * 1099511628211u;
    h ^= h >> 29;
  }
  memcpy(data + size - 8, &h, sizeof h);
}

static size_t good_file(uint8_t *data) {
  char path[] = "fuzz-restart-XXXXXX";
  const int fd = mkstemp(path);
  const double extra[2] = {1, 2};
  struct kith_nodes *nodes = make(3, 2);
  struct kith_checkpoint *c = NULL;
  if (fd < 0 || kith_checkpoint_open_new(&c, path, "scene: fuzz\n") != KITH_OK ||
      kith_checkpoint_put_nodes(c, nodes) != KITH_OK ||
      kith_checkpoint_put(c, "extra", KITH_F64, extra, 2) != KITH_OK || kith_checkpoint_commit(&c) != KITH_OK)
    abort();
  close(fd);
  FILE *f = fopen(path, "rb");
  const size_t n = f != NULL ? fread(data, 1, MOST, f) : 0;
  if (f != NULL) fclose(f);
  char previous[64];
  snprintf(previous, sizeof previous, "%s.previous", path);
  unlink(path), unlink(previous);
  kith_nodes_destroy(&nodes);
  return n;
}

static size_t below(uint64_t *seed, size_t n) {
  return (size_t)(check_random(seed) * (double)n);
}

/* Changes a bit, a byte, or a word, or copies a piece to another place. */
static void change(uint8_t *data, size_t n, uint64_t *seed) {
  static const uint64_t words[] = {0,         1,          2,         7,          63,         65,        255,
                                   INT32_MAX, UINT32_MAX, INT64_MAX, UINT64_MAX, 1ull << 61, 1ull << 32};
  const size_t place = below(seed, n);
  switch (below(seed, 4)) {
    case 0:
      data[place] ^= (uint8_t)(1 << below(seed, 8));
      break;
    case 1:
      data[place] = (uint8_t)below(seed, 256);
      break;
    case 2:
      memcpy(data + KITH_MIN(place / 8 * 8, n - 8), &words[below(seed, sizeof words / sizeof *words)], 8);
      break;
    default: {
      const size_t wanted = below(seed, 100), length = KITH_MIN(wanted, n - place),
                   from = below(seed, n - length);
      memmove(data + place, data + from, length);
    }
  }
}

int main(int argc, char **argv) {
  static uint8_t good[MOST], data[MOST];
  const size_t n = good_file(good);
  const long inputs = argc > 1 ? atol(argv[1]) : 20000;
  uint64_t seed = argc > 2 ? strtoull(argv[2], NULL, 10) : 1;
  LLVMFuzzerTestOneInput(good, n);
  for (long k = 0; k < inputs; ++k) {
    size_t size = n;
    memcpy(data, good, n);
    if (k % 5 == 4) size = below(&seed, n);
    for (size_t changes = 1 + below(&seed, 4); changes > 0 && size >= 16; --changes)
      change(data, size, &seed);
    if (k % 2 == 1 && size >= 16) seal(data, size = size / 8 * 8);
    LLVMFuzzerTestOneInput(data, size);
  }
  /* Inputs must be refused at different stages, and some not at all. */
  CHECK(opened > inputs / 20 && opened < inputs / 2 && restored > inputs / 50 && restored < opened);
  if (check_failures > 0) fprintf(stderr, "%d opened, %d restored of %ld\n", opened, restored, inputs);
  return check_failed();
}
#endif
