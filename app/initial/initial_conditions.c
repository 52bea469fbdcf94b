/* Nodes from a scene: how many each region gets, where they stand, and their state. */
#include "app/initial/initial_conditions.h"

#include <string.h>
#include <unistd.h>
#include "app/cli/text.h"
#include "app/initial/deposits.h"
#include "app/initial/lattice.h"
#include "app/initial/region.h"

kith_status kith_initial_conditions_inflow(const void *scene, const struct kith_boundary *b, int list,
                                           const double *x, double time, struct kith_flow_state *out) {
  const struct kith_scene *s = scene;
  const struct kith_flow_settings *flow = b->settings;
  struct kith_region_state state;
  double at[NDIM];
  memcpy(at, x, sizeof at);
  at[b->axis] = b->at_upper ? b->upper : b->lower;
  struct kith_expression *const formula[] = {flow->density, flow->pressure, flow->energy};
  for (int k = 0; k < 3; ++k) kith_expression_time(formula[k], time);
  for (int a = 0; a < NDIM; ++a) kith_expression_time(flow->velocity[a], time);
  KITH_TRY(
      kith_region_inflow_state(flow, &s->material[list], kith_scene_boundary_node(s, b->axis), at, &state));
  *out = (struct kith_flow_state){.density = state.density, .energy = state.energy};
  memcpy(out->velocity, state.velocity, sizeof out->velocity);
  return KITH_OK;
}

/* A region, or a zone behind a face of it, and the lattice that fills it. */
struct plan {
  const struct kith_region *region; /* borrowed */
  int axis, side; /* of the face behind which a zone continues the lattice; axis < 0: no zone */
  struct kith_box box;
  struct kith_lattice_fit fit;
  double mean_density; /* 0: not used, since `spacing` is given */
  int64_t begin, end;  /* the sites that this rank visits */
  int64_t id, nodes;   /* id of its first node here; nodes on all ranks */
  kith_index first, count;
};

struct setup {
  const struct kith_scene *scene;
  struct kith_ranks *ranks;
  struct kith_nodes *nodes;
  struct kith_hydro *hydro;
  struct plan *plan; /* one per region, then one per zone, owned */
  int n_plans;
  struct kith_field *damage; /* NULL: no region has any */
  struct kith_field *wanted; /* pressure of nodes in equilibrium, NaN for the others; NULL: no such region */
  double neighbors;
  double (*zone)[2][NDIM];   /* by axis and side: shift from a zone to what continues it */
  struct kith_field *volume; /* of nodes, for zones whose state changes; NULL: there are none */
};

/* Fits the lattice. volume: of a node, for which the number of cells is balanced; 0: it is not. */
static kith_status fit_lattice(struct plan *plan, double spacing, double volume) {
  kith_status status = kith_lattice_fit(&plan->fit, plan->region->lattice, &plan->box, spacing);
  if (status == KITH_OK && volume > 0) status = kith_lattice_balance(&plan->fit, volume);
  return status == KITH_OK ? KITH_OK : kith_config_fail(plan->region->node, NULL, "%s", kith_failure());
}

/* Fits the lattices of all regions. Equal mass: the volume of a node in the other regions follows from the
 * mass that a node got in the densest one, so that the rounding of cells there does not count twice. */
static kith_status fit_lattices(struct setup *s) {
  const double finest = 1 / s->scene->resolution;
  struct plan *densest = NULL; /* of the regions whose spacing is not given */
  for (int k = 0; k < s->scene->n_regions; ++k) {
    struct plan *plan = &s->plan[s->n_plans++];
    plan->region = &s->scene->region[k], plan->axis = -1;
    KITH_TRY(kith_region_box(plan->region, &s->scene->domain, &plan->box));
    if (plan->region->spacing > 0) continue;
    KITH_TRY(kith_region_mean_density(plan->region, &plan->box, &plan->mean_density));
    if (densest == NULL || plan->mean_density > densest->mean_density) densest = plan;
  }
  if (densest != NULL) KITH_TRY(fit_lattice(densest, finest, 0));
  for (int k = 0; k < s->scene->n_regions; ++k) {
    struct plan *plan = &s->plan[k];
    if (plan == densest) continue;
    const bool given = plan->region->spacing > 0;
    double spacing = given ? plan->region->spacing : finest, volume = 0;
    if (!given && s->scene->arrangement == KITH_EQUAL_MASS) {
      volume = densest->fit.site_volume * densest->mean_density / plan->mean_density;
      spacing = kith_root_dim(volume);
    }
    KITH_TRY(fit_lattice(plan, spacing, volume));
  }
  return KITH_OK;
}

/* --- zones behind faces that gas passes: the lattices of the regions at the face go on --- */

static kith_status refused_flow(const struct kith_scene *scene, int axis, const char *why, double value) {
  return kith_config_fail(kith_scene_boundary_node(scene, axis), NULL, why, value);
}

/* Moves x to where the state of its site in a zone is taken: at the face, inside of the region. */
static void to_face(const struct setup *s, const struct plan *plan, double *x) {
  const double *face = s->scene->boundary[plan->axis].face;
  x[plan->axis] = plan->side == 0 ? face[0] : nextafter(face[1], face[0]);
}

/* Checks the state at a face. An inflow must lead inwards; along the face only where the axis repeats or is
 * open upstream. Gas must not leave faster than sound if a pressure is to come back to it. */
static kith_status check_flow(const struct setup *s, const struct plan *plan,
                              const struct kith_region_state *state) {
  const struct kith_scene *scene = s->scene;
  const int a = plan->axis;
  const double inwards = plan->side == 0 ? state->velocity[a] : -state->velocity[a];
  const struct kith_flow_settings *flow = scene->boundary[a].settings[plan->side];
  double pressure, sound;
  kith_material_state(&scene->material[plan->region->material], 1, &state->density, &state->energy, &pressure,
                      &sound);
  if (flow->pressure_far > 0 && -inwards > sound)
    return refused_flow(
        scene, a,
        "gas leaves at Mach %g, faster than an outflow with pressure_far can take: no pressure "
        "reaches it from behind",
        -inwards / sound);
  if (scene->boundary[a].side[plan->side]->leaves) return KITH_OK;
  if (!(inwards > 0))
    return refused_flow(scene, a, "an inflow whose velocity into the domain is %g: nothing enters", inwards);
  for (int b = 0; b < NDIM; ++b)
    if (b != a && !(scene->period[b] > 0) && fabs(state->velocity[b]) > 1e-12 * inwards &&
        scene->boundary[b].side[state->velocity[b] > 0 ? 0 : 1] != NULL)
      return refused_flow(scene, a,
                          "a velocity of %g along the face of an inflow comes out of a wall beside it",
                          state->velocity[b]);
  return KITH_OK;
}

/* Finds the state of a zone: at its face, as the inflow says or as in the region. */
static kith_status zone_state(const struct setup *s, const struct plan *plan, const double *x,
                              struct kith_region_state *state) {
  const struct kith_flow_settings *flow = s->scene->boundary[plan->axis].settings[plan->side];
  const struct kith_material *material = &s->scene->material[plan->region->material];
  double at[NDIM];
  memcpy(at, x, sizeof at);
  to_face(s, plan, at);
  KITH_TRY(flow->density != NULL
               ? kith_region_inflow_state(flow, material, kith_scene_boundary_node(s->scene, plan->axis), at,
                                          state)
               : kith_region_state(plan->region, material, at, state));
  return kith_region_stays(plan->region) ? KITH_OK : check_flow(s, plan, state);
}

/* Slants the zone of gas that enters at an angle, so that it does not come through walls beside it: along
 * axes that do not repeat, sites lie upstream of where they enter. */
static kith_status slant_zone(const struct setup *s, const struct plan *zone) {
  struct kith_region_state state;
  double middle[NDIM], *shift = s->zone[zone->axis][zone->side];
  for (int a = 0; a < NDIM; ++a) middle[a] = 0.5 * (zone->box.lower[a] + zone->box.upper[a]);
  KITH_TRY(zone_state(s, zone, middle, &state));
  for (int b = 0; b < NDIM; ++b)
    if (NDIM > 1 && b != zone->axis && !(s->scene->period[b] > 0))
      shift[b] = shift[zone->axis] * state.velocity[b] / state.velocity[zone->axis];
  return KITH_OK;
}

/* Adds the zone behind a region that reaches the face: whole cells, to the depth that the settings want. */
static kith_status add_zone(struct setup *s, const struct plan *from, int axis, int side) {
  const struct kith_flow_settings *flow = s->scene->boundary[axis].settings[side];
  const double face = s->scene->boundary[axis].face[side],
               length = from->box.upper[axis] - from->box.lower[axis],
               cell = length / (double)from->fit.cells[axis],
               support = kith_root_dim(s->neighbors / kith_ball() * from->fit.site_volume);
  const double inside = side == 0 ? from->box.lower[axis] - face : face - from->box.upper[axis];
  if (inside < -1e-9 * cell)
    return kith_config_fail(from->region->node, NULL, "reaches %g behind the face of the %s", -inside,
                            s->scene->boundary[axis].side[side]->name);
  if (inside > 1e-9 * cell) return KITH_OK;
  struct plan *zone = &s->plan[s->n_plans++];
  *zone = *from;
  zone->axis = axis, zone->side = side;
  const bool enters = s->scene->boundary[axis].side[side]->enters, still = kith_region_stays(from->region);
  const int64_t cells = (int64_t)ceil((still && !enters ? 0.5 : 1) * flow->depth * support / cell);
  const double depth = (double)cells * cell;
  zone->fit.sites = from->fit.sites / from->fit.cells[axis] * cells;
  zone->fit.cells[axis] = cells;
  zone->fit.box.lower[axis] = side == 0 ? face - depth : face;
  zone->fit.box.upper[axis] = side == 0 ? face : face + depth;
  return KITH_OK;
}

/* Stores the depth of a zone that holds nodes, the same for all regions at an inflow, and slants the zone. */
static kith_status join_zone(const struct setup *s, const struct plan *zone) {
  const struct plan *from = &s->plan[zone->region - s->scene->region];
  const int axis = zone->axis, side = zone->side;
  const bool enters = s->scene->boundary[axis].side[side]->enters;
  const double cell = (from->box.upper[axis] - from->box.lower[axis]) / (double)from->fit.cells[axis],
               depth = (double)zone->fit.cells[axis] * cell;
  double *known = &s->zone[axis][side][axis];
  if (enters && *known != 0 && fabs(fabs(*known) - depth) > 1e-9 * cell)
    return refused_flow(s->scene, axis,
                        "regions with different lattices meet at the face: one has cells of %g, and layers "
                        "could not enter as a whole; give them one spacing",
                        cell);
  *known = (side == 0 ? -1 : 1) * fmax(fabs(*known), depth);
  return enters && !kith_region_stays(zone->region) ? slant_zone(s, zone) : KITH_OK;
}

static kith_status add_zones(struct setup *s) {
  for (int a = 0; a < NDIM; ++a)
    for (int side = 0; side < 2; ++side) {
      if (!kith_boundary_passes(s->scene->boundary[a].side[side])) continue;
      for (int k = 0; k < s->scene->n_regions; ++k) KITH_TRY(add_zone(s, &s->plan[k], a, side));
    }
  return KITH_OK;
}

/* Checks that no other region holds this site. */
static kith_status check_alone(const struct setup *s, const struct plan *plan, const double *x) {
  for (int k = 0; k < s->scene->n_regions; ++k) {
    const struct kith_region *other = s->plan[k].region;
    if (other == plan->region) continue;
    bool holds;
    KITH_TRY(kith_region_holds(other, x, &holds));
    if (!holds) continue;
    return kith_config_fail(plan->region->node, NULL, "overlaps the region of line %d, at " KITH_PLACE,
                            other->node->location.line, KITH_COORDINATES(x));
  }
  return KITH_OK;
}

static void slant(const struct setup *s, const struct plan *plan, double *x) {
  const double *shift = s->zone[plan->axis][plan->side];
  double at[NDIM];
  memcpy(at, x, sizeof at);
  to_face(s, plan, at);
  const double part = (x[plan->axis] - at[plan->axis]) / shift[plan->axis];
  for (int b = 0; b < NDIM; ++b)
    if (b != plan->axis) x[b] += part * shift[b];
}

/* Sets node i of this rank, at site x. id: its number in the whole scene. */
static kith_status fill_node(const struct setup *s, const struct plan *plan, kith_index i, int64_t id,
                             double *x) {
  const struct kith_region *region = plan->region;
  const double spacing = kith_root_dim(plan->fit.site_volume);
  const bool zone = plan->axis >= 0;
  double volume = plan->fit.site_volume, stretch = 1;
  struct kith_region_state state;
  if (region->jitter > 0 && !zone)
    kith_lattice_jitter(&plan->fit, region->jitter * spacing, region->seed, id, x);
  if (!zone) KITH_TRY(kith_region_displace(region, &s->scene->domain, 1e-3 * spacing, x, &stretch));
  volume *= stretch;
  KITH_TRY(zone ? zone_state(s, plan, x, &state)
                : kith_region_state(region, &s->scene->material[region->material], x, &state));
  for (int a = 0; a < NDIM; ++a) {
    s->nodes->position->f64[(size_t)i * NDIM + (size_t)a] = x[a];
    s->hydro->velocity->f64[(size_t)i * NDIM + (size_t)a] = state.velocity[a];
  }
  s->nodes->id->i64[i] = id;
  s->nodes->support->f64[i] = kith_root_dim(s->neighbors / kith_ball() * volume);
  s->hydro->mass->f64[i] = state.density * volume;
  s->hydro->density->f64[i] = state.density;
  s->hydro->energy->f64[i] = state.energy;
  if (s->volume != NULL) s->volume->f64[i] = volume;
  if (s->damage != NULL) KITH_TRY(kith_region_damage(region, x, &s->damage->f64[i]));
  if (s->wanted != NULL) s->wanted->f64[i] = region->equilibrium ? state.pressure : NAN;
  return KITH_OK;
}

/* Is each site of the box a node of this region and of no other? Then sites need not be tested. */
static bool fills_box(const struct setup *s, const struct plan *plan) {
  bool alone = plan->axis < 0 && plan->region->where.inside == NULL;
  for (int k = 0; k < s->scene->n_regions && alone; ++k) {
    const struct plan *other = &s->plan[k];
    bool apart = other->region == plan->region;
    for (int a = 0; a < NDIM; ++a)
      apart = apart || other->box.upper[a] <= plan->box.lower[a] || plan->box.upper[a] <= other->box.lower[a];
    alone = apart;
  }
  return alone;
}

/* Counts the sites that the region holds, and no other region may hold. fill: makes them its nodes. */
static kith_status visit_sites(const struct setup *s, struct plan *plan, bool fill) {
  const bool all = fills_box(s, plan);
  double x[NDIM], at[NDIM];
  bool holds = true;
  plan->count = all && !fill ? (kith_index)(plan->end - plan->begin) : 0;
  for (int64_t site = plan->begin; site < plan->end && (fill || !all); ++site) {
    kith_lattice_site(&plan->fit, site, x);
    memcpy(at, x, sizeof at);
    if (plan->axis >= 0) to_face(s, plan, at);
    if (!all) KITH_TRY(kith_region_holds(plan->region, at, &holds));
    if (!holds) continue;
    if (plan->axis >= 0) slant(s, plan, x);
    KITH_TRY(fill ? fill_node(s, plan, plan->first + plan->count, plan->id + plan->count, x)
                  : check_alone(s, plan, at));
    ++plan->count;
  }
  return KITH_OK;
}

/* Counts the nodes in this rank's equal part of the sites. Adds to plan->id those of the ranks before. */
static kith_status count_share(const struct setup *s, struct plan *plan) {
  const int me = kith_ranks_rank(s->ranks), size = kith_ranks_size(s->ranks);
  const bool whole = kith_region_stays(plan->region);
  char *counts = NULL;
  plan->begin = whole ? 0 : plan->fit.sites * me / size;
  plan->end = whole ? plan->fit.sites : plan->fit.sites * (me + 1) / size;
  KITH_TRY(kith_ranks_allreduce_status(s->ranks, visit_sites(s, plan, false)));
  const int64_t mine = me == 0 || !whole ? plan->count : 0;
  KITH_TRY(kith_ranks_gather(s->ranks, &mine, sizeof mine, &counts, NULL));
  for (int r = 0; r < size; ++r) {
    const int64_t of_rank = ((const int64_t *)counts)[r];
    if (r < me && !whole) plan->id += of_rank;
    plan->nodes += of_rank;
  }
  kith_free(&counts);
  if (plan->axis < 0)
    return plan->nodes > 0
               ? KITH_OK
               : kith_config_fail(plan->region->node, NULL,
                                  "it holds no node: it is outside of the domain or thinner than a spacing%s",
                                  NDIM == 1   ? "; in 1-D y and z are 0"
                                  : NDIM == 2 ? "; in 2-D z is 0"
                                              : "");
  return plan->nodes > 0 ? join_zone(s, plan) : KITH_OK;
}

static kith_status count_nodes(const struct setup *s, int64_t *total) {
  int64_t sites = 0;
  *total = 0;
  for (int k = 0; k < s->n_plans; ++k) sites += s->plan[k].fit.sites;
  if (sites > KITH_MAX_SITES)
    return kith_config_fail(s->plan->region->node, NULL,
                            "all regions need %.3g nodes: more than the %.0e allowed", (double)sites,
                            (double)KITH_MAX_SITES);
  for (int k = 0; k < s->n_plans; ++k) {
    KITH_TRY(count_share(s, &s->plan[k]));
    *total += s->plan[k].nodes;
  }
  for (int a = 0; a < NDIM; ++a)
    for (int side = 0; side < 2; ++side)
      if (kith_boundary_passes(s->scene->boundary[a].side[side]) && s->zone[a][side][a] == 0)
        return refused_flow(s->scene, a, "no region reaches the face that gas passes", 0);
  return KITH_OK;
}

/* Checks that the memory of this computer is enough for the ranks that run on it. Counted are rows, fields,
 * and twice as much as the fields for the search, the package and packed nodes, which is less than a run
 * takes (sph takes 1.1 to 1.6 times as much). */
static kith_status check_memory(const struct setup *s, int64_t total) {
  size_t each = 0;
  char need[32], there[32];
  for (int f = 0; f < s->nodes->n_fields; ++f) each += kith_field_node_size(s->nodes->fields[f]);
  const double part = (double)kith_ranks_on_this_machine(s->ranks) / kith_ranks_size(s->ranks),
               rows = ceil(s->neighbors) * sizeof(kith_index),
               bytes = (double)total * (3 * (double)each + rows) * part,
               memory = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
  if (bytes <= memory) return KITH_OK;
  return kith_config_fail(s->plan->region->node, NULL,
                          "all regions have %lld nodes, which take more than %s of memory, and there are %s: "
                          "set a lower resolution",
                          (long long)total, kith_text_bytes(need, bytes), kith_text_bytes(there, memory));
}

/* Appends the nodes list by list, so that none is moved and ids ascend. */
static kith_status append_nodes(const struct setup *s, int64_t total) {
  int64_t id = 0;
  kith_index mine = 0;
  KITH_TRY(check_memory(s, total));
  for (int k = 0; k < s->n_plans; ++k) mine += s->plan[k].count;
  KITH_TRY(kith_nodes_grow(s->nodes, mine, 0));
  for (int list = 0; list < s->scene->n_materials; ++list)
    for (int k = 0; k < s->n_plans; ++k) {
      if (s->plan[k].region->material != list) continue;
      KITH_TRY(kith_nodes_append(s->nodes, list, s->plan[k].count, &s->plan[k].first));
      s->plan[k].id += id;
      id += s->plan[k].nodes;
    }
  return KITH_OK;
}

/* Flags zones, frozen nodes and barriers. Barriers are frozen; their field makes ghosts barriers too. */
static kith_status flag_nodes(const struct setup *s, uint8_t **frozen) {
  static const struct kith_field_spec spec = {"barrier", KITH_SCALAR, KITH_U8, KITH_STATE, NULL, "1: a wall"};
  struct kith_field *barrier;
  for (int k = 0; k < s->n_plans; ++k) {
    const struct plan *plan = &s->plan[k];
    const size_t count = (size_t)plan->count;
    const bool wall = plan->region->barrier, still = kith_region_stays(plan->region);
    if (!still && plan->axis < 0) continue;
    KITH_TRY(kith_hydro_flag(s->hydro));
    memset(s->nodes->flag->u8 + plan->first,
           wall    ? KITH_BARRIER
           : still ? KITH_FROZEN
                   : KITH_ZONE + 2 * plan->axis + plan->side,
           count);
    if (!still) continue;
    if (*frozen == NULL) KITH_TRY(kith_resize(frozen, 0, (size_t)s->nodes->n_internal, 1));
    memset(*frozen + plan->first, 1, count);
    if (!wall) continue;
    KITH_TRY(kith_nodes_field(s->nodes, &spec, &barrier));
    memset(barrier->u8 + plan->first, 1, count);
  }
  return KITH_OK;
}

static const struct kith_field_spec wanted_pressure = {
    "wanted_pressure", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "initial pressure of regions in equilibrium"};

kith_status kith_initial_conditions_equilibrium(const struct kith_scene *scene, struct kith_hydro *hydro) {
  const struct kith_field *wanted = kith_nodes_field_named(hydro->nodes, wanted_pressure.name);
  for (kith_index i = 0; i < hydro->nodes->n_internal; ++i) {
    const struct kith_material *material = &hydro->material[hydro->nodes->list->u8[i]];
    const double pressure = wanted->f64[i];
    wanted->f64[i] = 0; /* a checkpoint with steps of nodes has this field, and a restart refuses NaN */
    if (isnan(pressure)) continue;
    hydro->energy->f64[i] = kith_material_energy(material, hydro->density->f64[i], pressure);
  }
  return kith_deposits_add(scene, hydro, 0);
}

static const struct kith_field_spec damage_spec = {
    "damage", KITH_SCALAR, KITH_F64, KITH_STATE, "Damage", "part of heat and momentum that does not pass"};

static const struct kith_field_spec zone_volume = {
    KITH_ZONE_VOLUME, KITH_SCALAR, KITH_F64, KITH_STATE, NULL, "of a site of the lattice that enters"};

static kith_status create_nodes(struct setup *s, struct kith_nodes **nodes) {
  const char *names[KITH_MAX_LISTS];
  for (int list = 0; list < s->scene->n_materials; ++list) names[list] = s->scene->material_name[list];
  KITH_TRY(kith_nodes_create(nodes, s->scene->n_materials, names));
  s->nodes = *nodes;
  s->nodes->ranks = s->ranks;
  KITH_TRY(kith_hydro_init(s->hydro, s->nodes));
  if (s->scene->equilibrium) KITH_TRY(kith_nodes_field(s->nodes, &wanted_pressure, &s->wanted));
  if (s->scene->unsteady) KITH_TRY(kith_nodes_field(s->nodes, &zone_volume, &s->volume));
  for (int k = 0; k < s->scene->n_regions; ++k)
    if (kith_region_damaged(&s->scene->region[k]))
      KITH_TRY(kith_nodes_field(s->nodes, &damage_spec, &s->damage));
  for (int list = 0; list < s->scene->n_materials; ++list)
    s->hydro->material[list] = s->scene->material[list];
  for (int a = 0; a < NDIM; ++a)
    s->hydro->center[a] = s->scene->external_force.mass > 0 ? s->scene->external_force.center[a]
                                                            : s->scene->external_force.origin[a];
  for (int a = 0; a < NDIM; ++a) s->hydro->wall[a] = s->scene->boundary[a].velocity;
  s->hydro->external_force = s->scene->external_force;
  return KITH_OK;
}

static kith_status lay_out(struct setup *s, struct kith_nodes **nodes) {
  int64_t sites = 0; /* in the regions that hold all sites of their boxes */
  KITH_TRY(kith_resize(&s->plan, 0, (size_t)KITH_MAX(s->scene->n_regions, 1) * 3, sizeof *s->plan));
  KITH_TRY(fit_lattices(s));
  KITH_TRY(add_zones(s));
  KITH_TRY(create_nodes(s, nodes));
  for (int k = 0; k < s->scene->n_regions; ++k)
    if (s->plan[k].region->where.inside == NULL) sites += s->plan[k].fit.sites;
  return check_memory(s, sites); /* before counting, which takes time for each site */
}

static kith_status build(struct setup *s, struct kith_nodes **nodes, uint8_t **frozen, int64_t *total) {
  KITH_TRY(kith_ranks_allreduce_status(s->ranks, lay_out(s, nodes)));
  KITH_TRY(count_nodes(s, total));
  KITH_TRY(kith_ranks_allreduce_status(s->ranks, append_nodes(s, *total)));
  for (int k = 0; k < s->n_plans; ++k)
    KITH_TRY(kith_ranks_allreduce_status(s->ranks, visit_sites(s, &s->plan[k], true)));
  s->nodes->positions += 1;
  KITH_TRY(kith_ranks_allreduce_status(s->ranks, flag_nodes(s, frozen)));
  return s->scene->equilibrium ? KITH_OK : kith_deposits_add(s->scene, s->hydro, 0);
}

kith_status kith_initial_conditions_outline(const struct kith_scene *scene, double *site_volume,
                                            double *sites) {
  struct setup s = {.scene = scene};
  *sites = 0;
  KITH_TRY(kith_resize(&s.plan, 0, (size_t)KITH_MAX(scene->n_regions, 1), sizeof *s.plan));
  const kith_status status = fit_lattices(&s);
  for (int k = 0; k < s.n_plans && status == KITH_OK; ++k) {
    site_volume[k] = s.plan[k].fit.site_volume;
    *sites += (double)s.plan[k].fit.sites;
  }
  kith_free(&s.plan);
  return status;
}

kith_status kith_initial_conditions(struct kith_nodes **nodes, struct kith_hydro *hydro,
                                    const struct kith_scene *scene, struct kith_ranks *ranks,
                                    double neighbors, uint8_t **frozen, double (*zone)[2][NDIM],
                                    int64_t *total) {
  *nodes = NULL;
  *frozen = NULL;
  struct setup s = {.scene = scene, .ranks = ranks, .hydro = hydro, .neighbors = neighbors, .zone = zone};
  const kith_status status = build(&s, nodes, frozen, total);
  kith_free(&s.plan);
  if (status == KITH_OK) return KITH_OK;
  kith_free(frozen);
  kith_nodes_destroy(nodes);
  return status;
}
