/* Constant: nodes that are removed from the flow and return as frozen ghosts. */
#include "boundaries/boundary.h"

#include <string.h>

kith_status kith_constant_take(struct kith_boundary *boundary, struct kith_nodes *nodes,
                               const uint8_t *chosen) {
  if (boundary->ops != &kith_boundary_constant || boundary->held != NULL)
    KITH_FAIL(INTERNAL, "a %s boundary takes no nodes, or has taken some", boundary->ops->name);
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    if (chosen[i] && nodes->id->i64[i] < 0)
      KITH_FAIL(INTERNAL, "a constant boundary needs ids: node %d has none", i);
  struct kith_nodes *held = NULL;
  uint8_t *others = NULL;
  kith_status status = kith_resize(&others, 0, (size_t)nodes->n_internal, 1);
  for (kith_index i = 0; status == KITH_OK && i < nodes->n_internal; ++i) others[i] = !chosen[i];
  if (status == KITH_OK) status = kith_nodes_copy(&held, nodes, true);
  if (status == KITH_OK) status = kith_nodes_delete(held, others);
  if (status == KITH_OK) status = kith_nodes_shrink(held);
  if (status == KITH_OK) status = kith_nodes_delete(nodes, chosen);
  if (status != KITH_OK) kith_nodes_destroy(&held);
  kith_free(&others);
  boundary->held = held;
  return status;
}

/* Measures the largest R / H of the internal nodes, at least 1: frozen ghosts get this R / H. */
static void measure(struct kith_boundary *boundary, const struct kith_nodes *nodes, double radius_factor) {
  const double *search_radius = nodes->search_radius->f64, *support = nodes->support->f64;
  double most = 1;
  (void)radius_factor;
#pragma omp parallel for schedule(static) reduction(max : most)
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    if (support[i] > 0) most = KITH_MAX(most, search_radius[i] / support[i]);
  boundary->most[0] = most;
}

static kith_status add_list(const struct kith_boundary *boundary, struct kith_nodes *nodes, int list) {
  const struct kith_nodes *held = boundary->held;
  const kith_index begin = held->lists[list].first, count = held->lists[list].count;
  const struct kith_ghost_block block = {
      .kind = KITH_GHOST_FROZEN, .boundary = boundary->index, .list = list, .count = count};
  const kith_index first = kith_nodes_count(nodes);
  KITH_TRY(kith_nodes_add_ghosts(nodes, &block));
  for (int f = 0; f < held->n_fields; ++f) { /* held->fields[f] is nodes->fields[f]; later fields stay zero */
    const struct kith_field *from = held->fields[f];
    const size_t size = kith_field_node_size(from);
    if (kith_field_is_own(from)) continue;
    memcpy((char *)nodes->fields[f]->data + (size_t)first * size,
           (const char *)from->data + (size_t)begin * size, (size_t)count * size);
  }
  for (kith_index i = first; i < first + count; ++i)
    nodes->search_radius->f64[i] = boundary->most[0] * nodes->support->f64[i];
  return KITH_OK;
}

static kith_status ghosts(struct kith_boundary *boundary, struct kith_nodes *nodes, double radius_factor) {
  (void)radius_factor; /* all frozen nodes become ghosts */
  const struct kith_nodes *held = boundary->held;
  if (held == NULL) return KITH_OK;
  for (int l = 0; l < held->n_lists; ++l)
    if (held->lists[l].count > 0) KITH_TRY(add_list(boundary, nodes, l));
  return KITH_OK;
}

const struct kith_boundary_ops kith_boundary_constant = {
    .name = "constant",
    .doc = "chosen nodes stay as they were",
    .measure = measure,
    .ghosts = ghosts,
};
