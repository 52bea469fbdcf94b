/* canonical.c - rows and pairs in an order that all ranks and all numbers of ranks share. */
#include "lib/connectivity/traversal.h"
#include "lib/core/sfc_key.h"

/* --- rows --- */

/* Sorts one row: counts how many entries come before each, without branches that could be mispredicted. */
static KITH_HOT void sort_row(kith_index *restrict node, size_t n, const uint32_t *restrict rank,
                              uint32_t *restrict key, kith_index *restrict spare) {
  for (size_t k = 0; k < n; ++k) key[k] = rank[node[k]], spare[k] = node[k];
  for (size_t k = 0; k < n; ++k) {
    uint32_t before = 0;
    for (size_t m = 0; m < n; ++m) before += key[m] < key[k];
    node[before] = spare[k];
  }
}

/* The number of the image of j that is displaced by a shift. */
static inline int64_t image_of(const struct kith_nodes *nodes, kith_index j, int shift) {
  return nodes->image->i64[j] + (nodes->shifts.n > 1 ? nodes->shifts.image[shift] : 0);
}

static bool precedes(const struct kith_nodes *nodes, kith_index i, int si, kith_index j, int sj) {
  const int64_t *id = nodes->id->i64;
  return id[i] < id[j] || (id[i] == id[j] && image_of(nodes, i, si) < image_of(nodes, j, sj));
}

/* sort_row for a row with displaced entries: by id, then by image. */
static KITH_HOT void sort_shifted(const struct kith_rows *rows, const struct kith_nodes *nodes, kith_index i,
                                  struct kith_scratch *s) {
  const size_t first = rows->first[i], n = rows->first[i + 1] - first;
  int64_t *restrict id = (int64_t *)kith_scratch_lane(s, 0);
  int64_t *restrict image = (int64_t *)kith_scratch_lane(s, 2);
  kith_index *restrict node = (kith_index *)kith_scratch_lane(s, 4);
  uint16_t *restrict shift = (uint16_t *)kith_scratch_lane(s, 5);
  for (size_t k = 0; k < n; ++k) {
    node[k] = rows->node[first + k], shift[k] = rows->shift[first + k];
    id[k] = nodes->id->i64[node[k]], image[k] = image_of(nodes, node[k], shift[k]);
  }
  for (size_t k = 0; k < n; ++k) {
    int64_t before = 0;
    for (size_t m = 0; m < n; ++m) before += (id[m] < id[k]) | ((id[m] == id[k]) & (image[m] < image[k]));
    rows->node[first + (size_t)before] = node[k], rows->shift[first + (size_t)before] = shift[k];
  }
}

struct sort {
  const struct kith_rows *rows;
  const struct kith_nodes *nodes;
  const uint32_t *rank;
};

static void sort_chunk(void *context, kith_index begin, kith_index end, struct kith_scratch *scratch) {
  const struct sort *sort = context;
  const size_t *first = sort->rows->first;
  uint32_t *key = (uint32_t *)kith_scratch_lane(scratch, 0);
  kith_index *spare = (kith_index *)kith_scratch_lane(scratch, 1);
  for (kith_index i = begin; i < end; ++i)
    if (kith_shifts_at(sort->rows->shift, sort->rows->zero, first[i], first[i + 1] - first[i]) != NULL)
      sort_shifted(sort->rows, sort->nodes, i, scratch);
    else
      sort_row(sort->rows->node + first[i], first[i + 1] - first[i], sort->rank, key, spare);
}

static kith_status sort_rows(const struct kith_rows *rows, const struct kith_nodes *nodes,
                             const uint32_t *rank) {
  struct sort sort = {rows, nodes, rank};
  return kith_traverse(rows->n, sort_chunk, &sort, 6, (kith_rows_longest(rows) + 1) / 2, NULL);
}

/* Sorts all rows by rank[i]: how many nodes and ghosts of this process come before i, by id and then by
 * image. */
static kith_status sort_all(struct kith_connectivity *c, const struct kith_nodes *nodes) {
  const size_t n = (size_t)kith_nodes_count(nodes);
  uint64_t *id = NULL; /* and behind it `order` and `rank` */
  struct kith_keyed *scratch;
  KITH_TRY(kith_nodes_work(nodes, 2 * n * sizeof *scratch, &scratch));
  KITH_TRY(kith_resize(&id, 0, 2 * n, sizeof *id));
  kith_index *order = (kith_index *)(id + n);
  uint32_t *rank = (uint32_t *)(order + n);
#pragma omp parallel for schedule(static)
  for (size_t i = 0; i < n; ++i) id[i] = (uint64_t)nodes->id->i64[i] ^ (UINT64_C(1) << 63); /* as signed */
  kith_status status = kith_sfc_key_sort(n, id, nodes->image->i64, scratch, order);
#pragma omp parallel for schedule(static)
  for (size_t k = 0; k < n; ++k) rank[order[k]] = (uint32_t)k;
  if (status == KITH_OK) status = sort_rows(&c->rows, nodes, rank);
  if (status == KITH_OK && c->built.overlap) status = sort_rows(&c->overlap, nodes, rank);
  kith_free(&id);
  return status;
}

/* --- pairs --- */

/* Does the pair of internal node i and j start at i? Between two nodes the lower id decides, also if j is a
 * ghost here: on another rank it is not. An image and a frozen node are partners of i only. */
static inline bool starts(const struct kith_nodes *nodes, kith_index i, kith_index j, int shift) {
  if (image_of(nodes, j, shift) != 0 || nodes->id->i64[i] < nodes->id->i64[j]) return true;
  return j >= nodes->n_internal && kith_nodes_ghost_block(nodes, j)->kind == KITH_GHOST_FROZEN;
}

/* Pairs that start at ghosts are counted and filled in by fixed parts of the nodes, each with a cursor for
 * each ghost, so that they ascend in the index of the partner for any number of threads. */
enum { PARTS = 16 };

static inline void put(struct kith_pairs *pairs, size_t p, kith_index i, kith_index j, int shift, size_t e) {
  pairs->node[p][0] = i, pairs->node[p][1] = j;
  if (pairs->shift != NULL) pairs->shift[p] = (uint16_t)shift;
  pairs->of_row[e] = (uint32_t)p;
}

/* The pairs that the rows of internal nodes hold: counts those of node i into first[i + 1] and those of each
 * part and ghost at its cursor; or fills in, in the order of the rows, those of ghosts from cursors on. */
static void walk(struct kith_pairs *pairs, const struct kith_rows *rows, const struct kith_nodes *nodes,
                 uint32_t *cursors, bool fill) {
  const kith_index n = nodes->n_internal;
#pragma omp parallel for schedule(dynamic, 1) if (n > KITH_FEW)
  for (int part = 0; part < PARTS; ++part) {
    uint32_t *cursor = cursors + (size_t)part * (size_t)nodes->n_ghost;
    for (kith_index i = kith_part_start(n, part, PARTS); i < kith_part_start(n, part + 1, PARTS); ++i) {
      size_t p = fill ? pairs->first[i] : 0;
      for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
        const kith_index j = rows->node[e];
        const int shift = kith_row_shift(rows, e); /* the zero shift if it starts at the ghost */
        const bool at_i = starts(nodes, i, j, shift), at_ghost = !at_i && j >= n;
        if (fill && at_i) put(pairs, p, i, j, shift, e);
        if (fill && at_ghost) put(pairs, cursor[j - n], j, i, shift, e);
        p += at_i;
        if (at_ghost) ++cursor[j - n];
      }
      if (!fill) pairs->first[i + 1] = p;
    }
  }
}

/* Turns counts into offsets: of the pairs of each node, and of the pairs that each part adds to a ghost. */
static void sum_counts(struct kith_pairs *pairs, const struct kith_nodes *nodes, uint32_t *cursors) {
  const kith_index n = nodes->n_internal, ghosts = nodes->n_ghost;
  pairs->first[0] = 0;
  for (kith_index i = 0; i < n; ++i) pairs->first[i + 1] += pairs->first[i];
  for (kith_index g = 0; g < ghosts; ++g) {
    size_t next = pairs->first[n + g];
    for (int part = 0; part < PARTS; ++part) {
      uint32_t *cursor = cursors + (size_t)part * (size_t)ghosts + g;
      const uint32_t here = *cursor;
      *cursor = (uint32_t)next;
      next += here;
    }
    pairs->first[n + g + 1] = next;
  }
  pairs->n = pairs->first[pairs->starts];
}

/* The pair of j and i that starts at internal node j, by bisection: its partners are in canonical order. */
static size_t find(const struct kith_pairs *pairs, const struct kith_nodes *nodes, kith_index j, kith_index i,
                   int shift) {
  size_t p = pairs->first[j];
  for (size_t n = pairs->first[j + 1] - p; n > 1; n -= n / 2) {
    const size_t middle = p + n / 2;
    const int at = pairs->shift != NULL ? pairs->shift[middle] : 0;
    if (!precedes(nodes, i, shift, pairs->node[middle][1], at)) p = middle;
  }
  return p;
}

static void find_others(struct kith_pairs *pairs, const struct kith_rows *rows,
                        const struct kith_nodes *nodes) {
  const kith_index n = nodes->n_internal;
#pragma omp parallel for schedule(dynamic, 128)
  for (kith_index i = 0; i < n; ++i)
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
      const kith_index j = rows->node[e];
      const int shift = kith_row_shift(rows, e); /* the zero shift: pairs with images start at i */
      if (j < n && !starts(nodes, i, j, shift)) pairs->of_row[e] = (uint32_t)find(pairs, nodes, j, i, shift);
    }
}

static kith_status canonical_pairs(struct kith_pairs *pairs, const struct kith_rows *rows,
                                   const struct kith_nodes *nodes) {
  uint32_t *cursors = NULL;
  ++pairs->generation;
  pairs->starts = kith_nodes_count(nodes);
  KITH_TRY(kith_pairs_reserve(pairs, pairs->starts, rows->first[nodes->n_internal]));
  KITH_TRY(kith_resize(&cursors, 0, PARTS * (size_t)nodes->n_ghost, sizeof *cursors));
  walk(pairs, rows, nodes, cursors, false);
  sum_counts(pairs, nodes, cursors);
  const kith_status status = kith_pairs_reserve_nodes(pairs, rows->shift != NULL);
  if (status == KITH_OK) walk(pairs, rows, nodes, cursors, true);
  kith_free(&cursors);
  KITH_TRY(status);
  find_others(pairs, rows, nodes);
  return KITH_OK;
}

/* --- f_couple --- */

/* The factor of each entry of the rows of internal nodes; NULL if all are 1. */
static kith_status keep_factors(const struct kith_connectivity *c, kith_index n, double **kept) {
  const double *factor = c->built.pairs ? kith_connectivity_factors(&c->pairs) : NULL;
  if (factor == NULL) return KITH_OK;
  KITH_TRY(kith_resize(kept, 0, c->rows.first[n], sizeof **kept));
#pragma omp parallel for schedule(static)
  for (size_t e = 0; e < c->rows.first[n]; ++e) (*kept)[e] = factor[c->pairs.of_row[e]];
  return KITH_OK;
}

/* Rows ascended when the factors were kept. */
static kith_status restore_factors(const struct kith_connectivity *c, kith_index n, const double *kept) {
  struct kith_pairwise *factor;
  if (kept == NULL) return KITH_OK;
  KITH_TRY(kith_pairwise_prepare(&c->pairs, &kith_f_couple, &factor));
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < n; ++i) {
    const size_t first = c->rows.first[i], end = c->rows.first[i + 1];
    for (size_t e = first; e < end; ++e) {
      const size_t p = c->pairs.of_row[e];
      size_t before = first;
      if (c->pairs.node[p][0] != i && c->pairs.node[p][0] < n) continue; /* that node does it */
      for (size_t m = first; m < end; ++m)
        before +=
            c->rows.node[m] < c->rows.node[e] ||
            (c->rows.node[m] == c->rows.node[e] && kith_row_shift(&c->rows, m) < kith_row_shift(&c->rows, e));
      factor->value[p] = kept[before];
    }
  }
  return KITH_OK;
}

static kith_status make_canonical(struct kith_connectivity *c, const struct kith_nodes *nodes,
                                  double **kept) {
  KITH_TRY(keep_factors(c, nodes->n_internal, kept));
  if (nodes->image == NULL) KITH_FAIL(INTERNAL, "a canonical order needs numbered images");
  KITH_TRY(sort_all(c, nodes));
  c->canonical = true;
  c->built.intersection = c->built.on_segment = false; /* pairs get other numbers */
  c->intersection.n = 0;
  if (c->built.overlap_pairs) KITH_TRY(canonical_pairs(&c->overlap_pairs, &c->overlap, nodes));
  if (c->built.pairs) KITH_TRY(canonical_pairs(&c->pairs, &c->rows, nodes));
  return restore_factors(c, nodes->n_internal, *kept);
}

kith_status kith_connectivity_canonical(struct kith_connectivity *c, const struct kith_nodes *nodes) {
  double *kept = NULL;
  const kith_status status = make_canonical(c, nodes, &kept);
  kith_free(&kept);
  return status;
}
