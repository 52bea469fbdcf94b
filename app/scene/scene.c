/* A scene: the tables of its parts, reading them in order, comparison with a checkpoint. */
#include "app/scene/scene.h"
#include "app/scene/scene_parts.h"
#include "integrator/integrator.h"
#include "lib/connectivity/list.h"
#include "lib/domain/partition/partition.h"
#include "physics/package.h"

#include <string.h>

#define IN(member) KITH_INTO(struct kith_scene, member)
#define FREE .restart_may_change = true

#define KERNEL_CHOICE(name, word, ...) "|" word
static const struct kith_param method_params[] = {
    {"package", KITH_PARAM_MEMBER, "sph", "", "hydro package (kith list package)", IN(method.package),
     .family = kith_package_member},
    {"kernel", KITH_PARAM_CHOICE, "wendland-c2", KITH_KERNEL_LIST(KERNEL_CHOICE),
     "interpolation kernel (kith list kernel)", IN(method.kernel)},
    {"neighbors", KITH_PARAM_NUMBER, "0", "[0, 1000]",
     "nodes in a support; 0: the default of the package, for the kernel", IN(method.neighbors)},
    {"energy", KITH_PARAM_CHOICE, "compatible", "thermal|compatible",
     "internal energy from its own equation, or from the work of pairs, which conserves the total",
     IN(method.compatible)},
    {0}};

/* Rows of an added package, read into a struct kith_selected. */
static const struct kith_param package_params[] = {
    {"name", KITH_PARAM_MEMBER, NULL, "", "package (kith list added)", .family = kith_added_member}, {0}};

static const struct kith_param scheme_params[] = {
    {"name", KITH_PARAM_MEMBER, "leapfrog", "", "time integration (kith list scheme)", IN(scheme.member),
     .family = kith_scheme_member},
    {"cfl", KITH_PARAM_NUMBER, "0", "[0, 1000]",
     "Courant number; 0: the default of the package; above 1 for implicit only", IN(scheme.cfl), FREE,
     .needs = "dt=0"},
    {"dt", KITH_PARAM_NUMBER, "0", "[0, inf)", "fixed step; 0: by the Courant number", IN(scheme.dt)},
    {0}};

static const struct kith_param neighbor_params[] = {
    {"search", KITH_PARAM_MEMBER, "tree", "", "neighbor search", IN(neighbor.search),
     .family = kith_search_member},
    {"storage", KITH_PARAM_CHOICE, "csr", "csr", "storage of the rows that packages read",
     IN(neighbor.storage)},
    {0}};

static const struct kith_param connectivity_params[] = {
    {"rebuild", KITH_PARAM_NAME, "always", "",
     "when neighbor lists are rebuilt: policies joined by | (kith list rebuild)", IN(connectivity.rebuild),
     .family = kith_rebuild_member},
    {"skin", KITH_PARAM_NUMBER, "", "[0, inf)",
     "how far Verlet lists reach beyond the support, as a part of it; none: 0.1", IN(connectivity.skin),
     .needs = "rebuild!=always"},
    {"cull", KITH_PARAM_BOOL, "true", "", "drop ghosts that no node needs", IN(connectivity.cull), FREE},
    {"reorder", KITH_PARAM_INTEGER, "20", "[0, inf)",
     "lifecycles between reorderings of the nodes along the curve, the first one included; 0: never",
     IN(connectivity.reorder), FREE},
    {"exclude", KITH_PARAM_NAME, "", "",
     "what are no neighbors, joined by |, with settings after a colon: materials:of=gas and=dust (kith list "
     "excluder)",
     IN(connectivity.exclude), .family = kith_excluder_member},
    {"storage", KITH_PARAM_NAME, "csr", "",
     "of the lists of probes and contacts: csr, padded:width=64, compressed (kith list storage)",
     IN(connectivity.storage), .family = kith_storage_member, FREE},
    {"contacts", KITH_PARAM_OTHER, "", "", "pairs of materials: contacts.csv tells how their nodes meet",
     KITH_BELOW(kith_contact_params, LIST), FREE},
    {0}};

static const struct kith_param partition_params[] = {
    {"name", KITH_PARAM_MEMBER, "kd", "", "partitioner (kith list partitioner)", IN(partition.member),
     .family = kith_partitioner_member, FREE},
    {"every", KITH_PARAM_INTEGER, "20", "[0, inf)",
     "rebuilds of neighbor lists between checks of the balance; 0: never", IN(partition.every), FREE},
    {"imbalance", KITH_PARAM_NUMBER, "1.05", "[1, inf)", "tolerated work of the busiest rank, over the mean",
     IN(partition.imbalance), FREE, .needs = "every!=0"},
    {"cells", KITH_PARAM_INTEGER, "256", "[1, 1000000]", "cells per rank that the partitioner distributes",
     IN(partition.cells), FREE},
    {"ghosts", KITH_PARAM_CHOICE, "exchange", "exchange|recompute",
     "how ghosts get values between passes: sent by their owners, or computed again from two "
     "layers of ghosts (not in all packages, nor if reproducible)",
     IN(partition.recompute)},
    {0}};

static const struct kith_param machine_params[] = {
    {"latency", KITH_PARAM_NUMBER, "2e-6", "[0, inf)", "seconds of a message between ranks",
     IN(machine.latency), FREE},
    {"bandwidth", KITH_PARAM_NUMBER, "1e9", "(0, inf)", "bytes a second that a rank sends",
     IN(machine.bandwidth), FREE},
    {"collective", KITH_PARAM_NUMBER, "2e-6", "[0, inf)",
     "seconds of a collective call, for each doubling of the ranks", IN(machine.collective), FREE},
    {"cores", KITH_PARAM_INTEGER, "0", "[0, inf)", "cores that the ranks share; 0: each has one",
     IN(machine.cores), FREE},
    {0}};

static const struct kith_param measure_params[] = {
#define X(name, doc) {#name, KITH_PARAM_BOOL, "false", "", doc, IN(measure.wanted[KITH_MEASURE_##name])},
    KITH_MEASURE_LIST(X)
#undef X
        {"rate", KITH_PARAM_NUMBER, "0", "[0, inf)",
         "growth rate of the mode by linear theory, drawn beside its amplitude; 0: not known",
         IN(measure.rate), FREE},
    {0}};

static const struct kith_param output_params[] = {
    {"every", KITH_PARAM_NUMBER, "0", "[0, inf)", "time between snapshots; 0: first and last only",
     IN(output.every)},
    {"plot", KITH_PARAM_OTHER, "", "",
     "true or none: a picture that suits the scene; false: no picture; a map: this picture",
     KITH_BELOW(kith_picture_params, MAP)},
    {"checkpoint", KITH_PARAM_INTEGER, "0", "[0, inf)", "steps between checkpoints; 0: by time only",
     IN(output.checkpoint)},
    {"checkpoint_minutes", KITH_PARAM_NUMBER, "15", "[0, inf)",
     "minutes between checkpoints, on the clock; 0: by steps only", IN(output.checkpoint_minutes)},
    {"checkpoint_at_end", KITH_PARAM_BOOL, "false", "", "one more checkpoint after the last step",
     IN(output.checkpoint_at_end)},
    {0}};

static const struct kith_param scene_params[] = {
    {"base", KITH_PARAM_OTHER, "", "",
     "another scene file to start from; the keys that follow replace its own, and may have dots",
     .params = NULL, FREE},
    {"scene", KITH_PARAM_NAME, "", "", "name of the scene; none: that of the file", IN(name), FREE},
    {KITH_DIMENSION_PARAM, IN(dimension)},
    {"resolution", KITH_PARAM_NUMBER, NULL, "(0, inf)", "nodes per unit length in the densest region",
     IN(resolution)},
    {"arrangement", KITH_PARAM_CHOICE, "equal-mass", "equal-mass|equal-spacing",
     "whether the nodes of all regions have the same mass or the same spacing", IN(arrangement)},
    {"domain", KITH_PARAM_MAP, NULL, "", "the box that regions fill", KITH_BELOW(kith_domain_params, MAP)},
    {"boundaries", KITH_PARAM_MAP, "", "", "what is beyond each face",
     KITH_BELOW(kith_boundaries_params, MAP)},
    {"materials", KITH_PARAM_OTHER, NULL, "", "the materials by name; the nodes of each form a node list",
     KITH_BELOW(kith_materials_params, NAMED)},
    {"gravity", KITH_PARAM_VECTOR, "[0, 0, 0]", "", "uniform acceleration, not along periodic axes",
     IN(external_force.gravity)},
    {"potential", KITH_PARAM_MAP, "", "", "gravity of a point mass", KITH_BELOW(kith_potential_params, MAP)},
    {"regions", KITH_PARAM_OTHER, NULL, "", "what fills the domain", KITH_BELOW(kith_region_params, LIST)},
    {"energy", KITH_PARAM_OTHER, "", "", "blast energies: one map, or a list",
     KITH_BELOW(kith_deposit_params, LIST)},
    {"method", KITH_PARAM_MAP, "", "", "hydrodynamics", KITH_BELOW(method_params, MAP)},
    {"packages", KITH_PARAM_OTHER, "", "", "what acts on top of the hydro package, in this order",
     KITH_BELOW(package_params, LIST)},
    {"scheme", KITH_PARAM_MAP, "", "", "time integration", KITH_BELOW(scheme_params, MAP)},
    {"neighbor", KITH_PARAM_MAP, "", "", "neighbor search", KITH_BELOW(neighbor_params, MAP), FREE},
    {"connectivity", KITH_PARAM_MAP, "", "", "neighbor lists", KITH_BELOW(connectivity_params, MAP)},
    {"reproducible", KITH_PARAM_BOOL, "false", "",
     "bitwise identical results for any number of ranks and threads, any partitioner and search; forces are "
     "gathered (traversal)",
     IN(reproducible)},
    {"partition", KITH_PARAM_MAP, "", "", "distribution over ranks", KITH_BELOW(partition_params, MAP)},
    {"machine", KITH_PARAM_MAP, "", "", "times of messages that kith plan --ranks assumes",
     KITH_BELOW(machine_params, MAP)},
    {"traversal", KITH_PARAM_NAME, "", "pairs|gather",
     "how forces are summed: over pairs, each once, or for each node; none: pairs, in 1-D gather; "
     "if reproducible they are gathered",
     IN(traversal), FREE},
    {"window", KITH_PARAM_CHOICE, "whole", "whole|follow",
     "what is searched and advanced: all nodes, or those that a signal can have reached since the start",
     IN(follows)},
    {"until", KITH_PARAM_NUMBER, NULL, "[0, inf)", "time at the end", IN(until), FREE},
    {"exact", KITH_PARAM_OTHER, "", "", "the exact solution to compare with",
     KITH_BELOW(kith_exact_params, MAP), FREE},
    {"probes", KITH_PARAM_OTHER, "", "",
     "points at which fields are interpolated while the run goes on, into probes.h5",
     KITH_BELOW(kith_probe_params, LIST), FREE},
    {"measure", KITH_PARAM_MAP, "", "", "what is measured at the end, beside the exact solution",
     KITH_BELOW(measure_params, MAP)},
    {"output", KITH_PARAM_MAP, "", "", "what is written", KITH_BELOW(output_params, MAP), FREE},
    {0}};

/* Checks the name of the scene: results go to out/NAME unless told otherwise. */
static kith_status check_name(const struct kith_scene *scene) {
  const char *name = scene->name;
  if (kith_path_is_name(name)) return KITH_OK;
  const struct kith_config_node *given = kith_config_at(scene->config, "scene"), *root = scene->config->root;
  return kith_config_fail(given != NULL ? given : root, given != NULL ? NULL : "scene",
                          "'%.60s' cannot name a directory: no '/', no '.' in front, no control characters",
                          name);
}

enum { MOST_SNAPSHOTS = 9998 }; /* besides the first and the last one: their numbers have four digits */

kith_status kith_scene_check_until(const struct kith_scene *scene, double until) {
  if (scene->output.every > 0 && until / scene->output.every > MOST_SNAPSHOTS)
    return kith_config_fail(kith_config_at(scene->config, "output.every"), NULL,
                            "%g makes more than %d snapshots until %g", scene->output.every, MOST_SNAPSHOTS,
                            until);
  for (int a = 0; a < NDIM; ++a) {
    const double length = scene->domain.upper[a] - scene->domain.lower[a], u = scene->boundary[a].velocity;
    const double inwards = scene->boundary[a].side[0] != NULL ? u : -u;
    if (inwards * until >= length)
      return kith_config_fail(
          kith_scene_boundary_node(scene, a), NULL,
          "a %s with velocity %g is through the domain at time %g, and the run goes until %g",
          scene->boundary[a].side[u == inwards ? 0 : 1]->name, u, length / inwards, until);
  }
  return KITH_OK;
}

static kith_status read_packages(struct kith_scene *scene, const struct kith_config_node *node) {
  if (node == NULL) return KITH_OK;
  KITH_TRY(kith_config_want(node, KITH_CONFIG_LIST));
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next) {
    const struct kith_config_node *name = kith_config_child(child, "name");
    if (name != NULL && name->kind == KITH_CONFIG_SCALAR && kith_package_find(name->text) != NULL)
      return kith_config_fail(
          name, NULL, "%s is a hydro package; a run has one, which method.package chooses", name->text);
    struct kith_selected *added = &scene->added[scene->n_added++];
    KITH_TRY(kith_params_read(package_params, child, added));
    for (const struct kith_selected *k = scene->added; k < added; ++k)
      if (kith_added_find(k->name) == kith_added_find(added->name))
        return kith_config_fail(name, NULL, "%s is in the list twice", added->name);
  }
  return KITH_OK;
}

/* Refuses keys that mean nothing beside what other parts of the scene say, unless those parts were chosen in
 * a later layer (kith_config_is_older). */
static kith_status check_idle(const struct kith_scene *scene) {
  const bool *measured = scene->measure.wanted;
  int spaced = 0; /* regions whose spacing is left to the arrangement */
  for (int k = 0; k < scene->n_regions; ++k) spaced += scene->region[k].spacing == 0;
  const struct {
    bool idle;
    const char *path, *without, *choice[2]; /* choice: the keys that decide it, one or two */
  } rows[] = {{!measured[KITH_MEASURE_growth] && !measured[KITH_MEASURE_mcnally],
               "measure.rate",
               "growth or mcnally",
               {"measure.growth", "measure.mcnally"}},
              {scene->n_probes + scene->n_contacts == 0,
               "connectivity.storage",
               "probes or contacts",
               {"probes", "connectivity.contacts"}},
              {spaced < 2, "arrangement", "two regions without a spacing of their own", {"regions"}}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; ++k) {
    const struct kith_config_node *given = kith_config_at(scene->config, rows[k].path);
    bool older = given == NULL;
    for (int c = 0; c < 2 && rows[k].choice[c] != NULL && !older; ++c)
      older = kith_config_is_older(given, kith_config_at(scene->config, rows[k].choice[c]));
    if (rows[k].idle && !older)
      return kith_config_fail(given, NULL, "means nothing without %s", rows[k].without);
  }
  return KITH_OK;
}

/* Checks measures of a flow along x and y, which would be NaN in 1-D: they are refused, or dropped if the
 * dimension was chosen in a later layer (--set). */
static kith_status check_measures(struct kith_scene *scene) {
  const struct kith_config_node *dimension = kith_config_at(scene->config, "dimension");
  static const enum kith_measure plane[] = {KITH_MEASURE_shear_viscosity, KITH_MEASURE_vortex_viscosity,
                                            KITH_MEASURE_mcnally,         KITH_MEASURE_growth,
                                            KITH_MEASURE_ripple,          KITH_MEASURE_asymmetry,
                                            KITH_MEASURE_shock_angle};
  char path[64];
  for (size_t k = 0; k < sizeof plane / sizeof *plane; ++k) {
    if (NDIM > 1 || !scene->measure.wanted[plane[k]]) continue;
    snprintf(path, sizeof path, "measure.%s", kith_measure_names[plane[k]]);
    const struct kith_config_node *given = kith_config_at(scene->config, path);
    if (!kith_config_is_older(given, dimension))
      return kith_config_fail(given, NULL, "means nothing in 1-D: it is of a flow along x and y");
    scene->measure.wanted[plane[k]] = false;
  }
  return KITH_OK;
}

/* Checks that the storage of the lists of probes and contacts keeps all neighbors of a node, and, if a
 * boundary stores its images as shifts, such images too. */
static kith_status check_storage(const struct kith_scene *scene) {
  const struct kith_config_node *given = kith_config_at(scene->config, "connectivity.storage");
  struct kith_stored stored;
  if (given == NULL) return KITH_OK;
  if (kith_stored_create(&stored, scene->connectivity.storage) != KITH_OK)
    return kith_config_fail(given, NULL, "%s", kith_failure());
  const struct kith_storage_ops *storage = stored.ops;
  kith_stored_clear(&stored);
  if (storage->upper)
    return kith_config_fail(given, NULL,
                            "%s keeps half of the neighbors of a node, and lists of probes and "
                            "contacts need all",
                            storage->name);
  for (int a = 0; a < NDIM && !storage->shifts; ++a) {
    const struct kith_boundary_ops *ops = scene->boundary[a].side[0];
    if (ops != NULL && ops->shifts != NULL && ops->shifts(scene->boundary[a].settings[0]))
      return kith_config_fail(given, NULL, "%s holds no images that are shifts (boundaries.%c): take csr",
                              storage->name, "xyz"[a]);
  }
  return KITH_OK;
}

static kith_status read_parts(struct kith_scene *scene) {
  const struct kith_config_node *root = scene->config->root;
  if (kith_config_child(root, "base") != NULL) /* that of a file is resolved by now */
    return kith_config_fail(kith_config_child(root, "base"), NULL, "only a scene in a file has a base");
  KITH_TRY(kith_param_read(kith_params_find(scene_params, "dimension"), root, scene));
  if (scene->dimension != NDIM)
    return kith_config_fail(kith_config_child(root, "dimension"), NULL,
                            "%d, but this program is the %d-D one", scene->dimension, NDIM);
  scene->connectivity.skin = -1;
  kith_path_stem(scene->config->file, scene->name, sizeof scene->name);
  KITH_TRY(kith_params_read(scene_params, root, scene));
  KITH_TRY(check_name(scene));
  KITH_TRY(kith_scene_domain(scene, kith_config_child(root, "domain")));
  KITH_TRY(kith_scene_boundaries(scene, kith_config_child(root, "boundaries")));
  KITH_TRY(kith_scene_check_until(scene, scene->until));
  KITH_TRY(kith_scene_forces(scene, root));
  KITH_TRY(kith_scene_materials(scene, kith_config_child(root, "materials")));
  KITH_TRY(kith_scene_regions(scene, kith_config_child(root, "regions")));
  KITH_TRY(kith_scene_deposits(scene, kith_config_child(root, "energy")));
  KITH_TRY(read_packages(scene, kith_config_child(root, "packages")));
  KITH_TRY(kith_scene_picture(scene, kith_config_at(scene->config, "output.plot")));
  KITH_TRY(kith_scene_probes(scene, kith_config_child(root, "probes")));
  KITH_TRY(kith_scene_contacts(scene, kith_config_at(scene->config, "connectivity.contacts")));
  KITH_TRY(check_idle(scene));
  KITH_TRY(check_measures(scene));
  KITH_TRY(check_storage(scene));
  return kith_scene_exact(scene, kith_config_child(root, "exact"));
}

/* Reads a scene from a config, which it takes over, also after a failure. */
static kith_status read_scene(struct kith_scene **out, struct kith_config *config, int n_overrides,
                              const char *const *overrides) {
  struct kith_scene *scene = NULL;
  kith_status status = kith_resize(&scene, 0, 1, sizeof *scene);
  if (status != KITH_OK) kith_config_destroy(&config);
  KITH_TRY(status);
  scene->config = config;
  config->root->dimension = NDIM;
  config->root->params = scene_params;
  for (int k = 0; k < n_overrides && status == KITH_OK; ++k)
    status = kith_config_override(config, overrides[k]);
  if (status == KITH_OK) status = read_parts(scene);
  if (status == KITH_OK) status = kith_config_emit(config->root, false, &scene->text);
  if (status != KITH_OK) kith_scene_destroy(&scene);
  *out = scene;
  return status;
}

kith_status kith_scene_read(struct kith_scene **out, const char *path, int n_overrides,
                            const char *const *overrides) {
  *out = NULL;
  struct kith_config *config;
  KITH_TRY(kith_config_read(&config, path));
  return read_scene(out, config, n_overrides, overrides);
}

kith_status kith_scene_parse(struct kith_scene **out, const char *name, const char *text, size_t length,
                             int n_overrides, const char *const *overrides) {
  *out = NULL;
  struct kith_config *config;
  KITH_TRY(kith_config_parse(&config, name, text, length));
  return read_scene(out, config, n_overrides, overrides);
}

void kith_scene_destroy(struct kith_scene **scene) {
  if (*scene == NULL) return;
  for (int k = 0; k < (*scene)->n_regions; ++k)
    kith_params_clear_formulas(kith_region_params, &(*scene)->region[k]);
  KITH_FREE(&(*scene)->region, &(*scene)->deposit, &(*scene)->probe, &(*scene)->contact);
  kith_params_clear(scene_params, *scene);
  KITH_FREE(&(*scene)->exact.settings, &(*scene)->exact.solution);
  for (int k = 0; k < (*scene)->n_added; ++k) kith_free(&(*scene)->added[k].settings);
  kith_scene_boundaries_clear(*scene);
  for (int m = 0; m < (*scene)->n_materials; ++m) kith_free(&(*scene)->material[m].settings);
  kith_free(&(*scene)->text);
  kith_config_destroy(&(*scene)->config);
  kith_free(scene);
}

kith_status kith_scene_check_same(const struct kith_scene *scene, const char *text) {
  struct kith_config *config;
  KITH_TRY(kith_config_parse(&config, "checkpoint", text, strlen(text)));
  config->root->dimension = NDIM;
  const kith_status status = kith_config_compare(scene_params, scene->config->root, config->root);
  kith_config_destroy(&config);
  return status;
}

void kith_scene_partitioner(const struct kith_scene *scene, char *text, size_t size) {
  const struct kith_selected *p = &scene->partition.member;
  kith_settings_format(kith_family_member(kith_partitioner_member, p->name), p->settings, text, size);
}

void kith_scene_reference(FILE *file) {
  kith_params_reference(scene_params, "a scene", file);
}
