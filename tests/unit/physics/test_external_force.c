/* test_external_force.c - external forces: the force against differences of the potential and by hand, free
 * fall against a run without gravity, energy and angular momentum of orbits, and energy when a mirror lifts
 * nodes. */
#include "tests/unit/scenario.h"

/* --- the force itself --- */

static void force_is_gradient(void) {
  struct kith_external_force external_force = {.mass = 1.7, .softening = 0.3};
  for (int a = 0; a < NDIM; ++a)
    external_force.gravity[a] = 0.4 - a, external_force.origin[a] = 0.1 * a,
    external_force.center[a] = 0.2 - a;
  for (int k = 0; k < 20; ++k) {
    double x[NDIM], force[NDIM];
    for (int a = 0; a < NDIM; ++a) x[a] = sin(1.0 + 3 * k + 5 * a), force[a] = 0.25;
    kith_external_force_add(&external_force, x, force);
    for (int a = 0; a < NDIM; ++a) {
      double low[NDIM], high[NDIM];
      memcpy(low, x, sizeof low), memcpy(high, x, sizeof high);
      low[a] -= 1e-5, high[a] += 1e-5;
      const double slope = (kith_external_force_potential(&external_force, high) -
                            kith_external_force_potential(&external_force, low)) /
                           2e-5;
      CHECK_CLOSE(force[a] - 0.25, -slope, 1e-8); /* third derivatives of about 100 times 1e-10 / 6 */
    }
  }
}

/* A point mass without softening: force G M / d^2, potential -G M / d. */
static void force_of_point_mass(void) {
  struct kith_external_force external_force = {.mass = 3};
  double x[NDIM] = {0}, force[NDIM] = {0};
  CHECK(kith_external_force_acts(&external_force) &&
        !kith_external_force_acts(&(struct kith_external_force){0}));
  x[0] = 2;
  kith_external_force_add(&external_force, x, force);
  CHECK_CLOSE(force[0], -0.75, 1e-15);
  CHECK_CLOSE(kith_external_force_potential(&external_force, x), -1.5, 1e-15);
  external_force = (struct kith_external_force){.gravity = {-2}, .origin = {0.5}};
  force[0] = 0;
  kith_external_force_add(&external_force, x, force);
  CHECK(force[0] == -2 && kith_external_force_potential(&external_force, x) == 3);
}

/* --- free fall --- */

/* A body of gas in vacuum, which expands and moves at random. */
static const char gas_body[] =
    "dimension: 1\nscene: lump\n"
    "resolution: {1d: 40, 2d: 10, 3d: 6}\n"
    "domain: {lower: [-1, -1, -1], upper: [2, 2, 2]}\n"
    "materials: {gas: {gamma: 1.6666666666666667}}\n"
    "regions:\n"
    "  - {material: gas, where: {x: [0, 1], y: [0, 1], z: [0, 1]}, lattice: cubic, jitter: 0.2,\n"
    "     density: 1, pressure: 1 + 0.5*x, velocity: [0.3*x, 0.1, -0.2]}\n"
    "connectivity: {reorder: 0}\n"
    "scheme: {dt: 0.004}\n"
    "until: 1\n";

/* Uniform gravity is an accelerated frame: after time t nodes are displaced by g t^2 / 2 and faster by g t,
 * with unchanged energies. All schemes are exact for this; the tolerance is the rounding of positions or, for
 * implicit, the residual at which it stops. */
static void falls_as_frame(const char *settings, double tolerance) {
  enum { STEPS = 12 };
  const double g[3] = {-2, 1.1, 0.7}, t = STEPS * 0.004;
  struct scenario free_one = {0}, falling = {0};
  const bool both = scenario_open(&free_one, gas_body, "%s", settings) &&
                    scenario_open(&falling, gas_body, "%s gravity=[%g,%g,%g]", settings, g[0],
                                  NDIM > 1 ? g[1] : 0.0, NDIM > 2 ? g[2] : 0.0);
  const int failures = check_failures;
  if (both && scenario_run(&free_one, STEPS) && scenario_run(&falling, STEPS)) {
    const kith_index n = free_one.simulation->nodes->n_internal;
    const double *x = scenario_field(&free_one, "position")->f64,
                 *y = scenario_field(&falling, "position")->f64;
    const double *v = scenario_field(&free_one, "velocity")->f64,
                 *w = scenario_field(&falling, "velocity")->f64;
    double far = 0, fast = 0;
    for (kith_index i = 0; i < n; ++i)
      for (int a = 0; a < NDIM; ++a) {
        far = fmax(far, fabs(y[i * NDIM + a] - x[i * NDIM + a] - 0.5 * g[a] * t * t));
        fast = fmax(fast, fabs(w[i * NDIM + a] - v[i * NDIM + a] - g[a] * t));
      }
    CHECK_CLOSE(far, 0, tolerance);
    CHECK_CLOSE(fast, 0, 100 * tolerance); /* rates depend on differences of positions a spacing apart */
    CHECK_CLOSE(scenario_distance(&free_one, &falling, "energy"), 0, 100 * tolerance);
    CHECK_CLOSE(falling.simulation->integrator.time, t, 1e-15);
    const struct kith_totals then = falling.start, now = kith_hydro_totals(&falling.simulation->hydro);
    const double e0 = then.kinetic + then.internal + then.potential;
    CHECK(fabs(now.potential - then.potential) > 1e-5 * fabs(e0)); /* gravity acts */
    if (strstr(settings, "thermal") == NULL)
      CHECK_CLOSE((now.kinetic + now.internal + now.potential) / e0, 1, 1e-12);
  }
  if (check_failures > failures) fprintf(stderr, "%d-D, %s\n", NDIM, settings);
  scenario_close(&falling);
  scenario_close(&free_one);
}

/* --- orbits --- */

/* Cold gas in orbit around a softened point mass; in 1-D it falls through it. */
static const char orbit[] =
    "dimension: 1\nscene: orbit\n"
    "resolution: {1d: 100, 2d: 50, 3d: 30}\n"
    "domain: {lower: [-2, -2, -2], upper: [2, 2, 2]}\n"
    "potential: {center: [0.1, 0, 0], mass: 1, softening: 0.3}\n"
    "materials: {gas: {gamma: 1.6666666666666667}}\n"
    "regions:\n"
    "  - {material: gas, where: {x: [0.7, 0.8], y: [0, 0.1], z: [0, 0.1]}, lattice: cubic,\n"
    "     density: 1, pressure: 1.0e-12, velocity: [0, 0.7, 0.1]}\n"
    "method: {viscosity: {name: none}}\n"
    "until: 1\n";

static double energy_error(double dt, double *angular_error) {
  struct scenario s = {0};
  double found = NAN;
  if (scenario_open(&s, orbit, "scheme.dt=%.17g", dt) && scenario_run(&s, 10000)) {
    const struct kith_totals now = kith_hydro_totals(&s.simulation->hydro);
    double change = 0;
    for (int a = 0; a < 3; ++a) change = fmax(change, fabs(now.angular[a] - s.start.angular[a]));
    *angular_error = change / fmax(s.start.angular_scale, 1e-300);
    found = fabs((now.kinetic + now.internal + now.potential) /
                     (s.start.kinetic + s.start.internal + s.start.potential) -
                 1);
  }
  scenario_close(&s);
  return found;
}

/* Energy errors are of second order: four times less for half the step, within 0.5 % for higher orders.
 * Angular momentum is conserved to round-off. */
static void orbits(void) {
  double angular_error[2] = {0};
  const double coarse = energy_error(0.02, &angular_error[0]), fine = energy_error(0.01, &angular_error[1]);
  CHECK(coarse < 2e-3);
  CHECK_CLOSE(coarse / fine, 4, 0.02);
  if (NDIM > 1) CHECK(angular_error[0] < 1e-13 && angular_error[1] < 1e-13);
}

/* --- a mirror as floor --- */

static const char floor_below[] = SCENARIO_UNIT
    "resolution: 10\n"
    "boundaries: {x: reflecting}\n"
    "gravity: [-3, 0, 0]\n"
    "materials: {gas: {eos: isothermal, sound_speed: 0.5}}\n"
    "regions:\n"
    "  - {material: gas, where: {x: [0, 0.5], y: [0, 0.5], z: [0, 0.5]}, lattice: cubic, density: 1,\n"
    "     energy: 1, velocity: [-2, 0, 0]}\n"
    "until: 1\n";

/* A step carries nodes through a mirror, which reflects their positions and so lifts them: this energy is
 * counted as passed through the boundary, and total energy is then conserved. */
static void mirror_lifts_nodes(const char *settings) {
  struct scenario s = {0};
  if (scenario_open(&s, floor_below, "scheme.dt=0.03 method.viscosity.name=none %s", settings) &&
      scenario_run(&s, 4)) {
    const struct kith_totals *then = &s.start, now = kith_hydro_totals(&s.simulation->hydro);
    const double e0 = then->kinetic + then->internal + then->potential;
    CHECK(now.through.energy > 1e-3 * fabs(e0));
    CHECK_CLOSE((now.kinetic + now.internal + now.potential - now.through.energy) / e0, 1, 1e-13);
  }
  scenario_close(&s);
}

int main(void) {
  force_is_gradient();
  force_of_point_mass();
  falls_as_frame("scheme.name=leapfrog", 1e-14);
  falls_as_frame("scheme.name=leapfrog method.package=crk", 1e-14);
  falls_as_frame("scheme.name=leapfrog method.package=mfm", 1e-14);
  falls_as_frame("scheme.name=rk2", 1e-14);
  falls_as_frame("scheme.name=cheap-rk2 traversal=pairs", 1e-14);
  falls_as_frame("scheme.name=verlet", 1e-14);
  falls_as_frame("scheme.name=leapfrog connectivity.rebuild=displacement", 1e-14);
  falls_as_frame("scheme.name=rk4 method.energy=thermal", 1e-14);
  falls_as_frame("scheme.name=arkode scheme.adaptive=false method.energy=thermal", 1e-14);
  if (NDIM < 3) falls_as_frame("scheme.name=implicit method.energy=thermal", 1e-7);
  orbits();
  mirror_lifts_nodes("scheme.name=leapfrog");
  mirror_lifts_nodes("scheme.name=verlet");
  mirror_lifts_nodes("scheme.steps=block");
  return check_failed();
}
