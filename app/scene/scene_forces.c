/* Forces from outside: gravity and the potential of a point. */
#include "app/scene/scene_parts.h"

#define IN(member) KITH_INTO(struct kith_scene, external_force.member)
const struct kith_param kith_potential_params[] = {
    {"center", KITH_PARAM_VECTOR, "[0, 0, 0]", "", "where the point is", IN(center)},
    {"mass", KITH_PARAM_NUMBER, "0", "[0, inf)", "G M: the acceleration is G M / d^2; 0: none", IN(mass)},
    {"softening", KITH_PARAM_NUMBER, "0", "[0, inf)", "s: d^2 + s^2 instead of d^2 (Plummer)", IN(softening)},
    {0}};
#undef IN

/* A force along an axis that is not there would be lost without a word. */
static kith_status check_gravity(const struct kith_scene *scene, const struct kith_config_node *node) {
  if (node == NULL) return KITH_OK;
  for (const struct kith_config_node *entry = node->first; entry != NULL; entry = entry->next) {
    static const struct kith_param number = {.key = "gravity", .kind = KITH_PARAM_NUMBER, .allowed = ""};
    const int axis = entry->index;
    double value;
    KITH_TRY(kith_param_value(&number, entry, &value));
    if (value == 0) continue;
    if (axis >= NDIM)
      return kith_config_fail(node, NULL, "%g along %c: there is no such axis in %d-D", value, "xyz"[axis],
                              NDIM);
    if (kith_boundary_wraps(scene->boundary[axis].lower))
      return kith_config_fail(node, NULL, "%g along %c, which is periodic: gas would fall for ever", value,
                              "xyz"[axis]);
  }
  return KITH_OK;
}

static kith_status check_periods(const struct kith_scene *scene, const struct kith_config_node *node) {
  for (int a = 0; a < NDIM; ++a)
    if (kith_boundary_wraps(scene->boundary[a].lower))
      return kith_config_fail(node, NULL, "its pull does not repeat, but the domain does along %c", "xyz"[a]);
  return KITH_OK;
}

/* Momentum along its axis tells the work of a piston: nothing else may give any. */
static kith_status check_piston(const struct kith_scene *scene, const struct kith_config_node *node) {
  for (int a = 0; a < NDIM; ++a)
    if (scene->boundary[a].velocity != 0 &&
        (scene->external_force.gravity[a] != 0 || scene->external_force.mass > 0))
      return kith_config_fail(
          node, NULL, "not together with a piston along %c, whose work could not be told from it", "xyz"[a]);
  return KITH_OK;
}

kith_status kith_scene_forces(struct kith_scene *scene, const struct kith_config_node *root) {
  const struct kith_config_node *gravity = kith_config_child(root, "gravity"),
                                *potential = kith_config_child(root, "potential");
  KITH_TRY(check_gravity(scene, gravity));
  if (scene->external_force.mass > 0) KITH_TRY(check_periods(scene, potential));
  for (int a = 0; a < NDIM; ++a) /* energies near 0: drifts are relative */
    scene->external_force.origin[a] = 0.5 * (scene->domain.lower[a] + scene->domain.upper[a]);
  return check_piston(scene, potential != NULL ? potential : gravity);
}
