/* Domain, boundaries, external forces and materials of a scene. */
#include <float.h>
#include <math.h>
#include <string.h>
#include "app/scene/scene_parts.h"
#include "lib/core/choices.h"

#define IN(member) KITH_INTO(struct kith_scene, member)
const struct kith_param kith_domain_params[] = {
    {"lower", KITH_PARAM_VECTOR, NULL, "", "lower corner", IN(domain.lower)},
    {"upper", KITH_PARAM_VECTOR, NULL, "", "upper corner", IN(domain.upper)},
    {"across", KITH_PARAM_INTEGER, "", "[1, inf)",
     "for tubes: width on all axes but x, in spacings of the densest region, instead of that by upper",
     IN(across)},
    {0}};
#undef IN

kith_status kith_scene_domain(struct kith_scene *scene, const struct kith_config_node *node) {
  double *lower = scene->domain.lower, *upper = scene->domain.upper;
  for (int a = 0; a < NDIM; ++a) {
    if (a > 0 && scene->across > 0) upper[a] = lower[a] + scene->across / scene->resolution;
    const double side = upper[a] - lower[a];
    if (side > 0 && !kith_scene_unit_holds(fmax(side, fmax(fabs(lower[a]), fabs(upper[a])))))
      return kith_config_fail(kith_config_child(node, "upper"), NULL,
                              "a box of %g along %c: squares and powers of lengths need units in which it is "
                              "between 1e-31 and 1e31",
                              side, "xyz"[a]);
    if (!(lower[a] < upper[a]))
      return kith_config_fail(kith_config_child(node, "upper"), NULL, "%g along %c is not above lower, %g",
                              upper[a], "xyz"[a], lower[a]);
    const double far = fmax(fabs(lower[a]), fabs(upper[a])), apart = far * DBL_EPSILON;
    if (far > side && 0x1p20 * apart * scene->resolution > 1)
      return kith_config_fail(kith_config_child(node, "upper"), NULL,
                              "numbers like %g along %c are %g apart, and spacings of %g need a million of "
                              "that: shift the domain towards 0",
                              far, "xyz"[a], apart, 1 / scene->resolution);
  }
  return KITH_OK;
}

struct kith_member kith_scene_side_member(int k) {
  if (k == 0) return (struct kith_member){.name = "open", .doc = "nothing beyond it"};
  for (const struct kith_boundary_ops *const *p = kith_boundary_all(); *p != NULL; ++p)
    if ((*p)->has_faces && --k == 0)
      return (struct kith_member){(*p)->name, (*p)->doc, (*p)->params, (*p)->settings_size};
  return (struct kith_member){.name = NULL};
}
static const struct kith_param side_params[] = {
    {"kind", KITH_PARAM_MEMBER, NULL, "", "boundary", .family = kith_scene_side_member}, {0}};
#define SIDES                                                                                  \
  "open or a boundary (kith list boundary), with its settings {kind: NAME, key: value}, or a " \
  "pair [lower, upper] of these"
const struct kith_param kith_boundaries_params[] = {
    {"x", KITH_PARAM_OTHER, "open", "", SIDES, KITH_BELOW(side_params, VALUE)},
    {"y", KITH_PARAM_OTHER, "open", "", SIDES, KITH_BELOW(side_params, VALUE)},
    {"z", KITH_PARAM_OTHER, "open", "", SIDES, KITH_BELOW(side_params, VALUE)},
    {0}};

/* Reads a side: a name, or a map {kind: name, ...} with settings. */
static kith_status read_side(const struct kith_config_node *node, struct kith_selected *side) {
  const struct kith_config_node *kind = kith_config_child(node, "kind");
  const bool map = node->kind == KITH_CONFIG_MAP &&
                   (node->first == NULL || kith_choices_index("1d|2d|3d", node->first->key) < 0);
  if (!map) KITH_TRY(kith_param_value(side_params, node, side));
  KITH_TRY(kith_params_read(side_params, map ? node : NULL, side));
  const struct kith_param *params = kith_family_member(kith_scene_side_member, side->name).params;
  if (map && params == NULL && node->n > 1)
    return kith_config_fail(kind, NULL, "%s has no settings", side->name);
  for (; !map && params != NULL && params->key != NULL; ++params)
    if (params->fallback == NULL)
      return kith_config_fail(node, NULL, "a %s has a %s: {kind: %s, %s: 1}", side->name, params->key,
                              side->name, params->key);
  return KITH_OK;
}

/* Checks the boundaries on opposite sides of an axis. They may be the same with the same settings, or one
 * may be open. If gas passes one of them, the other may be any that does not act on one side alone. Opposite
 * to one that does, a piston, must be an open side. */
static kith_status check_sides(const struct kith_boundary_ops *lower, const struct kith_boundary_ops *upper,
                               const struct kith_selected side[2], const struct kith_config_node *node) {
  if (kith_boundary_wraps(lower) != kith_boundary_wraps(upper))
    return kith_config_fail(node, NULL, "periodic on one side only; it must be on both");
  if (lower == NULL || upper == NULL) return KITH_OK;
  if ((kith_boundary_passes(lower) || kith_boundary_passes(upper)) && !lower->one_side && !upper->one_side)
    return KITH_OK;
  const char *alone = lower->one_side ? lower->name : upper->name;
  if (lower == upper && lower->one_side)
    return kith_config_fail(node, NULL, "%s on both sides; it may be on one, opposite to an open one", alone);
  if (lower->one_side || upper->one_side)
    return kith_config_fail(
        node, NULL,
        "a %s with %s on the other side: that must be open, or what the %s does could not be told from it; a "
        "region with barrier: true at its end closes a tube",
        alone, lower->one_side ? upper->name : lower->name, alone);
  if (lower == upper &&
      (lower->settings_size == 0 || memcmp(side[0].settings, side[1].settings, lower->settings_size) == 0))
    return KITH_OK;
  return kith_config_fail(node, NULL, "%s and %s: both sides must be the same, or one be open", lower->name,
                          upper->name);
}

static kith_status read_sides(const struct kith_config_node *node, struct kith_selected side[2]) {
  const bool pair = node != NULL && node->kind == KITH_CONFIG_LIST;
  if (node == NULL) return KITH_OK;
  if (pair && node->n != 2) return kith_config_fail(node, NULL, "%d entries, wanted [lower, upper]", node->n);
  KITH_TRY(read_side(pair ? node->first : node, &side[0]));
  return read_side(pair ? node->last : node, &side[1]);
}

static void clear_side(const struct kith_boundary_ops *ops, void **settings) {
  if (ops != NULL) kith_params_clear_formulas(ops->params, *settings);
  kith_free(settings);
}

void kith_scene_boundaries_clear(struct kith_scene *scene) {
  for (int a = 0; a < NDIM; ++a)
    for (int s = 0; s < 2; ++s) clear_side(scene->boundary[a].side[s], &scene->boundary[a].settings[s]);
}

static kith_status read_axis(struct kith_scene *scene, int axis, const struct kith_config_node *node) {
  struct kith_selected side[2] = {{.name = "open"}, {.name = "open"}};
  kith_status status = read_sides(node, side);
  const struct kith_boundary_ops *const ops[2] = {kith_boundary_find(side[0].name),
                                                  kith_boundary_find(side[1].name)};
  if (status == KITH_OK) status = check_sides(ops[0], ops[1], side, node);
  const int used = ops[0] == NULL ? 1 : 0;
  if (status == KITH_OK && axis < NDIM) {
    if (kith_boundary_wraps(ops[0]))
      scene->period[axis] = scene->domain.upper[axis] - scene->domain.lower[axis];
    scene->boundary[axis].velocity = kith_boundary_face_velocity(ops[used], side[used].settings);
    for (int s = 0; s < 2; ++s) {
      scene->boundary[axis].side[s] = ops[s];
      scene->boundary[axis].settings[s] = side[s].settings;
      side[s].settings = NULL;
    }
  }
  for (int s = 0; s < 2; ++s) clear_side(ops[s], &side[s].settings);
  return status;
}

/* Sets *face to the place of a face that gas passes, if that is given. Checks that the state at an inflow is
 * given as a whole or not at all. Sets *unsteady if this state varies with place or time. */
static kith_status check_flow(const struct kith_boundary_ops *ops, const struct kith_flow_settings *flow,
                              double *face, bool *unsteady, const struct kith_config_node *node) {
  if (!kith_boundary_passes(ops)) return KITH_OK;
  if (flow->at != NULL) *face = kith_expression_constant(flow->at);
  const bool energy = flow->energy != NULL, pressure = flow->pressure != NULL, any = energy || pressure;
  if ((flow->density != NULL) != any || (flow->velocity[0] != NULL) != any)
    return kith_config_fail(
        node, NULL,
        "the state at an inflow is density, velocity and pressure or energy; give all, or "
        "none and it is that of the region at the face");
  if (energy && pressure) return kith_config_fail(node, NULL, "energy: not together with pressure");
  struct kith_expression *const formula[] = {flow->density, pressure ? flow->pressure : flow->energy};
  for (int k = 0; k < 2 && any; ++k) *unsteady |= isnan(kith_expression_constant(formula[k]));
  for (int a = 0; a < NDIM && any; ++a) *unsteady |= isnan(kith_expression_constant(flow->velocity[a]));
  return KITH_OK;
}

/* Checks the faces that gas passes. Only one axis may have them, since the zones behind the faces of two axes
 * would have to meet in the corners. */
static kith_status check_flows(struct kith_scene *scene, const struct kith_config_node *node) {
  int axis = -1;
  for (int a = 0; a < NDIM; ++a) {
    const struct kith_config_node *own = kith_config_child(node, kith_boundaries_params[a].key);
    double *face = scene->boundary[a].face;
    face[0] = scene->domain.lower[a], face[1] = scene->domain.upper[a];
    for (int s = 0; s < 2; ++s)
      KITH_TRY(check_flow(scene->boundary[a].side[s], scene->boundary[a].settings[s], face + s,
                          &scene->unsteady, own));
    if (!(scene->domain.lower[a] <= face[0] && face[0] < face[1] && face[1] <= scene->domain.upper[a]))
      return kith_config_fail(own, NULL, "at: faces at %g and %g are not in the domain, one below the other",
                              face[0], face[1]);
    if (!kith_scene_passes(scene, a)) continue;
    if (axis >= 0)
      return kith_config_fail(own, NULL,
                              "gas passes faces along %c already, and the zones behind both would "
                              "meet in the corners; one axis can have an inflow or outflow",
                              "xyz"[axis]);
    axis = a;
  }
  return KITH_OK;
}

const struct kith_config_node *kith_scene_boundary_node(const struct kith_scene *scene, int axis) {
  return kith_config_child(kith_config_at(scene->config, "boundaries"), kith_boundaries_params[axis].key);
}

kith_status kith_scene_boundaries(struct kith_scene *scene, const struct kith_config_node *node) {
  for (int a = 0; a < 3; ++a)
    KITH_TRY(read_axis(scene, a, kith_config_child(node, kith_boundaries_params[a].key)));
  return check_flows(scene, node);
}

#define IN(member) KITH_INTO(struct kith_scene, external_force.member)
const struct kith_param kith_potential_params[] = {
    {"center", KITH_PARAM_VECTOR, "[0, 0, 0]", "", "where the point is", IN(center), .needs = "mass!=0"},
    {"mass", KITH_PARAM_NUMBER, "0", "[0, inf)", "G M: the acceleration is G M / d^2; 0: none", IN(mass)},
    {"softening", KITH_PARAM_NUMBER, "0", "[0, inf)",
     "s: d^2 + s^2 instead of d^2 (Plummer); at least a spacing, if gas comes near the point", IN(softening),
     .needs = "mass!=0"},
    {0}};
#undef IN

kith_status kith_scene_forces(struct kith_scene *scene, const struct kith_config_node *root) {
  static const struct kith_param number = {.key = "gravity", .kind = KITH_PARAM_NUMBER, .allowed = ""};
  struct kith_external_force *force = &scene->external_force;
  const struct kith_config_node *gravity = kith_config_child(root, "gravity"),
                                *potential = kith_config_child(root, "potential");
  for (int a = 0; a < NDIM; ++a) {
    const bool mass = force->mass > 0, repeats = scene->period[a] > 0;
    /* The potential is 0 in the middle, so that energies are near 0 there: drifts are relative to them. */
    force->origin[a] = 0.5 * (scene->domain.lower[a] + scene->domain.upper[a]);
    if (force->gravity[a] != 0 && repeats)
      return kith_config_fail(gravity, NULL, "%g along %c, which is periodic: gas would fall for ever",
                              force->gravity[a], "xyz"[a]);
    if (mass && repeats)
      return kith_config_fail(potential, NULL, "its force does not repeat, but the domain does along %c",
                              "xyz"[a]);
    if (kith_scene_passes(scene, a) && kith_external_force_acts(force))
      return kith_config_fail(potential != NULL ? potential : gravity, NULL,
                              "not together with an inflow or outflow: the gas behind their faces does not "
                              "fall");
    /* The work of a piston is told from the momentum along its axis. */
    if (scene->boundary[a].velocity != 0 && (force->gravity[a] != 0 || mass))
      return kith_config_fail(potential != NULL ? potential : gravity, NULL,
                              "not together with a piston along %c, whose work could not be told from it",
                              "xyz"[a]);
  }
  /* Refuses a force along an axis that this dimension does not have, which would be lost without a word. */
  for (const struct kith_config_node *entry = gravity != NULL ? gravity->first : NULL; entry != NULL;
       entry = entry->next) {
    double value = 0;
    if (entry->index >= NDIM) KITH_TRY(kith_param_value(&number, entry, &value));
    if (value != 0)
      return kith_config_fail(gravity, NULL, "%g along %c: there is no such axis in %d-D", value,
                              "xyz"[entry->index], NDIM);
  }
  return KITH_OK;
}

struct material {
  struct kith_selected eos;
  bool cut;
};
const struct kith_param kith_materials_params[] = {
    {"eos", KITH_PARAM_MEMBER, "ideal", "", "equation of state", .family = kith_eos_member,
     KITH_INTO(struct material, eos)},
    {"tension", KITH_PARAM_CHOICE, "allowed", "allowed|cut",
     "a negative pressure: as the equation of state has it, or 0, and the sound speed too",
     KITH_INTO(struct material, cut)},
    {0}};

static kith_status read_material(struct kith_scene *scene, const struct kith_config_node *node) {
  const int m = scene->n_materials;
  const size_t room = sizeof scene->material_name[m];
  struct material read = {.eos = {.name = ""}};
  if (m == KITH_MAX_LISTS) return kith_config_fail(node, NULL, "more than %d materials", KITH_MAX_LISTS);
  if (strlen(node->key) >= room)
    return kith_config_fail(node, NULL, "a name longer than %zu letters", room - 1);
  for (const char *c = node->key; *c != '\0'; ++c) /* in tables, and in lists of excluders */
    if ((unsigned char)*c <= ' ' || strchr(",;:=|\"'/", *c) != NULL)
      return kith_config_fail(node, NULL, "a name has no spaces and none of , ; : = | \" ' /");
  kith_status status = kith_params_read(kith_materials_params, node->null ? NULL : node, &read);
  const struct kith_eos_ops *eos = kith_eos_find(read.eos.name);
  if (status == KITH_OK && eos->load != NULL) {
    const char *file = kith_config_child(node, "file")->location.file;
    char folder[4096];
    snprintf(folder, sizeof folder, "%.*s", kith_path_folder(file), file);
    if (eos->load(&read.eos.settings, folder) != KITH_OK)
      status = kith_config_fail(node, NULL, "%s", kith_failure());
  }
  snprintf(scene->material_name[m], room, "%s", node->key);
  scene->material[m] = (struct kith_material){eos, read.eos.settings, read.cut};
  ++scene->n_materials;
  return status;
}

kith_status kith_scene_materials(struct kith_scene *scene, const struct kith_config_node *node) {
  KITH_TRY(kith_config_want(node, KITH_CONFIG_MAP));
  if (node->n == 0) return kith_config_fail(node, NULL, "no material; one is required");
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next)
    KITH_TRY(read_material(scene, child));
  return KITH_OK;
}
