#include "app/others.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "app/matrix.h"

enum {
  SCENE,
  CODE,
  MACHINE,
  RESOLUTION,
  CPU,
  NORM,
  VALUE,
  DIMENSION,
  VERSION,
  COLUMNS,
  REQUIRED = DIMENSION
};
static const char *const names[COLUMNS] = {"scene", "code",  "machine",   "resolution", "cpu_seconds",
                                           "norm",  "value", "dimension", "version"};

static kith_status positive(const struct kith_csv *csv, const char *path, int row, int column,
                            double *value) {
  char *end;
  const char *text = kith_csv_at(csv, row, column);
  *value = strtod(text, &end);
  if (end != text && *end == '\0' && isfinite(*value) && *value > 0) return KITH_OK;
  KITH_FAIL(BAD_INPUT, "%s:%d: %s: '%.60s' is not a number above 0", path, csv->line[row + 1],
            kith_csv_at(csv, -1, column), text);
}

static kith_status find_columns(const struct kith_csv *csv, const char *path, int column[COLUMNS]) {
  for (int k = 0; k < COLUMNS; ++k) {
    column[k] = kith_csv_column(csv, names[k]);
    if (column[k] < 0 && k < REQUIRED)
      KITH_FAIL(BAD_INPUT,
                "%s: no column '%s'; needed are scene, code, machine, resolution, cpu_seconds, norm, value",
                path, names[k]);
  }
  return KITH_OK;
}

static kith_status read_row(struct kith_others *o, const char *path, int r, const int column[COLUMNS],
                            const char *scene, int dimension) {
  const struct kith_csv *csv = o->csv;
  struct kith_other *other = &o->other[o->n];
  double own = dimension;
  *other = (struct kith_other){.code = kith_csv_at(csv, r, column[CODE]),
                               .machine = kith_csv_at(csv, r, column[MACHINE]),
                               .version = column[VERSION] < 0 ? "" : kith_csv_at(csv, r, column[VERSION]),
                               .norm = kith_csv_at(csv, r, column[NORM])};
  KITH_TRY(positive(csv, path, r, column[RESOLUTION], &other->resolution));
  KITH_TRY(positive(csv, path, r, column[CPU], &other->cpu_seconds));
  KITH_TRY(positive(csv, path, r, column[VALUE], &other->value));
  if (column[DIMENSION] >= 0) KITH_TRY(positive(csv, path, r, column[DIMENSION], &own));
  if (kith_metric_find(other->norm) < 0)
    KITH_FAIL(BAD_INPUT, "%s:%d: norm: '%.60s' is none of ours, which are as density.l1", path,
              csv->line[r + 1], other->norm);
  o->n += own == dimension && strcmp(kith_csv_at(csv, r, column[SCENE]), scene) == 0;
  return KITH_OK;
}

kith_status kith_others_read(struct kith_others *o, const char *path, const char *scene, int dimension) {
  int column[COLUMNS];
  *o = (struct kith_others){0};
  KITH_TRY(kith_csv_read(&o->csv, path, false));
  kith_status status = find_columns(o->csv, path, column);
  if (status == KITH_OK) status = kith_resize(&o->other, 0, (size_t)o->csv->n_rows + 1, sizeof *o->other);
  for (int r = 0; status == KITH_OK && r < o->csv->n_rows; ++r)
    status = read_row(o, path, r, column, scene, dimension);
  if (status != KITH_OK) kith_others_clear(o);
  return status;
}

void kith_others_clear(struct kith_others *o) {
  kith_csv_destroy(&o->csv);
  kith_free(&o->other);
  o->n = 0;
}
