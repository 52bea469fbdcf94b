/* The family of storages, and the simplest one. */
#include "lib/connectivity/storage/storage.h"

#include <string.h>
#include "lib/core/family.h"

#define X(name) &kith_storage_##name,
KITH_FAMILY(kith_storage, KITH_STORAGE_LIST(X))
#undef X

kith_status kith_stored_create(struct kith_stored *out, const char *words) {
  int member;
  *out = (struct kith_stored){0};
  KITH_TRY(kith_family_choose(kith_storage_member, "storage", words, strlen(words), &member, &out->settings));
  out->ops = kith_storage_all()[member];
  return KITH_OK;
}

kith_status kith_stored_keep(struct kith_stored *stored, const kith_index *node) {
  stored->n = stored->rows.n;
  stored->entries = stored->rows.first[stored->n];
  stored->longest = kith_rows_longest(&stored->rows);
  return stored->ops->keep != NULL ? stored->ops->keep(stored, node) : KITH_OK;
}

size_t kith_stored_bytes(const struct kith_stored *stored) {
  const struct kith_rows *rows = &stored->rows;
  const size_t own = stored->self != NULL && stored->ops->bytes != NULL ? stored->ops->bytes(stored) : 0,
               entry = sizeof *rows->node + (rows->shift != NULL ? sizeof *rows->shift : 0);
  return own + (rows->n > 0 ? ((size_t)rows->n + 1) * sizeof *rows->first + rows->first[rows->n] * entry : 0);
}

void kith_stored_clear(struct kith_stored *stored) {
  if (stored->self != NULL && stored->ops->clear != NULL) stored->ops->clear(stored);
  KITH_FREE(&stored->self, &stored->settings);
  kith_rows_clear(&stored->rows);
  *stored = (struct kith_stored){0};
}

/* --- csr, half --- */

static const kith_index *row(const struct kith_stored *stored, kith_index t, kith_index *space, size_t *n) {
  const struct kith_rows *rows = &stored->rows;
  (void)space;
  *n = rows->first[t + 1] - rows->first[t];
  return rows->node + rows->first[t];
}

const struct kith_storage_ops kith_storage_csr = {
    .name = "csr", .doc = "offsets and entries, read in place: the default", .shifts = true, .row = row};

static kith_status keep_upper(struct kith_stored *stored, const kith_index *node) {
  const struct kith_rows *rows = &stored->rows;
#pragma omp parallel for schedule(static) if (rows->n > KITH_FEW)
  for (kith_index t = 0; t < rows->n; ++t)
    for (size_t e = rows->first[t]; e < rows->first[t + 1]; ++e)
      if (rows->node[e] < node[t] || (rows->node[e] == node[t] && kith_row_shift(rows, e) < rows->zero))
        rows->node[e] = -1;
  kith_rows_compact(&stored->rows);
  return KITH_OK;
}

const struct kith_storage_ops kith_storage_half = {
    .name = "half",
    .doc = "csr with each interaction once, in the row of the node that comes first; for lists of programs",
    .shifts = true,
    .upper = true,
    .keep = keep_upper,
    .row = row};
