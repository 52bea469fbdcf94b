/* Nodes from a scene: how many each region gets, where they stand, their state. */
#include "app/initial/initial_conditions.h"

#include "app/initial/deposit.h"
#include "app/initial/lattice.h"
#include "app/initial/region.h"

#include <string.h>

/* A region and the lattice that fills it. */
struct plan {
  const struct kith_region *region; /* borrowed */
  struct kith_box box;
  struct kith_lattice_fit fit;
  double mean_density; /* 0 where `spacing` is given: not used */
  kith_index first, count;
};

struct setup {
  const struct kith_scene *scene;
  struct kith_nodes *nodes;
  struct kith_hydro *hydro;
  struct plan *plan;         /* one per region, owned */
  struct kith_field *wanted; /* pressure of nodes in equilibrium, NaN for the others; NULL: no such region */
  double neighbors;
};

static kith_status fit_plan(struct plan *plan, double spacing) {
  if (kith_lattice_fit(&plan->fit, plan->region->lattice, &plan->box, spacing) == KITH_OK) return KITH_OK;
  KITH_FAIL_AT(&plan->region->location, "region: %s", kith_failure());
}

/* The densest of the regions whose spacing is not given, or -1. */
static int densest(const struct setup *s) {
  int best = -1;
  for (int k = 0; k < s->scene->n_regions; ++k)
    if (s->plan[k].region->spacing == 0 && (best < 0 || s->plan[k].mean_density > s->plan[best].mean_density))
      best = k;
  return best;
}

static kith_status measure_regions(struct setup *s) {
  for (int k = 0; k < s->scene->n_regions; ++k) {
    struct plan *plan = &s->plan[k];
    plan->region = &s->scene->region[k];
    KITH_TRY(kith_region_box(plan->region, &s->scene->domain, &plan->box));
    if (plan->region->spacing > 0)
      KITH_TRY(fit_plan(plan, plan->region->spacing));
    else
      KITH_TRY(kith_region_mean_density(plan->region, &plan->box, &plan->mean_density));
  }
  return KITH_OK;
}

/* Equal mass: the volume of a node in the other regions follows from the mass that a node got in the densest
 * one, so that the rounding of cells there does not count twice. */
static kith_status fit_lattices(struct setup *s) {
  const int d = densest(s);
  if (d < 0) return KITH_OK;
  KITH_TRY(fit_plan(&s->plan[d], 1 / s->scene->resolution));
  for (int k = 0; k < s->scene->n_regions; ++k) {
    struct plan *plan = &s->plan[k];
    if (k == d || plan->region->spacing > 0) continue;
    if (s->scene->arrangement == KITH_EQUAL_SPACING) {
      KITH_TRY(fit_plan(plan, 1 / s->scene->resolution));
      continue;
    }
    const double volume = s->plan[d].fit.site_volume * s->plan[d].mean_density / plan->mean_density;
    KITH_TRY(fit_plan(plan, pow(volume, 1.0 / NDIM)));
    if (kith_lattice_balance(&plan->fit, volume) != KITH_OK)
      KITH_FAIL_AT(&plan->region->location, "region: %s", kith_failure());
  }
  return KITH_OK;
}

/* No other region holds this site. */
static kith_status check_alone(const struct setup *s, const struct plan *plan, const double *x) {
  for (int k = 0; k < s->scene->n_regions; ++k) {
    const struct kith_region *other = s->plan[k].region;
    if (other == plan->region) continue;
    bool holds;
    KITH_TRY(kith_region_holds(other, x, &holds));
    if (!holds) continue;
    char text[KITH_POINT_TEXT];
    KITH_FAIL_AT(&plan->region->location, "region: overlaps the region of line %d, at %s",
                 other->location.line, kith_point_text(text, x));
  }
  return KITH_OK;
}

/* Moves *site on to the next one that the region holds; to the number of sites if there is none. */
static kith_status next_site(const struct plan *plan, int64_t *site, double *x) {
  for (bool holds = false; *site < plan->fit.sites; ++*site) {
    kith_lattice_site(&plan->fit, *site, x);
    KITH_TRY(kith_region_holds(plan->region, x, &holds));
    if (holds) break;
  }
  return KITH_OK;
}

static kith_status count_region(const struct setup *s, struct plan *plan) {
  double x[NDIM];
  plan->count = 0;
  for (int64_t site = 0;; ++site, ++plan->count) {
    KITH_TRY(next_site(plan, &site, x));
    if (site == plan->fit.sites) break;
    KITH_TRY(check_alone(s, plan, x));
  }
  if (plan->count == 0) KITH_FAIL_AT(&plan->region->location, "region: it holds no node");
  return KITH_OK;
}

static kith_status count_nodes(struct setup *s) {
  int64_t sites = 0, total = 0;
  for (int k = 0; k < s->scene->n_regions; ++k) sites += s->plan[k].fit.sites;
  if (sites > KITH_MAX_SITES)
    KITH_FAIL(BAD_INPUT, "the regions need %.3g nodes: more than the %.0e allowed", (double)sites,
              (double)KITH_MAX_SITES);
  for (int k = 0; k < s->scene->n_regions; ++k) {
    KITH_TRY(count_region(s, &s->plan[k]));
    total += s->plan[k].count;
  }
  if (total == 0) KITH_FAIL(BAD_INPUT, "the scene has no node: it has no region");
  return KITH_OK;
}

/* Reserves memory for all nodes, then appends them list by list, so that no list is moved. */
static kith_status append_nodes(struct setup *s) {
  kith_index total = 0;
  for (int k = 0; k < s->scene->n_regions; ++k) total += s->plan[k].count;
  KITH_TRY(kith_nodes_grow(s->nodes, total));
  for (int list = 0; list < s->scene->n_materials; ++list)
    for (int k = 0; k < s->scene->n_regions; ++k)
      if (s->plan[k].region->material == list)
        KITH_TRY(kith_nodes_append(s->nodes, list, s->plan[k].count, &s->plan[k].first));
  return KITH_OK;
}

static kith_status fill_node(const struct setup *s, const struct plan *plan, kith_index i, double *x) {
  const struct kith_region *region = plan->region;
  const double spacing = pow(plan->fit.site_volume, 1.0 / NDIM);
  double volume = plan->fit.site_volume, stretch;
  struct kith_region_state state;
  if (region->jitter > 0) kith_lattice_jitter(&plan->fit, region->jitter * spacing, region->seed, i, x);
  KITH_TRY(kith_region_displace(region, &s->scene->domain, 1e-3 * spacing, x, &stretch));
  volume *= stretch;
  KITH_TRY(kith_region_state_at(region, &s->scene->material[region->material], x, &state));
  for (int a = 0; a < NDIM; ++a) {
    s->nodes->position->f64[i * NDIM + a] = x[a];
    s->hydro->velocity->f64[i * NDIM + a] = state.velocity[a];
  }
  s->nodes->id->i64[i] = i;
  s->nodes->support->f64[i] = pow(s->neighbors / kith_ball() * volume, 1.0 / NDIM);
  s->hydro->mass->f64[i] = state.density * volume;
  s->hydro->density->f64[i] = state.density;
  s->hydro->energy->f64[i] = state.energy;
  if (s->wanted != NULL) s->wanted->f64[i] = region->equilibrium ? state.pressure : NAN;
  return KITH_OK;
}

static kith_status fill_region(const struct setup *s, const struct plan *plan) {
  double x[NDIM];
  int64_t site = 0;
  for (kith_index i = 0; i < plan->count; ++i, ++site) {
    KITH_TRY(next_site(plan, &site, x));
    KITH_TRY(fill_node(s, plan, plan->first + i, x));
  }
  return KITH_OK;
}

/* Barriers are a field of their own: their ghosts are barriers too. Barriers are frozen. */
static kith_status mark_frozen(const struct setup *s, uint8_t **frozen) {
  static const struct kith_field_spec spec = {"barrier", KITH_SCALAR, KITH_U8, KITH_STATE, NULL, "1: a wall"};
  bool any_barrier = false, any_frozen = false;
  struct kith_field *barrier = NULL;
  for (int k = 0; k < s->scene->n_regions; ++k) {
    any_barrier = any_barrier || s->plan[k].region->barrier;
    any_frozen = any_frozen || s->plan[k].region->frozen;
  }
  if (any_barrier) KITH_TRY(kith_nodes_field(s->nodes, &spec, &barrier));
  if (any_barrier || any_frozen) KITH_TRY(kith_resize(frozen, 0, (size_t)s->nodes->n_internal, 1));
  for (int k = 0; k < s->scene->n_regions && *frozen != NULL; ++k) {
    const struct plan *plan = &s->plan[k];
    memset(*frozen + plan->first, plan->region->frozen || plan->region->barrier, (size_t)plan->count);
    if (barrier != NULL) memset(barrier->u8 + plan->first, plan->region->barrier, (size_t)plan->count);
  }
  return KITH_OK;
}

bool kith_initial_conditions_pending(const struct kith_scene *scene) {
  bool waits = false;
  for (int k = 0; k < scene->n_regions; ++k) waits = waits || scene->region[k].equilibrium;
  return waits;
}

static const struct kith_field_spec wanted_pressure = {
    "wanted_pressure", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "initial pressure of regions in equilibrium"};

static kith_status deposit_all(const struct kith_scene *scene, const struct kith_hydro *hydro) {
  for (int k = 0; k < scene->n_deposits; ++k) KITH_TRY(kith_deposit_add(&scene->deposit[k], scene, hydro));
  return KITH_OK;
}

kith_status kith_initial_conditions_equilibrium(const struct kith_scene *scene,
                                                const struct kith_hydro *hydro) {
  const struct kith_field *wanted = kith_nodes_field_named(hydro->nodes, wanted_pressure.name);
  for (kith_index i = 0; i < hydro->nodes->n_internal; ++i) {
    const struct kith_material *material = &hydro->material[hydro->nodes->list->u8[i]];
    const double pressure = wanted->f64[i];
    if (isnan(pressure)) continue;
    hydro->energy->f64[i] = material->eos->energy(material->settings, hydro->density->f64[i], pressure);
  }
  return deposit_all(scene, hydro);
}

static kith_status create_nodes(struct setup *s, struct kith_nodes **nodes) {
  const char *names[KITH_MAX_LISTS];
  for (int list = 0; list < s->scene->n_materials; ++list) names[list] = s->scene->material_name[list];
  KITH_TRY(kith_nodes_create(nodes, s->scene->n_materials, names));
  s->nodes = *nodes;
  KITH_TRY(kith_hydro_init(s->hydro, s->nodes));
  if (kith_initial_conditions_pending(s->scene))
    KITH_TRY(kith_nodes_field(s->nodes, &wanted_pressure, &s->wanted));
  for (int list = 0; list < s->scene->n_materials; ++list)
    s->hydro->material[list] = s->scene->material[list];
  for (int a = 0; a < NDIM; ++a)
    s->hydro->center[a] = s->scene->external_force.mass > 0 ? s->scene->external_force.center[a]
                                                            : s->scene->external_force.origin[a];
  for (int a = 0; a < NDIM; ++a) s->hydro->wall[a] = s->scene->boundary[a].velocity;
  s->hydro->external_force = s->scene->external_force;
  return KITH_OK;
}

static kith_status build(struct setup *s, struct kith_nodes **nodes, uint8_t **frozen) {
  KITH_TRY(kith_resize(&s->plan, 0, (size_t)KITH_MAX(s->scene->n_regions, 1), sizeof *s->plan));
  KITH_TRY(measure_regions(s));
  KITH_TRY(fit_lattices(s));
  KITH_TRY(count_nodes(s));
  KITH_TRY(create_nodes(s, nodes));
  KITH_TRY(append_nodes(s));
  for (int k = 0; k < s->scene->n_regions; ++k) KITH_TRY(fill_region(s, &s->plan[k]));
  s->nodes->positions += 1;
  KITH_TRY(mark_frozen(s, frozen));
  if (!kith_initial_conditions_pending(s->scene)) KITH_TRY(deposit_all(s->scene, s->hydro));
  return KITH_OK;
}

kith_status kith_initial_conditions(struct kith_nodes **nodes, struct kith_hydro *hydro,
                                    const struct kith_scene *scene, double neighbors, uint8_t **frozen) {
  *nodes = NULL;
  *frozen = NULL;
  struct setup s = {.scene = scene, .hydro = hydro, .neighbors = neighbors};
  const kith_status status = build(&s, nodes, frozen);
  kith_free(&s.plan);
  if (status == KITH_OK) return KITH_OK;
  kith_free(frozen);
  kith_nodes_destroy(nodes);
  return status;
}
