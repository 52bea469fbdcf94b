/* What a scene wants to know on the way: probes, and contacts of materials. */
#include <string.h>
#include "app/scene/scene_parts.h"
#include "lib/core/choices.h"

#define IN(member) KITH_INTO(struct kith_probe, member)
const struct kith_param kith_probe_params[] = {
    {"name", KITH_PARAM_NAME, NULL, "", "name of its group in probes.h5", IN(name)},
    {"at", KITH_PARAM_VECTOR, NULL, "", "the point, or where a line, a plane or a grid begins", IN(at)},
    {"along", KITH_PARAM_VECTOR, "[0, 0, 0]", "", "edge of a line, from its beginning to its end",
     IN(edge[0])},
    {"across", KITH_PARAM_VECTOR, "[0, 0, 0]", "", "second edge, of a plane", IN(edge[1])},
    {"up", KITH_PARAM_VECTOR, "[0, 0, 0]", "", "third edge, of a grid", IN(edge[2])},
    {"spacing", KITH_PARAM_NUMBER, "0", "[0, inf)",
     "spacing of the points along the edges, rounded so that both ends are points; 0: 1 / resolution",
     IN(spacing)},
    {"every", KITH_PARAM_INTEGER, "1", "[1, inf)", "steps between samples; the first and last state, too",
     IN(every)},
    {"gradients", KITH_PARAM_BOOL, "false", "", "gradients of the fields as well", IN(gradients)},
    {"plot", KITH_PARAM_OTHER, "", KITH_PICTURE_FIELDS(KITH_AS_LISTED_CHOICE),
     "fields of probe_NAME.png, one or a list; FIELD-error: its difference from the exact solution; "
     "true or none: the first four; false: no picture",
     .params = NULL},
    {0}};
#undef IN

const struct kith_param kith_contact_params[] = {
    {"of", KITH_PARAM_OTHER, NULL, "", "a material, whose nodes are counted, but for frozen ones",
     .params = NULL},
    {"with", KITH_PARAM_OTHER, NULL, "", "another material, which they meet", .params = NULL},
    {0}};

static kith_status read_plot(const struct kith_scene *scene, struct kith_probe *probe) {
  const struct kith_config_node *node = kith_config_child(probe->node, "plot");
  const bool word = node != NULL && node->kind == KITH_CONFIG_SCALAR;
  const int drawn = node == NULL ? 1 : word ? kith_choices_index("false|true", node->text) : -1;
  if (drawn < 0) return kith_scene_fields(scene, node, &probe->picture);
  for (int k = KITH_PICTURE_DENSITY; k <= KITH_PICTURE_ENERGY && drawn > 0; ++k)
    probe->picture.panel[probe->picture.n++].field = (enum kith_picture_field)k;
  return KITH_OK;
}

/* Counts the points along each edge, at least its ends, and refuses too many before memory is asked for. */
static kith_status count_points(const struct kith_scene *scene, struct kith_probe *probe) {
  const double spacing = probe->spacing > 0 ? probe->spacing : 1 / scene->resolution;
  double all = 1;
  for (int k = 0; k < 3; ++k) {
    const double length = kith_norm(probe->edge[k]), n = length > 0 ? fmax(rint(length / spacing), 1) + 1 : 1;
    all *= n;
    if (!(all <= KITH_MOST_PROBES))
      return kith_config_fail(probe->node, NULL, "more than %d points", KITH_MOST_PROBES);
    probe->points[k] = (int)n;
  }
  if (all == 1 && probe->spacing > 0)
    return kith_config_fail(probe->node, "spacing", "means nothing for one point; along gives a line");
  return KITH_OK;
}

/* Checks that a probe is in the domain, except along open axes, where gas may come out of it. */
static kith_status check_inside(const struct kith_scene *scene, const struct kith_probe *probe) {
  for (int corner = 0; corner < 8; ++corner)
    for (int a = 0; a < NDIM; ++a) {
      double x = probe->at[a];
      for (int k = 0; k < 3; ++k) x += (corner >> k & 1) * probe->edge[k][a];
      const double lower = scene->domain.lower[a], upper = scene->domain.upper[a],
                   slack = 1e-9 * (upper - lower);
      const bool below = scene->boundary[a].side[0] != NULL && x < lower - slack,
                 above = scene->boundary[a].side[1] != NULL && x > upper + slack;
      if (below || above)
        return kith_config_fail(probe->node, NULL, "a point at %c = %g is outside of the domain", "xyz"[a],
                                x);
    }
  return KITH_OK;
}

static bool all_are_barriers(const struct kith_scene *scene) {
  bool all = true;
  for (int r = 0; r < scene->n_regions; ++r) all = all && scene->region[r].barrier;
  return all;
}

kith_status kith_scene_probes(struct kith_scene *scene, const struct kith_config_node *node) {
  if (node == NULL) return KITH_OK;
  KITH_TRY(kith_config_want(node, KITH_CONFIG_LIST));
  if (node->n > 0 && all_are_barriers(scene))
    return kith_config_fail(node, NULL,
                            "all regions are barriers, between which there is no gas to probe: add a region "
                            "of gas, or leave out the probes");
  KITH_TRY(kith_resize(&scene->probe, 0, (size_t)node->n, sizeof *scene->probe));
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next) {
    struct kith_probe *probe = &scene->probe[scene->n_probes++];
    probe->node = child;
    KITH_TRY(kith_params_read(kith_probe_params, child, probe));
    if (!kith_path_is_name(probe->name) || strchr(probe->name, '\'') != NULL)
      return kith_config_fail(
          kith_config_child(child, "name"), NULL,
          "'%s' cannot name a group: no '/', no '.' in front, no quotes, no control characters", probe->name);
    for (const struct kith_probe *p = scene->probe; p < probe; ++p)
      if (strcmp(p->name, probe->name) == 0)
        return kith_config_fail(kith_config_child(child, "name"), NULL, "there are two probes '%s'", p->name);
    KITH_TRY(read_plot(scene, probe));
    KITH_TRY(count_points(scene, probe));
    KITH_TRY(check_inside(scene, probe));
  }
  return KITH_OK;
}

/* Reads a material, which some region must be of: otherwise there would be no nodes to find. counted: some of
 * these must not be frozen, whose neighbors are not searched. */
static kith_status read_contact_material(const struct kith_scene *scene, const struct kith_config_node *node,
                                         bool counted, int *material) {
  bool found = false;
  KITH_TRY(kith_scene_material(scene, node, material));
  for (int r = 0; r < scene->n_regions; ++r) {
    if (scene->region[r].material != *material) continue;
    if (!counted || !kith_region_stays(&scene->region[r])) return KITH_OK;
    found = true;
  }
  return kith_config_fail(node, NULL,
                          found ? "all nodes of '%s' are frozen, and have no lists: give it as `with`"
                                : "no region is of material '%s'",
                          scene->material_name[*material]);
}

kith_status kith_scene_contacts(struct kith_scene *scene, const struct kith_config_node *node) {
  if (node == NULL) return KITH_OK;
  KITH_TRY(kith_config_want(node, KITH_CONFIG_LIST));
  KITH_TRY(kith_resize(&scene->contact, 0, (size_t)node->n, sizeof *scene->contact));
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next) {
    struct kith_contact *contact = &scene->contact[scene->n_contacts++];
    KITH_TRY(kith_params_read(kith_contact_params, child, contact));
    KITH_TRY(read_contact_material(scene, kith_config_child(child, "of"), true, &contact->of));
    KITH_TRY(read_contact_material(scene, kith_config_child(child, "with"), false, &contact->with));
    if (contact->of == contact->with)
      return kith_config_fail(kith_config_child(child, "with"), NULL, "contacts are between two materials");
  }
  return KITH_OK;
}
