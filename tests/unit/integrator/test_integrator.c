/* test_integrator.c - steps of the schemes with compatible energies: conservation to round-off, symmetry (an
 * octant against the whole box), Galilean invariance, and the time-step limit against all nodes. Traversals
 * are compared by test_tiles.c, orders in time measured by conformance_scheme.c. */
#include <omp.h>
#include "tests/unit/scenario.h"

#define GAS "materials: {gas: {gamma: 1.6666666666666667}}\n"

static const char blast[] = SCENARIO_PERIODIC
    "resolution: {1d: 60, 2d: 16, 3d: 6}\n" GAS
    "regions:\n"
    "  - {material: gas, lattice: cubic, jitter: 0.2, seed: 3, density: 1, pressure: 0.01, velocity: "
    "[0.3, 0.2, -0.1]}\n"
    "energy: {energy: 1, center: [0.4, 0.55, 0.6], over: kernel, spacings: 2}\n"
    "until: 1\n";

/* The schemes that keep energies compatible. */
static const char *const schemes[] = {"leapfrog", "rk2", "cheap-rk2", "verlet"};
enum { SCHEMES = sizeof schemes / sizeof *schemes };

/* Forces act in pairs and energies are compatible, so every scheme conserves momentum and energy, since each
 * kick changes all velocities and energies by the same dt and the same forces. Tolerance: round-off of sums,
 * 1e-16 of the largest term for each of some 1e3 additions, at random, 60 times. Measured: 7e-15. (With
 * thermal energies the error is 1e-5 to 1e-3 here.) */
static void energy_and_momentum_conserved(void) {
  static const char *const traversal[] = {"pairs", "gather"};
  static const char *const rest[] = {"connectivity.rebuild=always",
                                     "connectivity.rebuild=displacement connectivity.reorder=2",
                                     "method.viscosity.name=monaghan"};
  for (int s = 0; s < SCHEMES; ++s)
    for (int t = 0; t < 2; ++t)
      for (int k = 0; k < 3; ++k) {
        struct scenario run = {0};
        if (scenario_open(&run, blast, "scheme.name=%s traversal=%s %s", schemes[s], traversal[t], rest[k]) &&
            scenario_run(&run, 60)) {
          CHECK(scenario_energy_error(&run) <= 1e-12);
          CHECK(scenario_momentum_error(&run) <= 1e-12);
        }
        scenario_close(&run);
      }
}

/* A mirror gives no energy, and momentum along its axis only. */
static void conserved_between_walls(void) {
  for (int s = 0; s < SCHEMES; ++s) {
    struct scenario run = {0};
    if (scenario_open(&run, blast, "scheme.name=%s boundaries.x=reflecting", schemes[s]) &&
        scenario_run(&run, 60)) {
      const struct kith_totals now = kith_hydro_totals(&run.simulation->hydro);
      CHECK(scenario_energy_error(&run) <= 1e-12);
      CHECK(fabs(now.momentum[0] - run.start.momentum[0]) > 1e-3 * now.momentum_scale);
      for (int a = 1; a < NDIM; ++a)
        CHECK(fabs(now.momentum[a] - run.start.momentum[a]) <= 1e-12 * now.momentum_scale);
    }
    scenario_close(&run);
  }
}

/* --- symmetry --- */

static const char sedov[] =
    "dimension: 3\nscene: sedov\n"
    "resolution: {1d: 60, 2d: 24, 3d: 12}\n"
    "domain: {lower: [-0.5, -0.5, -0.5], upper: [0.5, 0.5, 0.5]}\n"
    "boundaries: {x: periodic, y: periodic, z: periodic}\n" GAS
    "regions:\n"
    "  - {material: gas, lattice: cubic, density: 1, pressure: 1.0e-6}\n"
    "energy: {energy: 1, center: [0, 0, 0], over: kernel, spacings: 2.4}\n"
    "until: {1d: 0.16, 2d: 0.092, 3d: 0.05}\n";
static const char octant[] =
    "dimension: 3\nscene: octant\n"
    "resolution: {1d: 60, 2d: 24, 3d: 12}\n"
    "domain: {lower: [0, 0, 0], upper: [0.5, 0.5, 0.5]}\n"
    "boundaries: {x: reflecting, y: reflecting, z: reflecting}\n" GAS
    "regions:\n"
    "  - {material: gas, lattice: cubic, density: 1, pressure: 1.0e-6}\n"
    "energy: {energy: {1d: 0.5, 2d: 0.25, 3d: 0.125}, center: [0, 0, 0], over: kernel, spacings: 2.4}\n"
    "until: {1d: 0.16, 2d: 0.092, 3d: 0.05}\n";

/* The largest difference of a field between nodes of `part` and the nodes of `whole` at the same
 * positions. */
static double folded_distance(const struct scenario *part, const struct scenario *whole, const char *name) {
  const struct kith_field *p = scenario_field(part, name), *q = scenario_field(whole, name);
  const double *x = part->simulation->nodes->position->f64, *y = whole->simulation->nodes->position->f64;
  double largest = 0, distance = 0;
  for (kith_index i = 0; i < part->simulation->nodes->n_internal; ++i) {
    kith_index best = 0;
    double least = INFINITY;
    for (kith_index j = 0; j < whole->simulation->nodes->n_internal; ++j) {
      const double r = kith_distance2(x + (size_t)i * NDIM, y + (size_t)j * NDIM);
      if (r < least) least = r, best = j;
    }
    for (int c = 0; c < p->components; ++c) {
      largest = fmax(largest, fabs(p->f64[i * p->components + c]));
      distance = fmax(distance, fabs(p->f64[i * p->components + c] - q->f64[best * q->components + c]));
    }
  }
  return distance / largest;
}

/* Mirrors, and the other octants, contribute the same terms in another order: round-off, which a shock
 * amplifies. Measured: 3e-14. */
static void octant_is_whole(void) {
  static const char *const fields[] = {"position", "velocity", "energy", "density", "support"};
  struct scenario whole = {0}, part = {0};
  for (int s = 0; s < SCHEMES; ++s) {
    if (scenario_open(&whole, sedov, "scheme.name=%s", schemes[s])) scenario_run(&whole, 100000);
    if (scenario_open(&part, octant, "scheme.name=%s", schemes[s]) && scenario_run(&part, 100000)) {
      CHECK(part.simulation->integrator.step == whole.simulation->integrator.step);
      for (int f = 0; f < 5; ++f) CHECK(folded_distance(&part, &whole, fields[f]) <= 1e-11);
    }
    scenario_close(&part);
    scenario_close(&whole);
  }
}

static void boost(const struct scenario *s, double sign) {
  static const double by[] = {7, -5, 3};
  struct kith_field *v = scenario_field(s, "velocity");
  for (kith_index i = 0; i < s->simulation->nodes->n_internal * NDIM; ++i) v->f64[i] += sign * by[i % NDIM];
}

/* A common velocity changes nothing. Tolerance: velocities of 7 instead of 1 are rounded to 1e-15, and
 * positions wrap. A common motion is no displacement, so lists are kept as long as at rest. Measured:
 * 2e-14. */
static void galilean_invariance(void) {
  static const char *const policy[] = {"always", "displacement"};
  for (int k = 0; k < 2; ++k) {
    struct scenario rest = {0}, moving = {0};
    if (scenario_open(&rest, blast, "connectivity.rebuild=%s", policy[k])) scenario_run(&rest, 60);
    if (scenario_open(&moving, blast, "connectivity.rebuild=%s", policy[k])) {
      boost(&moving, 1);
      if (scenario_run(&moving, 60)) {
        boost(&moving, -1);
        CHECK(scenario_distance(&rest, &moving, "velocity") <= 1e-11);
        CHECK(scenario_distance(&rest, &moving, "energy") <= 1e-11);
        CHECK(scenario_distance(&rest, &moving, "density") <= 1e-11);
        CHECK_CLOSE(moving.simulation->integrator.time / rest.simulation->integrator.time, 1, 1e-11);
        CHECK(rest.simulation->integrator.ledger.lifecycles ==
              moving.simulation->integrator.ledger.lifecycles);
      }
    }
    scenario_close(&moving);
    scenario_close(&rest);
  }
}

/* The search for the limit skips nodes that surely allow more, and must find the least limit of all nodes. */
static void limit_is_the_least(void) {
  static const char *const settings[] = {"method.package=sph", "method.package=mfm", "materials.gas.gamma=3",
                                         "packages=[{\"name\":\"conduction\",\"conductivity\":0.1}]"};
  for (int k = 0; k < 4; ++k) {
    struct scenario s = {0};
    if (scenario_open(&s, blast, "%s", settings[k]))
      for (int step = 0; step < 20 && scenario_run(&s, 1); ++step) {
        const struct kith_package *package = s.simulation->integrator.package;
        const struct kith_timestep_limit found = kith_package_limit_of_rank(package, 0.3);
        struct kith_timestep_limit least = {.dt = INFINITY};
        for (kith_index i = 0; i < s.simulation->nodes->n_internal; ++i) {
          const struct kith_timestep_limit here = kith_package_limit_of_node(package, i, 0.3);
          if (here.dt < least.dt || (here.dt == least.dt && here.node < least.node)) least = here;
        }
        CHECK(found.dt == least.dt && found.node == least.node && found.reason == least.reason);
      }
    scenario_close(&s);
  }
}

int main(void) {
  limit_is_the_least();
  omp_set_num_threads(1);
  energy_and_momentum_conserved();
  conserved_between_walls();
  octant_is_whole();
  galilean_invariance();
  return check_failed();
}
