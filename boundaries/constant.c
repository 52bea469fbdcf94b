/* Constant: nodes that are removed from the flow and return as frozen ghosts. */
#include "boundaries/boundary.h"

#include <string.h>

static const struct kith_nodes *held_nodes(const struct kith_boundary *boundary) {
  return boundary->self;
}

static void destroy(struct kith_boundary *boundary) {
  struct kith_nodes *held = boundary->self;
  kith_nodes_destroy(&held);
  boundary->self = NULL;
}

/* Copies one node's values between fields of the same kind and type. */
static void copy_node(const struct kith_field *from, kith_index i, struct kith_field *to, kith_index j) {
  const size_t size = kith_field_node_size(from);
  memcpy((char *)to->data + (size_t)j * size, (const char *)from->data + (size_t)i * size, size);
}

/* Copies the chosen nodes of one list behind those that `held` has in it. `held` has the fields of `nodes`,
 * in order. */
static kith_status hold_list(const struct kith_nodes *nodes, int list, const uint8_t *chosen,
                             struct kith_nodes *held) {
  const kith_index begin = nodes->lists[list].first, end = begin + nodes->lists[list].count;
  kith_index count = 0;
  for (kith_index i = begin; i < end; ++i) {
    if (!chosen[i]) continue;
    if (nodes->id->i64[i] < 0) KITH_FAIL(INTERNAL, "a constant boundary needs ids: node %d has none", i);
    ++count;
  }
  kith_index place;
  KITH_TRY(kith_nodes_append(held, list, count, &place));
  for (kith_index i = begin; i < end; ++i) {
    if (!chosen[i]) continue;
    for (int f = 0; f < nodes->n_fields; ++f) copy_node(nodes->fields[f], i, held->fields[f], place);
    ++place;
  }
  return KITH_OK;
}

kith_status kith_constant_take(struct kith_boundary *boundary, struct kith_nodes *nodes,
                               const uint8_t *chosen) {
  if (boundary->ops->held_nodes != held_nodes)
    KITH_FAIL(INTERNAL, "a %s boundary takes no nodes", boundary->ops->name);
  if (boundary->self != NULL) KITH_FAIL(INTERNAL, "the constant boundary holds its nodes already");
  struct kith_nodes *held = NULL;
  KITH_TRY(kith_nodes_create_like(&held, nodes));
  kith_status status = KITH_OK;
  for (int l = 0; l < nodes->n_lists && status == KITH_OK; ++l) status = hold_list(nodes, l, chosen, held);
  if (status == KITH_OK) status = kith_nodes_delete(nodes, chosen);
  if (status != KITH_OK) kith_nodes_destroy(&held);
  boundary->self = held;
  return status;
}

/* Largest R / H of the internal nodes of all ranks, at least 1: the search radius in units of the support. */
static double radius_ratio(const struct kith_nodes *nodes) {
  const double *search_radius = nodes->search_radius->f64, *support = nodes->support->f64;
  double most = 1;
#pragma omp parallel for schedule(static) reduction(max : most)
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    if (support[i] > 0) most = KITH_MAX(most, search_radius[i] / support[i]);
  kith_ranks_max(nodes->ranks, &most, 1);
  return most;
}

/* `ratio`: radius_ratio. */
static kith_status add_list(const struct kith_boundary *boundary, struct kith_nodes *nodes, int list,
                            double ratio) {
  const struct kith_nodes *held = boundary->self;
  const kith_index begin = held->lists[list].first, count = held->lists[list].count;
  const struct kith_ghost_block block = {
      .kind = KITH_GHOST_FROZEN, .boundary = boundary->index, .list = list, .count = count};
  const kith_index first = kith_nodes_count(nodes);
  KITH_TRY(kith_nodes_add_ghosts(nodes, &block));
  for (int f = 0; f < nodes->n_fields; ++f) {
    struct kith_field *field = nodes->fields[f];
    const struct kith_field *source = kith_nodes_field_named(held, field->spec.name);
    if (source == NULL) continue; /* registered later: zero */
    const size_t size = kith_field_node_size(field);
    if (size != kith_field_node_size(source))
      KITH_FAIL(INTERNAL, "field '%s' changed since it was held", field->spec.name);
    memcpy((char *)field->data + (size_t)first * size, (const char *)source->data + (size_t)begin * size,
           (size_t)count * size);
  }
  for (kith_index i = first; i < first + count; ++i)
    nodes->search_radius->f64[i] = ratio * nodes->support->f64[i];
  return KITH_OK;
}

static kith_status ghosts(struct kith_boundary *boundary, struct kith_nodes *nodes, double radius_factor) {
  (void)radius_factor; /* all of them, always */
  const struct kith_nodes *held = boundary->self;
  if (held == NULL) return KITH_OK;
  if (held->n_lists != nodes->n_lists)
    KITH_FAIL(INTERNAL, "a constant boundary holds %d lists, there are %d", held->n_lists, nodes->n_lists);
  const double ratio = radius_ratio(nodes); /* by all ranks, before one of them can fail */
  for (int l = 0; l < held->n_lists; ++l)
    if (held->lists[l].count > 0) KITH_TRY(add_list(boundary, nodes, l, ratio));
  return KITH_OK;
}

const struct kith_boundary_ops kith_boundary_constant = {
    .name = "constant",
    .doc = "chosen nodes stay as they were",
    .ghosts = ghosts,
    .destroy = destroy,
    .held_nodes = held_nodes,
    .keeps_ghosts = true,
};
