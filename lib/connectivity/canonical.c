/* Rows and pairs in an order that all ranks and all numbers of ranks share. */
#include <stdlib.h>
#include <string.h>

#include "lib/connectivity/internal.h"
#include "lib/connectivity/traversal.h"

/* --- rows --- */

/* An entry, and what tells it apart from the others of its row. */
struct entry {
  int64_t id, image;
  kith_index node;
};

static int compare(const void *a, const void *b) {
  const struct entry *p = a, *q = b;
  if (p->id != q->id) return (p->id > q->id) - (p->id < q->id);
  return (p->image > q->image) - (p->image < q->image);
}

static struct entry entry_of(const struct kith_nodes *nodes, kith_index i) {
  return (struct entry){nodes->id->i64[i], nodes->image->i64[i], i};
}

/* place[i]: of node or ghost i among all of this process. */
static kith_status find_places(const struct kith_nodes *nodes, uint32_t **place) {
  const kith_index n = kith_nodes_count(nodes);
  struct entry *entry = NULL;
  KITH_TRY(kith_resize(&entry, 0, (size_t)n, sizeof *entry));
  const kith_status status = kith_resize(place, 0, (size_t)n, sizeof **place);
  for (kith_index i = 0; i < n; ++i) entry[i] = entry_of(nodes, i);
  qsort(entry, (size_t)n, sizeof *entry, compare);
  for (kith_index k = 0; status == KITH_OK && k < n; ++k) (*place)[entry[k].node] = (uint32_t)k;
  kith_free(&entry);
  return status;
}

/* One row, whose places are all different: who has how many before him is counted, without a branch to guess. */
static KITH_HOT void sort_row(kith_index *restrict node, size_t n, const uint32_t *restrict place,
                              uint32_t *restrict key, kith_index *restrict spare) {
  for (size_t k = 0; k < n; ++k) key[k] = place[node[k]], spare[k] = node[k];
  for (size_t k = 0; k < n; ++k) {
    uint32_t before = 0;
    for (size_t m = 0; m < n; ++m) before += key[m] < key[k];
    node[before] = spare[k];
  }
}

static kith_status sort_rows(struct kith_rows *rows, const uint32_t *place) {
  const size_t longest = kith_rows_longest(rows);
  bool failed = false;
#pragma omp parallel reduction(|| : failed)
  {
    uint32_t *key = NULL;
    kith_index *spare = NULL;
    failed = kith_resize(&key, 0, longest, sizeof *key) != KITH_OK ||
             kith_resize(&spare, 0, longest, sizeof *spare) != KITH_OK;
#pragma omp for schedule(dynamic, 128)
    for (kith_index i = 0; i < rows->n; ++i)
      if (!failed)
        sort_row(rows->node + rows->first[i], rows->first[i + 1] - rows->first[i], place, key, spare);
    kith_free(&key);
    kith_free(&spare);
  }
  if (failed) KITH_FAIL(NO_MEMORY, "no memory to sort rows of %zu", longest);
  return KITH_OK;
}

/* --- pairs --- */

static bool is_frozen(const struct kith_nodes *nodes, kith_index ghost) {
  int from = 0, to = nodes->n_blocks; /* the block lies in from .. to - 1 */
  while (to - from > 1) {
    const int middle = (from + to) / 2;
    if (nodes->blocks[middle].first <= ghost)
      from = middle;
    else
      to = middle;
  }
  return nodes->blocks[from].kind == KITH_GHOST_FROZEN;
}

/* Does the pair of internal node i and j start at i? Between two nodes the lower id decides, also if j is a ghost here: on another rank it is
 * not. An image and a frozen node are partners of i alone. */
static inline bool starts(const struct kith_nodes *nodes, kith_index i, kith_index j) {
  if (nodes->image->i64[j] != 0 || nodes->id->i64[i] < nodes->id->i64[j]) return true;
  return j >= nodes->n_internal && is_frozen(nodes, j);
}

/* first[i]: where the pairs of i start. */
static void count_pairs(struct kith_pairs *pairs, const struct kith_rows *rows,
                        const struct kith_nodes *nodes) {
  const kith_index n = nodes->n_internal;
  memset(pairs->first, 0, ((size_t)pairs->starts + 1) * sizeof *pairs->first);
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < n; ++i)
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e)
      pairs->first[i + 1] += starts(nodes, i, rows->node[e]);
  for (kith_index i = 0; i < n; ++i)
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e)
      if (rows->node[e] >= n) pairs->first[rows->node[e] + 1] += !starts(nodes, i, rows->node[e]);
  for (kith_index i = 0; i < pairs->starts; ++i) pairs->first[i + 1] += pairs->first[i];
  pairs->n = pairs->first[pairs->starts];
}

static inline void put(struct kith_pairs *pairs, size_t p, kith_index i, kith_index j, size_t e) {
  pairs->node[p][0] = i, pairs->node[p][1] = j;
  pairs->of_row[e] = (uint32_t)p;
}

/* Pairs that start at internal nodes, in the order of their rows. */
static void fill_internal(struct kith_pairs *pairs, const struct kith_rows *rows,
                          const struct kith_nodes *nodes) {
#pragma omp parallel for schedule(dynamic, 128)
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    size_t p = pairs->first[i];
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e)
      if (starts(nodes, i, rows->node[e])) put(pairs, p++, i, rows->node[e], e);
  }
}

/* Pairs that start at ghosts: while they are filled, first[j] is where the next one of j goes; in the end that is first[j + 1]. */
static void fill_ghosts(struct kith_pairs *pairs, const struct kith_rows *rows,
                        const struct kith_nodes *nodes) {
  const kith_index n = nodes->n_internal;
  const size_t begin = pairs->first[n];
  for (kith_index i = 0; i < n; ++i)
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
      const kith_index j = rows->node[e];
      if (j >= n && !starts(nodes, i, j)) put(pairs, pairs->first[j]++, j, i, e);
    }
  for (kith_index j = pairs->starts - 1; j > n; --j) pairs->first[j] = pairs->first[j - 1];
  pairs->first[n] = begin;
}

/* The pair of j and i that starts at internal node j: its partners are in order. */
static size_t find(const struct kith_pairs *pairs, const struct kith_nodes *nodes, kith_index j,
                   kith_index i) {
  const struct entry wanted = entry_of(nodes, i);
  size_t from = pairs->first[j], to = pairs->first[j + 1];
  while (to - from > 1) {
    const size_t middle = (from + to) / 2;
    const struct entry there = entry_of(nodes, pairs->node[middle][1]);
    if (compare(&there, &wanted) <= 0)
      from = middle;
    else
      to = middle;
  }
  return from;
}

static void find_others(struct kith_pairs *pairs, const struct kith_rows *rows,
                        const struct kith_nodes *nodes) {
  const kith_index n = nodes->n_internal;
#pragma omp parallel for schedule(dynamic, 128)
  for (kith_index i = 0; i < n; ++i)
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
      const kith_index j = rows->node[e];
      if (j < n && !starts(nodes, i, j)) pairs->of_row[e] = (uint32_t)find(pairs, nodes, j, i);
    }
}

kith_status kith_pairs_canonical(struct kith_pairs *pairs, const struct kith_rows *rows,
                                 const struct kith_nodes *nodes) {
  pairs->canonical = true;
  pairs->f_couple = NULL;
  pairs->starts = kith_nodes_count(nodes);
  KITH_TRY(kith_room(&pairs->first, &pairs->first_capacity, (size_t)pairs->starts + 1, sizeof *pairs->first));
  count_pairs(pairs, rows, nodes);
  if (pairs->n > UINT32_MAX) KITH_FAIL(UNSUPPORTED, "%zu pairs: a process can number 2^32", pairs->n);
  KITH_TRY(kith_room(&pairs->node, &pairs->capacity, pairs->n, sizeof *pairs->node));
  KITH_TRY(kith_room(&pairs->of_row, &pairs->of_row_capacity, rows->first[nodes->n_internal],
                     sizeof *pairs->of_row));
  fill_internal(pairs, rows, nodes);
  fill_ghosts(pairs, rows, nodes);
  find_others(pairs, rows, nodes);
  return KITH_OK;
}

kith_status kith_connectivity_canonical(struct kith_connectivity *c, const struct kith_nodes *nodes) {
  if (nodes->image == NULL) KITH_FAIL(INTERNAL, "a canonical order needs numbered images");
  uint32_t *place = NULL;
  kith_status status = find_places(nodes, &place);
  if (status == KITH_OK) status = sort_rows(&c->rows, place);
  if (status == KITH_OK && c->built.overlap) status = sort_rows(&c->overlap, place);
  kith_free(&place);
  KITH_TRY(status);
  c->canonical = true;
  ++c->generation;
  c->built.intersection = c->built.on_segment = false; /* pairs get other numbers */
  c->intersection.n = 0;
  return c->built.pairs ? kith_pairs_canonical(&c->pairs, &c->rows, nodes) : KITH_OK;
}
