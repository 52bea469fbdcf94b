/* Tables of comma-separated values. A table that is read is cut into cells in place. */
#include "lib/io/csv.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static int count(const char *text, char what) {
  int n = 0;
  for (; *text != '\0'; ++text) n += *text == what;
  return n;
}

static kith_status load(struct kith_csv *csv, const char *path) {
  FILE *file = fopen(path, "rb");
  if (file == NULL) KITH_FAIL(BAD_FILE, "%s: %s", path, strerror(errno));
  size_t size = 0;
  const bool empty = getdelim(&csv->text, &size, '\0', file) < 0, whole = !ferror(file);
  fclose(file);
  if (!whole) KITH_FAIL(BAD_FILE, "%s: cannot be read", path);
  if (empty) KITH_FAIL(BAD_FILE, "%s: no line of column names", path);
  return KITH_OK;
}

static kith_status cut(struct kith_csv *csv, const char *path) {
  const int n_lines = count(csv->text, '\n');
  char *line = csv->text;
  csv->n_columns = 1, csv->n_rows = n_lines - 1;
  if (n_lines == 0) KITH_FAIL(BAD_FILE, "%s: no line of column names", path);
  for (const char *c = line; *c != '\n'; ++c) csv->n_columns += *c == ',';
  KITH_TRY(kith_resize(&csv->cell, 0, (size_t)n_lines * csv->n_columns, sizeof *csv->cell));
  for (int row = 0; row < n_lines; ++row) {
    char *end = strchr(line, '\n'), *next = line;
    *end = '\0';
    if (count(line, ',') != csv->n_columns - 1)
      KITH_FAIL(BAD_FILE, "%s:%d: not %d values", path, row + 1, csv->n_columns);
    for (int k = 0; k < csv->n_columns; ++k) csv->cell[row * csv->n_columns + k] = strsep(&next, ",");
    line = end + 1;
  }
  return KITH_OK;
}

kith_status kith_csv_read(struct kith_csv *csv, const char *path) {
  *csv = (struct kith_csv){0};
  kith_status status = load(csv, path);
  if (status == KITH_OK) status = cut(csv, path);
  if (status != KITH_OK) kith_csv_clear(csv);
  return status;
}

void kith_csv_clear(struct kith_csv *csv) {
  kith_free(&csv->text);
  kith_free(&csv->cell);
}

int kith_csv_column(const struct kith_csv *csv, const char *name) {
  for (int k = 0; k < csv->n_columns; ++k)
    if (strcmp(csv->cell[k], name) == 0) return k;
  return -1;
}

const char *kith_csv_at(const struct kith_csv *csv, int row, int column) {
  return csv->cell[(row + 1) * csv->n_columns + column];
}

/* ---- writing ---- */

static kith_status failed(const struct kith_csv_log *log) {
  KITH_FAIL(BAD_FILE, "%s: cannot write: %s", log->path, strerror(errno));
}

/* Bytes of the names and of the rows up to the step `last`. */
static kith_status kept_length(const char *path, const char *names, uint64_t last, size_t *kept) {
  struct kith_csv csv = {0};
  kith_status status = load(&csv, path);
  *kept = strlen(names) + 1;
  if (status == KITH_OK && (strncmp(csv.text, names, *kept - 1) != 0 || csv.text[*kept - 1] != '\n'))
    status = kith_fail(KITH_BAD_FILE, "%s: its columns are not %s", path, names);
  if (status == KITH_OK) status = cut(&csv, path);
  const int step = status == KITH_OK ? kith_csv_column(&csv, "step") : -1;
  for (int row = 0; step >= 0 && row < csv.n_rows; ++row) {
    const char *end = kith_csv_at(&csv, row, csv.n_columns - 1);
    if (strtoull(kith_csv_at(&csv, row, step), NULL, 10) > last) break;
    *kept = (size_t)(end - csv.text) + strlen(end) + 1;
  }
  kith_csv_clear(&csv);
  return status;
}

static kith_status open_log(struct kith_csv_log *log, const char *names, const uint64_t *last) {
  size_t kept = 0;
  log->file = last != NULL ? fopen(log->path, "r+") : NULL;
  if (last != NULL && log->file == NULL && errno != ENOENT) return failed(log);
  if (log->file == NULL) log->file = fopen(log->path, "w");
  if (log->file == NULL || fseek(log->file, 0, SEEK_END) != 0) return failed(log);
  if (ftell(log->file) > 0) KITH_TRY(kept_length(log->path, names, *last, &kept));
  if (last != NULL && (ftruncate(fileno(log->file), (off_t)kept) != 0 || fseek(log->file, 0, SEEK_END) != 0))
    return failed(log);
  if (kept == 0 && (fprintf(log->file, "%s\n", names) < 0 || fflush(log->file) != 0)) return failed(log);
  return KITH_OK;
}

kith_status kith_csv_log_open(struct kith_csv_log *out, const char *path, const char *names,
                              const uint64_t *last) {
  *out = (struct kith_csv_log){.path = strdup(path)};
  if (out->path == NULL) KITH_FAIL(NO_MEMORY, "no memory for a path");
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

kith_status kith_csv_log_close(struct kith_csv_log *log) {
  if (log->file == NULL) return KITH_OK;
  const bool good = !ferror(log->file);
  const kith_status status = fclose(log->file) == 0 && good ? KITH_OK : failed(log);
  log->file = NULL;
  kith_free(&log->path);
  return status;
}
