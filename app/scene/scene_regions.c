/* Regions and deposits of a scene. */
#include "app/scene/scene_parts.h"
#include "app/cli/text.h"
#include "lib/core/choices.h"

const char *const kith_lattice_names[] = {
#define X(name, word, doc) #word,
    KITH_LATTICE_LIST(X)
#undef X
};

#define IN(member) KITH_INTO(struct kith_region, member)
static const struct kith_param where_params[] = {
    {"x", KITH_PARAM_INTERVAL, "", "", "[lower, upper)", IN(where.extent[0])},
    {"y", KITH_PARAM_INTERVAL, "", "", "[lower, upper)", IN(where.extent[1])},
    {"z", KITH_PARAM_INTERVAL, "", "", "[lower, upper)", IN(where.extent[2])},
    {"inside", KITH_PARAM_EXPRESSION, "", "", "a formula in x, y, z, r that is nonzero inside",
     IN(where.inside)},
    {0}};
const struct kith_param kith_region_params[] = {
    {"material", KITH_PARAM_OTHER, NULL, "", "one of materials", .params = NULL},
    {"where", KITH_PARAM_MAP, "", "",
     "where the region is: inside of all that is given; none: the whole domain",
     KITH_BELOW(where_params, MAP)},
    {"lattice", KITH_PARAM_CHOICE, "{1d: cubic, 2d: hcp, 3d: bcc}", KITH_LATTICE_LIST(KITH_AS_LISTED_CHOICE),
     "arrangement of the nodes; not fcc in 2-D", IN(lattice)},
    {"jitter", KITH_PARAM_NUMBER, "0", "[0, 0.5]", "largest random displacement along an axis, in spacings",
     IN(jitter)},
    {"seed", KITH_PARAM_INTEGER, "0", "[0, inf)", "seed of the jitter", IN(seed), .needs = "jitter!=0"},
    {"density", KITH_PARAM_EXPRESSION, NULL, "", "number or formula in x, y, z, r; above 0", IN(density)},
    {"pressure", KITH_PARAM_EXPRESSION, "", "", "number or formula; this or energy", IN(pressure)},
    {"energy", KITH_PARAM_EXPRESSION, "", "", "per unit mass, number or formula; this or pressure",
     IN(energy)},
    {"velocity", KITH_PARAM_EXPRESSIONS, "[0, 0, 0]", "", "numbers or formulas", IN(velocity)},
    {"displacement", KITH_PARAM_EXPRESSIONS, "", "",
     "numbers or formulas: how far a node is moved from its lattice site; its volume is stretched like the "
     "lattice",
     IN(displacement)},
    {"spacing", KITH_PARAM_NUMBER, "0", "[0, inf)",
     "spacing of the nodes; 0: from resolution and arrangement", IN(spacing)},
    {"frozen", KITH_PARAM_BOOL, "false", "",
     "its nodes never move, nor does their state change; not with a velocity", IN(frozen)},
    {"barrier", KITH_PARAM_BOOL, "false", "",
     "its nodes never move and are a wall: they reflect, and cut the pairs that cross them", IN(barrier)},
    {"porosity", KITH_PARAM_NUMBER, "", "[0, 1]",
     "part of heat and momentum that passes through; none: 0 for a barrier, else 1", IN(porosity)},
    {"damage", KITH_PARAM_EXPRESSION, "", "",
     "number or formula, 0 to 1: the part of heat and momentum that does not pass", IN(damage)},
    {"equilibrium", KITH_PARAM_BOOL, "false", "",
     "energies are such that the pressure is as given with the density that the method computes, not with "
     "the one given here",
     IN(equilibrium)},
    {0}};
#undef IN

kith_status kith_scene_material(const struct kith_scene *scene, const struct kith_config_node *node,
                                int *material) {
  char words[KITH_MAX_LISTS * 33] = "";
  for (int m = 0; m < scene->n_materials; ++m)
    kith_text_add(words, sizeof words, "|%s", scene->material_name[m]);
  const struct kith_param key = {"material", KITH_PARAM_CHOICE, NULL, words, "", .size = sizeof *material};
  return kith_param_value(&key, node, material);
}

/* Checks a region in equilibrium: it needs a pressure to hold, nodes whose density is summed, and an equation
 * of state whose pressure depends on the energy. */
static kith_status check_equilibrium(const struct kith_scene *scene, const struct kith_region *region,
                                     const struct kith_config_node *node) {
  const struct kith_config_node *equilibrium = kith_config_child(node, "equilibrium");
  if (!region->equilibrium) return KITH_OK;
  if (region->pressure == NULL) return kith_config_fail(equilibrium, NULL, "needs pressure, not energy");
  if (kith_region_stays(region))
    return kith_config_fail(equilibrium, NULL, "not together with frozen: their density stays as given");
  const struct kith_eos_ops *eos = scene->material[region->material].eos;
  if (!eos->barotropic) return KITH_OK;
  return kith_config_fail(equilibrium, NULL, "not for eos %s: its pressure takes nothing from energy",
                          eos->name);
}

/* Checks the state of a region as far as it is constant; formulas are checked when there are nodes. */
static kith_status check_state(const struct kith_scene *scene, const struct kith_region *region,
                               const struct kith_config_node *node) {
  const struct kith_config_node *pressure = kith_config_child(node, "pressure"),
                                *energy = kith_config_child(node, "energy");
  if (pressure == NULL && energy == NULL)
    return kith_config_fail(node, "pressure", "missing; pressure or energy is required");
  if (pressure != NULL && energy != NULL) return kith_config_fail(energy, NULL, "not together with pressure");
  const struct kith_material *m = &scene->material[region->material];
  const double density = kith_expression_constant(region->density),
               p = kith_expression_constant(region->pressure);
  const double u =
      energy != NULL ? kith_expression_constant(region->energy) : kith_material_energy(m, density, p);
  const double damage = kith_expression_constant(region->damage);
  if (damage < 0 || damage > 1)
    return kith_config_fail(kith_config_child(node, "damage"), NULL, "%g is out of range [0, 1]", damage);
  if (density <= 0)
    return kith_config_fail(kith_config_child(node, "density"), NULL, "%g is out of range (0, inf)", density);
  if (pressure != NULL && density > 0 && !kith_pressure_holds(m, density, u, p))
    return kith_config_fail(pressure, NULL,
                            "%g cannot be set: eos %s has %.10g at this density; give that, or energy: 0", p,
                            m->eos->name, kith_material_pressure(m, density, u));
  if (!m->eos->energy_positive || !(u < 0)) return KITH_OK;
  if (energy != NULL) return kith_config_fail(energy, NULL, "%g is out of range [0, inf)", u);
  return kith_config_fail(pressure, NULL, "%g needs a negative energy, %g", p, u);
}

/* Refuses t in the formulas of a region, which is filled once, at the start: t would always be 0. */
static kith_status check_timeless(const struct kith_param *params, const struct kith_region *region,
                                  const struct kith_config_node *map) {
  for (const struct kith_param *p = params; p->key != NULL; ++p) {
    const struct kith_config_node *given = kith_config_child(map, p->key);
    const bool formulas = p->kind == KITH_PARAM_EXPRESSION || p->kind == KITH_PARAM_EXPRESSIONS;
    struct kith_expression *const *formula = (void *)((uintptr_t)region + p->offset);
    if (p->kind == KITH_PARAM_MAP) KITH_TRY(check_timeless(p->params, region, given));
    for (size_t k = 0; formulas && k < p->size / sizeof *formula; ++k)
      if (kith_expression_is_timed(formula[k]))
        return kith_config_fail(given, NULL, "t means nothing at the start; variables are x, y, z, r");
  }
  return KITH_OK;
}

/* Refuses a velocity where nodes stay: pairs would see a motion that there is not. */
static kith_status check_rest(const struct kith_region *region, const struct kith_config_node *node) {
  for (int a = 0; kith_region_stays(region) && a < NDIM; ++a)
    if (region->velocity[a] != NULL && kith_expression_constant(region->velocity[a]) != 0)
      return kith_config_fail(kith_config_child(node, "velocity"), NULL, "not together with %s",
                              region->barrier ? "barrier, which is a wall at rest"
                                              : "frozen: its nodes never move; leave it out, or set it to 0");
  return KITH_OK;
}

static kith_status read_region(const struct kith_scene *scene, struct kith_region *region,
                               const struct kith_config_node *node) {
  region->node = node;
  region->porosity = -1;
  for (int a = 0; a < 3; ++a) region->where.extent[a][0] = -INFINITY, region->where.extent[a][1] = INFINITY;
  KITH_TRY(kith_params_read(kith_region_params, node, region));
  KITH_TRY(check_timeless(kith_region_params, region, node));
  KITH_TRY(kith_scene_material(scene, kith_config_child(node, "material"), &region->material));
  if (NDIM == 2 && region->lattice == KITH_LATTICE_FCC)
    return kith_config_fail(kith_config_child(node, "lattice"), NULL,
                            "fcc does not exist in 2-D; cubic, bcc, hcp and glass do");
  KITH_TRY(check_state(scene, region, node));
  KITH_TRY(check_rest(region, node));
  return check_equilibrium(scene, region, node);
}

kith_status kith_scene_regions(struct kith_scene *scene, const struct kith_config_node *node) {
  KITH_TRY(kith_config_want(node, KITH_CONFIG_LIST));
  if (node->n == 0) return kith_config_fail(node, NULL, "no region; one is required");
  KITH_TRY(kith_resize(&scene->region, 0, (size_t)node->n, sizeof *scene->region));
  scene->n_regions = node->n;
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next)
    KITH_TRY(read_region(scene, &scene->region[child->index], child));
  for (int k = 0; k < scene->n_regions; ++k) scene->equilibrium |= scene->region[k].equilibrium;
  return KITH_OK;
}

#define IN(member) KITH_INTO(struct kith_deposit, member)
const struct kith_param kith_deposit_params[] = {
    {"energy", KITH_PARAM_NUMBER, NULL, "[0, inf)", "total in the whole domain", IN(energy)},
    {"center", KITH_PARAM_VECTOR, "[0, 0, 0]", "", "center of the blast", IN(center)},
    {"over", KITH_PARAM_CHOICE, "point", "point|ball|kernel",
     "what gets it: the nearest nodes, those in a ball, or all within a cubic spline, weighted by it",
     IN(shape)},
    {"radius", KITH_PARAM_NUMBER, "0", "[0, inf)", "radius of the ball, or of the spline's support",
     IN(radius)},
    {"spacings", KITH_PARAM_NUMBER, "0", "[0, inf)",
     "instead of radius, in node spacings: radius of the ball, or half of that of the support", IN(spacings)},
    {"time", KITH_PARAM_NUMBER, "0", "[0, inf)", "when it is released; a step ends then", IN(time)},
    {0}};
#undef IN

static kith_status read_deposit(const struct kith_scene *scene, struct kith_deposit *deposit,
                                const struct kith_config_node *node) {
  deposit->node = node;
  KITH_TRY(kith_params_read(kith_deposit_params, node, deposit));
  for (int a = 0; a < NDIM; ++a)
    if (deposit->center[a] < scene->domain.lower[a] || deposit->center[a] > scene->domain.upper[a])
      return kith_config_fail(kith_config_child(node, "center"), NULL,
                              "%g is outside of the domain, %g to %g", deposit->center[a],
                              scene->domain.lower[a], scene->domain.upper[a]);
  const bool point = deposit->shape == KITH_DEPOSIT_POINT, radius = deposit->radius > 0,
             spacings = deposit->spacings > 0;
  const char *key = radius ? "radius" : "spacings";
  if (point && (radius || spacings))
    return kith_config_fail(node, key, "means nothing for a point; add over: ball or kernel");
  if (!point && !radius && !spacings)
    return kith_config_fail(node, "radius", "missing; radius or spacings is required");
  if (radius && spacings) return kith_config_fail(node, "spacings", "not together with radius");
  return KITH_OK;
}

kith_status kith_scene_deposits(struct kith_scene *scene, const struct kith_config_node *node) {
  if (node == NULL) return KITH_OK;
  const bool list = node->kind == KITH_CONFIG_LIST;
  const int n = list ? node->n : 1;
  KITH_TRY(kith_resize(&scene->deposit, 0, (size_t)n, sizeof *scene->deposit));
  scene->n_deposits = n;
  if (!list) return read_deposit(scene, scene->deposit, node);
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next)
    KITH_TRY(read_deposit(scene, &scene->deposit[child->index], child));
  return KITH_OK;
}
