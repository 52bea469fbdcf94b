/* The exact solution of a scene: its parameters, derived from the scene unless they are given. */
#include <string.h>
#include "app/scene_parts.h"
#include "app/words.h"

struct exact {
  char name[32];
  struct kith_exact_parameters p;
};

#define IN(member) KITH_INTO(struct exact, p.member)

struct window {
  double x[2], r[2];
};

static const struct kith_key window_keys[] = {
    {"x", KITH_KEY_INTERVAL, "", "", "a <= x <= b", KITH_INTO(struct window, x)},
    {"r", KITH_KEY_INTERVAL, "", "[0, inf)", "a <= |position - center| <= b", KITH_INTO(struct window, r)},
    {0}};
/* All "" keep what was derived. */
const struct kith_key kith_exact_keys[] = {
    {"name", KITH_KEY_NAME, NULL, KITH_EXACT_LIST(KITH_AS_WORD), "the solution",
     KITH_INTO(struct exact, name)},
    {"window", KITH_KEY_OTHER, "", "", "where the norms are taken; none: everywhere",
     KITH_BELOW(window_keys, MAP)},
    {"gamma", KITH_KEY_SIDES, "", "(1, inf)", "ratio of specific heats, or [left, right]", IN(gamma)},
    {"density", KITH_KEY_SIDES, "", "[0, inf)", "undisturbed, or [left, right]; 0: vacuum", IN(density)},
    {"velocity", KITH_KEY_SIDES, "", "", "riemann: [left, right]; noh: speed of the inflow", IN(velocity)},
    {"pressure", KITH_KEY_SIDES, "", "[0, inf)", "undisturbed, or [left, right]; gresho: on the axis",
     IN(pressure)},
    {"uniform_velocity", KITH_KEY_VECTOR, "", "", "uniform, waves, vortices, square: of the whole",
     IN(uniform_velocity)},
    {"interface_position", KITH_KEY_NUMBER, "", "", "riemann: x of the jump", IN(interface_position)},
    {"blast_energy", KITH_KEY_NUMBER, "", "(0, inf)", "sedov: on all sides of the center", IN(blast_energy)},
    {"omega", KITH_KEY_NUMBER, "", "[0, 3)",
     "sedov: the undisturbed density is density times r^-omega; below the dimension", IN(omega)},
    {"center", KITH_KEY_VECTOR, "", "", "sedov, noh, vortices, square", IN(center)},
    {"period", KITH_KEY_VECTOR, "", "",
     "vortices, square: sides of the periodic box that carries it along; 0: none", IN(period)},
    {"amplitude", KITH_KEY_NUMBER, "", "", "waves: of the density, relative; yee: strength", IN(amplitude)},
    {"wavelength", KITH_KEY_NUMBER, "", "(0, inf)", "waves: along x", IN(wavelength)},
    {"origin", KITH_KEY_NUMBER, "", "", "waves: x of phase 0 at the start; none: 0", IN(origin)},
    {"side", KITH_KEY_VECTOR, "", "(0, inf)", "square: its sides", IN(side)},
    {"end_time", KITH_KEY_NUMBER, "", "[0, inf)", "two-blasts: computed until then", IN(end_time)},
    {0}};

/* --- deriving: what is not constant stays NaN --- */

static double gamma_of(const struct kith_scene *scene, const struct kith_region *region) {
  const struct kith_material *m = &scene->material[region->material];
  return m->eos == &kith_eos_ideal ? m->parameters.gamma : NAN;
}

static double pressure_of(const struct kith_scene *scene, const struct kith_region *region) {
  if (region->pressure != NULL) return kith_constant_value(region->pressure);
  const struct kith_material *m = &scene->material[region->material];
  const double density = kith_constant_value(region->density), energy = kith_constant_value(region->energy);
  double pressure, sound_speed;
  m->eos->state(&m->parameters, 1, &density, &energy, &pressure, &sound_speed);
  return pressure;
}

static void derive_side(const struct kith_scene *scene, const struct kith_region *region, int side,
                        struct kith_exact_parameters *p) {
  p->gamma[side] = gamma_of(scene, region);
  p->density[side] = kith_constant_value(region->density);
  p->pressure[side] = pressure_of(scene, region);
  p->velocity[side] = kith_constant_value(region->velocity[0]);
}

/* One region, with nothing between it and an open face: a vacuum. */
static void derive_vacuum(const struct kith_scene *scene, struct kith_exact_parameters *p) {
  const struct kith_region *gas = &scene->region[0];
  const double lower = gas->where.box.lower[0], upper = gas->where.box.upper[0];
  const bool full_below = lower <= scene->domain.lower[0], full_above = upper >= scene->domain.upper[0];
  const bool above = full_below && !full_above && scene->boundary[0].upper == NULL;
  if (!above && !(full_above && !full_below && scene->boundary[0].lower == NULL)) return;
  derive_side(scene, gas, above ? 0 : 1, p);
  const int empty = above ? 1 : 0;
  p->interface_position = above ? upper : lower;
  p->gamma[empty] = p->gamma[!empty];
  p->density[empty] = p->velocity[empty] = p->pressure[empty] = 0;
}

static void derive_riemann(const struct kith_scene *scene, struct kith_exact_parameters *p) {
  if (scene->n_regions == 1) derive_vacuum(scene, p);
  if (scene->n_regions != 2) return;
  const struct kith_region *left = &scene->region[0], *right = &scene->region[1];
  if (left->where.box.lower[0] > right->where.box.lower[0] ||
      left->where.box.upper[0] > right->where.box.upper[0]) {
    right = left;
    left = &scene->region[1];
  }
  const double a = left->where.box.upper[0], b = right->where.box.lower[0];
  const double length = scene->domain.upper[0] - scene->domain.lower[0];
  if (!(fabs(a - b) <= 1e-12 * length)) return; /* they do not touch, or are not split along x */
  p->interface_position = a;
  derive_side(scene, left, 0, p);
  derive_side(scene, right, 1, p);
}

static void derive_undisturbed(const struct kith_scene *scene, struct kith_exact_parameters *p) {
  derive_side(scene, &scene->region[0], 0, p);
  p->gamma[1] = p->gamma[0], p->density[1] = p->density[0], p->pressure[1] = p->pressure[0];
}

/* A reflecting face through the center stands for the energy of the mirror image. */
static double mirrored_energy(const struct kith_scene *scene, const struct kith_deposit *deposit) {
  const struct kith_boundary_ops *reflecting = kith_boundary_find("reflecting");
  double energy = deposit->energy;
  for (int a = 0; a < NDIM; ++a) {
    const double lower = scene->domain.lower[a], upper = scene->domain.upper[a],
                 close = 1e-12 * (upper - lower);
    if (scene->boundary[a].lower == reflecting && fabs(deposit->center[a] - lower) <= close) energy *= 2;
    if (scene->boundary[a].upper == reflecting && fabs(deposit->center[a] - upper) <= close) energy *= 2;
  }
  return energy;
}

static void derive_sedov(const struct kith_scene *scene, struct kith_exact_parameters *p) {
  derive_undisturbed(scene, p);
  if (scene->n_deposits != 1) return;
  memcpy(p->center, scene->deposit[0].center, sizeof p->center);
  p->blast_energy = mirrored_energy(scene, &scene->deposit[0]);
}

static void derive_noh(const struct kith_scene *scene, struct kith_exact_parameters *p) {
  double x[NDIM], v[NDIM];
  derive_undisturbed(scene, p);
  p->velocity[0] = NAN;
  for (int a = 0; a < NDIM; ++a) { /* somewhere between the origin and the farther face */
    const double lower = scene->domain.lower[a], upper = scene->domain.upper[a];
    x[a] = (0.6 + 0.1 * a) * (fabs(lower) > fabs(upper) ? lower : upper);
  }
  for (int a = 0; a < NDIM; ++a)
    if (kith_expression_at(scene->region[0].velocity[a], x, &v[a]) != KITH_OK) return;
  p->velocity[0] = p->velocity[1] = kith_norm(v);
}

static void derive_velocity(const struct kith_scene *scene, struct kith_exact_parameters *p) {
  for (int a = 0; a < NDIM; ++a) p->uniform_velocity[a] = kith_constant_value(scene->region[0].velocity[a]);
}

static void derive_uniform(const struct kith_scene *scene, struct kith_exact_parameters *p) {
  derive_undisturbed(scene, p);
  derive_velocity(scene, p);
}

static void derive_acoustic_wave(const struct kith_scene *scene, struct kith_exact_parameters *p) {
  p->gamma[0] = p->gamma[1] = gamma_of(scene, &scene->region[0]);
  p->wavelength = scene->domain.upper[0] - scene->domain.lower[0];
  p->origin = 0;
}

static void derive_period(const struct kith_scene *scene, struct kith_exact_parameters *p) {
  for (int a = 0; a < NDIM; ++a)
    if (scene->boundary[a].lower == &kith_boundary_periodic)
      p->period[a] = scene->domain.upper[a] - scene->domain.lower[a];
}

static void derive_entropy_wave(const struct kith_scene *scene, struct kith_exact_parameters *p) {
  derive_acoustic_wave(scene, p);
  derive_velocity(scene, p);
  p->pressure[0] = p->pressure[1] = pressure_of(scene, &scene->region[0]);
}

static void derive_square(const struct kith_scene *scene, struct kith_exact_parameters *p) {
  if (scene->n_regions != 2) return;
  const struct kith_box *box = &scene->region[0].where.box;
  derive_side(scene, &scene->region[0], 0, p);
  derive_side(scene, &scene->region[1], 1, p);
  derive_velocity(scene, p);
  derive_period(scene, p);
  for (int a = 0; a < NDIM; ++a) {
    p->side[a] = box->upper[a] - box->lower[a];
    p->center[a] = 0.5 * (box->lower[a] + box->upper[a]);
  }
}

static void derive_yee(const struct kith_scene *scene, struct kith_exact_parameters *p) {
  p->gamma[0] = p->gamma[1] = gamma_of(scene, &scene->region[0]);
  p->amplitude = 5;
  derive_period(scene, p);
}

static void derive_two_blasts(const struct kith_scene *scene, struct kith_exact_parameters *p) {
  p->gamma[0] = p->gamma[1] = gamma_of(scene, &scene->region[0]);
  p->end_time = scene->until;
}

static void derive_gresho(const struct kith_scene *scene, struct kith_exact_parameters *p) {
  p->gamma[0] = p->gamma[1] = gamma_of(scene, &scene->region[0]);
  p->density[0] = p->density[1] = kith_constant_value(scene->region[0].density);
  derive_period(scene, p);
}

/* What a member needs, and how it is found. A member without a row needs everything given. */
static const struct {
  const char *name, *needs;
  void (*derive)(const struct kith_scene *scene, struct kith_exact_parameters *p);
} derivations[] = {
    {"riemann", "gamma|density|velocity|pressure|interface_position", derive_riemann},
    {"sedov", "gamma|density|pressure|blast_energy", derive_sedov},
    {"noh", "gamma|density|pressure|velocity", derive_noh},
    {"gresho", "gamma|density|pressure", derive_gresho},
    {"yee", "gamma|amplitude", derive_yee},
    {"entropy_wave", "gamma|density|pressure|uniform_velocity|amplitude|wavelength|origin",
     derive_entropy_wave},
    {"square", "gamma|density|pressure|uniform_velocity|side|center", derive_square},
    {"two_blasts", "gamma|end_time", derive_two_blasts},
    {"uniform", "gamma|density|pressure|uniform_velocity", derive_uniform},
    {"acoustic_wave", "gamma|density|pressure|amplitude|wavelength|origin", derive_acoustic_wave},
};

static struct kith_exact_parameters unknown(void) {
  struct kith_exact_parameters p = {
      .interface_position = NAN, .end_time = NAN, .blast_energy = NAN, .amplitude = NAN, .wavelength = NAN};
  for (int side = 0; side < 2; ++side)
    p.gamma[side] = p.density[side] = p.velocity[side] = p.pressure[side] = NAN;
  return p;
}

static kith_status check_needs(const char *needs, const struct exact *exact,
                               const struct kith_config_node *node) {
  for (const struct kith_key *k = kith_exact_keys; k->key != NULL; ++k) {
    if (kith_words_find(needs, k->key) < 0) continue;
    double value[3] = {0};
    memcpy(value, (const char *)exact + k->offset, k->size);
    for (size_t i = 0; i < k->size / sizeof value[0]; ++i)
      if (!isfinite(value[i]))
        return kith_config_fail(node, k->key, "missing; it does not follow from this scene");
  }
  return KITH_OK;
}

/* --- window --- */

static kith_status read_window(struct kith_scene *scene, const struct kith_config_node *node) {
  struct kith_window *out = &scene->exact.window;
  struct window w = {0};
  out->kind = KITH_WINDOW_ALL;
  if (node == NULL) return KITH_OK;
  KITH_TRY(kith_keys_read(window_keys, node, &w));
  const bool along = kith_config_child(node, "x") != NULL, radial = kith_config_child(node, "r") != NULL;
  if (along && radial) return kith_config_fail(kith_config_child(node, "r"), NULL, "not together with x");
  if (along) {
    out->kind = KITH_WINDOW_SLAB;
    out->center[0] = (w.x[0] + w.x[1]) / 2;
    out->outer = (w.x[1] - w.x[0]) / 2;
  } else if (radial) {
    out->kind = KITH_WINDOW_BALL;
    memcpy(out->center, scene->exact.parameters.center, sizeof out->center);
    out->inner = w.r[0], out->outer = w.r[1];
  }
  return KITH_OK;
}

/* Would the member take them? Better to know before anything runs. */
static kith_status try_exact(const struct kith_scene *scene, const struct kith_config_node *node) {
  void *solution = NULL;
  if (scene->exact.ops->create(&solution, &scene->exact.parameters) != KITH_OK)
    return kith_config_fail(node, NULL, "%s", kith_failure());
  scene->exact.ops->destroy(&solution);
  return KITH_OK;
}

kith_status kith_scene_exact(struct kith_scene *scene, const struct kith_config_node *node) {
  struct exact exact = {.p = unknown()};
  const char *needs = "";
  if (node == NULL) return KITH_OK;
  KITH_TRY(kith_config_want_map(node));
  KITH_TRY(kith_keys_read(kith_exact_keys, node, &exact));
  exact.p = unknown();
  for (size_t i = 0; i < sizeof derivations / sizeof derivations[0]; ++i) {
    if (kith_words_find(exact.name, derivations[i].name) != 0) continue;
    derivations[i].derive(scene, &exact.p);
    needs = derivations[i].needs;
  }
  KITH_TRY(kith_keys_read(kith_exact_keys, node, &exact)); /* what is given replaces what was derived */
  KITH_TRY(check_needs(needs, &exact, node));
  scene->exact.ops = kith_exact_find(exact.name);
  if (scene->exact.ops == NULL)
    KITH_FAIL(INTERNAL, "the exact solution %s is listed and not found", exact.name);
  scene->exact.parameters = exact.p;
  KITH_TRY(read_window(scene, kith_config_child(node, "window")));
  return try_exact(scene, node);
}
