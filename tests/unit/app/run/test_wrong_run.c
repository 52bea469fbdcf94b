/* test_wrong_run.c - unusual scenes that must work (against what is known: rest, conservation, an equivalent
 * scene), and wrong states, which must stop the run and name the node and the reason. */
#include <omp.h>
#include "app/output/output.h"
#include "tests/unit/files.h"
#include "tests/unit/scenario.h"

#define HEAD "dimension: 1\nscene: edge\ndomain: {lower: [0, 0, 0], upper: [1, 1, 1]}\n"
#define GAS "materials: {gas: {gamma: 1.4}}\n"
#define PERIODIC "boundaries: {x: periodic, y: periodic, z: periodic}\n"

static const char at_rest[] = HEAD PERIODIC GAS
    "resolution: {1d: 30, 2d: 10, 3d: 6}\n"
    "regions: [{material: gas, lattice: cubic, jitter: 0.2, density: 1, pressure: 1}]\nuntil: 1\n";

/* --- unusual, but correct --- */

/* A single node interacts with its images only, so that no force acts on it. */
static void one_node_in_a_thin_box(void) {
  static const char yaml[] = HEAD PERIODIC GAS
      "resolution: 1\nregions: [{material: gas, lattice: cubic, density: 1, pressure: 1, velocity: [0.3, "
      "0.2, 0.1]}]\nuntil: 5\n";
  static const char *const rebuild[] = {"always", "displacement"};
  for (int k = 0; k < 2; ++k) {
    struct scenario s = {0};
    if (scenario_open(&s, yaml, "connectivity.rebuild=%s", rebuild[k]) && scenario_run(&s, 20)) {
      const struct kith_hydro *h = &s.simulation->hydro;
      CHECK(s.simulation->nodes->n_internal == 1 && s.simulation->nodes->n_ghost > 2);
      CHECK(s.simulation->nodes->support->f64[0] > 1); /* the box is thinner than that */
      /* images form a cubic lattice; exact for the ideal lattice only */
      CHECK_CLOSE(h->density->f64[0], 1, 0.02);
      for (int a = 0; a < NDIM; ++a) CHECK_CLOSE(h->velocity->f64[a], 0.3 - 0.1 * a, 1e-14);
    }
    scenario_close(&s);
  }
}

/* Materials are labels: two materials of the same gas behave as one. */
static void materials_are_labels(void) {
  static const char one[] = HEAD PERIODIC
      "materials: {a: {gamma: 1.4}}\n"
      "resolution: {1d: 30, 2d: 10, 3d: 6}\nregions:\n"
      "  - {material: a, where: {x: [0, 0.5]}, lattice: cubic, jitter: 0.2, density: 1, pressure: 1}\n"
      "  - {material: a, where: {x: [0.5, 1]}, lattice: cubic, jitter: 0.2, density: 1, pressure: "
      "2}\nuntil: 1\n";
  static const char three[] = HEAD PERIODIC
      "materials: {empty: {gamma: 1.1}, a: {gamma: 1.4}, b: {gamma: 1.4}}\n"
      "resolution: {1d: 30, 2d: 10, 3d: 6}\nregions:\n"
      "  - {material: a, where: {x: [0, 0.5]}, lattice: cubic, jitter: 0.2, density: 1, pressure: 1}\n"
      "  - {material: b, where: {x: [0.5, 1]}, lattice: cubic, jitter: 0.2, density: 1, pressure: "
      "2}\nuntil: 1\n";
  struct scenario s = {0}, t = {0};
  if (scenario_open(&s, one, "%s", "scheme.name=leapfrog")) scenario_run(&s, 15);
  if (scenario_open(&t, three, "%s", "scheme.name=leapfrog") && scenario_run(&t, 15)) {
    CHECK(t.simulation->nodes->n_lists == 3 && t.simulation->nodes->lists[0].count == 0);
    /* ghosts are sorted by list, so rows have another order and sums differ by rounding */
    CHECK(scenario_distance(&s, &t, "velocity") <= 1e-12);
    CHECK(scenario_distance(&s, &t, "energy") <= 1e-12);
    CHECK(scenario_energy_error(&t) <= 1e-12 && scenario_momentum_error(&t) <= 1e-12);
  }
  scenario_close(&t);
  scenario_close(&s);
}

/* Three equations of state beside each other. */
static void several_materials(void) {
  static const char yaml[] = HEAD PERIODIC
      "materials: {a: {gamma: 1.4}, b: {eos: stiffened, gamma: 3, stiffness: 2}, c: {eos: isothermal, "
      "sound_speed: 1}}\n"
      "resolution: {1d: 60, 2d: 12, 3d: 6}\nregions:\n"
      "  - {material: a, where: {x: [0, 0.34]}, lattice: cubic, density: 1, pressure: 1}\n"
      "  - {material: b, where: {x: [0.34, 0.67]}, lattice: cubic, density: 2, pressure: 1}\n"
      "  - {material: c, where: {x: [0.67, 1]}, lattice: cubic, density: 1, energy: 1}\nuntil: 1\n";
  struct scenario s = {0};
  if (scenario_open(&s, yaml, "%s", "connectivity.rebuild=displacement") && scenario_run(&s, 30)) {
    CHECK(scenario_energy_error(&s) <= 1e-12);
    /* momentum is relative to what moves later, since the gas is at rest at first */
    CHECK(scenario_momentum_error(&s) <= 1e-12);
  }
  scenario_close(&s);
}

/* Gas in vacuum: nodes at its edge have fewer neighbors and larger supports, and fly away. */
static void expansion_into_vacuum(void) {
  static const char yaml[] = HEAD GAS
      "resolution: {1d: 30, 2d: 12, 3d: 7}\n"
      "regions: [{material: gas, lattice: cubic, density: 1, pressure: 1}]\nuntil: 0.4\n";
  struct scenario s = {0};
  if (scenario_open(&s, yaml, "%s", "connectivity.rebuild=displacement") && scenario_run(&s, 10000)) {
    const double *x = s.simulation->nodes->position->f64;
    double farthest = 0;
    for (kith_index i = 0; i < s.simulation->nodes->n_internal * NDIM; ++i) farthest = fmax(farthest, x[i]);
    CHECK(s.simulation->integrator.time == 0.4 && s.simulation->nodes->n_ghost == 0);
    CHECK(farthest > 1.2); /* the edge is faster than sound, 1.18 */
    CHECK(scenario_energy_error(&s) <= 1e-12);
  }
  scenario_close(&s);
}

/* --- wrong --- */

/* The run must stop within some steps as DIVERGED, and name node `id` (-1: any) and the reason. */
static void check_stop(struct scenario *s, int64_t id, const char *reason) {
  char node[32];
  snprintf(node, sizeof node, "node %lld", (long long)id);
  kith_status status = KITH_OK;
  for (int k = 0; k < 50 && status == KITH_OK; ++k)
    status = kith_integrator_step(&s->simulation->integrator, s->scene->until);
  CHECK_STATUS(KITH_DIVERGED, status);
  CHECK(check_says(id >= 0 ? node : "node ") && check_says(reason));
}

/* The present index of the node with this id; reordering changes it. */
static kith_index node_of(const struct scenario *s, int64_t id) {
  kith_index i = 0;
  while (s->simulation->nodes->id->i64[i] != id) ++i;
  return i;
}

/* Sets one value of node 7 after the start. */
static void check_broken(const char *settings, const char *field, double value, const char *reason) {
  struct scenario s = {0};
  if (scenario_open(&s, at_rest, "%s", settings)) {
    CHECK_OK(scenario_start(&s));
    struct kith_field *f = scenario_field(&s, field);
    f->f64[node_of(&s, 7) * f->components] = value;
    check_stop(&s, 7, reason);
  }
  scenario_close(&s);
}

static void broken_states(void) {
  static const char *const settings[] = {
      "scheme.name=leapfrog",
      "scheme.name=rk2",
      "scheme.name=cheap-rk2",
      "scheme.name=leapfrog connectivity.rebuild=displacement",
      "scheme.name=rk2 connectivity.rebuild=displacement boundaries.x=reflecting",
      "boundaries.x=open boundaries.y=open boundaries.z=open"};
  for (int k = 0; k < 6; ++k) {
    check_broken(settings[k], "velocity", NAN, "not finite");
    check_broken(settings[k], "velocity", INFINITY, "not finite");
    check_broken(settings[k], "position", NAN, "not finite");
    check_broken(settings[k], "energy", -1, "negative");
    check_broken(settings[k], "energy", NAN, "not finite");
    check_broken(settings[k], "support", NAN, "not finite");
  }
}

/* A single node without images: no support is large enough. */
static void single_node(void) {
  static const char yaml[] = HEAD GAS
      "resolution: 1\nregions: [{material: gas, lattice: cubic, density: 1, pressure: 1}]\nuntil: 1\n";
  static const char *const rebuild[] = {"always", "displacement"};
  for (int k = 0; k < 2; ++k) {
    struct scenario s = {0};
    if (scenario_open(&s, yaml, "connectivity.rebuild=%s", rebuild[k])) {
      CHECK_STATUS(KITH_DIVERGED, scenario_start(&s));
      CHECK(strstr(kith_failure(), "node 0") != NULL && strstr(kith_failure(), "support") != NULL);
    }
    scenario_close(&s);
  }
}

/* Many nodes at one place: no support is small enough. */
static void coincident_nodes(void) {
  struct scenario s = {0};
  if (scenario_open(&s, at_rest, "%s", "resolution=10")) {
    for (kith_index i = 0; i < s.simulation->nodes->n_internal * NDIM; ++i)
      s.simulation->nodes->position->f64[i] = 0.5;
    s.simulation->nodes->positions += 1;
    CHECK_STATUS(KITH_DIVERGED, scenario_start(&s));
    CHECK(strstr(kith_failure(), "node 0") != NULL && strstr(kith_failure(), "does not converge") != NULL);
  }
  scenario_close(&s);
}

/* A step that is too small to change the time. */
static void collapse(void) {
  struct scenario s = {0};
  if (scenario_open(&s, at_rest, "%s", "scheme.name=leapfrog")) {
    CHECK_OK(scenario_start(&s));
    CHECK_OK(kith_integrator_step(&s.simulation->integrator, 1));
    s.simulation->integrator.timestep_limit = (struct kith_timestep_limit){1e-20, 3, KITH_LIMIT_courant};
    check_stop(&s, 3, "collapsed");
    CHECK(strstr(kith_failure(), "courant") != NULL);
  }
  scenario_close(&s);
  if (scenario_open(&s, at_rest, "%s", "scheme.name=leapfrog")) {
    CHECK_OK(scenario_start(&s));
    s.simulation->hydro.acceleration->f64[node_of(&s, 7) * NDIM] = 1e80;
    check_stop(&s, 7, "");
  }
  scenario_close(&s);
}

/* offenders.hdf has the nodes whose supports, spheres or ellipsoids, hold a node or are held by it. */
static void offenders(const char *stretch) {
  struct scenario s = {0};
  struct kith_output output = {.n_snapshots = 0};
  bool written = false;
  snprintf(output.directory, sizeof output.directory, "%s", directory);
  if (scenario_open(&s, at_rest, "method.stretch=%s", stretch)) {
    CHECK_OK(scenario_start(&s));
    const struct kith_nodes *nodes = s.simulation->nodes;
    const double *x = nodes->position->f64, *h = nodes->support->f64;
    kith_index wanted = 0;
    const kith_index o = node_of(&s, 5);
    for (kith_index i = 0; i < nodes->n_internal; ++i) {
      double r2 = 0;
      for (int a = 0; a < NDIM; ++a)
        r2 += pow(remainder(x[(size_t)i * NDIM + a] - x[(size_t)o * NDIM + a], 1) / nodes->stretch[a], 2);
      wanted += sqrt(r2) <= fmax(h[i], h[o]);
    }
    CHECK_OK(kith_output_offenders(&output, s.simulation, 5, &written));
    CHECK(written && nodes->n_internal == wanted);
  }
  scenario_close(&s);
}

int main(void) {
  static const char *const files[] = {"offenders.hdf"};
  directory_make();
  omp_set_num_threads(1);
  one_node_in_a_thin_box();
  materials_are_labels();
  several_materials();
  expansion_into_vacuum();
  broken_states();
  single_node();
  coincident_nodes();
  collapse();
  offenders("[1,1,1]");
  offenders("[2,1,1.5]");
  directory_remove(sizeof files / sizeof *files, files);
  return check_failed();
}
