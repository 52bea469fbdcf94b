/* ghosts.c - ghost blocks, and the values that image ghosts get from their control nodes. */
#include "lib/nodes/nodes.h"

#include <omp.h>
#include <string.h>

/* out[k] = sign in[control[k]] + shift, component by component. Inlined where their number is a constant. */
static inline void copy_mapped(double *restrict out, const double *in, const kith_index *restrict control,
                               kith_index begin, kith_index end, int components, const double *sign,
                               const double *shift) {
  for (kith_index k = begin; k < end; ++k) {
    const double *from = in + (size_t)control[k] * (size_t)components;
    double *to = out + (size_t)k * (size_t)components;
    for (int c = 0; c < components; ++c) to[c] = sign[c] * from[c] + shift[c];
  }
}

/* How an image changes each component of a field of this kind. */
struct map {
  double sign[NDIM * NDIM], shift[NDIM * NDIM];
};

static struct map map_of(enum kith_kind kind, const struct kith_image *image) {
  const bool two_indices = kind == KITH_TENSOR || kind == KITH_SYMMETRIC;
  struct map map;
  double *sign = map.sign;
  for (int c = 0; c < NDIM * NDIM; ++c) map.shift[c] = -0.0; /* + -0 changes nothing */
  for (int a = 0; a < NDIM; ++a) {
    if (!two_indices) *sign++ = image->sign[a];
    for (int b = kind == KITH_TENSOR ? 0 : a; two_indices && b < NDIM; ++b)
      *sign++ = image->sign[a] * image->sign[b];
    if (kind == KITH_POSITION) map.shift[a] = image->shift[a];
    if (kind == KITH_VELOCITY) map.shift[a] = image->velocity[a];
  }
  return map;
}

/* Ghosts begin .. end of the block get their values of one field. */
static void refresh_part(struct kith_field *field, const struct kith_ghost_block *block, kith_index begin,
                         kith_index end) {
  const size_t first = (size_t)block->first * (size_t)field->components;
  const kith_index *control = block->control;
  if (field->spec.type == KITH_U8) {
    for (kith_index k = begin; k < end; ++k) field->u8[first + (size_t)k] = field->u8[control[k]];
  } else if (field->spec.kind == KITH_SCALAR) { /* doubles are copied as words too: bitwise */
    int64_t *restrict to = field->i64 + first;
    for (kith_index k = begin; k < end; ++k) to[k] = field->i64[control[k]];
  } else {
    const struct map map = map_of(field->spec.kind, &block->image);
    double *to = field->f64 + first;
    if (field->components == NDIM)
      copy_mapped(to, field->f64, control, begin, end, NDIM, map.sign, map.shift);
    else if (field->components == NDIM * NDIM)
      copy_mapped(to, field->f64, control, begin, end, NDIM * NDIM, map.sign, map.shift);
    else
      copy_mapped(to, field->f64, control, begin, end, NDIM * (NDIM + 1) / 2, map.sign, map.shift);
  }
}

void kith_nodes_map(struct kith_nodes *nodes, kith_index i, const struct kith_image *image) {
  for (int f = 0; f < nodes->n_fields; ++f) {
    const struct kith_field *field = nodes->fields[f];
    if (field->spec.kind == KITH_SCALAR) continue;
    const struct map map = map_of(field->spec.kind, image);
    double *value = field->f64 + (size_t)i * (size_t)field->components;
    for (int c = 0; c < field->components; ++c) value[c] = map.sign[c] * value[c] + map.shift[c];
  }
}

/* Called by all threads of a team: each refreshes its share of the ghosts in all fields. */
static void refresh_block(const struct kith_ghost_block *block, struct kith_field *const *fields,
                          int n_fields) {
  const int threads = omp_get_num_threads(), me = omp_get_thread_num();
  const kith_index begin = kith_part_start(block->count, me, threads),
                   end = kith_part_start(block->count, me + 1, threads);
  for (int f = 0; f < n_fields; ++f) refresh_part(fields[f], block, begin, end);
}

void kith_nodes_refresh_images(struct kith_nodes *nodes, struct kith_field *const *fields, int n_fields) {
#pragma omp parallel if ((int64_t)nodes->n_ghost * n_fields > KITH_FEW_COPIES)
  for (int b = 0; b < nodes->n_blocks; ++b) {
    if (nodes->blocks[b].kind == KITH_GHOST_IMAGE) refresh_block(&nodes->blocks[b], fields, n_fields);
#pragma omp barrier /* a later block may have its control nodes in this one */
  }
}

kith_index kith_nodes_first_remote(const struct kith_nodes *nodes) {
  for (int b = 0; b < nodes->n_blocks; ++b)
    if (nodes->blocks[b].kind == KITH_GHOST_REMOTE) return nodes->blocks[b].first;
  return kith_nodes_count(nodes);
}

int kith_nodes_ghost_fields(const struct kith_nodes *nodes, struct kith_field **fields) {
  int n = 0;
  for (int f = 0; f < nodes->n_fields; ++f)
    if (nodes->fields[f]->spec.role == KITH_STATE || nodes->fields[f] == nodes->search_radius ||
        nodes->fields[f] == nodes->list || nodes->fields[f] == nodes->image ||
        nodes->fields[f] == nodes->activity)
      fields[n++] = nodes->fields[f];
  return n;
}

static kith_status check_block(const struct kith_nodes *nodes, const struct kith_ghost_block *block) {
  if (block->list < 0 || block->list >= nodes->n_lists || block->count < 0)
    KITH_FAIL(INTERNAL, "a block of %d ghosts for list %d of %d", block->count, block->list, nodes->n_lists);
  const kith_index first = kith_nodes_count(nodes);
  for (kith_index k = 0; block->kind == KITH_GHOST_IMAGE && k < block->count; ++k) {
    const kith_index c = block->control[k];
    if (c < 0 || c >= first || nodes->list->u8[c] != block->list)
      KITH_FAIL(INTERNAL, "node %d cannot control ghost %d of list %d", c, first + k, block->list);
  }
  return KITH_OK;
}

static void clear_values(struct kith_nodes *nodes, kith_index first, kith_index count) {
  for (int f = 0; f < nodes->n_fields; ++f) {
    const size_t size = kith_field_node_size(nodes->fields[f]);
    if (kith_field_is_own(nodes->fields[f])) continue;
    memset((char *)nodes->fields[f]->data + (size_t)first * size, 0, (size_t)count * size);
  }
}

kith_status kith_nodes_add_ghosts(struct kith_nodes *nodes, const struct kith_ghost_block *block) {
  struct kith_ghost_block fresh = *block;
  const size_t n = (size_t)nodes->n_blocks;
  kith_status status = check_block(nodes, block);
  if (status == KITH_OK) status = kith_nodes_grow(nodes, 0, fresh.count);
  if (status == KITH_OK)
    status = kith_grow(&nodes->blocks, &nodes->blocks_capacity, n, n + 1, sizeof *nodes->blocks);
  if (status != KITH_OK || fresh.count == 0) {
    kith_free(&fresh.control);
    return status;
  }
  fresh.first = kith_nodes_count(nodes);
  nodes->blocks[nodes->n_blocks++] = fresh;
  nodes->n_ghost += fresh.count;
  ++nodes->ghosts;
  if (fresh.kind == KITH_GHOST_IMAGE) {
    struct kith_field *fields[KITH_MAX_FIELDS];
    const int n_fields = kith_nodes_ghost_fields(nodes, fields);
#pragma omp parallel if ((int64_t)fresh.count * n_fields > KITH_FEW_COPIES)
    refresh_block(&fresh, fields, n_fields);
    return KITH_OK;
  }
  if (fresh.kind == KITH_GHOST_FROZEN) clear_values(nodes, fresh.first, fresh.count);
  memset(nodes->list->u8 + fresh.first, fresh.list, (size_t)fresh.count);
  return KITH_OK;
}
