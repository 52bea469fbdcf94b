/* Scenes: one that is read right in every dimension, and one message for each thing that can be wrong. */
#include "app/scene.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "app/keys.h"
#include "tests/check.h"

static void check_message(const char *what, kith_status status, const char *wanted) {
  if (status == KITH_BAD_INPUT && strcmp(kith_failure(), wanted) == 0) return;
  ++check_failures;
  fprintf(stderr, "%s\n  gave   %s: %s\n  wanted %s\n", what, kith_status_text(status),
          status == KITH_OK ? "" : kith_failure(), wanted);
}

/* Overrides that every dimension needs: the scene below is written once. */
static const char *dimension_override(void) {
  return NDIM == 1 ? "dimension=1" : NDIM == 2 ? "dimension=2" : "dimension=3";
}

static kith_status read_text(struct kith_scene **scene, const char *text, const char *override_) {
  const char *overrides[] = {dimension_override(), override_};
  return kith_scene_parse(scene, "f", text, strlen(text), override_ == NULL ? 1 : 2, overrides);
}

/* --- a scene that is right --- */

static const char sod[] =
    "scene: sod\n"
    "dimension: 3\n"
    "resolution: 60                    # nodes per unit length in the densest region\n"
    "domain: {lower: [-1, 0, 0], upper: [1, 0.2, 0.2]}\n"
    "boundaries: {x: reflecting, y: periodic, z: periodic}\n"
    "materials:\n"
    "  gas: {eos: ideal, gamma: 1.4}\n"
    "regions:\n"
    "  - {material: gas, where: {x: [-1, 0]}, lattice: bcc, density: 1.0,   pressure: 1.0}\n"
    "  - {material: gas, where: {x: [0, 1]},  lattice: bcc, density: 0.125, pressure: 0.1}\n"
    "method: {package: sph, kernel: wendland-c2, neighbors: 60, energy: compatible, viscosity: {name: limited, alpha: 1, beta: 2}}\n"
    "scheme: {name: leapfrog, cfl: 0.3}\n"
    "until: 0.2\n"
    "exact: {name: riemann}\n"
    "output: {every: 0.05}\n";

static void sod_regions(const struct kith_scene *s) {
  const double origin[NDIM] = {0};
  double value;
  CHECK(s->n_regions == 2 && s->n_materials == 1 && strcmp(s->material_name[0], "gas") == 0);
  CHECK(s->material[0].eos == &kith_eos_ideal && s->material[0].parameters.gamma == 1.4);
  const struct kith_region *right = &s->region[1];
  CHECK(right->where.box.lower[0] == 0 && right->where.box.upper[0] == 1 && !right->where.has_ball);
  CHECK(NDIM == 1 || isinf(right->where.box.lower[NDIM - 1]));
  CHECK(right->lattice == KITH_LATTICE_BCC && right->material == 0 && right->energy == NULL &&
        !right->frozen);
  CHECK(right->place.line == 10 && strcmp(right->place.file, "f") == 0);
  CHECK_OK(kith_expression_at(right->density, origin, &value));
  CHECK(value == 0.125);
  CHECK_OK(kith_expression_at(right->velocity[NDIM - 1], origin, &value));
  CHECK(value == 0);
}

static void sod_rest(const struct kith_scene *s) {
  CHECK(strcmp(s->name, "sod") == 0 && s->dimension == NDIM && s->resolution == 60 && s->until == 0.2);
  CHECK(s->arrangement == KITH_EQUAL_MASS && !s->reproducible && s->traversal[0] == '\0');
  CHECK(s->domain.lower[0] == -1 && s->domain.upper[0] == 1 &&
        (NDIM == 1 || s->domain.upper[NDIM - 1] == 0.2));
  CHECK(s->boundary[0].lower == kith_boundary_find("reflecting") &&
        s->boundary[0].upper == s->boundary[0].lower);
  CHECK(NDIM == 1 || s->boundary[NDIM - 1].upper == kith_boundary_find("periodic"));
  CHECK(strcmp(s->method.package, "sph") == 0 && strcmp(s->method.kernel, "wendland-c2") == 0);
  CHECK(s->method.neighbors == 60 && s->method.compatible && strcmp(s->method.viscosity, "limited") == 0);
  CHECK(s->method.alpha == 1 && s->method.beta == 2);
  CHECK(strcmp(s->scheme.name, "leapfrog") == 0 && s->scheme.cfl == 0.3 && s->scheme.dt == 0);
  CHECK(s->neighbor.search == kith_search_find("tree") && strcmp(s->connectivity.rebuild, "always") == 0);
  CHECK(s->connectivity.skin < 0 && s->connectivity.cull && s->connectivity.reorder == 0);
  CHECK(s->output.every == 0.05 && s->output.plot && s->output.checkpoint == 0 &&
        !s->output.checkpoint_at_end);
  const struct kith_exact_parameters *p = &s->exact.parameters;
  CHECK(s->exact.ops == kith_exact_find("riemann") && s->exact.window.kind == KITH_WINDOW_ALL);
  CHECK(p->gamma[0] == 1.4 && p->gamma[1] == 1.4 && p->density[0] == 1 && p->density[1] == 0.125);
  CHECK(p->pressure[0] == 1 && p->pressure[1] == 0.1 && p->velocity[0] == 0 && p->interface_position == 0);
}

static void example(void) {
  struct kith_scene *s;
  CHECK_OK(read_text(&s, sod, NULL));
  if (s == NULL) return;
  sod_regions(s);
  sod_rest(s);
  struct kith_scene *again; /* its text is the same scene, and the same text */
  CHECK_OK(kith_scene_parse(&again, "g", s->text, strlen(s->text), 0, NULL));
  CHECK(again != NULL && strcmp(again->text, s->text) == 0);
  kith_scene_destroy(&again);
  kith_scene_destroy(&s);
  CHECK(s == NULL);
}

static void reads_overrides(void) {
  struct kith_scene *s;
  const char *overrides[] = {dimension_override(),
                             "scheme.cfl=0.1",
                             "method.viscosity.name=monaghan",
                             "scheme.cfl=0.2",
                             "regions.1.pressure=0.2",
                             "connectivity.rebuild= displacement | entity-change",
                             "neighbor.search=brute",
                             "method.neighbors={1d: 11, 2d: 22, 3d: 33}",
                             "output.plot=no",
                             "arrangement=equal-spacing",
                             "method.energy=thermal",
                             "scene="};
  CHECK_OK(kith_scene_parse(&s, "a/b.c.yaml", sod, strlen(sod), sizeof overrides / sizeof overrides[0],
                            overrides));
  if (s == NULL) return;
  CHECK(s->scheme.cfl == 0.2 && strcmp(s->method.viscosity, "monaghan") == 0 &&
        s->method.neighbors == 11 * NDIM);
  CHECK(s->exact.parameters.pressure[1] == 0.2 && s->neighbor.search == kith_search_find("brute"));
  CHECK(strcmp(s->connectivity.rebuild, "displacement | entity-change") == 0 && !s->output.plot);
  CHECK(s->arrangement == KITH_EQUAL_SPACING && !s->method.compatible && strcmp(s->name, "b.c") == 0);
  CHECK(strstr(s->text, "cfl: 0.2\n") != NULL && strstr(s->text, "cfl: 0.1\n") == NULL);
  CHECK_OK(kith_scene_check_word(s, "method.kernel", s->method.kernel, "cubic|wendland-c2"));
  check_message("word", kith_scene_check_word(s, "method.package", s->method.package, "|sphe|crk"),
                "a/b.c.yaml:11: method.package: 'sph' is not one of sphe, crk; did you mean 'sphe'?");
  kith_scene_destroy(&s);
}

/* --- derived exact solutions --- */

#define BASE                                                            \
  "scene: base\n"                                                       \
  "dimension: 3\n"                                                      \
  "resolution: 20\n"                                                    \
  "domain: {lower: [0, 0, 0], upper: [1, 1, 1]}\n"                      \
  "boundaries: {x: reflecting, y: reflecting, z: [reflecting, open]}\n" \
  "materials: {gas: {gamma: 1.5}}\n"                                    \
  "until: 0.2\n"

static struct kith_scene *read_exact(const char *rest) {
  char text[2048];
  struct kith_scene *scene;
  snprintf(text, sizeof text, "%s%s", BASE, rest);
  CHECK_OK(read_text(&scene, text, NULL));
  return scene;
}

static void derives_sedov(void) {
  struct kith_scene *s = read_exact(
      "regions: [{material: gas, density: 2, energy: 1e-3}]\n"
      "energy: {energy: 0.125, center: [0, 0, 0], over: kernel, spacings: 2}\n"
      "exact: {name: sedov, window: {r: [0.1, 0.7]}}\n");
  if (s == NULL) return;
  const struct kith_exact_parameters *p = &s->exact.parameters;
  CHECK(p->gamma[0] == 1.5 && p->density[0] == 2 && p->blast_energy == 0.125 * (1 << NDIM));
  CHECK_CLOSE(p->pressure[0], 1e-3, 1e-18); /* 0.5 * 2 * 1e-3, rounded */
  CHECK(s->exact.window.kind == KITH_WINDOW_BALL && s->exact.window.inner == 0.1 &&
        s->exact.window.outer == 0.7);
  CHECK(s->n_deposits == 1 && s->deposit->shape == KITH_DEPOSIT_KERNEL && s->deposit->spacings == 2);
  CHECK(s->deposit->place.line == 9);
  kith_scene_destroy(&s);
  s = read_exact(/* on no face but the upper one of x: two halves */
                 "regions: [{material: gas, density: 2, pressure: 1e-3}]\n"
                 "energy:\n  - {energy: 1, center: [1, 0.5, 0.5]}\n"
                 "exact: {name: sedov}\n");
  if (s == NULL) return;
  CHECK(s->exact.parameters.blast_energy == 2 && s->exact.parameters.center[0] == 1);
  CHECK(s->deposit->shape == KITH_DEPOSIT_POINT && s->deposit->place.line == 10);
  kith_scene_destroy(&s);
}

static void derives_others(void) {
  struct kith_scene *s = read_exact(
      "regions: [{material: gas, density: 1, pressure: 1e-6, velocity: ['-2*x/r', '-2*y/r', '-2*z/r']}]\n"
      "exact: {name: noh, window: {x: [0.25, 0.75]}}\n");
  if (s != NULL) CHECK_CLOSE(s->exact.parameters.velocity[0], 2, 1e-14); /* a root of a sum of squares */
  if (s != NULL) CHECK(s->exact.window.kind == KITH_WINDOW_SLAB && s->exact.window.center[0] == 0.5);
  if (s != NULL) CHECK(s->exact.window.inner == 0 && s->exact.window.outer == 0.25);
  kith_scene_destroy(&s);
  s = read_exact(
      "regions: [{material: gas, density: 1, pressure: 2, velocity: [1, 2, 3]}]\nexact: {name: uniform}\n");
  if (s != NULL)
    CHECK(s->exact.parameters.uniform_velocity[NDIM - 1] == NDIM && s->exact.parameters.pressure[0] == 2);
  kith_scene_destroy(&s);
  s = read_exact(
      "regions: [{material: gas, density: '1+0.01*sin(2*pi*x)', pressure: 2}]\n"
      "exact: {name: acoustic-wave, amplitude: 0.01, density: 1, pressure: 2, wavelength: 0.5}\n");
  if (s != NULL) CHECK(s->exact.parameters.wavelength == 0.5 && s->exact.parameters.origin == 0);
  if (s != NULL) CHECK(s->exact.parameters.gamma[0] == 1.5 && s->exact.parameters.uniform_velocity[0] == 0);
  kith_scene_destroy(&s);
  s = read_exact(
      "regions:\n  - {material: gas, density: 1, pressure: 2, where: {x: [0.25, 1]}, velocity: [3, 0, 0]}\n"
      "  - {material: gas, density: 4, pressure: 5, where: {x: [0, 0.25]}}\n"
      "exact: {name: riemann, pressure: [6, 7], gamma: 2}\n");
  if (s != NULL) CHECK(s->exact.parameters.density[0] == 4 && s->exact.parameters.velocity[1] == 3);
  if (s != NULL) CHECK(s->exact.parameters.pressure[0] == 6 && s->exact.parameters.gamma[1] == 2);
  if (s != NULL) CHECK(s->exact.parameters.interface_position == 0.25);
  kith_scene_destroy(&s);
}

/* --- shapes and values --- */

static void reads_shapes(void) {
  struct kith_scene *s = read_exact(
      "regions:\n"
      "  - {material: gas, density: 1, pressure: 1, lattice: {1d: fcc, 2d: cubic, 3d: fcc}, jitter: 0.5,\n"
      "     seed: 18446744073709551615, spacing: 0.1, frozen: true, where: {ball: {center: [1, 2, 3], radius: 4}}}\n"
      "  - {material: gas, density: 1, pressure: 1, where: {outside-ball: {center: [0, 0, 0], radius: 1}, z: [0, 1],\n"
      "     half-space: {point: [1, 1, 1], normal: [2, 0, 0]}, inside: 'x > y'}}\n");
  if (s == NULL) return;
  const struct kith_region *r = s->region;
  CHECK(r[0].where.has_ball && !r[0].where.outside_ball && r[0].where.radius == 4 &&
        r[0].where.center[NDIM - 1] == NDIM);
  CHECK(r[0].lattice == (NDIM == 2 ? KITH_LATTICE_CUBIC : KITH_LATTICE_FCC) && r[0].jitter == 0.5);
  CHECK(r[0].seed == UINT64_MAX && r[0].spacing == 0.1 && r[0].frozen);
  CHECK(r[1].where.has_ball && r[1].where.outside_ball && r[1].where.has_half_space &&
        r[1].where.inside != NULL);
  CHECK(r[1].where.normal[0] == 2 && isinf(r[1].where.box.upper[0]) && r[1].where.box.upper[NDIM - 1] >= 1);
  CHECK(r[1].lattice == (NDIM == 1 ? KITH_LATTICE_CUBIC : NDIM == 2 ? KITH_LATTICE_HCP : KITH_LATTICE_BCC));
  CHECK(s->boundary[0].upper != NULL && (NDIM < 3 || s->boundary[NDIM - 1].upper == NULL));
  kith_scene_destroy(&s);
}

static void reads_across(void) {
  struct kith_scene *s = read_exact("regions: [{material: gas, density: 1, pressure: 1}]\n");
  kith_scene_destroy(&s);
  char text[2048];
  snprintf(text, sizeof text, "%sregions: [{material: gas, density: 1, pressure: 1}]\n", BASE);
  CHECK_OK(read_text(&s, text, "domain.across=8"));
  if (s == NULL) return;
  CHECK(s->domain.upper[0] == 1 && (NDIM == 1 || s->domain.upper[NDIM - 1] == 8 / 20.0));
  kith_scene_destroy(&s);
}

/* --- what is wrong --- */

/* Line 2 is the dimension; the tables below put other lines in the place of one, or behind the last (11). */
static const char *const lines[] = {
    "scene: base",
    "dimension: {1d: 1, 2d: 2, 3d: 3}",
    "resolution: 20",
    "domain: {lower: [0, 0, 0], upper: [1, 1, 1]}",
    "boundaries: {x: reflecting, y: periodic, z: periodic}",
    "materials: {gas: {gamma: 1.4}}",
    "regions:",
    "  - {material: gas, where: {x: [0, 0.5]}, density: 1, pressure: 1}",
    "  - {material: gas, where: {x: [0.5, 1]}, density: 0.125, pressure: 0.1}",
    "until: 0.2",
    ""};
enum { N_LINES = sizeof lines / sizeof lines[0] };

struct wrong {
  int line;
  const char *text, *message;
};

static void base_with(char *text, size_t size, int line, const char *replacement) {
  size_t used = 0;
  for (int i = 0; i < N_LINES; ++i)
    used += (size_t)snprintf(text + used, size - used, "%s\n", i + 1 == line ? replacement : lines[i]);
}

static void refuse(const struct wrong *wrong, int n) {
  for (int i = 0; i < n; ++i) {
    char text[4096];
    struct kith_scene *scene;
    base_with(text, sizeof text, wrong[i].line, wrong[i].text);
    check_message(wrong[i].text, kith_scene_parse(&scene, "f", text, strlen(text), 0, NULL),
                  wrong[i].message);
    CHECK(scene == NULL);
  }
}
#define REFUSE(table) refuse(table, sizeof(table) / sizeof(table)[0])

static const struct wrong keys[] = {
    {1, "scen: base", "f:1: scen: unknown key; did you mean 'scene'?"},
    {11, "outputs: {}", "f:11: outputs: unknown key; did you mean 'output'?"},
    {11, "method: {kernl: cubic}", "f:11: method.kernl: unknown key; did you mean 'kernel'?"},
    {11, "method:\n  package: sph\n  viscosity:\n    alfa: 1",
     "f:14: method.viscosity.alfa: unknown key; did you mean 'alpha'?"},
    {11, "scheme: {order_of_accuracy: 2}",
     "f:11: scheme.order_of_accuracy: unknown key; known are name, cfl, dt"},
    {8, "  - {material: gas, densty: 1}", "f:8: regions.0.densty: unknown key; did you mean 'density'?"},
    {8, "  - {material: gas, density: 1, pressure: 1, where: {outside_bal: 1}}",
     "f:8: regions.0.where.outside_bal: unknown key; did you mean 'outside-ball'?"},
    {8, "  - {material: gas, density: 1, pressure: 1, where: {ball: {centre: [0, 0, 0], radius: 1}}}",
     "f:8: regions.0.where.ball.centre: unknown key; did you mean 'center'?"},
    {5, "boundaries: {w: open}", "f:5: boundaries.w: unknown key; known are x, y, z"},
    {6, "materials: {gas: {gama: 1.4}}", "f:6: materials.gas.gama: unknown key; did you mean 'gamma'?"},
    {11, "energy: {enrgy: 1}", "f:11: energy.enrgy: unknown key; did you mean 'energy'?"},
    {11, "exact: {name: riemann, windw: {}}", "f:11: exact.windw: unknown key; did you mean 'window'?"},
    {3, "resolution: {1d: 1, 2d: 1, 3d: 1, 4d: 1}",
     "f:3: resolution.4d: unknown key; 1d, 2d and 3d tell dimensions apart"},
    {11, "until: 3", "f:11: until: duplicate key, first on line 10"},
    {11, "<<: {a: 1}",
     "f:11: <<: unknown key; known are scene, dimension, resolution, arrangement, domain, boundaries, "
     "materials, regions, energy, method, scheme, neighbor, connectivity, reproducible, traversal, "
     "until, exact, output"},
};

static const struct wrong missing[] = {
    {2, "", "f:1: dimension: missing; it is required"},
    {3, "", "f:1: resolution: missing; it is required"},
    {3, "resolution:", "f:1: resolution: missing; it is required"},
    {4, "", "f:1: domain: missing; it is required"},
    {4, "domain: {upper: [1, 1, 1]}", "f:4: domain.lower: missing; it is required"},
    {6, "", "f:1: materials: missing; it is required"},
    {6, "materials: {}", "f:6: materials: no material; one is required"},
    {10, "", "f:1: until: missing; it is required"},
    {8, "  - {density: 1, pressure: 1}", "f:8: regions.0.material: missing; it is required"},
    {9, "  - {material: gas, pressure: 1}", "f:9: regions.1.density: missing; it is required"},
    {9, "  - {material: gas, density: 1}",
     "f:9: regions.1.pressure: missing; pressure or energy is required"},
    {8, "  - {material: gas, density: 1, pressure: 1, where: {ball: {center: [0, 0, 0]}}}",
     "f:8: regions.0.where.ball.radius: missing; it is required"},
    {11, "energy: {center: [0, 0, 0]}", "f:11: energy.energy: missing; it is required"},
    {11, "energy: [{energy: 1, over: ball}]",
     "f:11: energy.0.radius: missing; radius or spacings is required"},
    {11, "exact: {}", "f:11: exact.name: missing; it is required"},
    {11, "exact: {name: sedov}", "f:11: exact.blast_energy: missing; it does not follow from this scene"},
    {11, "exact: {name: acoustic_wave}", "f:11: exact.density: missing; it does not follow from this scene"},
};

static const struct wrong types[] = {
    {3, "resolution: many", "f:3: resolution: 'many' is not a number"},
    {3, "resolution: 20 cells", "f:3: resolution: '20 cells' is not a number"},
    {3, "resolution: ''", "f:3: resolution: '' is not a number"},
    {3, "resolution: [20]", "f:3: resolution: a list where a single value belongs"},
    {3, "resolution: {1d: [2], 2d: [2], 3d: [2]}", "f:3: resolution.1d: a list where a single value belongs"},
    {3, "resolution: {1d: x, 2d: x, 3d: x}", "f:3: resolution.1d: 'x' is not a number"},
    {2, "dimension: 2.5", "f:2: dimension: '2.5' is not a whole number"},
    {2, "dimension: two", "f:2: dimension: 'two' is not a number"},
    {1, "scene: {a: 1}", "f:1: scene.a: unknown key; 1d, 2d and 3d tell dimensions apart"},
    {4, "domain: [0, 1]", "f:4: domain: a list where a map belongs"},
    {4, "domain: 1", "f:4: domain: '1' where a map belongs"},
    {4, "domain: {lower: 0, upper: [1, 1, 1]}", "f:4: domain.lower: '0' where a list belongs"},
    {4, "domain: {lower: [0, 0, 0], upper: [1, 1, x]}", "f:4: domain.upper.2: 'x' is not a number"},
    {4, "domain: {lower: [0, 0, 0], upper: [1, 1, ~]}", "f:4: domain.upper.2: has no value"},
    {5, "boundaries: reflecting", "f:5: boundaries: 'reflecting' where a map belongs"},
    {5, "boundaries: {x: {lower: open}}",
     "f:5: boundaries.x.lower: unknown key; 1d, 2d and 3d tell dimensions apart"},
    {5, "boundaries: {x: [open]}", "f:5: boundaries.x: 1 entries, wanted [lower, upper]"},
    {6, "materials: [gas]", "f:6: materials: a list where a map belongs"},
    {6, "materials: {gas: ideal}", "f:6: materials.gas: 'ideal' where a map belongs"},
    {8, "  - gas", "f:8: regions.0: 'gas' where a map belongs"},
    {8, "  -", "f:8: regions.0: '' where a map belongs"},
    {8, "  - {material: gas, density: 1, pressure: 1, where: [0, 1]}",
     "f:8: regions.0.where: a list where a map belongs"},
    {8, "  - {material: gas, density: 1, pressure: 1, where: {x: 0}}",
     "f:8: regions.0.where.x: '0' where a list belongs"},
    {8, "  - {material: gas, density: 1, pressure: 1, where: {x: [0, 1, 2]}}",
     "f:8: regions.0.where.x: 3 entries, wanted 2"},
    {8, "  - {material: gas, density: [1], pressure: 1}",
     "f:8: regions.0.density: a list where a single value belongs"},
    {8, "  - {material: gas, density: 1, pressure: 1, velocity: 1}",
     "f:8: regions.0.velocity: '1' where a list belongs"},
    {8, "  - {material: gas, density: 1, pressure: 1, seed: 1e3}",
     "f:8: regions.0.seed: '1e3' is not a whole number"},
    {8, "  - {material: gas, density: 1, pressure: 1, frozen: 1}",
     "f:8: regions.0.frozen: '1' is not one of true, false"},
    {11, "method: [sph]", "f:11: method: a list where a map belongs"},
    {11, "method: {viscosity: limited}", "f:11: method.viscosity: 'limited' where a map belongs"},
    {11, "reproducible: treu", "f:11: reproducible: 'treu' is not one of true, false; did you mean 'true'?"},
    {11, "exact: riemann", "f:11: exact: 'riemann' where a map belongs"},
    {11, "exact: {name: riemann, density: [1, 2, 3]}", "f:11: exact.density: 3 entries, wanted 2"},
    {11, "output: {checkpoint: 0.5}", "f:11: output.checkpoint: '0.5' is not a whole number"},
};

static const struct wrong ranges[] = {
    {2, "dimension: 4", "f:2: dimension: 4 is out of range [1, 3]"},
    {3, "resolution: 0", "f:3: resolution: 0 is out of range (0, inf)"},
    {3, "resolution: -20", "f:3: resolution: -20 is out of range (0, inf)"},
    {3, "resolution: .nan", "f:3: resolution: .nan is not a finite number"},
    {3, "resolution: .inf", "f:3: resolution: .inf is not a finite number"},
    {3, "resolution: nan", "f:3: resolution: nan is not a finite number"},
    {3, "resolution: 1e999", "f:3: resolution: 1e999 is not a finite number"},
    {10, "until: -1", "f:10: until: -1 is out of range [0, inf)"},
    {10, "until: -.inf", "f:10: until: -.inf is not a finite number"},
    {4, "domain: {lower: [0, 0, 0], upper: [0, 1, 1]}", "f:4: domain.upper: 0 along x is not above lower, 0"},
    {4, "domain: {lower: [2, 0, 0], upper: [1, 1, 1]}", "f:4: domain.upper: 1 along x is not above lower, 2"},
    {4, "domain: {lower: [0, 0, 0], upper: [1, 1, .inf]}",
     "f:4: domain.upper.2: .inf is not a finite number"},
    {4, "domain: {lower: [0, 0, 0], upper: [1, 1, 1], across: 0}",
     "f:4: domain.across: 0 is out of range [1, inf)"},
    {6, "materials: {gas: {gamma: 1}}", "f:6: materials.gas.gamma: 1 is out of range (1, inf)"},
    {6, "materials: {gas: {eos: isothermal, sound_speed: 0}}",
     "f:6: materials.gas.sound_speed: 0 is out of range (0, inf)"},
    {6, "materials: {gas: {}, a-name-that-is-longer-than-any-other: {}}",
     "f:6: materials.a-name-that-is-longer-than-any-other: a name longer than 31 letters"},
    {8, "  - {material: gas, density: 0, pressure: 1}", "f:8: regions.0.density: 0 is out of range (0, inf)"},
    {8, "  - {material: gas, density: 1e999, pressure: 1}",
     "f:8: regions.0.density: 1e999 is not a finite number"},
    {8, "  - {material: gas, density: 1, pressure: .nan}",
     "f:8: regions.0.pressure: .nan is not a finite number"},
    {8, "  - {material: gas, density: 1, energy: -2}", "f:8: regions.0.energy: -2 is out of range [0, inf)"},
    {8, "  - {material: gas, density: 1, pressure: -1}",
     "f:8: regions.0.pressure: -1 needs a negative energy, -2.5"},
    {8, "  - {material: gas, density: 1, pressure: 1, jitter: 0.6}",
     "f:8: regions.0.jitter: 0.6 is out of range [0, 0.5]"},
    {8, "  - {material: gas, density: 1, pressure: 1, seed: -1}",
     "f:8: regions.0.seed: -1 is out of range [0, inf)"},
    {8, "  - {material: gas, density: 1, pressure: 1, seed: 99999999999999999999}",
     "f:8: regions.0.seed: 99999999999999999999 does not fit a 64-bit integer"},
    {8, "  - {material: gas, density: 1, pressure: 1, where: {x: [1, 1]}}",
     "f:8: regions.0.where.x: [1, 1] is empty: the first must be below the second"},
    {8, "  - {material: gas, density: 1, pressure: 1, where: {ball: {center: [0, 0, 0], radius: 0}}}",
     "f:8: regions.0.where.ball.radius: 0 is out of range (0, inf)"},
    {11, "scheme: {cfl: -1}", "f:11: scheme.cfl: -1 is out of range (0, 1]"},
    {11, "scheme: {cfl: 1.01}", "f:11: scheme.cfl: 1.01 is out of range (0, 1]"},
    {11, "method: {neighbors: -4}", "f:11: method.neighbors: -4 is out of range [0, 1000]"},
    {11, "connectivity: {reorder: 9999999999}",
     "f:11: connectivity.reorder: 9999999999 does not fit a 32-bit integer"},
    {11, "connectivity: {skin: -1}", "f:11: connectivity.skin: -1 is out of range [0, inf)"},
    {11, "energy: {energy: -1}", "f:11: energy.energy: -1 is out of range [0, inf)"},
    {11, "exact: {name: riemann, gamma: [1.4, 1]}", "f:11: exact.gamma.1: 1 is out of range (1, inf)"},
    {11, "exact: {name: riemann, window: {r: [-1, 1]}}",
     "f:11: exact.window.r.0: -1 is out of range [0, inf)"},
};

static const struct wrong meanings[] = {
    {5, "boundaries: {x: [periodic, open]}",
     "f:5: boundaries.x: periodic on one side only; it must be on both"},
    {5, "boundaries: {z: [reflecting, periodic]}",
     "f:5: boundaries.z: periodic on one side only; it must be on both"},
    {6, "materials: {gas: {eos: idael}}",
     "f:6: materials.gas.eos: 'idael' is not one of ideal, isothermal, stiffened; did you mean 'ideal'?"},
    {8, "  - {material: gsa, density: 1, pressure: 1}",
     "f:8: regions.0.material: 'gsa' is not one of gas; did you mean 'gas'?"},
    {8, "  - {material: water, density: 1, pressure: 1}",
     "f:8: regions.0.material: 'water' is not one of gas"},
    {8, "  - {material: gas, density: 1, pressure: 1, lattice: fc}",
     "f:8: regions.0.lattice: 'fc' is not one of cubic, bcc, fcc, hcp; did you mean 'fcc'?"},
    {8, "  - {material: gas, density: 1, pressure: 1, energy: 1}",
     "f:8: regions.0.energy: not together with pressure"},
    {8,
     "  - {material: gas, density: 1, pressure: 1, where: {ball: {center: [0, 0, 0], radius: 1},\n"
     "     outside-ball: {center: [0, 0, 0], radius: 2}}}",
     "f:9: regions.0.where.outside-ball: not together with ball; write a shell as inside: \"...\""},
    {11, "arrangement: equal", "f:11: arrangement: 'equal' is not one of equal-mass, equal-spacing"},
    {11, "traversal: pair", "f:11: traversal: 'pair' is not one of pairs, gather; did you mean 'pairs'?"},
    {11, "method: {energy: thermals}",
     "f:11: method.energy: 'thermals' is not one of thermal, compatible; did you mean 'thermal'?"},
    {11, "method: {viscosity: {name: limted}}",
     "f:11: method.viscosity.name: 'limted' is not one of monaghan, limited; did you mean 'limited'?"},
    {11, "method: {kernel: a-name-that-is-longer-than-any-other}",
     "f:11: method.kernel: 'a-name-that-is-longer-than-any-other' is longer than 31 letters"},
    {11, "connectivity: {rebuild: always | nevr}",
     "f:11: connectivity.rebuild: 'nevr' is not one of always, never, entity-change, displacement; did you mean 'never'?"},
    {11, "connectivity: {rebuild: always |}",
     "f:11: connectivity.rebuild: '' is not one of always, never, entity-change, displacement"},
    {11, "connectivity: {rebuild: always never}",
     "f:11: connectivity.rebuild: 'always never' is not one of always, never, entity-change, displacement"},
    {11, "neighbor: {storage: crs}", "f:11: neighbor.storage: 'crs' is not one of csr; did you mean 'csr'?"},
    {11, "energy: {energy: 1, over: bal, radius: 1}",
     "f:11: energy.over: 'bal' is not one of point, ball, kernel; did you mean 'ball'?"},
    {11, "energy: {energy: 1, radius: 1}",
     "f:11: energy.radius: means nothing for a point; add over: ball or kernel"},
    {11, "energy: {energy: 1, over: ball, radius: 1, spacings: 1}",
     "f:11: energy.spacings: not together with radius"},
    {11, "exact: {name: reimann}",
     "f:11: exact.name: 'reimann' is not one of riemann, sedov, noh, acoustic-wave, uniform; did you mean 'riemann'?"},
    {11, "exact: {name: riemann, window: {x: [0, 1], r: [0, 1]}}",
     "f:11: exact.window.r: not together with x"},
};

/* Messages whose words depend on the dimension, or on another room: that they are there, and where. */
static void refused_at(int line, const char *replacement, const char *start, const char *part) {
  char text[4096];
  struct kith_scene *scene;
  base_with(text, sizeof text, line, replacement);
  CHECK_STATUS(KITH_BAD_INPUT, kith_scene_parse(&scene, "f", text, strlen(text), 0, NULL));
  if (strncmp(kith_failure(), start, strlen(start)) == 0 && strstr(kith_failure(), part) != NULL) return;
  ++check_failures;
  fprintf(stderr, "%s\n  gave %s\n  wanted %s ... %s\n", replacement, kith_failure(), start, part);
}

static void refused_elsewhere(void) {
  refused_at(4, "domain: {lower: [0, 0, 0], upper: [1, 1, 1, 1]}", "f:4: domain.upper: 4 entries, wanted ",
             "3");
  refused_at(4, "domain: {lower: [], upper: [1, 1, 1]}", "f:4: domain.lower: 0 entries, wanted ", "3");
  refused_at(5, "boundaries: {y: periodik}", "f:5: boundaries.y: 'periodik' is not one of open, ",
             "; did you mean 'periodic'?");
  refused_at(5, "boundaries: {x: constant}", "f:5: boundaries.x: 'constant' is not one of open, ",
             "periodic");
  refused_at(8, "  - {material: gas, density: 1, pressure: 1, velocity: [1, 0, 0, 0]}",
             "f:8: regions.0.velocity: 4 entries, wanted ", "3");
  refused_at(8, "  - {material: gas, density: '1 +', pressure: 1}", "f:8: regions.0.density: formula '1 +'",
             "");
  refused_at(8, "  - {material: gas, density: q, pressure: 1}", "f:8: regions.0.density: formula 'q'", "");
  refused_at(8, "  - {material: gas, density: '', pressure: 1}", "f:8: regions.0.density: formula ''", "");
  refused_at(8, "  - {material: gas, density: 1, pressure: 1, velocity: [x, y, 'z)']}",
             "f:8: regions.0.velocity.2: formula 'z)'", ""); /* beyond the dimension too */
  refused_at(8, "  - {material: gas, density: 1, pressure: 1,\n     where: {inside: 'x <'}}",
             "f:9: regions.0.where.inside: formula 'x <'", "");
  refused_at(
      8,
      "  - {material: gas, density: 1, pressure: 1, where: {half-space: {point: [0, 0, 0], normal: [0, 0, 0]}}}",
      "f:8: regions.0.where.half-space.normal: has no direction in ", "-D");
  refused_at(11, "neighbor: {search: tre}", "f:11: neighbor.search: 'tre' is not one of ",
             "did you mean 'tree'?");
  refused_at(11, "exact: {name: riemann, density: 1, pressure: [-1, 0]}",
             "f:11: exact.pressure.0: -1 is out of range", "");
}

static void refuses_shapes(void) {
  struct kith_scene *scene;
  const char *wrong = NDIM == 1 ? "dimension=2" : "dimension=1",
             *overrides[] = {wrong, "q=1", "until", "until=-3"};
  char wanted[128];
  snprintf(wanted, sizeof wanted, "--set dimension: %c, but this program is the %d-D one", wrong[10], NDIM);
  check_message(wrong, kith_scene_parse(&scene, "f", sod, strlen(sod), 1, overrides), wanted);
  overrides[0] = dimension_override();
  check_message(
      "q", kith_scene_parse(&scene, "f", sod, strlen(sod), 2, overrides),
      "--set q: unknown key; known are scene, dimension, resolution, arrangement, domain, boundaries, materials, "
      "regions, energy, method, scheme, neighbor, connectivity, reproducible, traversal, until, exact, output");
  overrides[1] = "untill=1";
  check_message("untill", kith_scene_parse(&scene, "f", sod, strlen(sod), 2, overrides),
                "--set untill: unknown key; did you mean 'until'?");
  check_message("until", kith_scene_parse(&scene, "f", sod, strlen(sod), 1, overrides + 2),
                "--set until: write it as key=value");
  overrides[2] = dimension_override();
  check_message("until", kith_scene_parse(&scene, "f", sod, strlen(sod), 2, overrides + 2),
                "--set until: -3 is out of range [0, inf)");
  overrides[3] = "regions=[]";
  check_message("regions", kith_scene_parse(&scene, "f", sod, strlen(sod), 2, overrides + 2),
                "--set regions: no region; one is required");
  if (NDIM == 2)
    refused_at(9, "  - {material: gas, density: 1, pressure: 1,\n     lattice: fcc}",
               "f:10: regions.1.lattice: fcc does not exist in 2-D; cubic, bcc and hcp do", "");
  refused_at(3, NDIM == 1 ? "resolution: {2d: 1}" : "resolution: {1d: 1}",
             NDIM == 1   ? "f:3: resolution.1d: missing, and the scene is 1-D"
             : NDIM == 2 ? "f:3: resolution.2d: missing, and the scene is 2-D"
                         : "f:3: resolution.3d: missing, and the scene is 3-D",
             "");
  if (NDIM > 1)
    refused_at(4, "domain: {lower: [0, 0, 0], upper: [1, 0, 0]}",
               "f:4: domain.upper: 0 along y is not above lower, 0", "");
}

/* --- the rest --- */

static void reads_files(void) {
  char folder[] = "scene_XXXXXX", path[64];
  CHECK(mkdtemp(folder) != NULL);
  snprintf(path, sizeof path, "%s/sod.yaml", folder);
  FILE *file = fopen(path, "w");
  fputs(sod, file);
  fclose(file);
  struct kith_scene *scene;
  const char *overrides[] = {dimension_override(), "dimension=1.5"};
  int dimension = 0;
  CHECK_OK(kith_scene_dimension(path, 0, NULL, &dimension));
  CHECK(dimension == 3);
  CHECK_OK(kith_scene_dimension(path, 1, overrides, &dimension));
  CHECK(dimension == NDIM);
  check_message("1.5", kith_scene_dimension(path, 2, overrides, &dimension),
                "--set dimension: '1.5' is not a whole number");
  CHECK_OK(kith_scene_read(&scene, path, 1, overrides));
  kith_scene_destroy(&scene);
  remove(path);
  CHECK_STATUS(KITH_BAD_INPUT, kith_scene_read(&scene, path, 0, NULL));
  CHECK(scene == NULL);
  CHECK_STATUS(KITH_BAD_INPUT, kith_scene_dimension(path, 0, NULL, &dimension));
  rmdir(folder);
}

/* The reference is a scene once what is required is filled in: so every key in it is known, and every default
 * is allowed. */
static void reference(void) {
  char text[16384] = "";
  FILE *file = tmpfile();
  kith_scene_reference(file);
  rewind(file);
  const size_t length = fread(text, 1, sizeof text, file);
  fclose(file);
  const char *overrides[] = {dimension_override(),      "resolution=1",
                             "domain.lower=[0, 0, 0]",  "domain.upper=[1, 1, 1]",
                             "regions.0.material=NAME", "regions.0.density=1",
                             "regions.0.pressure=1",    "regions.0.where=",
                             "energy.0.energy=1",       "until=1",
                             "exact.name=uniform"};
  struct kith_scene *s;
  CHECK_OK(kith_scene_parse(&s, "f", text, length, sizeof overrides / sizeof overrides[0], overrides));
  CHECK(s != NULL && s->n_regions == 1 && s->n_deposits == 1 && s->scheme.cfl == 0.3);
  kith_scene_destroy(&s);
}

int main(void) {
  example();
  reads_overrides();
  derives_sedov();
  derives_others();
  reads_shapes();
  reads_across();
  REFUSE(keys);
  REFUSE(missing);
  REFUSE(types);
  REFUSE(ranges);
  REFUSE(meanings);
  refused_elsewhere();
  refuses_shapes();
  reads_files();
  reference();
  return check_failed();
}
