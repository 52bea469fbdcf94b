/* storage.h - how the rows of a neighbor list are kept: one family (`kith list storage`). All members but
 * half give back the same rows in the same order. */
#ifndef KITH_CONNECTIVITY_STORAGE_STORAGE_H
#define KITH_CONNECTIVITY_STORAGE_STORAGE_H

#include "lib/connectivity/rows.h"
#include "lib/core/param.h"

struct kith_stored;

struct kith_storage_ops {
  const char *name, *doc;
  const struct kith_param *params; /* its own parameters (stored->settings), NULL: none */
  size_t settings_size;
  bool ascending; /* needs sorted rows */
  bool shifts;    /* keeps which images the sources are */
  bool upper;     /* keeps sources beyond the target only: targets and sources are one selection */
  /* Keeps the rows that were built in stored->rows: there, or in another form in stored->self, and may then
   * clear stored->rows. NULL: they stay as they are. node[t]: the node of target t, borrowed as long as the
   * rows are kept. UNSUPPORTED if the storage cannot hold them. */
  kith_status (*keep)(struct kith_stored *stored, const kith_index *node);
  /* Row t and its length; in `space`, [stored->longest], if it must be unpacked. Thread-safe. */
  const kith_index *(*row)(const struct kith_stored *stored, kith_index t, kith_index *space, size_t *n);
  size_t (*bytes)(const struct kith_stored *stored); /* of self; NULL: there is none */
  void (*clear)(struct kith_stored *stored);         /* frees what self owns; NULL: nothing */
};

#define KITH_STORAGE_LIST(X) X(csr) X(padded) X(half) X(compressed)
#define X(name) extern const struct kith_storage_ops kith_storage_##name;
KITH_STORAGE_LIST(X)
#undef X
KITH_FAMILY_FUNCTIONS(kith_storage);

struct kith_stored {
  const struct kith_storage_ops *ops;
  void *settings;
  void *self;
  struct kith_rows rows; /* as built; empty if the member keeps them in another form */
  kith_index n;
  size_t entries, longest; /* of the rows as built */
};
/* From a name, with settings after a colon: "padded:width=64". BAD_INPUT for what it does not know. */
kith_status kith_stored_create(struct kith_stored *out, const char *words);
/* Keeps stored->rows, which were just built. node: as above. */
kith_status kith_stored_keep(struct kith_stored *stored, const kith_index *node);
/* Memory that the rows need; what is reserved for the next ones is not counted. */
size_t kith_stored_bytes(const struct kith_stored *stored);
void kith_stored_clear(struct kith_stored *stored);

#endif
