/* The trace of all ranks: rank 0 writes the events of one rank after the other. */
#include "app/output/trace.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "lib/io/atomic_file.h"

/* The events of this rank, with blanks behind them up to whole words: messages have those. */
static kith_status make_text(const struct kith_profile *profile, int rank, char **text, size_t *bytes) {
  FILE *file = open_memstream(text, bytes);
  if (file == NULL) KITH_FAIL(NO_MEMORY, "no memory for the trace");
  kith_profile_write_events(profile, rank, file);
  for (fflush(file); *bytes % 8 != 0; fflush(file)) fputc(' ', file);
  const bool whole = ferror(file) == 0;
  if (fclose(file) != 0 || !whole) KITH_FAIL(NO_MEMORY, "no memory for the trace");
  return KITH_OK;
}

/* Rank 0 gets what `from` has, and writes it. */
static kith_status pass(struct kith_ranks *ranks, int from, const char *text, size_t bytes, FILE *file) {
  const bool writes = kith_ranks_rank(ranks) == 0, sends = kith_ranks_rank(ranks) == from;
  char *got = NULL;
  kith_status status = KITH_OK;
  if (writes) status = kith_resize(&got, 0, bytes, 1);
  status = kith_ranks_allreduce_status(ranks, status);
  const struct kith_message out = {0, (void *)text, bytes}, in = {from, got, bytes};
  if (status == KITH_OK) status = kith_ranks_exchange(ranks, sends, &out, writes, &in);
  if (status == KITH_OK && writes) fputs(",\n", file), fwrite(got, 1, bytes, file);
  kith_free(&got);
  return status;
}

static kith_status collect(struct kith_ranks *ranks, const char *text, const uint64_t *bytes, FILE *file) {
  if (file != NULL) fputs("[\n", file), fwrite(text, 1, bytes[0], file);
  for (int r = 1; r < kith_ranks_size(ranks); ++r) KITH_TRY(pass(ranks, r, text, bytes[r], file));
  if (file != NULL) fputs("\n]\n", file);
  return KITH_OK;
}

/* Opened by rank 0. */
static kith_status write_all(struct kith_ranks *ranks, const char *text, size_t bytes, const char *path) {
  struct kith_atomic_file *file = NULL;
  char *sizes = NULL;
  const uint64_t mine = bytes;
  kith_status status = kith_ranks_rank(ranks) == 0 ? kith_atomic_file_open(&file, path) : KITH_OK;
  status = kith_ranks_allreduce_status(ranks, status);
  if (status == KITH_OK) status = kith_ranks_gather(ranks, &mine, sizeof mine, &sizes, NULL);
  if (status == KITH_OK)
    status = collect(ranks, text, (const uint64_t *)(const void *)sizes, file != NULL ? file->stream : NULL);
  kith_free(&sizes);
  if (file != NULL && status == KITH_OK) status = kith_atomic_file_commit(&file, false);
  kith_atomic_file_abandon(&file);
  return kith_ranks_allreduce_status(ranks, status);
}

kith_status kith_trace_write(struct kith_ranks *ranks, const struct kith_profile *profile, const char *path) {
  char *text = NULL;
  size_t bytes = 0;
  if (ranks == NULL) return kith_profile_write_trace(profile, path);
  kith_status status =
      kith_ranks_allreduce_status(ranks, make_text(profile, kith_ranks_rank(ranks), &text, &bytes));
  if (status == KITH_OK) status = write_all(ranks, text, bytes, path);
  free(text);
  return status;
}
