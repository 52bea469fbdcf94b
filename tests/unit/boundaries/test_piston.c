/* test_piston.c - a piston. Oracle: a wall at rest in gas that moves towards it, which is the same run in
 * another frame; energies must grow by the work of the piston. */
#include "tests/unit/scenario.h"

static const double speed = 0.8;

/* Gas at rest, into which a piston runs from below or from above; in the frame of the wall gas moves instead.
 * Only x differs. */
static const char tube[] =
    "dimension: 1\nscene: tube\n"
    "resolution: {1d: 50, 2d: 20, 3d: 12}\n"
    "domain: {lower: [0, 0, 0], upper: [1, 1, 1], across: 8}\n"
    "boundaries: {x: reflecting, y: periodic, z: reflecting}\n"
    "materials: {gas: {gamma: 1.6666666666666667}}\n"
    "regions:\n"
    "  - {material: gas, lattice: cubic, jitter: 0.2, seed: 3, density: 1 + 0.3*x, pressure: 0.02, "
    "velocity: [0, 0.1, -0.1]}\n"
    "connectivity: {reorder: 0}\n"
    "until: 0.5\n";

static bool open_both(struct scenario *lab, struct scenario *wall, const char *settings, bool above) {
  const double u = above ? -speed : speed;
  char piston[64];
  snprintf(piston, sizeof piston, "{kind:\tpiston,velocity:\t%g}", u);
  return scenario_open(lab, tube, "%s boundaries.x=[%s,%s]", settings, above ? "open" : piston,
                       above ? piston : "open") &&
         scenario_open(wall, tube, "%s boundaries.x=[%s] regions.0.velocity=[%g,0.1,-0.1]", settings,
                       above ? "open,reflecting" : "reflecting,open", -u);
}

/* Rounding differs between the frames, and disorder amplifies it, by about a hundred in so few steps. */
static void is_a_wall(const char *settings, bool above, int steps) {
  struct scenario lab = {0}, wall = {0};
  const int failures = check_failures;
  if (open_both(&lab, &wall, settings, above) && scenario_run(&lab, steps) && scenario_run(&wall, steps)) {
    const double u = above ? -speed : speed, t = lab.simulation->integrator.time;
    const double *x = scenario_field(&lab, "position")->f64, *y = scenario_field(&wall, "position")->f64;
    const double *v = scenario_field(&lab, "velocity")->f64, *w = scenario_field(&wall, "velocity")->f64;
    double far = 0, fast = 0, edge = above ? -INFINITY : INFINITY;
    for (kith_index i = 0; i < lab.simulation->nodes->n_internal; ++i) {
      edge = above ? fmax(edge, x[i * NDIM]) : fmin(edge, x[i * NDIM]);
      for (int a = 0; a < NDIM; ++a) {
        far = fmax(far, fabs(x[i * NDIM + a] - y[i * NDIM + a] - (a == 0 ? u * t : 0)));
        fast = fmax(fast, fabs(v[i * NDIM + a] - w[i * NDIM + a] - (a == 0 ? u : 0)));
      }
    }
    CHECK(speed * t > 0.02); /* the face has moved by more than a spacing */
    CHECK_CLOSE(t, wall.simulation->integrator.time, 1e-12);
    CHECK_CLOSE(far, 0, 1e-11);
    CHECK_CLOSE(fast, 0, 1e-9);
    CHECK_CLOSE(scenario_distance(&lab, &wall, "energy"), 0, 1e-9);
    CHECK(above ? edge <= 1 + u * t : edge >= u * t);
    const struct kith_totals a = lab.start, b = kith_hydro_totals(&lab.simulation->hydro);
    const double given = b.kinetic + b.internal - a.kinetic - a.internal;
    CHECK(given > 0.01); /* it does work on the gas */
    CHECK_CLOSE(given, b.work - a.work, 1e-12 * (b.kinetic + b.internal));
    CHECK_CLOSE(b.work, u * b.momentum[0], 1e-15);
  }
  if (check_failures > failures) fprintf(stderr, "%d-D, %s, %s\n", NDIM, settings, above ? "above" : "below");
  scenario_close(&wall);
  scenario_close(&lab);
}

/* What does not go together with a piston. */
static void refusals(void) {
#define PISTON "boundaries.x=[{kind:\tpiston,velocity:\t0.5},open] "
  scenario_refused(tube, PISTON "connectivity.rebuild=displacement",
                   "a piston requires that neighbor lists are rebuilt always");
  scenario_refused(tube, PISTON "scheme.name=rk4 method.energy=thermal", "rk4 does not know of pistons");
  scenario_refused(tube, PISTON "scheme.name=arkode method.energy=thermal",
                   "arkode does not know of pistons");
  scenario_refused(tube, PISTON "scheme.name=implicit method.energy=thermal",
                   "implicit does not know of pistons");
}

int main(void) {
  const int steps = NDIM == 1 ? 100 : 40;
  is_a_wall("scheme.name=leapfrog", false, steps);
  is_a_wall("scheme.name=leapfrog", true, steps);
  is_a_wall("scheme.name=leapfrog method.package=crk", false, steps);
  is_a_wall("scheme.name=leapfrog method.package=mfm", true, steps);
  if (NDIM < 3) /* it is expensive */
    is_a_wall("scheme.name=leapfrog method.package=mfm method.faces=integrated", false, steps);
  is_a_wall("scheme.name=rk2", false, steps);
  is_a_wall("scheme.name=cheap-rk2 traversal=pairs", true, steps);
  is_a_wall("scheme.name=verlet", false, steps);
  /* Without viscosity nodes cross the face, and are put back. */
  is_a_wall("scheme.name=leapfrog method.viscosity.name=none", false, steps);
  is_a_wall("scheme.name=rk2 method.viscosity.name=none", true, steps);
  refusals();
  return check_failed();
}
