#include "app/csv.h"

#include <errno.h>
#include <string.h>

enum { LARGEST = 64 << 20, MOST_COLUMNS = 256 };

struct cursor {
  const char *path;
  char *next;
  int line;
  bool done; /* nothing but an unfinished line is left */
};

static kith_status load(struct kith_csv *csv, const char *path, bool whole_lines) {
  FILE *file = fopen(path, "rb");
  if (file == NULL) KITH_FAIL(BAD_INPUT, "%s: %s", path, strerror(errno));
  long size = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
  rewind(file);
  kith_status status = KITH_OK;
  if (size < 0 || size > LARGEST)
    status = kith_fail(KITH_BAD_INPUT, "%s: not a table of at most 64 MiB", path);
  if (status == KITH_OK) status = kith_resize(&csv->text, 0, (size_t)size + 2, 1);
  if (status == KITH_OK && fread(csv->text, 1, (size_t)size, file) != (size_t)size)
    status = kith_fail(KITH_BAD_INPUT, "%s: cannot be read", path);
  fclose(file);
  if (status == KITH_OK && strlen(csv->text) != (size_t)size)
    status = kith_fail(KITH_BAD_INPUT, "%s: not a text", path);
  if (status == KITH_OK && !whole_lines && size > 0 && csv->text[size - 1] != '\n') csv->text[size] = '\n';
  return status;
}

/* One field, its quotes resolved where it stands; *end: what ended it, ',' or '\n'. */
static kith_status field(struct cursor *c, char **out, char *end) {
  char *from = c->next, *to = from;
  const int line = c->line;
  *out = from;
  if (*from == '"') {
    for (++from; *from != '\0'; *to++ = *from++) {
      if (*from == '"' && *++from != '"') break;
      if (*from == '\n') ++c->line;
    }
    if (*from == '\0') KITH_FAIL(BAD_INPUT, "%s:%d: a quote that does not end", c->path, line);
  }
  while (*from != ',' && *from != '\n' && *from != '\0') *to++ = *from++;
  if (to > *out && to[-1] == '\r') --to;
  *end = *from == '\0' ? '\n' : *from;
  c->next = from + (*from != '\0');
  c->line += *end == '\n';
  *to = '\0';
  return KITH_OK;
}

/* Past comments and empty lines. A line without newline is none. */
static void skip(struct cursor *c) {
  for (char *end; (end = strchr(c->next, '\n')) != NULL; c->next = end + 1, ++c->line)
    if (*c->next != '#' && *c->next != '\n' && strncmp(c->next, "\r\n", 2) != 0) return;
  c->done = true;
}

static kith_status row(struct cursor *c, char *cells[MOST_COLUMNS], int *n) {
  char end = ',';
  for (*n = 0; end == ','; ++*n) {
    if (*n == MOST_COLUMNS)
      KITH_FAIL(BAD_INPUT, "%s:%d: more than %d columns", c->path, c->line, MOST_COLUMNS);
    KITH_TRY(field(c, &cells[*n], &end));
  }
  return KITH_OK;
}

static kith_status keep(struct kith_csv *csv, char *const *cells, int line) {
  const int rows = csv->n_rows + 1, n = csv->n_columns; /* with the names */
  if ((rows & (rows - 1)) == 0) {
    KITH_TRY(kith_resize(&csv->cell, (size_t)rows * n, (size_t)rows * 2 * n, sizeof *csv->cell));
    KITH_TRY(kith_resize(&csv->line, (size_t)rows, (size_t)rows * 2, sizeof *csv->line));
  }
  memcpy(csv->cell + (size_t)rows * n, cells, (size_t)n * sizeof *cells);
  csv->line[rows] = line;
  ++csv->n_rows;
  return KITH_OK;
}

static kith_status parse(struct kith_csv *csv, const char *path) {
  struct cursor c = {.path = path, .next = csv->text, .line = 1};
  char *cells[MOST_COLUMNS];
  int n;
  skip(&c);
  if (c.done) KITH_FAIL(BAD_INPUT, "%s: no line of column names", path);
  KITH_TRY(row(&c, cells, &csv->n_columns));
  KITH_TRY(kith_resize(&csv->cell, 0, (size_t)csv->n_columns, sizeof *csv->cell));
  KITH_TRY(kith_resize(&csv->line, 0, 1, sizeof *csv->line));
  memcpy(csv->cell, cells, (size_t)csv->n_columns * sizeof *cells);
  for (skip(&c); !c.done; skip(&c)) {
    const int line = c.line;
    KITH_TRY(row(&c, cells, &n));
    if (n != csv->n_columns)
      KITH_FAIL(BAD_INPUT, "%s:%d: %d fields, but there are %d columns", path, line, n, csv->n_columns);
    KITH_TRY(keep(csv, cells, line));
  }
  csv->whole = (size_t)(c.next - csv->text);
  return KITH_OK;
}

kith_status kith_csv_read(struct kith_csv **out, const char *path, bool whole_lines) {
  struct kith_csv *csv = NULL;
  *out = NULL;
  KITH_TRY(kith_resize(&csv, 0, 1, sizeof *csv));
  kith_status status = load(csv, path, whole_lines);
  if (status == KITH_OK) status = parse(csv, path);
  if (status != KITH_OK) kith_csv_destroy(&csv);
  *out = csv;
  return status;
}

void kith_csv_destroy(struct kith_csv **csv) {
  if (*csv == NULL) return;
  kith_free(&(*csv)->text);
  kith_free(&(*csv)->cell);
  kith_free(&(*csv)->line);
  kith_free(csv);
}

int kith_csv_column(const struct kith_csv *csv, const char *name) {
  for (int k = 0; k < csv->n_columns; ++k)
    if (strcmp(csv->cell[k], name) == 0) return k;
  return -1;
}

const char *kith_csv_at(const struct kith_csv *csv, int r, int column) {
  return csv->cell[(size_t)(r + 1) * csv->n_columns + column];
}

void kith_csv_quoted(FILE *out, const char *text) {
  fputc('"', out);
  for (const char *s = text; *s != '\0'; ++s) {
    if (*s == '"') fputc('"', out);
    fputc((unsigned char)*s < ' ' ? ' ' : *s, out);
  }
  fputc('"', out);
}
