/* The trace of all ranks: they append their events to one file, in turn. */
#include "app/output/trace.h"

#include <errno.h>
#include <string.h>
#include "lib/io/atomic_file.h"

static kith_status append(const struct kith_atomic_file *file, const struct kith_profile *profile, int rank,
                          bool last) {
  FILE *f = fopen(file->temporary, "a");
  if (f == NULL) KITH_FAIL(BAD_FILE, "%s: cannot write: %s", file->path, strerror(errno));
  fputs(rank == 0 ? "[\n" : ",\n", f);
  kith_profile_write_events(profile, rank, f);
  if (last) fputs("\n]\n", f);
  const bool whole = !ferror(f);
  if (fclose(f) != 0 || !whole) KITH_FAIL(BAD_FILE, "%s: cannot write: %s", file->path, strerror(errno));
  return KITH_OK;
}

kith_status kith_trace_write(struct kith_ranks *ranks, const struct kith_profile *profile, const char *path) {
  const int me = kith_ranks_rank(ranks), size = kith_ranks_size(ranks);
  struct kith_atomic_file *file = NULL;
  kith_status status = me == 0 ? kith_atomic_file_open(&file, path) : kith_atomic_file_join(&file, path);
  status = kith_ranks_allreduce_status(ranks, status);
  for (int r = 0; r < size && status == KITH_OK; ++r)
    status = kith_ranks_allreduce_status(ranks, r == me ? append(file, profile, me, r == size - 1) : KITH_OK);
  if (status == KITH_OK)
    status = kith_ranks_allreduce_status(ranks, me == 0 ? kith_atomic_file_commit(&file, false) : KITH_OK);
  kith_atomic_file_abandon(&file);
  return status;
}
