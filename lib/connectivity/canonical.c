/* Rows in an order that all ranks and all numbers of ranks share. */
#include <stdlib.h>

#include "lib/connectivity/internal.h"

/* An entry, and what tells it apart from the others of its row. */
struct entry {
  int64_t id, image;
  kith_index node;
  uint32_t pair;
};

static int compare(const void *a, const void *b) {
  const struct entry *p = a, *q = b;
  if (p->id != q->id) return (p->id > q->id) - (p->id < q->id);
  return (p->image > q->image) - (p->image < q->image);
}

static void sort_row(struct kith_connectivity *c, const struct kith_nodes *nodes, kith_index i,
                     struct entry *entry) {
  const size_t first = c->rows.first[i], n = c->rows.first[i + 1] - first;
  kith_index *node = c->rows.node + first;
  uint32_t *pair = c->built.pairs ? c->pairs.of_row + first : NULL;
  for (size_t k = 0; k < n; ++k)
    entry[k] = (struct entry){nodes->id->i64[node[k]], nodes->image->i64[node[k]], node[k],
                              pair != NULL ? pair[k] : 0};
  qsort(entry, n, sizeof *entry, compare);
  for (size_t k = 0; k < n; ++k) {
    node[k] = entry[k].node;
    if (pair != NULL) pair[k] = entry[k].pair;
  }
}

static size_t longest_row(const struct kith_rows *rows) {
  size_t longest = 0;
  for (kith_index i = 0; i < rows->n; ++i) longest = KITH_MAX(longest, rows->first[i + 1] - rows->first[i]);
  return longest;
}

kith_status kith_connectivity_canonical(struct kith_connectivity *c, const struct kith_nodes *nodes) {
  const size_t longest = longest_row(&c->rows);
  bool failed = false;
  if (nodes->image == NULL) KITH_FAIL(INTERNAL, "a canonical order needs numbered images");
#pragma omp parallel reduction(|| : failed)
  {
    struct entry *entry = NULL;
    failed = kith_resize(&entry, 0, longest, sizeof *entry) != KITH_OK;
#pragma omp for schedule(dynamic, 128)
    for (kith_index i = 0; i < nodes->n_internal; ++i)
      if (!failed) sort_row(c, nodes, i, entry);
    kith_free(&entry);
  }
  if (failed) KITH_FAIL(NO_MEMORY, "no memory to sort rows of %zu", longest);
  return KITH_OK;
}
