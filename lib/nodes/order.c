/* order.c - deletion, reordering and culling: every registered field follows. */
#include "lib/core/sfc_key.h"
#include "lib/nodes/nodes.h"

#include <string.h>

/* to[k] = from[order[k]] for values of `size` bytes. to == from is allowed if order ascends (then order[k] >=
 * k). */
static inline void take_values(void *to, const void *from, const kith_index *order, kith_index begin,
                               kith_index end, size_t size) {
  char *t = to;
  const char *s = from;
  for (kith_index k = begin; k < end; ++k) memmove(t + (size_t)k * size, s + (size_t)order[k] * size, size);
}

/* take_values, with the size known to the compiler for the sizes that occur. */
static void gather_sized(void *to, const void *from, const kith_index *order, kith_index begin,
                         kith_index end, size_t size) {
  if (size == 8)
    take_values(to, from, order, begin, end, 8);
  else if (size == 8 * NDIM)
    take_values(to, from, order, begin, end, 8 * NDIM);
  else if (size == 8 * NDIM * NDIM)
    take_values(to, from, order, begin, end, 8 * NDIM * NDIM);
  else
    take_values(to, from, order, begin, end, size);
}

/* Moves node from[k] to index k for begin <= k < end in all fields; `from` ascends. In place: threads share
 * out the fields. */
static void compact(struct kith_nodes *nodes, const kith_index *from, kith_index begin, kith_index end) {
#pragma omp parallel for schedule(dynamic) if (end - begin > KITH_FEW_COPIES)
  for (int f = 0; f < nodes->n_fields; ++f) {
    struct kith_field *field = nodes->fields[f];
    if (begin >= nodes->n_internal && kith_field_is_own(field)) continue;
    gather_sized(field->data, field->data, from, begin, end, kith_field_node_size(field));
  }
}

kith_status kith_nodes_delete(struct kith_nodes *nodes, const uint8_t *dead) {
  kith_nodes_drop_ghosts(nodes);
  kith_index *from = NULL;
  KITH_TRY(kith_resize(&from, 0, (size_t)nodes->n_internal, sizeof *from));
  kith_index alive = 0;
  for (int l = 0; l < nodes->n_lists; ++l) {
    struct kith_node_list *list = &nodes->lists[l];
    const kith_index end = list->first + list->count, begin = alive;
    for (kith_index i = list->first; i < end; ++i)
      if (dead != NULL && !dead[i]) from[alive++] = i;
    list->first = begin;
    list->count = alive - begin;
  }
  if (alive < nodes->n_internal) {
    compact(nodes, from, 0, alive);
    nodes->n_internal = alive;
    ++nodes->order, ++nodes->ghosts;
  }
  kith_free(&from);
  return KITH_OK;
}

kith_status kith_nodes_reorder(struct kith_nodes *nodes, const kith_index *order) {
  size_t widest = 0;
  for (int f = 0; f < nodes->n_fields; ++f) widest = KITH_MAX(widest, kith_field_node_size(nodes->fields[f]));
  char *scratch;
  KITH_TRY(kith_nodes_work(nodes, (size_t)nodes->n_internal * widest, &scratch));
  kith_nodes_drop_ghosts(nodes);
  enum { RUN = 1024 };
  const kith_index n = nodes->n_internal, runs = (n + RUN - 1) / RUN;
  for (int f = 0; f < nodes->n_fields; ++f) {
    char *data = nodes->fields[f]->data;
    const size_t size = kith_field_node_size(nodes->fields[f]);
#pragma omp parallel if (runs > 4)
    {
#pragma omp for schedule(static)
      for (kith_index r = 0; r < runs; ++r)
        gather_sized(scratch, data, order, r * RUN, KITH_MIN((r + 1) * RUN, n), size);
#pragma omp for schedule(static)
      for (kith_index r = 0; r < runs; ++r) {
        const size_t begin = (size_t)r * RUN * size, end = KITH_MIN(((size_t)r + 1) * RUN, (size_t)n) * size;
        memcpy(data + begin, scratch + begin, end - begin);
      }
    }
  }
  ++nodes->order, ++nodes->ghosts;
  return KITH_OK;
}

/* The permutation that sorts each list by key, then id. */
static kith_status find_order(const struct kith_nodes *nodes, const uint64_t *key, kith_index *order,
                              bool *sorted) {
  *sorted = true;
  struct kith_keyed *scratch;
  KITH_TRY(kith_nodes_work(nodes, 2 * (size_t)nodes->n_internal * sizeof *scratch, &scratch));
  for (int l = 0; l < nodes->n_lists; ++l) {
    const kith_index first = nodes->lists[l].first, count = nodes->lists[l].count;
    if (count == 0) continue;
    KITH_TRY(kith_sfc_key_sort((size_t)count, key + first, nodes->id->i64 + first, scratch, order + first));
    for (kith_index k = first; k < first + count; ++k) {
      order[k] += first;
      if (order[k] != k) *sorted = false;
    }
  }
  return KITH_OK;
}

kith_status kith_nodes_sort(struct kith_nodes *nodes, const uint64_t *key, bool *sorted) {
  kith_index *order = NULL;
  bool same = true;
  kith_status status = kith_resize(&order, 0, (size_t)nodes->n_internal, sizeof *order);
  if (status == KITH_OK) status = find_order(nodes, key, order, &same);
  if (status == KITH_OK && !same) status = kith_nodes_reorder(nodes, order);
  if (sorted != NULL) *sorted = same;
  kith_free(&order);
  return status;
}

/* Adds the controls of kept ghosts to the kept ones. A control lies before its ghosts, so one sweep from the
 * back is enough. */
static void keep_controls(const struct kith_nodes *nodes, uint8_t *keep) {
  for (int b = nodes->n_blocks - 1; b >= 0; --b) {
    const struct kith_ghost_block *block = &nodes->blocks[b];
    if (block->control == NULL) continue;
    const uint8_t *kept = keep + (block->first - nodes->n_internal);
#pragma omp parallel for schedule(static) if (block->count > KITH_FEW_COPIES)
    for (kith_index k = 0; k < block->count; ++k) {
      if (!kept[k] || block->control[k] < nodes->n_internal) continue;
#pragma omp atomic write
      keep[block->control[k] - nodes->n_internal] = 1;
    }
  }
}

/* Shrinks the blocks to their kept ghosts. */
static void cull_blocks(struct kith_nodes *nodes, const kith_index *renumber) {
  int left = 0;
  kith_index next = nodes->n_internal;
  for (int b = 0; b < nodes->n_blocks; ++b) {
    struct kith_ghost_block block = nodes->blocks[b];
    kith_index kept = 0;
    for (kith_index k = 0; k < block.count; ++k) {
      if (renumber[block.first + k] < 0) continue;
      if (block.control != NULL) block.control[kept] = renumber[block.control[k]];
      ++kept;
    }
    block.first = next, block.count = kept;
    next += kept;
    if (kept > 0)
      nodes->blocks[left++] = block;
    else
      kith_free(&block.control);
  }
  nodes->n_blocks = left;
  nodes->n_ghost = next - nodes->n_internal;
}

kith_status kith_nodes_cull_ghosts(struct kith_nodes *nodes, uint8_t *keep, kith_index *renumber) {
  const kith_index n = kith_nodes_count(nodes), internal = nodes->n_internal;
  kith_index *from;
  KITH_TRY(kith_nodes_work(nodes, (size_t)n * sizeof *from, &from));
  keep_controls(nodes, keep);
#pragma omp parallel for schedule(static) if (internal > KITH_FEW_COPIES)
  for (kith_index i = 0; i < internal; ++i) renumber[i] = i;
  kith_index kept = internal;
  for (kith_index i = internal; i < n; ++i) {
    renumber[i] = keep[i - internal] ? kept : -1;
    if (keep[i - internal]) from[kept++] = i;
  }
  if (kept < n) {
    compact(nodes, from, internal, kept);
    cull_blocks(nodes, renumber);
    ++nodes->ghosts;
  }
  return KITH_OK;
}
