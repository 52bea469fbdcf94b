/* Storage `padded`: a table of equal rows. A row that is longer goes on in the overflow. */
#include <string.h>
#include "lib/connectivity/storage/storage.h"

struct settings {
  int width;
  bool overflow;
};
static const struct kith_param params[] = {
    {"width", KITH_PARAM_INTEGER, "0", "[0, inf)", "entries of each row; 0: of the longest",
     KITH_INTO(struct settings, width)},
    {"overflow", KITH_PARAM_BOOL, "true", "", "longer rows go on elsewhere; else they are refused",
     KITH_INTO(struct settings, overflow)},
    {0}};

struct padded {
  size_t width, cells_capacity, lengths_capacity;
  kith_index *cell;      /* [targets][width]; -1 behind the end of a row */
  kith_index *length;    /* [targets] of whole rows */
  struct kith_rows over; /* of each target what does not fit */
};

/* What does not fit, row by row. */
static kith_status spill(struct padded *p, const struct kith_rows *rows) {
  KITH_TRY(kith_rows_reserve(&p->over, rows->n));
  for (kith_index t = 0; t < rows->n; ++t) {
    const size_t n = rows->first[t + 1] - rows->first[t];
    p->over.first[t + 1] = n > p->width ? n - p->width : 0;
  }
  KITH_TRY(kith_rows_sum(&p->over, -1));
#pragma omp parallel for schedule(static) if (rows->n > KITH_FEW)
  for (kith_index t = 0; t < rows->n; ++t) {
    const size_t from = p->over.first[t], n = p->over.first[t + 1] - from;
    if (n > 0) memcpy(p->over.node + from, rows->node + rows->first[t] + p->width, n * sizeof *rows->node);
  }
  return KITH_OK;
}

static void fill(const struct padded *p, const struct kith_rows *rows) {
#pragma omp parallel for schedule(static) if (rows->n > KITH_FEW)
  for (kith_index t = 0; t < rows->n; ++t) {
    const size_t n = rows->first[t + 1] - rows->first[t], fits = KITH_MIN(n, p->width);
    kith_index *cell = p->cell + (size_t)t * p->width;
    p->length[t] = (kith_index)n;
    if (fits > 0) memcpy(cell, rows->node + rows->first[t], fits * sizeof *cell);
    for (size_t k = fits; k < p->width; ++k) cell[k] = -1;
  }
}

static kith_status keep(struct kith_stored *stored, const kith_index *node) {
  const struct settings *settings = stored->settings;
  struct kith_rows *rows = &stored->rows;
  (void)node;
  if (stored->self == NULL) KITH_TRY(kith_resize(&stored->self, 0, 1, sizeof(struct padded)));
  struct padded *p = stored->self;
  p->width = settings->width > 0 ? (size_t)settings->width : stored->longest;
  if (stored->longest > p->width && !settings->overflow)
    KITH_FAIL(UNSUPPORTED, "storage padded: a row of %zu entries does not fit into %zu", stored->longest,
              p->width);
  KITH_TRY(kith_reserve(&p->cell, &p->cells_capacity, (size_t)rows->n * p->width, sizeof *p->cell));
  KITH_TRY(kith_reserve(&p->length, &p->lengths_capacity, (size_t)rows->n, sizeof *p->length));
  KITH_TRY(spill(p, rows));
  fill(p, rows);
  rows->n = 0;
  return KITH_OK;
}

static const kith_index *row(const struct kith_stored *stored, kith_index t, kith_index *space, size_t *n) {
  const struct padded *p = stored->self;
  const kith_index *cell = p->cell + (size_t)t * p->width;
  *n = (size_t)p->length[t];
  if (*n <= p->width) return cell;
  memcpy(space, cell, p->width * sizeof *space);
  memcpy(space + p->width, p->over.node + p->over.first[t], (*n - p->width) * sizeof *space);
  return space;
}

static size_t bytes(const struct kith_stored *stored) {
  const struct padded *p = stored->self;
  const size_t n = (size_t)stored->n, over = p->over.first[stored->n];
  const size_t rows = over > 0 ? (n + 1) * sizeof *p->over.first + over * sizeof *p->over.node : 0;
  return n * (p->width * sizeof *p->cell + sizeof *p->length) + rows;
}

static void clear(struct kith_stored *stored) {
  struct padded *p = stored->self;
  KITH_FREE(&p->cell, &p->length);
  kith_rows_clear(&p->over);
}

const struct kith_storage_ops kith_storage_padded = {
    .name = "padded",
    .doc = "a table of equal rows: no offsets, but every row is as long as the longest",
    KITH_SETTINGS(params, settings),
    .keep = keep,
    .row = row,
    .bytes = bytes,
    .clear = clear};
