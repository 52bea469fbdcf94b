#include "app/scene.h"
#include "app/scene_parts.h"
#include "app/words.h"
#include "lib/connectivity/rebuild.h"
#include "lib/domain/partition.h"
#include "physics/package.h"

#include <string.h>

#define IN(member) KITH_INTO(struct kith_scene, member)

static const struct kith_key viscosity_keys[] = {
    {"name", KITH_KEY_WORD, "limited", KITH_VISCOSITY_LIST(KITH_AS_LISTED_WORD), "its form",
     IN(method.viscosity)},
    {"alpha", KITH_KEY_NUMBER, "1", "[0, inf)", "linear coefficient", IN(method.alpha)},
    {"beta", KITH_KEY_NUMBER, "2", "[0, inf)", "quadratic coefficient", IN(method.beta)},
    {"balsara", KITH_KEY_WORD, "none", KITH_BALSARA_LIST(KITH_AS_LISTED_WORD), "less of it in shear (sph)",
     IN(method.balsara)},
    {0}};

static const struct kith_key method_keys[] = {
    {"package", KITH_KEY_NAME, "sph", "", "hydro package (kith list package)", IN(method.package)},
    {"kernel", KITH_KEY_NAME, "wendland-c2", "", "interpolation kernel (kith list kernel)",
     IN(method.kernel)},
    {"neighbors", KITH_KEY_NUMBER, "0", "[0, 1000]", "nodes in a support; 0: the default of the kernel",
     IN(method.neighbors)},
    {"energy", KITH_KEY_WORD, "compatible", "thermal|compatible",
     "energy from the work of pairs, or from its own equation", IN(method.compatible)},
    {"conduction", KITH_KEY_NUMBER, "0", "[0, inf)", "of heat, where pressure jumps; 0: none, 1: usual (sph)",
     IN(method.conduction)},
    {"faces", KITH_KEY_WORD, "one-point", KITH_FACES_LIST(KITH_AS_LISTED_WORD), "between nodes (mfm)",
     IN(method.faces)},
    {"closed", KITH_KEY_BOOL, "false", "", "the faces of each node sum to zero (mfm)", IN(method.closed)},
    {"viscosity", KITH_KEY_MAP, "", "", "artificial viscosity", KITH_BELOW(viscosity_keys, MAP)},
    {0}};

static const struct kith_key scheme_keys[] = {
    {"name", KITH_KEY_NAME, "leapfrog", "", "time integration (kith list scheme)", IN(scheme.name)},
    {"cfl", KITH_KEY_NUMBER, "0.3", "(0, 1000]", "Courant number; above 1 for implicit only", IN(scheme.cfl)},
    {"dt", KITH_KEY_NUMBER, "0", "[0, inf)", "fixed step; 0: by the Courant number", IN(scheme.dt)},
    {"table", KITH_KEY_NAME, "bogacki-shampine-4-2-3", "", "Runge-Kutta table of arkode (kith list table)",
     IN(scheme.table)},
    {"adaptive", KITH_KEY_BOOL, "true", "", "arkode: dt by the error estimate too, unless dt is given",
     IN(scheme.adaptive)},
    {"method", KITH_KEY_WORD, "crank-nicolson", "crank-nicolson|backward-euler", "of implicit",
     IN(scheme.backward_euler)},
    {"rtol", KITH_KEY_NUMBER, "1e-4", "[1e-12, 1]",
     "error of a step of arkode, and a thousand residuals of implicit: of a node's support, sound speed, energy",
     IN(scheme.rtol)},
    {"atol", KITH_KEY_NUMBER, "1e-5", "[0, 1]",
     "the same, of the energy per mass of the whole run, and its speed", IN(scheme.atol)},
    {0}};

struct neighbor_names {
  char search[32], storage[32];
};

static const struct kith_key neighbor_keys[] = {
    {"search", KITH_KEY_NAME, "tree", KITH_SEARCH_LIST(KITH_AS_WORD), "neighbor search",
     KITH_INTO(struct neighbor_names, search)},
    {"storage", KITH_KEY_NAME, "csr", "csr", "storage of rows", KITH_INTO(struct neighbor_names, storage)},
    {0}};

static const struct kith_key connectivity_keys[] = {
    {"rebuild", KITH_KEY_NAME, "always", "",
     "when lists are made anew; any of these, joined by |: " KITH_REBUILD_LIST(KITH_AS_WORD),
     IN(connectivity.rebuild)},
    {"skin", KITH_KEY_NUMBER, "", "[0, inf)",
     "reach of lasting lists beyond the support, as a part of it; none: the default of the policy",
     IN(connectivity.skin)},
    {"cull", KITH_KEY_BOOL, "true", "", "drop ghosts that no node needs", IN(connectivity.cull)},
    {"reorder", KITH_KEY_INTEGER, "20", "[0, inf)",
     "lifecycles between reorderings of the nodes along the curve, the first one included; 0: never",
     IN(connectivity.reorder)},
    {0}};

static const struct kith_key partition_keys[] = {
    {"name", KITH_KEY_NAME, "kd", "",
     "partitioner (kith list partitioner), and after a colon its words: diffusion:fixed,morton",
     IN(partition.name)},
    {"every", KITH_KEY_INTEGER, "20", "[0, inf)", "rebuilds of lists between looks at the balance; 0: never",
     IN(partition.every)},
    {"imbalance", KITH_KEY_NUMBER, "1.05", "[1, inf)", "work of the busiest rank over the mean that is borne",
     IN(partition.imbalance)},
    {"cells", KITH_KEY_INTEGER, "256", "[1, 1000000]", "cells per rank that are dealt out",
     IN(partition.cells)},
    {"ghosts", KITH_KEY_WORD, "exchange", "exchange|recompute",
     "values of ghosts between the passes of a package: sent by their owners, or computed again from two layers of ghosts (sph; not if reproducible)",
     IN(partition.recompute)},
    {0}};

static const struct kith_key measure_keys[] = {
#define X(name, doc) {#name, KITH_KEY_BOOL, "false", "", doc, IN(measure.wanted[KITH_MEASURE_##name])},
    KITH_MEASURE_LIST(X)
#undef X
        {0}};

static const struct kith_key output_keys[] = {
    {"every", KITH_KEY_NUMBER, "0", "[0, inf)", "time between snapshots; 0: first and last only",
     IN(output.every)},
    {"plot", KITH_KEY_BOOL, "true", "", "plot the result beside the exact solution", IN(output.plot)},
    {"checkpoint", KITH_KEY_INTEGER, "0", "[0, inf)", "steps between checkpoints; 0: on a signal only",
     IN(output.checkpoint)},
    {"checkpoint_at_end", KITH_KEY_BOOL, "false", "", "one more checkpoint after the last step",
     IN(output.checkpoint_at_end)},
    {0}};

static const struct kith_key scene_keys[] = {
    {"base", KITH_KEY_OTHER, "", "",
     "a scene that this one is, but for the keys that follow: these may have dots", .keys = NULL},
    {"scene", KITH_KEY_TEXT, "", "", "its name; none: the name of the file", IN(name)},
    {"dimension", KITH_KEY_INTEGER, NULL, "[1, 3]", "number of dimensions", IN(dimension)},
    {"resolution", KITH_KEY_NUMBER, NULL, "(0, inf)", "nodes per unit length in the densest region",
     IN(resolution)},
    {"arrangement", KITH_KEY_WORD, "equal-mass", "equal-mass|equal-spacing",
     "what all regions have in common", IN(arrangement)},
    {"domain", KITH_KEY_OTHER, NULL, "", "the box that regions fill", KITH_BELOW(kith_domain_keys, MAP)},
    {"boundaries", KITH_KEY_OTHER, "", "", "what is beyond each face", KITH_BELOW(kith_boundaries_keys, MAP)},
    {"materials", KITH_KEY_OTHER, NULL, "", "by name; the nodes of each are a list",
     KITH_BELOW(kith_materials_keys, NAMED)},
    {"gravity", KITH_KEY_VECTOR, "[0, 0, 0]", "", "uniform acceleration, not along periodic axes",
     IN(body.gravity)},
    {"potential", KITH_KEY_OTHER, "", "", "the pull of a point", KITH_BELOW(kith_potential_keys, MAP)},
    {"regions", KITH_KEY_OTHER, NULL, "", "what fills the domain", KITH_BELOW(kith_region_keys, LIST)},
    {"energy", KITH_KEY_OTHER, "", "", "blast energies: one map, or a list",
     KITH_BELOW(kith_deposit_keys, LIST)},
    {"method", KITH_KEY_MAP, "", "", "the hydrodynamics", KITH_BELOW(method_keys, MAP)},
    {"scheme", KITH_KEY_MAP, "", "", "the step", KITH_BELOW(scheme_keys, MAP)},
    {"neighbor", KITH_KEY_OTHER, "", "", "who may be near", KITH_BELOW(neighbor_keys, MAP)},
    {"connectivity", KITH_KEY_MAP, "", "", "who is near", KITH_BELOW(connectivity_keys, MAP)},
    {"reproducible", KITH_KEY_BOOL, "false", "",
     "bitwise the same for any number of ranks and threads, partitioner and search, whatever the method and the scheme",
     IN(reproducible)},
    {"partition", KITH_KEY_MAP, "", "", "what each rank has, if there are several",
     KITH_BELOW(partition_keys, MAP)},
    {"traversal", KITH_KEY_NAME, "", "pairs|gather",
     "how passes walk the pairs; none: the default of each pass", IN(traversal)},
    {"until", KITH_KEY_NUMBER, NULL, "[0, inf)", "time at the end", IN(until)},
    {"exact", KITH_KEY_OTHER, "", "", "the exact solution to compare with", KITH_BELOW(kith_exact_keys, MAP)},
    {"measure", KITH_KEY_MAP, "", "", "what is measured at the end, beside the exact solution",
     KITH_BELOW(measure_keys, MAP)},
    {"output", KITH_KEY_MAP, "", "", "what is written", KITH_BELOW(output_keys, MAP)},
    {0}};

static kith_status read_neighbor(struct kith_scene *scene, const struct kith_config_node *node) {
  struct neighbor_names names;
  KITH_TRY(kith_keys_read(neighbor_keys, node, &names));
  scene->neighbor.search = kith_search_find(names.search);
  if (scene->neighbor.search == NULL)
    KITH_FAIL(INTERNAL, "the search %s is listed and not found", names.search);
  return KITH_OK;
}

/* "displacement | entity-change": each of the joined words. */
static kith_status check_rebuild(const struct kith_scene *scene) {
  char word[sizeof scene->connectivity.rebuild];
  const char *p = scene->connectivity.rebuild;
  for (bool more = true; more; ++p) {
    p += strspn(p, " ");
    size_t length = strcspn(p, "|");
    more = p[length] == '|';
    const char *end = p + length;
    while (length > 0 && p[length - 1] == ' ') --length;
    snprintf(word, sizeof word, "%.*s", (int)length, p);
    KITH_TRY(kith_scene_check_word(scene, "connectivity.rebuild", word, KITH_REBUILD_LIST(KITH_AS_WORD)));
    p = end;
  }
  return KITH_OK;
}

static kith_status check_dimension(const struct kith_scene *scene) {
  if (scene->dimension == NDIM) return KITH_OK;
  return kith_config_fail(kith_config_child(scene->config->root, "dimension"), NULL,
                          "%d, but this program is the %d-D one", scene->dimension, NDIM);
}

/* The name of the file without folders and ending. */
static kith_status default_name(struct kith_scene *scene) {
  const char *slash = strrchr(scene->config->file, '/');
  const char *stem = slash != NULL ? slash + 1 : scene->config->file;
  const char *dot = strrchr(stem, '.');
  return kith_text_copy(&scene->name, stem, dot != NULL && dot != stem ? (size_t)(dot - stem) : strlen(stem));
}

/* Results go to out/NAME unless told otherwise. */
static kith_status check_name(const struct kith_scene *scene) {
  enum { LONGEST = 100 };
  const char *name = scene->name;
  if (name[0] != '\0' && name[0] != '.' && strchr(name, '/') == NULL && strlen(name) <= LONGEST)
    return KITH_OK;
  const struct kith_config_node *given = kith_config_at(scene->config, "scene"), *root = scene->config->root;
  return kith_config_fail(given != NULL ? given : root, given != NULL ? NULL : "scene",
                          "'%.60s' cannot name a directory: 1 to %d letters, no '/', no '.' in front", name,
                          LONGEST);
}

static kith_status read_parts(struct kith_scene *scene) {
  const struct kith_config_node *root = scene->config->root;
  if (kith_config_child(root, "base") != NULL) /* a file's own is gone by now */
    return kith_config_fail(kith_config_child(root, "base"), NULL, "only a scene in a file has a base");
  KITH_TRY(kith_key_read(kith_keys_find(scene_keys, "dimension"), root, scene));
  KITH_TRY(check_dimension(scene));
  scene->connectivity.skin = -1;
  KITH_TRY(kith_keys_read(scene_keys, root, scene));
  if (scene->name == NULL) KITH_TRY(default_name(scene));
  KITH_TRY(check_name(scene));
  KITH_TRY(check_rebuild(scene));
  KITH_TRY(kith_scene_domain(scene, kith_config_child(root, "domain")));
  KITH_TRY(kith_scene_boundaries(scene, kith_config_child(root, "boundaries")));
  KITH_TRY(kith_scene_forces(scene, root));
  KITH_TRY(kith_scene_materials(scene, kith_config_child(root, "materials")));
  KITH_TRY(kith_scene_regions(scene, kith_config_child(root, "regions")));
  KITH_TRY(kith_scene_deposits(scene, kith_config_child(root, "energy")));
  KITH_TRY(read_neighbor(scene, kith_config_child(root, "neighbor")));
  return kith_scene_exact(scene, kith_config_child(root, "exact"));
}

static kith_status apply(struct kith_config *config, int n_overrides, const char *const *overrides) {
  for (int i = 0; i < n_overrides; ++i) KITH_TRY(kith_config_override(config, overrides[i]));
  return KITH_OK;
}

/* Takes the config. */
static kith_status read_scene(struct kith_scene **out, struct kith_config *config, int n_overrides,
                              const char *const *overrides) {
  struct kith_scene *scene = NULL;
  kith_status status = kith_resize(&scene, 0, 1, sizeof *scene);
  if (status != KITH_OK) kith_config_destroy(&config);
  KITH_TRY(status);
  scene->config = config;
  status = apply(config, n_overrides, overrides);
  if (status == KITH_OK) status = read_parts(scene);
  if (status == KITH_OK) status = kith_config_emit(config, &scene->text);
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
  kith_scene_regions_clear(*scene);
  kith_free(&(*scene)->deposit);
  kith_free(&(*scene)->name);
  kith_free(&(*scene)->text);
  kith_config_destroy(&(*scene)->config);
  kith_free(scene);
}

kith_status kith_scene_dimension(const char *path, int n_overrides, const char *const *overrides,
                                 int *dimension) {
  struct kith_config *config;
  struct kith_scene scene = {0};
  KITH_TRY(kith_config_read(&config, path));
  kith_status status = apply(config, n_overrides, overrides);
  if (status == KITH_OK)
    status = kith_key_read(kith_keys_find(scene_keys, "dimension"), config->root, &scene);
  kith_config_destroy(&config);
  *dimension = scene.dimension;
  return status;
}

kith_status kith_scene_check_word(const struct kith_scene *scene, const char *key, const char *value,
                                  const char *words) {
  if (kith_words_find(words, value) >= 0) return KITH_OK;
  const struct kith_config_node *node = kith_config_at(scene->config, key);
  struct kith_config_node shown = node != NULL ? *node : *scene->config->root;
  char text[128];
  snprintf(text, sizeof text, "%s", value);
  shown.text = text;
  if (node != NULL) return kith_config_fail_word(&shown, words);
  return kith_config_fail(&shown, key, "the default '%s' is not available", value);
}

void kith_scene_reference(FILE *file) {
  fprintf(file, "# Every key of a scene: its default, what it means, what it may be.\n");
  kith_keys_reference(scene_keys, file);
}
