#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* getline */
#endif
#include "app/history.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct kith_history {
  FILE *file;
  char *path; /* owned */
};

static const char title[] =
    "step,time,dt,limiter,kinetic,internal,potential,work,total,momentum_x"
#if NDIM > 1
    ",momentum_y"
#endif
#if NDIM > 2
    ",momentum_z,angular_x,angular_y"
#endif
#if NDIM > 1
    ",angular_z"
#endif
    ",velocity_over_sound,nodes,ghosts,entries,rebuilds,seconds\n";

static void release(struct kith_history **history) {
  if (*history == NULL) return;
  if ((*history)->file != NULL) fclose((*history)->file);
  kith_free(&(*history)->path);
  kith_free(history);
}

static kith_status create(struct kith_history **out, const char *path) {
  *out = NULL;
  KITH_TRY(kith_resize(out, 0, 1, sizeof **out));
  const kith_status status = kith_resize(&(*out)->path, 0, strlen(path) + 1, 1);
  if (status == KITH_OK)
    strcpy((*out)->path, path);
  else
    release(out);
  return status;
}

static kith_status failed(const struct kith_history *history) {
  KITH_FAIL(BAD_FILE, "%s: cannot write: %s", history->path, strerror(errno));
}

static kith_status begin(struct kith_history *history) {
  history->file = fopen(history->path, "w");
  if (history->file == NULL || fputs(title, history->file) == EOF || fflush(history->file) == EOF)
    return failed(history);
  return KITH_OK;
}

kith_status kith_history_open(struct kith_history **out, const char *path) {
  KITH_TRY(create(out, path));
  const kith_status status = begin(*out);
  if (status != KITH_OK) release(out);
  return status;
}

/* A whole row of a step up to `last`. */
static bool is_kept(const char *line, ssize_t length, uint64_t last) {
  char *end;
  const uint64_t step = strtoull(line, &end, 10);
  return length > 0 && line[length - 1] == '\n' && end > line && *end == ',' && step <= last;
}

/* Where the rows to keep end; -1 if the first line is not the title (NULL: any). An empty file has nothing to keep. */
static off_t kept_length(FILE *file, uint64_t last, const char *wanted) {
  char *line = NULL;
  size_t room = 0;
  ssize_t length = getline(&line, &room, file);
  off_t kept = length <= 0 ? 0 : wanted == NULL || strcmp(line, wanted) == 0 ? (off_t)length : -1;
  while (kept > 0 && (length = getline(&line, &room, file)) > 0 && is_kept(line, length, last))
    kept += length;
  free(line);
  return kept;
}

/* The file is open for reading and writing. */
static kith_status cut(struct kith_history *history, uint64_t last) {
  const off_t kept = kept_length(history->file, last, title);
  if (kept < 0) KITH_FAIL(BAD_FILE, "%s: not the history of a %d-D run", history->path, NDIM);
  if (ftruncate(fileno(history->file), kept) != 0 || fseek(history->file, 0, SEEK_END) != 0)
    return failed(history);
  if (kept == 0 && (fputs(title, history->file) == EOF || fflush(history->file) == EOF))
    return failed(history);
  return KITH_OK;
}

kith_status kith_history_cut(const char *path, uint64_t step) {
  FILE *file = fopen(path, "r+");
  if (file == NULL && errno == ENOENT) return KITH_OK;
  const bool cut_off = file != NULL && ftruncate(fileno(file), kept_length(file, step, NULL)) == 0;
  const int error = errno;
  if (file != NULL) fclose(file);
  if (!cut_off) KITH_FAIL(BAD_FILE, "%s: cannot write: %s", path, strerror(error));
  return KITH_OK;
}

kith_status kith_history_continue(struct kith_history **out, const char *path, uint64_t step) {
  KITH_TRY(create(out, path));
  (*out)->file = fopen(path, "r+");
  kith_status status;
  if ((*out)->file != NULL)
    status = cut(*out, step);
  else
    status = errno == ENOENT ? begin(*out) : failed(*out);
  if (status != KITH_OK) release(out);
  return status;
}

kith_status kith_history_add(struct kith_history *history, const struct kith_history_row *row) {
  FILE *f = history->file;
  fprintf(f, "%" PRIu64 ",%.17g,%.17g,%s,%.17g,%.17g,%.17g,%.17g,%.17g", row->step, row->time, row->dt,
          row->limiter != NULL ? row->limiter : "", row->kinetic, row->internal, row->potential, row->work,
          row->kinetic + row->internal + row->potential - row->work);
  for (int a = 0; a < NDIM; ++a) fprintf(f, ",%.17g", row->momentum[a]);
  for (int a = NDIM == 3 ? 0 : 2; a < 3 && NDIM > 1; ++a) fprintf(f, ",%.17g", row->angular[a]);
  fprintf(f, ",%.17g,%" PRId64 ",%" PRId64 ",%" PRId64 ",%" PRId64 ",%.6g\n", row->velocity_over_sound,
          row->nodes, row->ghosts, row->entries, row->rebuilds, row->seconds);
  return fflush(f) == EOF || ferror(f) ? failed(history) : KITH_OK;
}

kith_status kith_history_close(struct kith_history **history) {
  if (*history == NULL) return KITH_OK;
  FILE *file = (*history)->file;
  const bool good = !ferror(file);
  (*history)->file = NULL;
  const kith_status status = fclose(file) == 0 && good ? KITH_OK : failed(*history);
  release(history);
  return status;
}
