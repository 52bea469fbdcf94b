/* files.h - for tests that write files: a directory for these, and what is in a file. */
#ifndef KITH_TESTS_FILES_H
#define KITH_TESTS_FILES_H

#include <stdlib.h>
#include <unistd.h>
#include "tests/check.h"

static char directory[] = "kith-test-XXXXXX";

static inline void directory_make(void) {
  CHECK(mkdtemp(directory) != NULL);
}

/* The path of a file in the directory. It lasts for the next three calls. */
static inline const char *path_in(const char *name) {
  static char path[4][128];
  static int turn;
  char *p = path[turn++ % 4];
  snprintf(p, sizeof path[0], "%s/%.100s", directory, name);
  return p;
}

/* Removes these files, as far as they are there, and the directory; other files may not be left. */
static inline void directory_remove(int n, const char *const *files) {
  for (int k = 0; k < n; ++k) unlink(path_in(files[k]));
  CHECK(rmdir(directory) == 0);
}

/* Reads at most `room` bytes of a file; returns their number. */
static inline size_t load(const char *path, void *bytes, size_t room) {
  FILE *f = fopen(path, "rb");
  CHECK(f != NULL);
  const size_t n = f != NULL ? fread(bytes, 1, room, f) : 0;
  if (f != NULL) fclose(f);
  return n;
}

static inline void write_text(const char *path, const char *text) {
  FILE *f = fopen(path, "w");
  CHECK(f != NULL && fputs(text, f) >= 0 && fclose(f) == 0);
}

#endif
