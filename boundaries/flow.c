/* Inflow and outflow: their settings, and the ghosts that continue the zone of an inflow. */
#include "boundaries/flow.h"

#include "boundaries/images.h"

#define IN(member) KITH_INTO(struct kith_flow_settings, member)
#define DEPTH                                                                                              \
  {                                                                                                        \
    "depth", KITH_PARAM_NUMBER, "4", "[1, 20]", "depth of the zone of nodes behind the face, in supports", \
        IN(depth)                                                                                          \
  }
#define AT                                                                                                 \
  {                                                                                                        \
    "at", KITH_PARAM_EXPRESSION, "", "", "position of the face on its axis; none: the side of the domain", \
        IN(at)                                                                                             \
  }
static const struct kith_param inflow_params[] = {
    DEPTH,
    AT,
    {"density", KITH_PARAM_EXPRESSION, "", "",
     "density at the face, a formula in x, y, z, t; none of these: the state of the region there",
     IN(density)},
    {"pressure", KITH_PARAM_EXPRESSION, "", "", "pressure at the face; this or energy", IN(pressure)},
    {"energy", KITH_PARAM_EXPRESSION, "", "", "energy per unit mass at the face; this or pressure",
     IN(energy)},
    {"velocity", KITH_PARAM_EXPRESSIONS, "", "", "velocity at the face", IN(velocity)},
    {0}};
static const struct kith_param outflow_params[] = {
    DEPTH,
    AT,
    {"pressure_far", KITH_PARAM_NUMBER, "0", "[0, inf)",
     "pressure far behind the face, to which the gas slowly tends; 0: no waves come back", IN(pressure_far)},
    {0}};

/* Measures f times the largest search radius in the zone. */
static void measure(struct kith_boundary *boundary, const struct kith_nodes *nodes, double radius_factor) {
  double most = 0;
  if (nodes->flag == NULL) return;
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    if (nodes->flag->u8[i] == kith_flow_flag(boundary)) most = KITH_MAX(most, nodes->search_radius->f64[i]);
  boundary->most[0] = radius_factor * most;
}

static kith_status add_list(const struct kith_boundary *boundary, struct kith_nodes *nodes,
                            struct kith_ghost_block block) {
  const struct kith_node_list *list = &nodes->lists[block.list];
  const uint8_t *flag = nodes->flag->u8, wanted = kith_flow_flag(boundary);
  for (kith_index i = list->first; i < list->first + list->count; ++i) block.count += flag[i] == wanted;
  KITH_TRY(kith_resize(&block.control, 0, (size_t)block.count, sizeof *block.control));
  for (kith_index i = list->first, k = 0; i < list->first + list->count; ++i)
    if (flag[i] == wanted) block.control[k++] = i;
  return kith_images_add(nodes, &block, boundary->axis, boundary->at_upper ? 1 : -1);
}

static kith_status continue_zone(struct kith_boundary *boundary, struct kith_nodes *nodes,
                                 double radius_factor) {
  struct kith_ghost_block block = {.kind = KITH_GHOST_IMAGE, .boundary = boundary->index};
  if (nodes->flag == NULL) return KITH_OK;
  const double reach = boundary->most[0];
  (void)radius_factor;
  if (reach > kith_flow_deepest(boundary))
    KITH_FAIL(DIVERGED,
              "the zone of the %s on axis %d is %g deep, and a node in it needs partners up to %g away: a "
              "larger depth is required",
              boundary->ops->name, boundary->axis, kith_flow_deepest(boundary), reach);
  for (int a = 0; a < NDIM; ++a) block.image.sign[a] = 1, block.image.shift[a] = boundary->zone[a];
  for (block.list = 0; block.list < nodes->n_lists; ++block.list) KITH_TRY(add_list(boundary, nodes, block));
  return KITH_OK;
}

const struct kith_boundary_ops kith_boundary_inflow = {
    .name = "inflow",
    .doc = "gas enters, layer by layer, with a state that may depend on time",
    KITH_SETTINGS(inflow_params, kith_flow_settings),
    .measure = measure,
    .ghosts = continue_zone,
    .has_faces = true,
    .enters = true,
};
const struct kith_boundary_ops kith_boundary_outflow = {
    .name = "outflow",
    .doc = "gas leaves, and waves with it",
    KITH_SETTINGS(outflow_params, kith_flow_settings),
    .has_faces = true,
    .leaves = true,
};
