/* test_equilibrium.c - regions that start in equilibrium have exactly the pressure of the scene; energies
 * that are released later; and how conservation errors are derived from totals, with values known by hand. */
#include "app/output/output.h"
#include "tests/unit/scenario.h"

/* The pressure varies, and on disordered nodes the summed density is not 1. */
static const char disordered[] = SCENARIO_PERIODIC
    "resolution: {1d: 40, 2d: 14, 3d: 8}\n"
    "materials: {gas: {gamma: 1.4}, water: {eos: stiffened, gamma: 4, stiffness: 2}}\n"
    "regions:\n"
    "  - {material: gas, where: {x: [0, 0.5]}, lattice: cubic, jitter: 0.3, seed: 5, density: 1, "
    "pressure: 1 + 0.5*x}\n"
    "  - {material: water, where: {x: [0.5, 1]}, lattice: cubic, jitter: 0.3, density: 1, pressure: 0.7}\n"
    "until: 1\n";

/* Tolerance: supports are solved twice, until a Newton step is below 1e-7, so that densities differ by its
 * square, times the slopes of 3 dimensions and the factor 10 by which terms of a stiffened gas cancel. */
static const double tolerance = 1e-12;

static double wanted(const struct scenario *s, kith_index i) {
  return s->simulation->nodes->list->u8[i] == 0 ? 1 + 0.5 * s->simulation->nodes->position->f64[i * NDIM]
                                                : 0.7;
}

/* The largest difference of the initial pressure from that of the scene, among nodes of a list. */
static double deviation(const struct scenario *s, int list) {
  double worst = 0;
  for (kith_index i = 0; i < s->simulation->nodes->n_internal; ++i)
    if (s->simulation->nodes->list->u8[i] == list)
      worst = fmax(worst, fabs(s->simulation->hydro.pressure->f64[i] - wanted(s, i)));
  return worst;
}

/* Regions have their pressure if equilibrium is set, with any order of nodes, and differ by more than 0.01 if
 * not. */
static void pressures_are_wanted(void) {
  static const char *const settings[] = {"regions.0.equilibrium=true regions.1.equilibrium=true",
                                         "regions.1.equilibrium=true connectivity.reorder=1",
                                         "connectivity.reorder=1"};
  for (int k = 0; k < 3; ++k) {
    struct scenario s = {0};
    if (scenario_open(&s, disordered, "%s", settings[k])) {
      CHECK_OK(scenario_start(&s));
      CHECK(k == 0 ? deviation(&s, 0) < tolerance : deviation(&s, 0) > 0.01);
      CHECK(k <= 1 ? deviation(&s, 1) < tolerance : deviation(&s, 1) > 0.01);
      CHECK((kith_nodes_field_named(s.simulation->nodes, "wanted_pressure") != NULL) == (k <= 1));
      CHECK_OK(scenario_steps(&s, 3));
      /* Energy is conserved from the equilibrium on. */
      CHECK(scenario_energy_error(&s) < 1e-13);
    }
    scenario_close(&s);
  }
}

/* A deposit is added to the equilibrium. */
static void deposits_come_after(void) {
  struct scenario s = {0}, t = {0};
  if (scenario_open(&s, disordered, "regions.0.equilibrium=true") &&
      scenario_open(&t, disordered,
                    "regions.0.equilibrium=true "
                    "energy={'energy':3,'center':[0.25,0.5,0.5],'over':'ball','radius':0.2}")) {
    CHECK_OK(scenario_start(&s));
    CHECK_OK(scenario_start(&t));
    CHECK_CLOSE(t.start.internal - s.start.internal, 3, 1e-13); /* sums of some 500 terms, of 2 and 5 */
    CHECK(deviation(&t, 0) > 1);
    scenario_close(&t);
  }
  scenario_close(&s);
}

/* Steps until the end of the scene end where energies are released, there the gas has them, and as they came
 * from outside, no step changes what is conserved. */
static void released_on_the_way(const char *settings) {
  struct scenario s = {0};
  if (scenario_open(&s, disordered,
                    "energy=[{'energy':3,'center':[0.25,0.5,0.5],'over':'ball','radius':0.2},"
                    "{'energy':2,'center':[0.6,0.5,0.5],'time':0.9},"
                    "{'energy':5,'center':[0.4,0.5,0.5],'over':'kernel','spacings':2,'time':0.5}] %s",
                    settings)) {
    CHECK_OK(scenario_start(&s));
    struct kith_simulation *m = s.simulation;
    const double first = m->integrator.timestep_limit.dt;
    s.scene->deposit[1].time = 7.3 * first, s.scene->deposit[2].time = 3.1 * first;
    s.scene->until = 15 * first;
    for (int k = 0; k < 2; ++k) {
      const double until = s.scene->deposit[2 - k].time;
      struct kith_totals before = s.start, after;
      while (m->integrator.time < until && check_failures == 0) {
        before = kith_hydro_totals(&m->hydro);
        CHECK_OK(kith_simulation_step(m, s.scene->until));
      }
      after = kith_hydro_totals(&m->hydro);
      CHECK(m->integrator.time == until);
      CHECK(before.through.energy == (k == 0 ? 0 : 5) && after.through.energy == (k == 0 ? 5 : 7));
      CHECK_CLOSE(after.kinetic + after.internal - before.kinetic - before.internal, k == 0 ? 5 : 2, 1e-12);
    }
    CHECK_OK(scenario_steps(&s, 20));
    CHECK(scenario_energy_error(&s) < 1e-13);
  }
  scenario_close(&s);
}

/* The pressure is uniform across two regions. */
static void uniform_pressure(void) {
  struct scenario s = {0};
  if (scenario_open(&s, disordered,
                    "regions.0.pressure=0.7 regions.0.equilibrium=true regions.1.material=gas "
                    "regions.1.equilibrium=true")) {
    CHECK_OK(scenario_start(&s));
    double low = INFINITY, high = 0;
    for (kith_index i = 0; i < s.simulation->nodes->n_internal; ++i) {
      low = fmin(low, s.simulation->hydro.pressure->f64[i]);
      high = fmax(high, s.simulation->hydro.pressure->f64[i]);
    }
    CHECK(high - low < tolerance);
  }
  scenario_close(&s);
}

/* ---- conservation errors ---- */

static struct kith_totals totals(double kinetic, double along, double turn, double fast) {
  struct kith_totals t = {.mass = 1,
                          .kinetic = kinetic,
                          .internal = 10 - kinetic,
                          .momentum_scale = 2,
                          .angular_scale = 4,
                          .velocity_over_sound = fast};
  t.momentum[0] = along, t.angular[2] = turn;
  return t;
}

/* Kinetic energies 4, 1, 3, 2, 0.5, 2: the largest rise above an earlier minimum is 2. */
static void baseline_follows(void) {
  static const double kinetic[] = {4, 1, 3, 2, 0.5, 2}, turn[] = {1, 0.9, 0.5, 0.8, 0.9, 1},
                      fast[] = {0.1, 0.4, 0.2, 0.1, 0.1, 0.1};
  struct scenario s = {0};
  if (scenario_open(&s, disordered, "materials.water.stiffness=2")) {
    const struct kith_totals first = totals(kinetic[0], 0.5, turn[0], fast[0]);
    struct kith_conservation_baseline baseline = kith_conservation_baseline_of(&first);
    for (int k = 0; k < 6; ++k) {
      const struct kith_totals now = totals(kinetic[k], k == 3 ? 0.7 : 0.5, turn[k], fast[k]);
      kith_conservation_baseline_update(&baseline, s.simulation, &now);
    }
    CHECK_CLOSE(baseline.kinetic_rebound, 2, 1e-15);
    CHECK(baseline.kinetic_least == 0.5 && baseline.velocity_over_sound == 0.4 && baseline.energy_drift == 0);
    CHECK_CLOSE(baseline.momentum_drift, 0.1, 1e-15);
    if (NDIM == 1)
      CHECK(isnan(baseline.angular_drift)); /* in 1-D there is no angular momentum */
    else
      CHECK_CLOSE(baseline.angular_drift, 0.125, 1e-15);
  }
  scenario_close(&s);
}

/* A liquid under pressure expands suddenly, and its internal energy may be negative: errors are relative to
 * the kinetic energy. */
static void error_relative_to_motion(void) {
  struct scenario s = {0};
  if (scenario_open(&s, disordered, "materials.water.stiffness=2")) {
    const struct kith_totals first = {.kinetic = 1e-12, .momentum_scale = 1, .angular_scale = 1},
                             now = {.kinetic = 1,
                                    .internal = 1e-15 - 1,
                                    .momentum_scale = 1,
                                    .angular_scale = 1};
    struct kith_conservation_baseline baseline = kith_conservation_baseline_of(&first);
    kith_conservation_baseline_update(&baseline, s.simulation, &now);
    CHECK_CLOSE(baseline.energy_drift, 1e-12, 1e-14);
  }
  scenario_close(&s);
}

/* A solid at rest without energy: what rounding makes of it is no error. */
static void no_error_at_rest(void) {
  struct scenario s = {0};
  if (scenario_open(&s, disordered, "materials.water.stiffness=2")) {
    const struct kith_totals first = {.mass = 2, .momentum_scale = 8},
                             now = {.mass = 2, .momentum_scale = 8, .kinetic = 1e-30, .internal = 1e-30};
    struct kith_conservation_baseline baseline = kith_conservation_baseline_of(&first);
    kith_conservation_baseline_update(&baseline, s.simulation, &now);
    CHECK(baseline.energy_drift < 1e-14);
  }
  scenario_close(&s);
}

/* Walls and frozen nodes take angular momentum: no error is reported. */
static void no_angular_error_with_walls(void) {
  static const char *const settings[] = {"boundaries.x=reflecting", "boundaries.x=[open,reflecting]",
                                         "regions.1.frozen=true"};
  for (int k = 0; k < 3; ++k) {
    struct scenario s = {0};
    if (scenario_open(&s, disordered, "%s", settings[k])) {
      const struct kith_totals first = totals(1, 0, 1, 1);
      struct kith_conservation_baseline baseline = kith_conservation_baseline_of(&first);
      kith_conservation_baseline_update(&baseline, s.simulation, &first);
      CHECK(isnan(baseline.angular_drift));
      CHECK(baseline.kinetic_rebound == 0);
      CHECK(baseline.momentum_drift == 0);
      CHECK(kith_simulation_momentum_axes(s.simulation) == (k < 2 ? NDIM - 1 : NDIM));
    }
    scenario_close(&s);
  }
}

/* Walls on all sides and a point mass change the momentum along all axes. */
static void momentum_is_not_kept(void) {
  static const char *const settings[] = {
      "boundaries.x=reflecting boundaries.y=reflecting boundaries.z=reflecting",
      "boundaries.x=open boundaries.y=open boundaries.z=open potential.mass=1 potential.softening=0.1"};
  for (int k = 0; k < 2; ++k) {
    struct scenario s = {0};
    if (scenario_open(&s, disordered, "%s", settings[k])) {
      CHECK(kith_simulation_momentum_axes(s.simulation) == 0);
    }
    scenario_close(&s);
  }
}

int main(void) {
  pressures_are_wanted();
  deposits_come_after();
  released_on_the_way("scheme.steps=global");
  released_on_the_way("scheme.steps=block");
  uniform_pressure();
  baseline_follows();
  error_relative_to_motion();
  no_error_at_rest();
  no_angular_error_with_walls();
  momentum_is_not_kept();
  return check_failed();
}
