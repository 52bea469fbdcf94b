/* Tables of comma-separated values: written, and continued after a restart. */
#define _GNU_SOURCE /* asprintf */
#include "lib/io/csv.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static kith_status failed(const struct kith_csv_log *log) {
  KITH_FAIL(BAD_FILE, "%s: cannot write: %s", log->path, strerror(errno));
}

/* *kept: bytes of the line of names and of the rows up to step `last`. */
static kith_status kept_length(FILE *file, const char *path, const char *names, uint64_t last, size_t *kept) {
  char *line = NULL;
  size_t size = 0;
  rewind(file);
  ssize_t n = getline(&line, &size, file);
  const bool same = (n > 0 && line[n - 1] != '\n') || /* not finished: the table is begun */
                    (n == (ssize_t)strlen(names) + 1 && strncmp(line, names, strlen(names)) == 0);
  for (*kept = 0; n > 0 && line[n - 1] == '\n'; n = getline(&line, &size, file)) {
    if (*kept > 0 && strtoull(line, NULL, 10) > last) break;
    *kept += (size_t)n;
  }
  const bool readable = n >= 0 || feof(file);
  const int why = errno;
  free(line);
  if (!readable) KITH_FAIL(BAD_FILE, "%s: cannot read: %s", path, strerror(why));
  return same ? KITH_OK : kith_fail(KITH_BAD_FILE, "%s: its columns are not %s", path, names);
}

static kith_status open_log(struct kith_csv_log *log, const char *names, const uint64_t *last) {
  size_t kept = 0;
  /* A link is not followed: it may point anywhere. */
  const int flags = O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC | (last == NULL ? O_TRUNC : 0),
            descriptor = open(log->path, flags, 0666);
  log->file = descriptor >= 0 ? fdopen(descriptor, "r+") : NULL;
  if (log->file == NULL || fseek(log->file, 0, SEEK_END) != 0) return failed(log);
  if (ftell(log->file) > 0) KITH_TRY(kept_length(log->file, log->path, names, *last, &kept));
  if (last != NULL && (ftruncate(fileno(log->file), (off_t)kept) != 0 || fseek(log->file, 0, SEEK_END) != 0))
    return failed(log);
  if (kept == 0 && (fprintf(log->file, "%s\n", names) < 0 || fflush(log->file) != 0)) return failed(log);
  return KITH_OK;
}

kith_status kith_csv_log_open(struct kith_csv_log *out, const char *directory, const char *file,
                              const char *names, const uint64_t *last) {
  *out = (struct kith_csv_log){0};
  if (asprintf(&out->path, "%s/%s", directory, file) < 0) KITH_FAIL(NO_MEMORY, "no memory for a path");
  const kith_status status = open_log(out, names, last);
  if (status == KITH_OK) return KITH_OK;
  if (out->file != NULL) fclose(out->file);
  out->file = NULL;
  kith_free(&out->path);
  return status;
}

kith_status kith_csv_log_row(struct kith_csv_log *log) {
  fputc('\n', log->file);
  return fflush(log->file) != 0 || ferror(log->file) ? failed(log) : KITH_OK;
}

kith_status kith_csv_log_sync(struct kith_csv_log *log) {
  return log->file != NULL && fsync(fileno(log->file)) != 0 ? failed(log) : KITH_OK;
}

kith_status kith_csv_log_close(struct kith_csv_log *log) {
  if (log->file == NULL) return KITH_OK;
  struct stat file;
  const bool good = !ferror(log->file), gone = fstat(fileno(log->file), &file) != 0 || file.st_nlink == 0;
  kith_status status = fclose(log->file) == 0 && good ? KITH_OK : failed(log);
  if (status == KITH_OK && gone)
    status = kith_fail(KITH_BAD_FILE, "%s: someone has removed it during the run", log->path);
  log->file = NULL;
  kith_free(&log->path);
  return status;
}
