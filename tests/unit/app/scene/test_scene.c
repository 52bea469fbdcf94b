/* test_scene.c - correct scenes: every value is where it belongs, in every dimension; parameters of exact
 * solutions that follow from the scene; and the reference of all keys, which is itself a scene. */
#include "app/scene/scene.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "app/scene/params.h"
#include "tests/unit/files.h"
#include "tests/unit/materials.h"
#include "tests/unit/exact_settings.h"
#include "physics/passes/viscosity.h"

/* Settings of package sph begin with those of viscosity. */
static const struct kith_viscosity_settings *viscosity_of(const struct kith_scene *scene) {
  return scene->method.package.settings;
}

/* The override that each dimension needs, since the scene below is written once. */
static const char *dimension_override(void) {
  return NDIM == 1 ? "dimension=1" : NDIM == 2 ? "dimension=2" : "dimension=3";
}

static kith_status read_text(struct kith_scene **scene, const char *text, const char *override_) {
  const char *overrides[] = {dimension_override(), override_};
  return kith_scene_parse(scene, "f", text, strlen(text), override_ == NULL ? 1 : 2, overrides);
}

/* --- a correct scene --- */

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
    "method: {package: sph, kernel: wendland-c2, neighbors: 60, energy: compatible, viscosity: {name: "
    "limited, alpha: 1, beta: 2}}\n"
    "scheme: {name: leapfrog, cfl: 0.3}\n"
    "until: 0.2\n"
    "exact: {name: riemann}\n"
    "output: {every: 0.05}\n";

static void sod_regions(const struct kith_scene *s) {
  const double origin[NDIM] = {0};
  double value;
  CHECK(s->n_regions == 2 && s->n_materials == 1 && strcmp(s->material_name[0], "gas") == 0);
  CHECK(s->material[0].eos == &kith_eos_ideal && material_value(&s->material[0], "gamma") == 1.4);
  const struct kith_region *right = &s->region[1];
  CHECK(right->where.extent[0][0] == 0 && right->where.extent[0][1] == 1 && right->where.inside == NULL);
  CHECK(NDIM == 1 || isinf(right->where.extent[NDIM - 1][0]));
  CHECK(right->lattice == KITH_LATTICE_BCC && right->material == 0 && right->energy == NULL &&
        !right->frozen);
  CHECK(right->node->location.line == 10 && strcmp(right->node->location.file, "f") == 0);
  CHECK_OK(kith_expression_at(right->density, NDIM, origin, &value));
  CHECK(value == 0.125);
  CHECK(right->velocity[NDIM - 1] == NULL);
}

static void sod_rest(const struct kith_scene *s) {
  CHECK(strcmp(s->name, "sod") == 0 && s->dimension == NDIM && s->resolution == 60 && s->until == 0.2);
  CHECK(s->arrangement == KITH_EQUAL_MASS && !s->reproducible && s->traversal[0] == '\0');
  CHECK(s->domain.lower[0] == -1 && s->domain.upper[0] == 1 &&
        (NDIM == 1 || s->domain.upper[NDIM - 1] == 0.2));
  CHECK(s->boundary[0].side[0] == kith_boundary_find("reflecting") &&
        s->boundary[0].side[1] == s->boundary[0].side[0]);
  CHECK(NDIM == 1 || s->boundary[NDIM - 1].side[1] == kith_boundary_find("periodic"));
  CHECK(strcmp(s->method.package.name, "sph") == 0 && s->method.kernel == KITH_KERNEL_wendland_c2);
  CHECK(s->method.neighbors == 60 && s->method.compatible && viscosity_of(s)->name == KITH_VISCOSITY_LIMITED);
  CHECK(viscosity_of(s)->alpha == 1 && viscosity_of(s)->beta == 2);
  CHECK(strcmp(s->scheme.member.name, "leapfrog") == 0 && s->scheme.cfl == 0.3 && s->scheme.dt == 0);
  CHECK(strcmp(s->neighbor.search.name, "tree") == 0 && strcmp(s->connectivity.rebuild, "always") == 0);
  CHECK(s->connectivity.skin < 0 && s->connectivity.cull && s->connectivity.reorder == 20);
  CHECK(s->output.picture.kind == KITH_PICTURE_AUTO && isnan(s->output.picture.range[0]));
  CHECK(s->output.every == 0.05 && s->output.plot && s->output.checkpoint == 0 &&
        !s->output.checkpoint_at_end);
  const struct exact_parameters held = exact_parameters_of(s->exact.ops, s->exact.settings), *p = &held;
  CHECK(s->exact.ops == kith_exact_find("riemann") && s->exact.window.x[1] == INFINITY &&
        s->exact.window.r[1] == INFINITY);
  CHECK(p->gamma[0] == 1.4 && p->gamma[1] == 1.4 && p->density[0] == 1 && p->density[1] == 0.125);
  CHECK(p->pressure[0] == 1 && p->pressure[1] == 0.1 && p->velocity[0] == 0 && p->interface_position == 0);
}

static void example(void) {
  struct kith_scene *s;
  CHECK_OK(read_text(&s, sod, NULL));
  if (s == NULL) return;
  sod_regions(s);
  sod_rest(s);
  struct kith_scene *again; /* its text parses to the same scene, and the same text */
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
  CHECK(s->scheme.cfl == 0.2 && viscosity_of(s)->name == KITH_VISCOSITY_MONAGHAN &&
        s->method.neighbors == 11 * NDIM);
  CHECK(exact_parameters_of(s->exact.ops, s->exact.settings).pressure[1] == 0.2 &&
        strcmp(s->neighbor.search.name, "brute") == 0);
  CHECK(strcmp(s->connectivity.rebuild, "displacement | entity-change") == 0 && !s->output.plot);
  CHECK(s->arrangement == KITH_EQUAL_SPACING && !s->method.compatible && strcmp(s->name, "b.c") == 0);
  CHECK(strstr(s->text, "cfl: 0.2\n") != NULL && strstr(s->text, "cfl: 0.1\n") == NULL);
  kith_scene_destroy(&s);
}

/* Keys that an override of another key leaves without a meaning are dropped. */
static void drops_idle_keys(void) {
  static const char *const overrides[] = {"probes=[]", "measure.growth=false"};
  struct kith_scene *s;
  char text[2048];
  snprintf(text, sizeof text,
           "%s%sconnectivity: {storage: compressed}\nprobes: [{name: p, at: [0.1, 0.1, 0.1]}]\n", sod,
           NDIM > 1 ? "measure: {rate: 2, growth: true}\n" : "");
  for (int k = 0; k < (NDIM > 1 ? 2 : 1); ++k) {
    CHECK_OK(read_text(&s, text, overrides[k]));
    kith_scene_destroy(&s);
  }
}

/* --- derived exact solutions --- */

#define BASE                                                            \
  "scene: base\n"                                                       \
  "dimension: 3\n"                                                      \
  "resolution: 20\n"                                                    \
  "domain: {lower: [0, 0, 0], upper: [1, 1, 1]}\n"                      \
  "boundaries: {x: reflecting, y: reflecting, z: [reflecting, open]}\n" \
  "materials: {gas: {gamma: 3/2}}\n"                                    \
  "until: 0.2\n"

/* KEY?=VALUE is dropped if it means nothing, whether the value is a word or a map; KEY=VALUE is refused. */
static void drops_optional_maps(void) {
  static const char text[] =
      BASE "regions: [{material: gas, density: 2, energy: 1}]\nmethod: {package: mfm}\n";
  struct kith_scene *s;
  CHECK_OK(read_text(&s, text, "method.viscosity?={name: monaghan, alpha: 2}"));
  kith_scene_destroy(&s);
  CHECK_STATUS(KITH_BAD_INPUT, read_text(&s, text, "method.viscosity={name: monaghan, alpha: 2}"));
}

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
      "exact: {name: sedov, window: {r: [1/10, 0.7]}}\n");
  if (s == NULL) return;
  const struct exact_parameters held = exact_parameters_of(s->exact.ops, s->exact.settings), *p = &held;
  CHECK(p->gamma[0] == 1.5 && p->density[0] == 2 && p->blast_energy == 0.125 * (1 << NDIM));
  CHECK_CLOSE(p->pressure[0], 1e-3, 1e-18); /* 0.5 * 2 * 1e-3, rounded */
  CHECK(s->exact.window.x[0] == -INFINITY && s->exact.window.r[0] == 0.1 && s->exact.window.r[1] == 0.7);
  CHECK(s->n_deposits == 1 && s->deposit->shape == KITH_DEPOSIT_KERNEL && s->deposit->spacings == 2);
  CHECK(s->deposit->node->location.line == 9);
  kith_scene_destroy(&s);
  s = read_exact(/* on the upper face of x only: two halves */
                 "regions: [{material: gas, density: 2, pressure: 1e-3}]\n"
                 "energy:\n  - {energy: 1, center: [1, 0.5, 0.5]}\n"
                 "exact: {name: sedov}\n");
  if (s == NULL) return;
  const struct exact_parameters halves = exact_parameters_of(s->exact.ops, s->exact.settings);
  CHECK(halves.blast_energy == 2 && halves.center[0] == 1);
  CHECK(s->deposit->shape == KITH_DEPOSIT_POINT && s->deposit->node->location.line == 10);
  kith_scene_destroy(&s);
}

static void derives_others(void) {
  struct exact_parameters p;
  struct kith_scene *s = read_exact(
      "regions: [{material: gas, density: 1, pressure: 1e-6, velocity: ['-2*x/r', '-2*y/r', '-2*z/r']}]\n"
      "exact: {name: noh, velocity: 2, window: {x: [0.25, 0.75]}}\n");
  if (s == NULL) return;
  p = exact_parameters_of(s->exact.ops, s->exact.settings);
  CHECK(p.density[0] == 1 && s->exact.window.x[0] == 0.25 && s->exact.window.x[1] == 0.75);
  CHECK(s->region->lattice == (NDIM == 1   ? KITH_LATTICE_CUBIC
                               : NDIM == 2 ? KITH_LATTICE_HCP
                                           : KITH_LATTICE_BCC));
  kith_scene_destroy(&s);
  s = read_exact(
      "regions: [{material: gas, density: 1, pressure: 2, velocity: [1, 2, 3]}]\nexact: {name: uniform}\n");
  if (s == NULL) return;
  p = exact_parameters_of(s->exact.ops, s->exact.settings);
  CHECK(p.uniform_velocity[NDIM - 1] == NDIM && p.pressure[0] == 2);
  kith_scene_destroy(&s);
  s = read_exact(
      "regions: [{material: gas, density: '1+0.01*sin(2*pi*x)', pressure: 2}]\n"
      "exact: {name: acoustic-wave, amplitude: 0.01, density: 1, pressure: 2, wavelength: 0.5}\n");
  if (s == NULL) return;
  p = exact_parameters_of(s->exact.ops, s->exact.settings);
  CHECK(p.wavelength == 0.5 && p.origin == 0 && p.gamma[0] == 1.5 && p.uniform_velocity[0] == 0);
  kith_scene_destroy(&s);
  s = read_exact(
      "regions:\n  - {material: gas, density: 1, pressure: 2, where: {x: [0.25, 1]}, velocity: [3, 0, 0]}\n"
      "  - {material: gas, density: 4, pressure: 5, where: {x: [0, 0.25]}}\n"
      "exact: {name: riemann, pressure: [6, 7], gamma: 2}\n");
  if (s == NULL) return;
  p = exact_parameters_of(s->exact.ops, s->exact.settings);
  CHECK(p.density[0] == 4 && p.velocity[1] == 3 && p.pressure[0] == 6 && p.gamma[1] == 2);
  CHECK(p.interface_position == 0.25);
  kith_scene_destroy(&s);
}

/* A vortex: gamma, density and the velocity that carries it; its pressure varies, so it must be given. */
static void derives_gresho(void) {
  static const char text[] = BASE
      "regions: [{material: gas, density: 3, pressure: 5 + x, equilibrium: true}]\n"
      "exact: {name: gresho, pressure: 5, uniform_velocity: [1, 2, 3], window: {r: [0, 0.5]}}\n";
  struct kith_scene *s;
  if (NDIM == 1) {
    check_message("1-D", read_text(&s, text, "boundaries.x=periodic"),
                  "f:9: exact: exact solution gresho: a vortex needs 2 or 3 dimensions");
    return;
  }
  CHECK_OK(read_text(&s, text, "boundaries.x=periodic"));
  if (s == NULL) return;
  const struct exact_parameters held = exact_parameters_of(s->exact.ops, s->exact.settings), *p = &held;
  CHECK(s->exact.ops == &kith_exact_gresho && p->gamma[0] == 1.5 && p->density[0] == 3 &&
        p->pressure[0] == 5);
  CHECK(p->period[0] == 1 && p->period[NDIM - 1] == 0 && p->uniform_velocity[NDIM - 1] == NDIM);
  CHECK(s->exact.window.r[1] == 0.5 && s->region[0].equilibrium);
  kith_scene_destroy(&s);
}

/* --- shapes and values --- */

static void reads_shapes(void) {
  struct kith_scene *s = read_exact(
      "regions:\n"
      "  - {material: gas, density: 1, pressure: 1, lattice: {1d: fcc, 2d: cubic, 3d: fcc}, jitter: 0.5,\n"
      "     seed: 18446744073709551615, spacing: 0.1, frozen: true, where: {inside: 'r < 4'}}\n"
      "  - {material: gas, density: 1, pressure: 1, where: {z: [0, 1], inside: 'x > y'}}\n");
  if (s == NULL) return;
  const struct kith_region *r = s->region;
  CHECK(r[0].where.inside != NULL && isinf(r[0].where.extent[2][1]));
  CHECK(r[0].lattice == (NDIM == 2 ? KITH_LATTICE_CUBIC : KITH_LATTICE_FCC) && r[0].jitter == 0.5);
  CHECK(r[0].seed == UINT64_MAX && r[0].spacing == 0.1 && r[0].frozen && !r[0].equilibrium);
  CHECK(r[1].where.inside != NULL && isinf(r[1].where.extent[0][1]) && r[1].where.extent[2][1] == 1);
  CHECK(r[1].lattice == (NDIM == 1 ? KITH_LATTICE_CUBIC : NDIM == 2 ? KITH_LATTICE_HCP : KITH_LATTICE_BCC));
  CHECK(s->boundary[0].side[1] != NULL && (NDIM < 3 || s->boundary[NDIM - 1].side[1] == NULL));
  kith_scene_destroy(&s);
}

static void reads_across(void) {
  struct kith_scene *s;
  CHECK_OK(read_text(&s, BASE "regions: [{material: gas, density: 1, pressure: 1}]\n", "domain.across=8"));
  if (s == NULL) return;
  CHECK(s->domain.upper[0] == 1 && (NDIM == 1 || s->domain.upper[NDIM - 1] == 8 / 20.0));
  kith_scene_destroy(&s);
}

static void reads_pictures(void) {
  if (NDIM < 3) return; /* slices need 3 dimensions */
  struct kith_scene *s = read_exact(
      "regions: [{material: gas, density: 1, pressure: 1}]\nexact: {name: uniform}\n"
      "output:\n"
      "  plot: {kind: slice, field: [pressure, velocity-y, density-error], plane: {y: 0.25},\n"
      "    range: [1, 2], frames: true}\n");
  if (s == NULL) return;
  const struct kith_picture *p = &s->output.picture;
  CHECK(s->output.plot && p->kind == KITH_PICTURE_SLICE && p->frames && p->fields.n == 3);
  CHECK(p->fields.panel[0].field == KITH_PICTURE_PRESSURE &&
        p->fields.panel[1].field == KITH_PICTURE_VELOCITY_Y);
  CHECK(p->fields.panel[2].field == KITH_PICTURE_DENSITY && p->fields.panel[2].error &&
        !p->fields.panel[1].error);
  CHECK(p->plane[1] == 0.25 && isnan(p->plane[0]) && isnan(p->plane[2]) && p->range[1] == 2);
  kith_scene_destroy(&s);
}

/* Both ends of an edge are points, however long the spacing is. */
static void counts_probe_points(void) {
  static const struct {
    const char *along;
    int points;
  } tries[] = {{"0", 1}, {"0.001", 2}, {"0.02", 2}, {"0.05", 4}, {"0.5", 31}};
  for (size_t k = 0; k < sizeof tries / sizeof *tries; ++k) {
    struct kith_scene *s;
    char probes[96];
    snprintf(probes, sizeof probes, "probes=[{name: p, at: [0, 0, 0], along: [%s, 0, 0]}]", tries[k].along);
    CHECK_OK(read_text(&s, sod, probes));
    if (s == NULL) continue;
    CHECK(s->probe->points[0] == tries[k].points && s->probe->points[1] == 1 && s->probe->points[2] == 1);
    kith_scene_destroy(&s);
  }
}

/* --- files, the reference, comparison --- */

static void reads_files(void) {
  directory_make();
  const char *const path = path_in("sod.yaml");
  write_text(path, sod);
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
  unlink(path);
  CHECK_STATUS(KITH_BAD_INPUT, kith_scene_read(&scene, path, 0, NULL));
  CHECK(scene == NULL);
  CHECK_STATUS(KITH_BAD_INPUT, kith_scene_dimension(path, 0, NULL, &dimension));
  directory_remove(0, NULL);
}

/* The reference is a scene once required values are given: so all keys in it are known, and all defaults
 * allowed. */
static void reference(void) {
  static char text[1 << 16];
  FILE *file = tmpfile();
  kith_scene_reference(file);
  rewind(file);
  const size_t length = fread(text, 1, sizeof text, file);
  CHECK(length < sizeof text);
  fclose(file);
  const char *overrides[] = {dimension_override(),
                             "resolution=1",
                             "domain.lower=[0, 0, 0]",
                             "domain.upper=[1, 1, 1]",
                             "regions.0.material=NAME",
                             "regions.0.density=1",
                             "regions.0.pressure=1",
                             "regions.0.where=",
                             "energy.0.energy=1",
                             "until=1",
                             "packages.0.name=conduction",
                             "packages.0.conductivity=1",
                             "exact.name=uniform",
                             "measure.rate=",
                             "probes.0.name=p",
                             "probes.0.at=[0, 0, 0]",
                             "connectivity.contacts=",
                             "arrangement="};
  struct kith_scene *s;
  CHECK_OK(kith_scene_parse(&s, "f", text, length, sizeof overrides / sizeof overrides[0], overrides));
  CHECK(s != NULL && s->n_regions == 1 && s->n_deposits == 1 && s->scheme.cfl == 0);
  kith_scene_destroy(&s);
}

/* A checkpoint fits a scene with the same values, however they are written. */
static void compares(void) {
  static const struct {
    const char *setting, *differs; /* NULL: nothing */
  } tries[] = {{"method.kernel=wendland_c2", NULL},
               {"scheme.cfl=3.0e-1", NULL},
               {"materials.gas.gamma=1.40", NULL},
               {"materials.gas.eos=ideal", NULL},
               {"regions.0.density=1.0", NULL},
               {"reproducible=false", NULL},        /* the default, not given before */
               {"method.viscosity.alpha=", NULL},   /* that of the package */
               {"materials.gamma.gamma=1.4", NULL}, /* the name of a material may be that of a key */
               {"gravity=[0,0.0,0]", NULL},
               {"regions.1.lattice=",
                NDIM == 3 ? NULL : "regions.1.lattice is not given there, and bcc now"}, /* the default */
               {"regions.1.velocity=[0,0,0]", NULL},
               {"boundaries.y={kind: periodic, images: ghosts}", NULL},
               /* settings that do not affect the state */
               {"output.plot=true", NULL},
               {"output={}", NULL},
               {"neighbor.search=grid", NULL},
               {"until=0.20001", NULL},
               {"scheme.cfl=0.31", NULL},
               {"partition.name=morton", NULL},
               {"partition={name: diffusion, flow: willebeek}", NULL},
               {"exact.window.x=[0,1]", NULL},
               /* settings that affect it */
               {"partition.ghosts=recompute", "partition.ghosts is recompute there, and not given now"},
               {"scheme.name=verlet", "scheme.name is verlet there, and leapfrog now"},
               {"method.viscosity.alpha=1.5", "method.viscosity.alpha is 1.5 there, and 1 now"},
               {"gravity=[1,0,0]", "gravity is [1, 0, 0] there, and not given now"},
               {"materials.gas.gamma=1.5", "materials.gas.gamma is 1.5 there, and 1.4 now"},
               {"materials.gas.eos=isothermal", "materials.gas.eos is isothermal there, and ideal now"},
               {"regions.1.velocity=[1,0,0]", "regions.1.velocity is [1, 0, 0] there, and not given now"},
               {"regions.1.where.inside=x||y", "regions.1.where.inside is x||y there, and not given now"},
               {"boundaries.x=open", "boundaries.x is open there, and reflecting now"},
               {"boundaries.x={kind: open}", "boundaries.x is open there, and reflecting now"},
               {"energy={energy: 1}", "energy.energy is 1 there, and not given now"}};
  struct kith_scene *s;
  CHECK_OK(read_text(&s, sod, NULL));
  if (s == NULL) return;
  for (size_t k = 0; k < sizeof tries / sizeof tries[0]; ++k) {
    struct kith_config *other;
    char *text, wanted[128];
    CHECK_OK(kith_config_parse(&other, "g", s->text, strlen(s->text)));
    CHECK_OK(kith_config_override(other, tries[k].setting));
    CHECK_OK(kith_config_emit(other->root, false, &text));
    snprintf(wanted, sizeof wanted, "written by another scene or with other settings: %s",
             tries[k].differs != NULL ? tries[k].differs : "");
    const kith_status status = kith_scene_check_same(s, text);
    if (tries[k].differs != NULL) check_message(tries[k].setting, status, wanted);
    if (tries[k].differs == NULL) CHECK_OK(status);
    kith_free(&text);
    kith_config_destroy(&other);
  }
  kith_scene_destroy(&s);
}

int main(void) {
  compares();
  example();
  reads_overrides();
  drops_idle_keys();
  drops_optional_maps();
  derives_sedov();
  derives_others();
  derives_gresho();
  reads_shapes();
  reads_across();
  reads_pictures();
  counts_probe_points();
  reads_files();
  reference();
  return check_failed();
}
