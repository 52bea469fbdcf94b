/* Domain, boundaries and materials of a scene. */
#include <string.h>
#include "app/scene_parts.h"
#include "app/words.h"

struct domain {
  double lower[NDIM], upper[NDIM];
  int across;
};

#define IN(member) KITH_INTO(struct domain, member)
const struct kith_key kith_domain_keys[] = {
    {"lower", KITH_KEY_VECTOR, NULL, "", "corner", IN(lower)},
    {"upper", KITH_KEY_VECTOR, NULL, "", "opposite corner", IN(upper)},
    {"across", KITH_KEY_INTEGER, "", "[1, inf)",
     "upper on all axes but x: this many spacings of the densest region above lower", IN(across)},
    {0}};
#undef IN

kith_status kith_scene_domain(struct kith_scene *scene, const struct kith_config_node *node) {
  struct domain d = {.across = 0};
  KITH_TRY(kith_keys_read(kith_domain_keys, node, &d));
  for (int a = 0; a < NDIM; ++a) {
    if (a > 0 && d.across > 0) d.upper[a] = d.lower[a] + d.across / scene->resolution;
    if (!(d.lower[a] < d.upper[a]))
      return kith_config_fail(kith_config_child(node, "upper"), NULL, "%g along %c is not above lower, %g",
                              d.upper[a], "xyz"[a], d.lower[a]);
    scene->domain.lower[a] = d.lower[a];
    scene->domain.upper[a] = d.upper[a];
  }
  return KITH_OK;
}

#define SIDES                                                                                                \
  "reflecting, periodic, open, {kind: piston, velocity: u}, or a pair [lower, upper] of these; periodic is " \
  "on both sides, a piston opposite to an open one"
const struct kith_key kith_boundaries_keys[] = {{"x", KITH_KEY_OTHER, "open", "", SIDES, .keys = NULL},
                                                {"y", KITH_KEY_OTHER, "open", "", SIDES, .keys = NULL},
                                                {"z", KITH_KEY_OTHER, "open", "", SIDES, .keys = NULL},
                                                {0}};

struct side {
  const struct kith_boundary_ops *ops; /* NULL: open */
  double velocity;
};

static const struct kith_key piston_keys[] = {
    {"kind", KITH_KEY_OTHER, NULL, "", "piston", .keys = NULL},
    {"velocity", KITH_KEY_NUMBER, NULL, "", "of the face, along its axis", KITH_INTO(struct side, velocity)},
    {0}};

/* Members that act on a side of the domain; constant acts on regions that are frozen, distributed between ranks. */
static const char *side_words(char *words, size_t size) {
  size_t used = (size_t)snprintf(words, size, "open");
  for (const struct kith_boundary_ops *const *p = kith_boundary_all(); *p != NULL && used < size; ++p)
    if (strcmp((*p)->name, "constant") != 0 && strcmp((*p)->name, "distributed") != 0)
      used += (size_t)snprintf(words + used, size - used, "|%s", (*p)->name);
  return words;
}

static kith_status read_side(const struct kith_config_node *node, struct side *side) {
  char words[128], name[32];
  const bool map = node->kind == KITH_CONFIG_MAP && kith_config_child(node, "kind") != NULL;
  const struct kith_config_node *kind = map ? kith_config_child(node, "kind") : node;
  const struct kith_key key = {
      .key = "side", .kind = KITH_KEY_NAME, .allowed = side_words(words, sizeof words), .size = sizeof name};
  KITH_TRY(kith_key_value(&key, kind, name));
  side->ops = strcmp(name, "open") == 0 ? NULL : kith_boundary_find(name);
  side->velocity = 0;
  if (side->ops == &kith_boundary_piston && map) return kith_keys_read(piston_keys, node, side);
  if (side->ops == &kith_boundary_piston)
    return kith_config_fail(node, NULL, "a piston has a velocity: {kind: piston, velocity: 1}");
  return map ? kith_config_fail(kind, NULL, "%s has no settings; only a piston has", name) : KITH_OK;
}

static kith_status read_sides(const struct kith_config_node *node, struct side side[2]) {
  side[0] = side[1] = (struct side){NULL, 0};
  if (node == NULL) return KITH_OK;
  if (node->kind != KITH_CONFIG_LIST) {
    KITH_TRY(read_side(node, &side[0]));
    side[1] = side[0];
    return KITH_OK;
  }
  if (node->n != 2) return kith_config_fail(node, NULL, "%d entries, wanted [lower, upper]", node->n);
  KITH_TRY(read_side(node->first, &side[0]));
  KITH_TRY(read_side(node->last, &side[1]));
  const struct kith_boundary_ops *periodic = &kith_boundary_periodic;
  if ((side[0].ops == periodic) != (side[1].ops == periodic))
    return kith_config_fail(node, NULL, "periodic on one side only; it must be on both");
  return KITH_OK;
}

/* It works on one side, against nothing. */
static kith_status check_piston(const struct side side[2], const struct kith_config_node *node) {
  const bool at_lower = side[0].ops == &kith_boundary_piston, at_upper = side[1].ops == &kith_boundary_piston;
  if (!at_lower && !at_upper) return KITH_OK;
  if (at_lower && at_upper)
    return kith_config_fail(node, NULL, "two pistons; one acts on a side, opposite to an open one");
  if (side[at_lower].ops != NULL)
    return kith_config_fail(node, NULL,
                            "a piston opposite to a %s side: it must be open, or what the piston "
                            "does could not be told from it",
                            side[at_lower].ops->name);
  return KITH_OK;
}

kith_status kith_scene_lasts(const struct kith_scene *scene, double until) {
  for (int a = 0; a < NDIM; ++a) {
    char path[] = "boundaries.x";
    path[sizeof path - 2] = "xyz"[a];
    const double length = scene->domain.upper[a] - scene->domain.lower[a], u = scene->boundary[a].velocity;
    const double inwards = scene->boundary[a].lower == &kith_boundary_piston ? u : -u;
    if (inwards * until >= length)
      return kith_config_fail(
          kith_config_at(scene->config, path), NULL,
          "a piston with velocity %g is through the domain at time %g, and the run goes until %g", u,
          length / inwards, until);
  }
  return KITH_OK;
}

kith_status kith_scene_boundaries(struct kith_scene *scene, const struct kith_config_node *node) {
  static const char *const axes[] = {"x", "y", "z"};
  KITH_TRY(kith_keys_read(kith_boundaries_keys, node, scene));
  for (int a = 0; a < 3; ++a) {
    const struct kith_config_node *of_axis = kith_config_child(node, axes[a]);
    struct side side[2];
    KITH_TRY(read_sides(of_axis, side));
    if (a >= NDIM) continue;
    KITH_TRY(check_piston(side, of_axis));
    scene->boundary[a].lower = side[0].ops, scene->boundary[a].upper = side[1].ops;
    scene->boundary[a].velocity = side[0].velocity + side[1].velocity; /* one of them at most */
  }
  return kith_scene_lasts(scene, scene->until);
}

struct material {
  char eos[32];
  struct kith_eos_parameters parameters;
};

#define IN(member) KITH_INTO(struct material, member)
const struct kith_key kith_materials_keys[] = {
    {"eos", KITH_KEY_NAME, "ideal", KITH_EOS_LIST(KITH_AS_WORD), "equation of state", IN(eos)},
    {"gamma", KITH_KEY_NUMBER, "1.4", "(1, inf)", "ratio of specific heats (ideal, stiffened)",
     IN(parameters.gamma)},
    {"sound_speed", KITH_KEY_NUMBER, "1", "(0, inf)", "of an isothermal gas", IN(parameters.sound_speed)},
    {"stiffness", KITH_KEY_NUMBER, "0", "[0, inf)", "pressure P0 of a stiffened gas",
     IN(parameters.stiffness)},
    {0}};
#undef IN

static kith_status read_material(struct kith_scene *scene, const struct kith_config_node *node) {
  const int m = scene->n_materials;
  const size_t room = sizeof scene->material_name[m];
  struct material read = {.eos = ""};
  if (m == KITH_MAX_LISTS) return kith_config_fail(node, NULL, "more than %d materials", KITH_MAX_LISTS);
  if (strlen(node->key) >= room)
    return kith_config_fail(node, NULL, "a name longer than %zu letters", room - 1);
  KITH_TRY(kith_keys_read(kith_materials_keys, node->null ? NULL : node, &read));
  snprintf(scene->material_name[m], room, "%s", node->key);
  scene->material[m].eos = kith_eos_find(read.eos);
  scene->material[m].parameters = read.parameters;
  ++scene->n_materials;
  return KITH_OK;
}

kith_status kith_scene_materials(struct kith_scene *scene, const struct kith_config_node *node) {
  KITH_TRY(kith_config_want_map(node));
  if (node->n == 0) return kith_config_fail(node, NULL, "no material; one is required");
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next)
    KITH_TRY(read_material(scene, child));
  return KITH_OK;
}
