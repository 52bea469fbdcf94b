/* atomic_file.h - a file that appears whole or not at all.
 *
 *   kith_atomic_file_open(&f, path); write to f->stream; kith_atomic_file_commit(&f, false);
 *
 * Everything is written under f->temporary (PATH.partial); commit flushes and syncs it, renames it to PATH
 * and syncs the directory: PATH is good at every moment. A library that wants a name instead of a stream may
 * write f->temporary itself, and close it before the commit. */
#ifndef KITH_IO_ATOMIC_FILE_H
#define KITH_IO_ATOMIC_FILE_H

#include <stdio.h>
#include "lib/core/base.h"

struct kith_atomic_file {
  char *path, *temporary, *previous; /* stored behind this */
  FILE *stream;
  bool opened; /* this object has created the temporary file, not only joined it */
};

/* BAD_FILE if the directory is not there or not writable, or if PATH is something else than a regular
 * file. */
kith_status kith_atomic_file_open(struct kith_atomic_file **out, const char *path);
/* Fills in the names alone, for a rank that writes into the temporary file which another rank has opened. End
 * it with kith_atomic_file_abandon when the other rank has committed. */
kith_status kith_atomic_file_join(struct kith_atomic_file **out, const char *path);
/* keep_previous: the file that PATH was stays as PATH.previous. Frees *file in any case; on failure (a full
 * disk shows at the latest here) the temporary file is removed and PATH is as it was, or the new file if only
 * its directory could not be synced. */
kith_status kith_atomic_file_commit(struct kith_atomic_file **file, bool keep_previous);
/* Gives up: removes the temporary file, unless it is joined. Accepts a pointer to NULL. */
void kith_atomic_file_abandon(struct kith_atomic_file **file);
/* Writes all bytes at a place of a file, as pwrite writes some. Returns 0, or -1 with errno. */
int kith_write_at(int descriptor, const void *data, size_t bytes, uint64_t place);

#endif
