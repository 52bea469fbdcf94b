#include "app/model.h"

#include <stdio.h>
#include <string.h>
#include "app/setup.h"
#include "app/words.h"
#include "boundaries/distributed.h"

#define KITH_AS_TABLE(constant, word) "|" #word

static kith_status make_package(struct kith_model *m) {
  const struct kith_scene *scene = m->scene;
  struct kith_package *p = &m->package;
  p->ops = kith_package_find(scene->method.package);
  p->hydro = &m->hydro;
  p->kernel = kith_kernel_find(scene->method.kernel);
  p->neighbors = scene->method.neighbors > 0 ? scene->method.neighbors : kith_kernel_neighbors(p->kernel);
  p->compatible = scene->method.compatible;
  p->viscosity = scene->method.viscosity;
  p->balsara = scene->method.balsara;
  p->alpha = scene->method.alpha;
  p->beta = scene->method.beta;
  p->conduction = scene->method.conduction;
  p->faces = scene->method.faces;
  p->closed = scene->method.closed;
  /* Measured (kith bench, Sod): keeping forces that are needed twice gains 19 % with the few neighbors of 1-D, costs 5 % in 2-D and 17 %
   * in 3-D, where a second evaluation is cheaper than memory; unless pairs are dear. */
  p->traversal = p->ops->dear || (p->compatible && NDIM == 1) ? KITH_TRAVERSE_PAIRS : KITH_TRAVERSE_GATHER;
  if (strcmp(scene->traversal, "pairs") == 0) p->traversal = KITH_TRAVERSE_PAIRS;
  if (strcmp(scene->traversal, "gather") == 0) p->traversal = KITH_TRAVERSE_GATHER;
  p->barrier = kith_nodes_field_named(m->nodes, "barrier");
  p->profile = m->profile;
  return kith_package_init(p);
}

/* Frozen nodes first: the images of the others' axes include them. */
static kith_status make_boundaries(struct kith_model *m, const uint8_t *frozen) {
  if (frozen != NULL) {
    KITH_TRY(kith_boundaries_add(&m->boundaries, &kith_boundary_constant, 0, 0, 1, false, false));
    KITH_TRY(kith_constant_take(m->boundaries.boundary[0], m->nodes, frozen));
  }
  for (int a = 0; a < NDIM; ++a) {
    const struct kith_boundary_ops *lower = m->scene->boundary[a].lower, *upper = m->scene->boundary[a].upper;
    if (lower != NULL || upper != NULL)
      KITH_TRY(kith_boundaries_add(&m->boundaries, lower != NULL ? lower : upper, a,
                                   m->scene->domain.lower[a], m->scene->domain.upper[a], lower != NULL,
                                   upper != NULL));
    if (m->scene->boundary[a].velocity != 0)
      m->boundaries.boundary[m->boundaries.n - 1]->velocity = m->scene->boundary[a].velocity;
  }
  return KITH_OK;
}

static kith_status make_rebuilds(struct kith_model *m) {
  double period[NDIM];
  for (int a = 0; a < NDIM; ++a)
    period[a] = m->scene->boundary[a].lower == &kith_boundary_periodic
                    ? m->scene->domain.upper[a] - m->scene->domain.lower[a]
                    : 0;
  return kith_rebuilds_create(&m->rebuilds, m->scene->connectivity.rebuild, period);
}

static kith_status make_integrator(struct kith_model *m, bool check) {
  const struct kith_scene *scene = m->scene;
  /* Lists of one step need room for the change of supports within it only. */
  const double skin = kith_rebuilds_lasting(&m->rebuilds) ? 0.1 : 0.005;
  m->integrator =
      (struct kith_integrator){.nodes = m->nodes,
                               .hydro = &m->hydro,
                               .package = &m->package,
                               .boundaries = &m->boundaries,
                               .search = m->search,
                               .connectivity = m->connectivity,
                               .rebuilds = &m->rebuilds,
                               .scheme = kith_scheme_find(scene->scheme.name),
                               .profile = m->profile,
                               .cfl = scene->scheme.cfl,
                               .fixed_dt = scene->scheme.dt,
                               .skin = scene->connectivity.skin >= 0 ? scene->connectivity.skin : skin,
                               .cull = scene->connectivity.cull,
                               .check = check,
                               .canonical = scene->reproducible,
                               .reorder_every = scene->connectivity.reorder,
                               .stepping = {.table = scene->scheme.table,
                                            .adaptive = scene->scheme.adaptive,
                                            .rtol = scene->scheme.rtol,
                                            .atol = scene->scheme.atol,
                                            .theta = scene->scheme.backward_euler ? 1 : 0.5}};
  return kith_integrator_init(&m->integrator);
}

/* arkode's table, and whether it can do what it is asked for. */
static kith_status check_table(const struct kith_scene *scene) {
  const struct kith_config_node *key = kith_config_at(scene->config, "scheme.table");
  char word[sizeof scene->scheme.table], near[64];
  struct kith_table table;
  kith_table_word(scene->scheme.table, word, sizeof word);
  if (kith_words_find(KITH_TABLE_LIST(KITH_AS_TABLE), word) < 0) {
    const bool like = kith_words_nearest(KITH_TABLE_LIST(KITH_AS_TABLE), word, near, sizeof near);
    return kith_config_fail(key, NULL, "'%s' is no table of ARKODE (kith list table)%s%s%s",
                            scene->scheme.table, like ? "; did you mean '" : "", like ? near : "",
                            like ? "'?" : "");
  }
  KITH_TRY(kith_table_read(&table, word));
  if (table.embedded > 0 || !scene->scheme.adaptive || scene->scheme.dt > 0) return KITH_OK;
  return kith_config_fail(key, NULL, "%s has no error estimate; give it scheme.adaptive=false",
                          scene->scheme.table);
}

/* Lists that last do not know how far the images in a face that moves have gone; and what goes through it within a step needs a
 * velocity of the face in every sum of a scheme. */
static kith_status check_piston(const struct kith_scene *scene) {
  const struct kith_config_node *rebuild = kith_config_at(scene->config, "connectivity.rebuild"),
                                *name = kith_config_at(scene->config, "scheme.name");
  bool moves = false, frozen = false;
  for (int a = 0; a < NDIM; ++a) moves = moves || scene->boundary[a].velocity != 0;
  for (int k = 0; k < scene->n_regions; ++k)
    frozen = frozen || scene->region[k].frozen || scene->region[k].barrier;
  if (!moves) return KITH_OK;
  if (strcmp(scene->connectivity.rebuild, "always") != 0)
    return kith_config_fail(rebuild, NULL, "with a piston lists are made anew always");
  if (kith_scheme_find(scene->scheme.name)->incompatible != NULL)
    return kith_config_fail(name, NULL, "%s does not know of pistons; leapfrog, rk2, cheap-rk2 and verlet do",
                            scene->scheme.name);
  if (frozen)
    return kith_config_fail(
        kith_config_at(scene->config, "regions"), NULL,
        "frozen nodes and barriers give momentum, and the work of a piston is told by it");
  return KITH_OK;
}

/* A scheme and what is asked of it. */
static kith_status check_scheme(const struct kith_scene *scene) {
  const struct kith_config_node *root = scene->config->root,
                                *name = kith_config_at(scene->config, "scheme.name");
  const struct kith_scheme_ops *scheme = kith_scheme_find(scene->scheme.name);
  if (scene->method.compatible && scheme->incompatible != NULL)
    return kith_config_fail(name != NULL ? name : root, NULL,
                            "%s cannot keep energy compatible: %s; give it method.energy=thermal",
                            scheme->name, scheme->incompatible);
  if (scene->scheme.cfl > 1 && !scheme->implicit)
    return kith_config_fail(kith_config_at(scene->config, "scheme.cfl"), NULL,
                            "%g is out of range (0, 1] of %s; more is for implicit", scene->scheme.cfl,
                            scheme->name);
  const bool tries = scheme == &kith_scheme_arkode || scheme->implicit;
  if (tries && scene->method.viscosity == KITH_VISCOSITY_CULLEN_DEHNEN)
    return kith_config_fail(kith_config_at(scene->config, "method.viscosity.name"), NULL,
                            "cullen-dehnen has a history, and %s tries steps that it takes back",
                            scheme->name);
  if (scheme != &kith_scheme_arkode) return KITH_OK;
  return check_table(scene);
}

/* A package and what is asked of it. */
static kith_status check_method(const struct kith_scene *scene) {
  bool barrier = false;
  for (int k = 0; k < scene->n_regions; ++k) barrier = barrier || scene->region[k].barrier;
  if (barrier && scene->method.faces == KITH_FACES_INTEGRATED)
    return kith_config_fail(kith_config_at(scene->config, "method.faces"), NULL,
                            "integrated faces reach beyond the pairs that a barrier region cuts; "
                            "with barriers use one-point");
  return KITH_OK;
}

/* Passes before the forces: one in sph, whose sums over its neighbors a ghost can make by itself. */
static kith_status check_recompute(const struct kith_scene *scene) {
  const struct kith_config_node *key = kith_config_at(scene->config, "partition.ghosts");
  if (!scene->partition.recompute) return KITH_OK;
  if (strcmp(scene->method.package, "sph") != 0)
    return kith_config_fail(key, NULL,
                            "package %s has two passes before its forces: ghosts of ghosts of ghosts; "
                            "take exchange",
                            scene->method.package);
  if (scene->method.viscosity == KITH_VISCOSITY_CULLEN_DEHNEN)
    return kith_config_fail(
        key, NULL,
        "the strength of viscosity cullen-dehnen is kept by the owner of a node only; take exchange");
  if (scene->reproducible)
    return kith_config_fail(
        key, NULL, "what is computed again is summed in another order; reproducible runs take exchange");
  return KITH_OK;
}

static kith_status check_partitioner(const struct kith_scene *scene) {
  char word[sizeof scene->partition.name];
  snprintf(word, sizeof word, "%.*s", (int)strcspn(scene->partition.name, ":"), scene->partition.name);
  return kith_scene_check_word(scene, "partition.name", word, KITH_PARTITIONER_LIST(KITH_AS_WORD));
}

static kith_status check_words(const struct kith_scene *scene) {
  char kernels[256] = "";
  for (int k = 0; k < KITH_N_KERNELS; ++k) strcat(strcat(kernels, "|"), kith_kernel_facts[k].name);
  KITH_TRY(
      kith_scene_check_word(scene, "method.package", scene->method.package, KITH_PACKAGE_LIST(KITH_AS_WORD)));
  KITH_TRY(kith_scene_check_word(scene, "method.kernel", scene->method.kernel, kernels));
  KITH_TRY(kith_scene_check_word(scene, "scheme.name", scene->scheme.name, KITH_SCHEME_LIST(KITH_AS_WORD)));
  KITH_TRY(check_method(scene));
  KITH_TRY(check_partitioner(scene));
  KITH_TRY(check_recompute(scene));
  KITH_TRY(check_scheme(scene));
  return check_piston(scene);
}

static kith_status make(struct kith_model *m, bool check) {
  KITH_TRY(check_words(m->scene));
  const enum kith_kernel kernel = kith_kernel_find(m->scene->method.kernel);
  const double neighbors =
      m->scene->method.neighbors > 0 ? m->scene->method.neighbors : kith_kernel_neighbors(kernel);
  uint8_t *frozen = NULL;
  kith_status status = kith_setup(&m->nodes, &m->hydro, m->scene, neighbors, &frozen);
  if (status == KITH_OK && m->scene->reproducible) status = kith_nodes_number_images(m->nodes);
  if (status == KITH_OK) kith_hydro_close(&m->hydro);
  if (status == KITH_OK) status = make_package(m);
  if (status == KITH_OK) status = make_rebuilds(m);
  if (status == KITH_OK) status = kith_search_create(&m->search, m->scene->neighbor.search, m->nodes);
  if (status == KITH_OK) status = kith_connectivity_create(&m->connectivity);
  if (status == KITH_OK) status = make_integrator(m, check);
  if (status == KITH_OK) status = make_boundaries(m, frozen); /* last: frozen nodes take all fields along */
  kith_free(&frozen);
  return status;
}

kith_status kith_model_create(struct kith_model **out, const struct kith_scene *scene,
                              struct kith_profile *profile, bool check) {
  struct kith_model *m = NULL;
  KITH_TRY(kith_resize(&m, 0, 1, sizeof *m));
  m->scene = scene;
  m->profile = profile;
  const kith_status status = make(m, check);
  if (status != KITH_OK) {
    kith_model_destroy(&m);
    return status;
  }
  *out = m;
  return KITH_OK;
}

static kith_status make_share(struct kith_model *m) {
  bool periodic[NDIM];
  const struct kith_sharing sharing = {m->scene->partition.name, m->scene->partition.every,
                                       m->scene->partition.imbalance, m->scene->partition.cells};
  for (int a = 0; a < NDIM; ++a) periodic[a] = m->scene->boundary[a].lower == &kith_boundary_periodic;
  KITH_TRY(kith_share_create(&m->share, m->nodes, &m->scene->domain, periodic, &sharing));
  m->integrator.share = m->share;
  KITH_TRY(kith_boundaries_add(&m->boundaries, &kith_boundary_distributed, 0, 0, 1, false, false));
  KITH_TRY(kith_distributed_init(m->boundaries.boundary[m->boundaries.n - 1], m->nodes, m->share->home,
                                 &m->share->cells));
  m->package.recompute = m->scene->partition.recompute;
  return kith_share_keep(m->share, m->nodes);
}

kith_status kith_model_share(struct kith_model *m, struct kith_ranks *ranks) {
  if (ranks == NULL) return KITH_OK;
  m->nodes->ranks = ranks;
  return make_share(m);
}

kith_status kith_model_start(struct kith_model *m) {
  KITH_TRY(kith_integrator_start(&m->integrator));
  if (!kith_setup_waits(m->scene)) return KITH_OK;
  KITH_TRY(kith_setup_equilibrium(m->scene, &m->hydro));
  return kith_integrator_start(&m->integrator);
}

void kith_model_warn(const struct kith_model *m) {
  const struct kith_package *p = &m->package;
  const double most = kith_kernel_most_neighbors(p->kernel);
  if (p->neighbors <= most) return;
  fprintf(stderr,
          "kith: warning: method.neighbors: nodes pair up with %.4g neighbors under kernel %s, which carries "
          "%.3g in %d-D; take %s\n",
          p->neighbors, kith_kernel_facts[p->kernel].name, most, NDIM,
          kith_kernel_facts[kith_kernel_unpaired(p->neighbors)].name);
}

void kith_model_destroy(struct kith_model **model) {
  struct kith_model *m = *model;
  if (m == NULL) return;
  kith_integrator_clear(&m->integrator);
  kith_package_clear(&m->package);
  kith_boundaries_clear(&m->boundaries);
  kith_share_destroy(&m->share);
  kith_rebuilds_clear(&m->rebuilds);
  kith_connectivity_destroy(&m->connectivity);
  kith_search_destroy(&m->search);
  kith_nodes_destroy(&m->nodes);
  kith_free(model);
}

void kith_model_bytes(const struct kith_model *m, struct kith_bytes out[KITH_MODEL_STRUCTURES]) {
  const size_t pairwise = kith_package_pairwise_bytes(&m->package);
  out[0] = (struct kith_bytes){"nodes", kith_nodes_bytes(m->nodes)};
  out[1] = (struct kith_bytes){"search", kith_search_bytes(m->search)};
  out[2] = (struct kith_bytes){"connectivity", kith_connectivity_bytes(m->connectivity)};
  out[3] = (struct kith_bytes){"package", kith_package_bytes(&m->package) - pairwise};
  out[4] = (struct kith_bytes){"pairwise", pairwise};
  out[5] = (struct kith_bytes){"integrator", kith_integrator_bytes(&m->integrator)};
}
