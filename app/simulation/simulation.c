/* The objects of a run, created from a scene. */
#include "app/simulation/simulation.h"

#include <float.h>
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "app/cli/text.h"
#include "app/initial/deposits.h"
#include "app/initial/initial_conditions.h"

static const struct kith_package_ops *package_of(const struct kith_scene *scene) {
  return kith_package_find(scene->method.package.name);
}

/* Turns the message of a package or scheme, "KEY: why", into one with the place of KEY in the scene.
 * `section`: what KEY belongs to; NULL: KEY is a path from the root. */
static kith_status refuse_setting(const struct kith_scene *scene, const char *section) {
  char message[2048];
  snprintf(message, sizeof message, "%s", kith_failure());
  char *why = strstr(message, ": ");
  if (why == NULL) return KITH_BAD_INPUT;
  *why = '\0';
  const struct kith_config_node *key =
      section != NULL ? kith_config_child(kith_config_at(scene->config, section), message)
                      : kith_config_at(scene->config, message);
  return key != NULL ? kith_config_fail(key, NULL, "%s", why + 2) : KITH_BAD_INPUT;
}

/* Initializes a package. `next`: the package after it in the list, which is initialized already. */
static kith_status make_package(struct kith_simulation *m, struct kith_package *p,
                                const struct kith_package_ops *ops, const void *settings,
                                struct kith_package *next) {
  const struct kith_scene *scene = m->scene;
  p->ops = ops;
  p->next = next;
  p->hydro = &m->hydro;
  p->kernel = m->package.kernel;
  p->neighbors = m->package.neighbors;
  p->compatible = scene->method.compatible;
  p->recompute = m->nodes->ranks != NULL && scene->partition.recompute;
  p->added_cfl = kith_scheme_find(scene->scheme.member.name)->implicit ? 0 : KITH_DIFFUSION_STABLE;
  p->settings = settings;
  p->traversal = NDIM > 1 ? KITH_TRAVERSE_PAIRS : KITH_TRAVERSE_GATHER; /* rows are short in 1-D */
  if (strcmp(scene->traversal, "pairs") == 0) p->traversal = KITH_TRAVERSE_PAIRS;
  if (strcmp(scene->traversal, "gather") == 0) p->traversal = KITH_TRAVERSE_GATHER;
  p->barrier = kith_nodes_field_named(m->nodes, "barrier");
  p->profile = m->profile;
  const kith_status status = kith_package_init(p);
  return status == KITH_BAD_INPUT ? refuse_setting(scene, NULL) : status;
}

static bool is_coupled(const struct kith_region *region) {
  return region->barrier || kith_region_damaged(region);
}
static bool any_region(const struct kith_scene *scene, bool (*is)(const struct kith_region *)) {
  bool any = false;
  for (int k = 0; k < scene->n_regions; ++k) any = any || is(&scene->region[k]);
  return any;
}

/* Links the packages: the hydro package, then those that the scene adds. If none of these couples, but some
 * region is a barrier or damaged, the coupling package comes first among the added ones. */
static kith_status make_packages(struct kith_simulation *m) {
  const struct kith_selected *hydro = &m->scene->method.package, *added = m->scene->added;
  struct kith_package *next = NULL;
  bool coupled = false;
  for (int k = m->scene->n_added - 1; k >= 0; next = &m->added[k--]) {
    KITH_TRY(make_package(m, &m->added[k], kith_added_find(added[k].name), added[k].settings, next));
    coupled = coupled || m->added[k].ops->couple != NULL;
  }
  if (!coupled && any_region(m->scene, is_coupled)) {
    struct kith_package *coupling = &m->added[m->scene->n_added];
    KITH_TRY(make_package(m, coupling, &kith_package_coupling, NULL, next));
    next = coupling;
  }
  KITH_TRY(make_package(m, &m->package, package_of(m->scene), hydro->settings, next));
  for (const struct kith_package *p = &m->package; p != NULL; p = p->next)
    kith_text_join(m->packages, sizeof m->packages, ", ", "%s", p->ops->name);
  return KITH_OK;
}

/* Adds the boundary of one side of an axis (the other is NULL), or of both. */
static kith_status add_boundary(struct kith_simulation *m, int axis, const struct kith_boundary_ops *lower,
                                const struct kith_boundary_ops *upper) {
  if (lower == NULL && upper == NULL) return KITH_OK;
  const int side = lower != NULL ? 0 : 1;
  const double *face = m->scene->boundary[axis].face;
  KITH_TRY(kith_boundaries_add(&m->boundaries, side == 0 ? lower : upper, axis, face[0], face[1],
                               lower != NULL, upper != NULL));
  struct kith_boundary *made = m->boundaries.boundary[m->boundaries.n - 1];
  made->settings = m->scene->boundary[axis].settings[side];
  memcpy(made->zone, m->zone[axis][side], sizeof made->zone);
  return KITH_OK;
}

/* Makes frozen nodes first, then faces that gas passes, then the others: so the images of an axis include
 * frozen nodes and those of the zones behind such faces. */
static kith_status make_boundaries(struct kith_simulation *m, const uint8_t *frozen) {
  m->nodes->shifts.wanted = true;
  if (frozen != NULL) {
    KITH_TRY(kith_boundaries_add(&m->boundaries, &kith_boundary_constant, 0, 0, 1, false, false));
    KITH_TRY(kith_constant_take(m->boundaries.boundary[0], m->nodes, frozen));
  }
  for (int walls = 0; walls < 2; ++walls)
    for (int a = 0; a < NDIM; ++a) {
      const struct kith_boundary_ops *const *of = m->scene->boundary[a].side;
      const bool apart = kith_scene_passes(m->scene, a);
      for (int side = 0; apart && side < 2; ++side)
        if (kith_boundary_passes(of[side]) == !walls)
          KITH_TRY(add_boundary(m, a, side == 0 ? of[0] : NULL, side == 1 ? of[1] : NULL));
      if (!apart && walls) KITH_TRY(add_boundary(m, a, of[0], of[1]));
    }
  return KITH_OK;
}

static kith_status make_integrator(struct kith_simulation *m, int64_t n_nodes, bool check) {
  const struct kith_scene *scene = m->scene;
  /* The skin of lists that are rebuilt each step only covers the change of supports within the step. */
  const double skin = kith_rebuilds_lasting(&m->rebuilds) ? 0.1 : 0.005;
  /* Culling drops ghosts that are in no row of the packages. These rows lack excluded pairs and sleeping
   * nodes, while contacts ask all nodes for all neighbors: then ghosts are kept. */
  const bool needed = scene->n_contacts > 0 && (m->excluders.n > 0 || scene->follows);
  m->integrator =
      (struct kith_integrator){.nodes = m->nodes,
                               .hydro = &m->hydro,
                               .package = &m->package,
                               .boundaries = &m->boundaries,
                               .search = m->search,
                               .connectivity = m->connectivity,
                               .rebuilds = &m->rebuilds,
                               .excluders = m->excluders.n > 0 ? m->excluders.excluder : NULL,
                               .scheme = kith_scheme_find(scene->scheme.member.name),
                               .settings = scene->scheme.member.settings,
                               .profile = m->profile,
                               .cfl = scene->scheme.cfl > 0 ? scene->scheme.cfl : package_of(scene)->cfl,
                               .fixed_dt = scene->scheme.dt,
                               .skin = scene->connectivity.skin >= 0 ? scene->connectivity.skin : skin,
                               .cull = scene->connectivity.cull && !needed,
                               .check = check,
                               .canonical = scene->reproducible,
                               .follows = scene->follows,
                               .flow = {.state = scene->unsteady ? kith_initial_conditions_inflow : NULL,
                                        .context = scene,
                                        .id_stride = n_nodes},
                               .reorder_every = scene->connectivity.reorder};
  const kith_status status = kith_integrator_init(&m->integrator);
  return status == KITH_BAD_INPUT ? refuse_setting(scene, "scheme") : status;
}

/* Returns the node of a key of the scene, or the root if it is not given. */
static const struct kith_config_node *at(const struct kith_scene *scene, const char *path) {
  const struct kith_config_node *node = kith_config_at(scene->config, path);
  return node != NULL ? node : scene->config->root;
}

/* Refuses combinations of scheme, package and boundaries. `key`: where in the scene the message points. */
static kith_status check_combination(const struct kith_simulation *m) {
#define REFUSE_IF(wrong, key, ...) \
  if (wrong) return kith_config_fail(at(s, key), NULL, __VA_ARGS__)
  const struct kith_scene *s = m->scene;
  const struct kith_scheme_ops *scheme = kith_scheme_find(s->scheme.member.name);
  const char *name = s->method.package.name;
  const struct kith_package_traits package = kith_package_traits(package_of(s), s->method.package.settings);
  const bool blocks = kith_scheme_has_blocks(scheme, s->scheme.member.settings);
  const bool recompute = s->partition.recompute; /* ghosts compute their own values between the passes */
  char no_between[64];
  snprintf(no_between, sizeof no_between, "method.%s", package.no_between != NULL ? package.no_between : "");
  bool piston = false, passes = false, couples = any_region(s, is_coupled);
  for (int k = 0; k < s->n_added; ++k) couples = couples || kith_added_find(s->added[k].name)->couple != NULL;
  for (int a = 0; a < NDIM; ++a) {
    piston = piston || s->boundary[a].velocity != 0;
    passes = passes || kith_scene_passes(s, a);
  }
  REFUSE_IF(package.uncoupled != NULL && any_region(s, kith_region_damaged), "method", "%s",
            package.uncoupled);
  REFUSE_IF(
      package.no_between != NULL && couples, no_between,
      "ellipsoids do not tell what is between two nodes, as barriers, porosity and damage require; take "
      "spheres");
  REFUSE_IF(package.no_between != NULL && s->n_added > 0, no_between,
            "conduction and viscosity would differ along the axes of ellipsoids; take spheres");
  REFUSE_IF(recompute && !package.recomputes, "partition.ghosts",
            "package %s, with these settings, does not compute values of ghosts; take exchange", name);
  REFUSE_IF(recompute && package.history != NULL, "partition.ghosts",
            "only the owner of a node keeps the history of %s; take exchange", package.history);
  REFUSE_IF(recompute && s->reproducible, "partition.ghosts",
            "what is computed again is summed in another order; reproducible runs take exchange");
  REFUSE_IF(
      s->method.compatible && scheme->thermal_only, "scheme.name",
      "%s cannot keep energy compatible: that energy follows from the kicks of each step, and this scheme "
      "needs du/dt as a function of the state; give it method.energy=thermal",
      scheme->name);
  REFUSE_IF(s->follows && blocks, "window",
            "not together with block time steps, in which gas at rest has long steps anyway: take whole, or "
            "scheme.steps=global");
  REFUSE_IF(s->follows && (scheme->retries || scheme->implicit), "window",
            "%s solves for the rates of all nodes together: take whole", scheme->name);
  REFUSE_IF(
      s->follows && s->scheme.dt > 0, "window",
      "steps must end before a signal gets farther than the neighbors that wake up, and scheme.dt may be "
      "longer: take whole, or no scheme.dt");
  REFUSE_IF(s->follows && package.history != NULL, "window", "%s changes in gas at rest, too: take whole",
            package.history);
  if (blocks || s->follows) {
    const char *key = blocks ? "scheme.steps" : "window", *take = blocks ? "global steps" : "whole";
    REFUSE_IF(
        kith_rebuilds_lasting(&m->rebuilds), "connectivity.rebuild",
        "block time steps, and window: follow, have other active nodes in each step, and need new lists: "
        "take always");
    REFUSE_IF(package.all_rows != NULL, key, "%s need the rows of all nodes: take %s", package.all_rows,
              take);
    REFUSE_IF(recompute, "partition.ghosts",
              "where not all nodes are active, ghosts have no rows; take exchange");
    REFUSE_IF(
        passes, key, "%s: take %s",
        blocks ? "block time steps do not let gas come and go" : "gas that enters or leaves is never at rest",
        take);
  }
  REFUSE_IF(s->scheme.cfl > 1 && !scheme->implicit, "scheme.cfl",
            "%g is out of range (0, 1] of %s; more is for implicit", s->scheme.cfl, scheme->name);
  REFUSE_IF(scheme->retries && package.history != NULL, "scheme.name",
            "%s has a history, and %s may reject a step after trying it", package.history, scheme->name);
  /* Rebuild policies do not know how far the images in a moving face have moved; and what goes through the
   * face within a step needs its velocity in every sum of a scheme. */
  REFUSE_IF(piston && kith_rebuilds_lasting(&m->rebuilds), "connectivity.rebuild",
            "a piston requires that neighbor lists are rebuilt always");
  REFUSE_IF(piston && scheme->thermal_only, "scheme.name",
            "%s does not know of pistons; leapfrog, rk2, cheap-rk2 and verlet do", scheme->name);
  REFUSE_IF(s->unsteady && kith_rebuilds_lasting(&m->rebuilds), "connectivity.rebuild",
            "an inflow whose state changes requires that neighbor lists are rebuilt always");
  REFUSE_IF(passes && scheme->thermal_only, "scheme.name",
            "%s does not let gas come and go; leapfrog with global steps, rk2, cheap-rk2 and verlet do",
            scheme->name);
  return KITH_OK;
#undef REFUSE_IF
}

/* Sets the excluders up with all nodes, so that what is wrong with them shows now, before the first step. */
static kith_status make_excluders(struct kith_simulation *m) {
  const struct kith_selection all = {.nodes = m->nodes};
  struct kith_excluder self = {.ops = &kith_excluder_self};
  kith_status status = kith_excluders_create(&m->excluders, m->scene->connectivity.exclude);
  if (m->excluders.n > 0) self.next = m->excluders.excluder;
  if (status == KITH_OK) status = kith_excluder_setup(&self, &all, &all);
  if (status == KITH_OK && m->excluders.n > 0) status = kith_excluder_keeps_pairs(m->excluders.excluder);
  char message[2048];
  snprintf(message, sizeof message, "%s", kith_failure());
  return status == KITH_BAD_INPUT
             ? kith_config_fail(at(m->scene, "connectivity.exclude"), NULL, "%s", message)
             : status;
}

/* Checks that powers of the largest mass, density and speed (of a node or of sound; 0 if nothing moves) stay
 * within the range of a double. */
static kith_status check_units(const struct kith_simulation *m) {
  const double *velocity = m->hydro.velocity->f64, *sound_speed = m->hydro.sound_speed->f64;
  double most[3] = {0}; /* speed, mass, density */
  for (kith_index i = 0; i < m->nodes->n_internal; ++i) {
    most[0] = fmax(most[0], sound_speed[i]);
    for (int a = 0; a < NDIM; ++a) most[0] = fmax(most[0], fabs(velocity[(size_t)i * NDIM + a]));
    most[1] = fmax(most[1], m->hydro.mass->f64[i]);
    most[2] = fmax(most[2], m->hydro.density->f64[i]);
  }
  kith_ranks_max(m->nodes->ranks, most, 3);
  const double speed = most[0], mass = most[1], density = most[2];
  if (!(mass >= 1e-100 && mass <= 1e100))
    return kith_config_fail(m->scene->config->root, "regions",
                            "nodes of mass %g: sums need units in which it is between 1e-100 and 1e100",
                            mass);
  if (speed != 0 && !kith_scene_unit_holds(speed))
    return kith_config_fail(m->scene->config->root, "regions",
                            "a velocity of %g: powers of it need units in which it is between 1e-31 and 1e31",
                            speed);
  /* These may be out of range although each unit is in it: packages multiply pairs of them, and a product
   * that is rounded to 0 raises no error. */
  const double pressure = density * speed * speed, volume = mass / density;
  const struct {
    const char *name;
    double value;
  } products[] = {
      {"density", density}, {"pressure", pressure}, {"force", pressure * volume / kith_root_dim(volume)}};
  for (int k = 0; k < (speed != 0 ? 3 : 1); ++k)
    if (!(products[k].value >= 1e-100 && products[k].value <= 1e100))
      return kith_config_fail(m->scene->config->root, "regions",
                              "a %s of about %g: squares of it need units in which it is between 1e-100 and "
                              "1e100",
                              products[k].name, products[k].value);
  return KITH_OK;
}

static kith_status check_settings(struct kith_simulation *m) {
  const char *rebuild = m->scene->connectivity.rebuild;
  const kith_status status = kith_rebuilds_create(&m->rebuilds, rebuild, m->scene->period);
  if (status == KITH_BAD_INPUT)
    return kith_config_fail(at(m->scene, "connectivity.rebuild"), NULL, "%s", kith_failure());
  KITH_TRY(status);
  return check_combination(m);
}

kith_status kith_simulation_check(const struct kith_scene *scene) {
  struct kith_simulation none = {.scene = scene};
  const kith_status status = check_settings(&none);
  kith_rebuilds_clear(&none.rebuilds);
  return status;
}

/* Makes the objects of this rank. n_nodes: nodes of the whole scene. */
static kith_status make_objects(struct kith_simulation *m, int64_t n_nodes, const uint8_t *frozen,
                                bool check) {
  KITH_TRY(make_packages(m));
  KITH_TRY(kith_search_create(&m->search, kith_search_find(m->scene->neighbor.search.name), m->nodes));
  m->search->settings = m->scene->neighbor.search.settings;
  KITH_TRY(kith_connectivity_create(&m->connectivity));
  KITH_TRY(make_excluders(m));
  KITH_TRY(make_integrator(m, n_nodes, check));
  return make_boundaries(m, frozen); /* last: frozen nodes take along all fields that there are */
}

/* Sends nodes to the ranks that own their cells; makes the decomposition and the halo. */
static kith_status distribute(struct kith_simulation *m) {
  bool periodic[NDIM];
  char partitioner[128];
  kith_scene_partitioner(m->scene, partitioner, sizeof partitioner);
  const struct kith_decomposition_options sharing = {
      partitioner, m->scene->partition.every, m->scene->partition.imbalance, m->scene->partition.cells};
  if (m->nodes->ranks == NULL) return KITH_OK;
  for (int a = 0; a < NDIM; ++a) periodic[a] = m->scene->period[a] > 0;
  KITH_TRY(kith_decomposition_create(&m->decomposition, m->nodes, &m->scene->domain, periodic, &sharing));
  m->integrator.decomposition = m->decomposition;
  KITH_TRY(kith_boundaries_add(&m->boundaries, &kith_boundary_distributed, 0, 0, 1, false, false));
  KITH_TRY(kith_halo_create(&m->halo, m->nodes->ranks, m->decomposition));
  m->boundaries.boundary[m->boundaries.n - 1]->self = m->halo;
  m->hydro.halo = m->halo;
  return KITH_OK;
}

static kith_status make(struct kith_simulation *m, struct kith_ranks *ranks, bool check) {
  uint8_t *frozen = NULL;
  int64_t n_nodes = 0;
  KITH_TRY(kith_ranks_allreduce_status(ranks, check_settings(m)));
  m->package.kernel = m->scene->method.kernel;
  m->package.neighbors = m->scene->method.neighbors;
  if (!(m->package.neighbors > 0))
    m->package.neighbors = kith_kernel_neighbors(m->package.kernel, package_of(m->scene)->spacings);
  kith_status status = kith_initial_conditions(&m->nodes, &m->hydro, m->scene, ranks, m->package.neighbors,
                                               &frozen, m->zone, &n_nodes);
  if (status == KITH_OK) kith_hydro_evaluate_eos(&m->hydro);
  if (status == KITH_OK) status = check_units(m);
  if (status == KITH_OK) {
    if (m->scene->reproducible) status = kith_nodes_number_images(m->nodes);
    if (status == KITH_OK) status = make_objects(m, n_nodes, frozen, check);
    status = kith_ranks_allreduce_status(ranks, status);
  }
  kith_free(&frozen);
  return status == KITH_OK ? kith_ranks_allreduce_status(ranks, distribute(m)) : status;
}

kith_status kith_simulation_create(struct kith_simulation **out, const struct kith_scene *scene,
                                   struct kith_ranks *ranks, struct kith_profile *profile, bool check) {
  struct kith_simulation *m = NULL;
  KITH_TRY(kith_ranks_allreduce_status(ranks, kith_resize(&m, 0, 1, sizeof *m)));
  m->scene = scene;
  m->profile = profile;
  const kith_status status = make(m, ranks, check);
  if (status != KITH_OK) {
    kith_simulation_destroy(&m);
    return status;
  }
  *out = m;
  return KITH_OK;
}

kith_status kith_simulation_start(struct kith_simulation *m) {
  const bool pending = m->scene->equilibrium;
  /* Cuts tension until the energies fit the summed densities: otherwise material could count as torn. */
  for (int l = 0; l < m->nodes->n_lists; ++l) m->hydro.material[l].cut |= pending;
  KITH_TRY(kith_integrator_start(&m->integrator));
  if (!pending) return KITH_OK;
  for (int l = 0; l < m->nodes->n_lists; ++l) m->hydro.material[l].cut = m->scene->material[l].cut;
  KITH_TRY(kith_initial_conditions_equilibrium(m->scene, &m->hydro));
  return kith_integrator_start(&m->integrator);
}

kith_status kith_simulation_step(struct kith_simulation *m, double until) {
  const double release = kith_deposits_next(m->scene, m->integrator.time);
  KITH_TRY(kith_integrator_step(&m->integrator, KITH_MIN(until, release)));
  if (m->integrator.time < release) return KITH_OK;
  KITH_TRY(kith_deposits_add(m->scene, &m->hydro, release));
  return kith_integrator_start(&m->integrator);
}

void kith_simulation_destroy(struct kith_simulation **simulation) {
  struct kith_simulation *m = *simulation;
  if (m == NULL) return;
  kith_integrator_clear(&m->integrator);
  kith_package_clear(&m->package);
  for (int k = 0; k < KITH_ADDED_PACKAGES; ++k)
    kith_package_clear(&m->added[k]); /* also those that were not linked yet */
  kith_boundaries_clear(&m->boundaries);
  kith_halo_destroy(&m->halo);
  kith_decomposition_destroy(&m->decomposition);
  kith_rebuilds_clear(&m->rebuilds);
  kith_excluders_clear(&m->excluders);
  kith_connectivity_destroy(&m->connectivity);
  kith_search_destroy(&m->search);
  kith_nodes_destroy(&m->nodes);
  kith_free(simulation);
}

void kith_simulation_bytes(const struct kith_simulation *m,
                           struct kith_bytes out[KITH_SIMULATION_STRUCTURES]) {
  const struct kith_connectivity *c = m->connectivity;
  out[0] = (struct kith_bytes){"nodes", true, kith_nodes_bytes(m->nodes)};
  out[1] = (struct kith_bytes){"search", true, kith_search_bytes(m->search)};
  out[2] = (struct kith_bytes){"connectivity", false, kith_connectivity_bytes(c)};
  out[3] = (struct kith_bytes){"package", false, kith_package_bytes(&m->package)};
  out[4] = (struct kith_bytes){"pairwise", false,
                               kith_pairwise_bytes(&c->pairs) + kith_pairwise_bytes(&c->overlap_pairs)};
  out[5] = (struct kith_bytes){"integrator", true, kith_integrator_bytes(&m->integrator)};
}

/* --- conservation --- */

struct kith_conservation_baseline kith_conservation_baseline_of(const struct kith_totals *first) {
  return (struct kith_conservation_baseline){
      .totals = *first, .kinetic_least = first->kinetic, .velocity_over_sound = first->velocity_over_sound};
}

static bool is_wall(const struct kith_boundary_ops *side) {
  return side != NULL && !side->wraps && !kith_boundary_passes(side);
}

/* Does nothing but a point mass change the momentum along this axis? */
static bool is_free(const struct kith_simulation *m, int axis) {
  return !is_wall(m->scene->boundary[axis].side[0]) && !is_wall(m->scene->boundary[axis].side[1]) &&
         m->hydro.external_force.gravity[axis] == 0;
}

static bool keeps_momentum(const struct kith_simulation *m, int axis) {
  return is_free(m, axis) && m->hydro.external_force.mass == 0;
}

int kith_simulation_momentum_axes(const struct kith_simulation *m) {
  int n = 0;
  for (int a = 0; a < NDIM; ++a) n += keeps_momentum(m, a);
  return n;
}

static bool can_turn(const struct kith_simulation *m) {
  bool can = NDIM > 1;
  for (int a = 0; a < NDIM; ++a) can = can && is_free(m, a) && !kith_scene_passes(m->scene, a);
  for (int k = 0; k < m->scene->n_regions; ++k) can = can && !kith_region_stays(&m->scene->region[k]);
  return can;
}

/* The larger of two sums m |.|, never 0. */
static double scale(double now, double then) {
  return fmax(fmax(now, then), 1e-300);
}

void kith_conservation_baseline_update(struct kith_conservation_baseline *baseline,
                                       const struct kith_simulation *simulation,
                                       const struct kith_totals *now) {
  const struct kith_totals *then = &baseline->totals;
  /* Material at rest without energy has one by rounding, as if each node moved at 1e-8 of its sound speed. */
  const double fast = fmax(now->momentum_scale, then->momentum_scale),
               least = now->mass > 0 ? DBL_EPSILON * fast * fast / now->mass : 0,
               e0 = kith_totals_energy(then),
               moved = fmax(fabs(now->work - then->work), fabs(now->through.energy)),
               e = fmax(fmax(fmax(fabs(e0), moved), now->kinetic), least);
  const double energy = fabs(kith_totals_energy(now) - e0) / (e > 0 ? e : 1);
  double momentum = 0, angular2 = 0;
  for (int a = 0; a < NDIM; ++a)
    if (keeps_momentum(simulation, a))
      momentum = fmax(momentum, fabs((now->momentum[a] - now->through.momentum[a]) -
                                     (then->momentum[a] - then->through.momentum[a])));
  for (int a = 0; a < 3; ++a)
    angular2 += (now->angular[a] - then->angular[a]) * (now->angular[a] - then->angular[a]);
  momentum /= scale(now->momentum_scale, then->momentum_scale);
  const double angular =
      can_turn(simulation) ? sqrt(angular2) / scale(now->angular_scale, then->angular_scale) : NAN;
  baseline->energy_drift = fmax(baseline->energy_drift, energy);
  baseline->momentum_drift = fmax(baseline->momentum_drift, momentum);
  baseline->angular_drift = isnan(angular) ? NAN : fmax(baseline->angular_drift, angular);
  baseline->kinetic_least = fmin(baseline->kinetic_least, now->kinetic);
  baseline->kinetic_rebound = fmax(baseline->kinetic_rebound, now->kinetic - baseline->kinetic_least);
  baseline->velocity_over_sound = fmax(baseline->velocity_over_sound, now->velocity_over_sound);
}

void kith_share_cores(const struct kith_ranks *ranks, kith_index n_nodes) {
  enum { NODES_A_THREAD = 2000 };
  const char *wanted = getenv("OMP_NUM_THREADS"); /* OpenMP ignores what is no number of threads */
  if (wanted != NULL && strtol(wanted, NULL, 10) >= 1) return;
  const int cores = (int)sysconf(_SC_NPROCESSORS_ONLN) / kith_ranks_on_this_machine(ranks);
  const int most = KITH_MIN(omp_get_num_procs(), n_nodes / NODES_A_THREAD); /* procs: cores it is bound to */
  omp_set_num_threads(KITH_MAX(1, KITH_MIN(KITH_MIN(cores, most), omp_get_thread_limit())));
}
