/* The exact solution of a scene: its settings, derived from the scene unless they are given. */
#include "app/scene/scene_parts.h"

static const struct kith_param window_params[] = {
    {"x", KITH_PARAM_INTERVAL, "", "", "a <= x <= b", KITH_INTO(struct kith_window, x)},
    {"r", KITH_PARAM_INTERVAL, "", "[0, inf)",
     "a <= |position - center| <= b; the center moves with uniform_velocity",
     KITH_INTO(struct kith_window, r)},
    {0}};
const struct kith_param kith_exact_params[] = {
    {"name", KITH_PARAM_MEMBER, NULL, "", "the solution; what follows from the scene need not be given",
     .family = kith_exact_member, .derives = true},
    {"window", KITH_PARAM_OTHER, "", "", "where the norms are taken; none: everywhere",
     KITH_BELOW(window_params, MAP)},
    {0}};

static struct kith_exact_scene describe(const struct kith_scene *scene) {
  struct kith_exact_scene out = {
      .until = scene->until, .n_regions = scene->n_regions, .n_deposits = scene->n_deposits};
  for (int a = 0; a < NDIM; ++a) {
    const struct kith_boundary_ops *const *side = scene->boundary[a].side;
    out.lower[a] = scene->domain.lower[a], out.upper[a] = scene->domain.upper[a];
    out.axis[a].periodic = scene->period[a] > 0;
    out.axis[a].velocity = scene->boundary[a].velocity;
    for (int s = 0; s < 2; ++s) {
      out.axis[a].open[s] = side[s] == NULL;
      out.axis[a].mirror[s] = side[s] != NULL && side[s]->mirrors;
    }
    if (scene->n_deposits > 0) out.deposit_center[a] = scene->deposit[0].center[a];
  }
  out.forced = kith_external_force_acts(&scene->external_force);
  if (scene->n_deposits > 0)
    out.deposit_energy = scene->deposit[0].energy, out.deposit_time = scene->deposit[0].time;
  for (int r = 0; r < KITH_MIN(scene->n_regions, 2); ++r) {
    const struct kith_region *region = &scene->region[r];
    const struct kith_material *m = &scene->material[region->material];
    const struct kith_power_law law =
        m->eos->power_law != NULL ? m->eos->power_law(m->settings) : (struct kith_power_law){NAN, NAN};
    out.region[r].gamma = law.gamma, out.region[r].stiffness = law.stiffness;
    out.region[r].irregular = region->where.inside != NULL || kith_region_stays(region);
    out.region[r].barotropic = m->eos->barotropic;
    out.region[r].density = kith_expression_constant(region->density);
    out.region[r].pressure =
        region->pressure != NULL
            ? kith_expression_constant(region->pressure)
            : kith_material_pressure(m, out.region[r].density, kith_expression_constant(region->energy));
    out.region[r].energy = region->energy != NULL
                               ? kith_expression_constant(region->energy)
                               : kith_material_energy(m, out.region[r].density, out.region[r].pressure);
    for (int a = 0; a < NDIM; ++a) {
      out.region[r].velocity[a] =
          region->velocity[a] != NULL ? kith_expression_constant(region->velocity[a]) : 0;
      out.region[r].lower[a] = region->where.extent[a][0];
      out.region[r].upper[a] = region->where.extent[a][1];
    }
  }
  return out;
}

static kith_status check_complete(const struct kith_exact_ops *ops, const void *settings,
                                  const struct kith_config_node *node) {
  for (const struct kith_param *p = ops->params; p != NULL && p->key != NULL; ++p) {
    const double *value = (const double *)((const char *)settings + p->offset);
    for (size_t i = 0; i < p->size / sizeof *value; ++i)
      if (!isfinite(value[i]) && p->given)
        return kith_config_fail(node, p->key, "missing; it is required");
      else if (!isfinite(value[i]))
        return kith_config_fail(node, p->key, "missing; it does not follow from this scene%s%s",
                                ops->derived_from != NULL ? ", only from one of " : "",
                                ops->derived_from != NULL ? ops->derived_from : "");
  }
  return KITH_OK;
}

kith_status kith_scene_exact(struct kith_scene *scene, const struct kith_config_node *node) {
  struct kith_selected exact = {.name = ""};
  if (node == NULL) return KITH_OK;
  KITH_TRY(kith_params_want_map(kith_exact_params, node));
  KITH_TRY(kith_param_read(&kith_exact_params[0], node, &exact));
  scene->exact.ops = kith_exact_find(exact.name);
  KITH_TRY(kith_settings_create(&exact.settings, kith_family_member(kith_exact_member, exact.name), NULL));
  const struct kith_exact_scene description = describe(scene);
  if (scene->exact.ops->derive != NULL) scene->exact.ops->derive(exact.settings, &description);
  scene->exact.settings = exact.settings;
  KITH_TRY(kith_params_read(kith_exact_params, node, &exact));
  KITH_TRY(check_complete(scene->exact.ops, exact.settings, node));
  scene->exact.window = KITH_WINDOW_ALL;
  const struct kith_config_node *window = kith_config_child(node, "window");
  if (window != NULL) KITH_TRY(kith_params_read(window_params, window, &scene->exact.window));
  const kith_status status =
      kith_exact_create(&scene->exact.solution, scene->exact.ops, scene->exact.settings);
  return status == KITH_OK || status == KITH_NO_MEMORY ? status
                                                       : kith_config_fail(node, NULL, "%s", kith_failure());
}
