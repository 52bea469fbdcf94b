/* test_inputs.c - shipped scenes in all dimensions, resolutions and arrangements: their nodes start with the
 * exact solution at time 0 and the mass of the regions; blast energies and numbers of nodes are those that
 * the scenes promise. */
#include <string.h>
#include "app/scene/scene.h"
#include "app/initial/initial_conditions.h"
#include "tests/check.h"
#include "lib/core/choices.h"
#include "tests/unit/exact_settings.h"

struct made {
  struct kith_scene *scene;
  struct kith_nodes *nodes;
  struct kith_hydro hydro;
  uint8_t *frozen;
  double zone[NDIM][2][NDIM];
};

static void path_of(char *path, size_t size, const char *name) {
  snprintf(path, size, KITH_INPUTS "/%s.yaml", name);
}

static bool create(struct made *m, const char *name, const char *resolution, const char *arrangement) {
  char path[512], dimension[32], fine[64], arranged[64];
  memset(m, 0, sizeof *m);
  path_of(path, sizeof path, name);
  snprintf(dimension, sizeof dimension, "dimension=%d", NDIM);
  snprintf(fine, sizeof fine, "resolution=%s", resolution);
  snprintf(arranged, sizeof arranged, "arrangement?=%s", arrangement); /* means nothing with one region */
  const char *const overrides[] = {dimension, arranged, fine};
  CHECK_OK(kith_scene_read(&m->scene, path, resolution ? 3 : 2, overrides));
  if (!m->scene) return false;
  CHECK(strcmp(m->scene->name, name) == 0);
  int64_t total = 0;
  CHECK_OK(kith_initial_conditions(&m->nodes, &m->hydro, m->scene, NULL, 50, &m->frozen, m->zone, &total));
  return m->nodes != NULL && total == m->nodes->n_internal;
}

static void destroy(struct made *m) {
  kith_free(&m->frozen);
  kith_nodes_destroy(&m->nodes);
  kith_scene_destroy(&m->scene);
}

/* Density, velocity and pressure of nodes are those of the exact solution at time 0. */
static void check_initial_state(const struct made *m, const char *name) {
  void *solution = NULL;
  CHECK(m->scene->exact.ops != NULL);
  CHECK_OK(kith_exact_create(&solution, m->scene->exact.ops, m->scene->exact.settings));
  const bool blast = m->scene->n_deposits > 0;
  /* linear theory of a wave of amplitude 1e-6 is exact up to its square */
  const double tolerance = strcmp(name, "acoustic-wave") == 0 ? 3e-12 : 1e-14;
  kith_hydro_evaluate_eos(&m->hydro);
  for (kith_index i = 0; i < m->nodes->n_internal; ++i) {
    struct kith_exact_state exact;
    m->scene->exact.ops->state(solution, m->nodes->position->f64 + i * NDIM, 0, &exact);
    CHECK_CLOSE(m->hydro.density->f64[i], exact.density, tolerance);
    for (int a = 0; a < NDIM; ++a)
      CHECK_CLOSE(m->hydro.velocity->f64[i * NDIM + a], exact.velocity[a], tolerance);
    if (!blast) CHECK_CLOSE(m->hydro.pressure->f64[i], exact.pressure, tolerance);
  }
  kith_free(&solution);
}

/* The mass of the regions: densities times boxes. */
static double mass_of(const struct made *m) {
  double mass = 0;
  for (int k = 0; k < m->scene->n_regions; ++k) {
    const struct kith_region *region = &m->scene->region[k];
    const double origin[NDIM] = {0};
    double density;
    /* waves are 1 there, which is their mean */
    CHECK_OK(kith_expression_at(region->density, NDIM, origin, &density));
    for (int a = 0; a < NDIM; ++a)
      density *= fmin(region->where.extent[a][1], m->scene->domain.upper[a]) -
                 fmax(region->where.extent[a][0], m->scene->domain.lower[a]);
    mass += density;
  }
  return mass;
}

static void check_scene(const char *name, const char *resolution, const char *arrangement) {
  struct made m;
  if (create(&m, name, resolution, arrangement)) {
    const struct kith_totals t = kith_hydro_totals(&m.hydro);
    /* scenes of boxes of one density, or waves around it; a displacement is a difference */
    const bool boxes =
        strcmp(name, "yee") != 0 && strcmp(name, "square") != 0 && strcmp(name, "sedov-gradient") != 0;
    const double tolerance = m.scene->region[0].displacement[0] != NULL ? 1e-10 : 1e-12;
    if (boxes) CHECK_CLOSE(t.mass, mass_of(&m), tolerance * t.mass);
    CHECK(m.nodes->n_internal > 0 && m.nodes->n_internal < 200000);
    CHECK(!m.frozen);
    CHECK_OK(kith_hydro_physical(&m.hydro));
    check_initial_state(&m, name);
  }
  destroy(&m);
}

/* Scenes without an exact solution; rayleigh-taylor needs two dimensions. */
static void check_gravity_scene(const char *name, bool exists) {
  struct made m = {0};
  char path[512], dimension[32];
  path_of(path, sizeof path, name);
  snprintf(dimension, sizeof dimension, "dimension=%d", NDIM);
  const char *const overrides[] = {dimension};
  CHECK_STATUS(exists ? KITH_OK : KITH_BAD_INPUT, kith_scene_read(&m.scene, path, 1, overrides));
  if (m.scene != NULL) {
    int64_t total;
    CHECK_OK(kith_initial_conditions(&m.nodes, &m.hydro, m.scene, NULL, 50, &m.frozen, m.zone, &total));
    CHECK_OK(kith_hydro_physical(&m.hydro));
    CHECK(kith_external_force_acts(&m.hydro.external_force));
  }
  destroy(&m);
}

/* The energy of the blast is that of the deposit on all sides of the center, and the shock is at 0.35 at the
 * end. */
static void check_blast(const char *name, double part) {
  struct made m;
  if (create(&m, name, NDIM == 3 ? "20" : "40", "equal-mass")) {
    const double background = 1e-6 / (5. / 3 - 1) * part;
    CHECK_CLOSE(kith_hydro_totals(&m.hydro).internal / (part + background), 1, 1e-14);
    CHECK_CLOSE(exact_parameters_of(m.scene->exact.ops, m.scene->exact.settings).blast_energy, 1, 1e-15);
    void *solution = NULL;
    CHECK_OK(kith_exact_create(&solution, m.scene->exact.ops, m.scene->exact.settings));
    CHECK_CLOSE(m.scene->exact.ops->shock(solution, m.scene->until), 0.35, 0.003); /* as the file says */
    kith_free(&solution);
  }
  destroy(&m);
}

/* Every node of the octant is a node of the whole box, with the same energy. */
static void octant_is_a_part(void) {
  struct made whole, part;
  const char *resolution = NDIM == 3 ? "10" : "20";
  if (create(&whole, "sedov", resolution, "equal-mass") &&
      create(&part, "sedov-octant", resolution, "equal-mass")) {
    CHECK(part.nodes->n_internal * (1 << NDIM) == whole.nodes->n_internal);
    kith_index found = 0;
    for (kith_index i = 0; i < part.nodes->n_internal; ++i) {
      for (kith_index j = 0; j < whole.nodes->n_internal; ++j) {
        const double *x = part.nodes->position->f64 + i * NDIM, *y = whole.nodes->position->f64 + j * NDIM;
        if (kith_distance2(x, y) > 1e-24) continue; /* round-off of positions below 1 */
        ++found;
        CHECK_CLOSE(part.hydro.energy->f64[i] / whole.hydro.energy->f64[j], 1, 1e-12);
        CHECK_CLOSE(part.hydro.mass->f64[i] / whole.hydro.mass->f64[j], 1, 1e-13);
      }
    }
    CHECK(found == part.nodes->n_internal);
    destroy(&part);
  }
  destroy(&whole);
}

/* Numbers of nodes that are used in comparisons with other codes. */
static void numbers_of_nodes(void) {
  struct made m;
  if (create(&m, "sod", NULL, "equal-mass")) {
    const kith_index n = m.nodes->n_internal;
    if (NDIM == 1) CHECK(n == 200 + 25);
    double low = INFINITY, high = 0;
    for (kith_index i = 0; i < n; ++i) {
      low = fmin(low, m.hydro.mass->f64[i]);
      high = fmax(high, m.hydro.mass->f64[i]);
    }
    CHECK(high / low < 1.005); /* the widths in the file are whole cells on both sides */
  }
  destroy(&m);
  if (create(&m, "noh", NULL, "equal-mass") && NDIM == 1) CHECK(m.nodes->n_internal == 110);
  destroy(&m);
  if (create(&m, "sedov", NULL, "equal-mass"))
    CHECK(m.nodes->n_internal == (NDIM == 1 ? 200 : NDIM == 2 ? 10000 : 125000));
  destroy(&m);
  if (create(&m, "sod-two-materials", NULL, "equal-mass")) {
    CHECK(m.nodes->n_lists == 2 && m.nodes->lists[0].count > m.nodes->lists[1].count);
    CHECK(strcmp(m.nodes->lists[0].name, "driver") == 0 && strcmp(m.nodes->lists[1].name, "driven") == 0);
  }
  destroy(&m);
}

/* Scenes with an exact solution. */
static const char scenes[] =
    "sod|sod-two-materials|sedov|sedov-octant|noh|acoustic-wave|noisy-box|periodic-drift|sph-sod|lax|toro-1|"
    "toro-2|toro-3|toro-4|toro-5|leblanc|free-expansion|two-blasts|entropy-wave|square|heat-wave|slabs|"
    "viscous-wave|saltzman|sedov-gradient|water-tube|tait-tube|isothermal-tube|slow-shock|copper-piston|"
    "copper-table"
#if KITH_NDIM > 1
    "|gresho|yee"
#endif
    ;

int main(void) {
  const char *words = scenes, *word;
  size_t length;
  while (kith_next_word(&words, &word, &length)) {
    char name[32];
    snprintf(name, sizeof name, "%.*s", (int)length, word);
    check_scene(name, NULL, "equal-mass");
    if (strcmp(name, "yee") == 0) continue; /* its box is large */
    check_scene(name, NDIM == 1 ? "50" : "20", "equal-mass");
    check_scene(name, NDIM == 1 ? "50" : "20", "equal-spacing");
  }
  check_gravity_scene("hydrostatic", true);
  check_gravity_scene("ring", true);
  check_gravity_scene("rayleigh-taylor", NDIM > 1);
  check_blast("sedov", 1);
  check_blast("sedov-octant", pow(0.5, NDIM));
  octant_is_a_part();
  numbers_of_nodes();
  return check_failed();
}
