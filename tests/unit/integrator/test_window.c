/* test_window.c - window: follow, in which gas that no signal has reached is inactive. Oracle: the run of all
 * nodes, to round-off, for fewer updates; inactive nodes stay bitwise unchanged; disordered gas is all
 * active; gas and pistons that arrive from afar; settings that are refused. Ranks and restarts: tests/mpi. */
#include "tests/unit/scenario.h"

#define FOLLOW "window: follow\n"

/* A jump of pressure in a long tube; in 1-D with walls. */
static const char tube[] =
    "dimension: 3\nscene: tube\n"
    "resolution: {1d: 50, 2d: 24, 3d: 20}\n"
    "domain: {lower: [-2, 0, 0], upper: [2, 1, 1], across: 7}\n"
    "boundaries: {x: {1d: reflecting, 2d: periodic, 3d: periodic}, y: periodic, z: periodic}\n"
    "materials: {gas: {gamma: 1.4}}\n"
    "regions:\n"
    "  - {material: gas, where: {x: [-2, 0]}, lattice: cubic, density: 1, pressure: 1}\n"
    "  - {material: gas, where: {x: [0, 2]}, lattice: cubic, density: 1, pressure: 0.1}\n"
    "until: 0.05\n" FOLLOW;

static uint64_t updates(const struct scenario *s) {
  return s->simulation->integrator.ledger.updates;
}

static void check_window(const char *settings) {
  struct scenario window = {0}, whole = {0};
  if (scenario_open(&window, tube, "%s", settings) && scenario_run(&window, 100000) &&
      scenario_open(&whole, tube, "%s window=whole", settings) && scenario_run(&whole, 100000)) {
    CHECK(scenario_distance(&whole, &window, "velocity") < 1e-11);
    CHECK(scenario_distance(&whole, &window, "energy") < 1e-12);
    CHECK(scenario_distance(&whole, &window, "density") < 1e-12);
    CHECK(scenario_distance(&whole, &window, "position") < 1e-12);
    CHECK(whole.simulation->integrator.step == window.simulation->integrator.step);
    CHECK(100 * updates(&window) < (NDIM == 1 ? 50 : 90) * updates(&whole));
    CHECK(scenario_energy_error(&window) < 1e-12);
    CHECK(NDIM == 1 || scenario_momentum_error(&window) < 1e-12);
  }
  scenario_close(&window);
  scenario_close(&whole);
}

static void agrees_with_fewer_updates(void) {
  char package[64];
  int tried = 0;
  check_window("traversal=gather");
  for (const struct kith_package_ops *const *p = kith_package_all(); *p != NULL; ++p) {
    snprintf(package, sizeof package, "method.package=%s", (*p)->name);
    if ((NDIM == 3 && tried > 1) || scenario_status(tube, package) == KITH_BAD_INPUT)
      continue; /* a history */
    check_window(package), ++tried;
  }
  CHECK(tried > 1);
  if (NDIM < 3) check_window("scheme.name=rk2");
}

/* Dust at rest meets what arrives from afar: gas that flies through empty space, whose neighbor it is from
 * one step to the next, and a piston, in which it has nothing but its own images as neighbors. */
static void arrives_late(void) {
  static const char dust[] =
      "resolution: {1d: 100, 2d: 30, 3d: 12}\narrangement: equal-spacing\n"
      "domain: {lower: [-1, 0, 0], upper: [1, 1, 1], across: 8}\n"
      "materials:\n"
      "  dust: {eos: mie-grueneisen, density: 1.5, sound_speed: 1, slope: 1.5, gamma: 2, tension: cut}\n"
      "  gas: {gamma: 1.4}\n"
      "regions:\n"
      "  - {material: dust, lattice: cubic, where: {x: [-0.5, 0]}, density: 1, energy: 0}\n";
  static const char *const arrivals[] = {
      "  - {material: gas, lattice: cubic, where: {x: [0.4, 0.9]}, density: 1, pressure: 0.01,\n"
      "     velocity: [-1, 0, 0]}\n"
      "boundaries: {x: periodic, y: periodic, z: periodic}\nuntil: 0.5\n",
      "  - {material: gas, lattice: cubic, where: {x: [0.6, 0.9]}, density: 1, pressure: 0.01}\n"
      "boundaries: {x: [{kind: piston, velocity: 1}, open], y: periodic, z: periodic}\nuntil: 0.55\n"};
  for (size_t k = 0; k < sizeof arrivals / sizeof *arrivals; ++k) {
    char scene[1024];
    snprintf(scene, sizeof scene, "%s%s" FOLLOW, dust, arrivals[k]);
    struct scenario window = {0}, whole = {0};
    if (scenario_open(&window, scene, "scene=dust") && scenario_run(&window, 100000) &&
        scenario_open(&whole, scene, "scene=dust window=whole") && scenario_run(&whole, 100000)) {
      CHECK(scenario_distance(&whole, &window, "velocity") < 1e-11);
      CHECK(scenario_distance(&whole, &window, "position") < 1e-12);
      CHECK(updates(&window) < updates(&whole));
      CHECK(scenario_energy_error(&window) < 1e-12);
      CHECK(k > 0 || scenario_momentum_error(&window) < 1e-12);
    }
    scenario_close(&window);
    scenario_close(&whole);
  }
}

/* Inactive nodes are read by neighbors, but not written. */
static void inactive_nodes_stay(void) {
  struct scenario before = {0}, after = {0};
  kith_index inactive = 0, changed = 0;
  if (scenario_open(&before, tube, "connectivity.reorder=0") && scenario_run(&before, 0) &&
      scenario_open(&after, tube, "connectivity.reorder=0") && scenario_run(&after, 4)) {
    const struct kith_nodes *m = before.simulation->nodes, *n = after.simulation->nodes;
    for (kith_index i = 0; i < n->n_internal; ++i) {
      if (n->activity->u8[i] == KITH_ACTIVE) continue;
      ++inactive;
      for (int f = 0; f < n->n_fields; ++f) {
        const size_t size = kith_field_node_size(n->fields[f]);
        if (n->fields[f]->spec.role == KITH_STATE &&
            memcmp((const char *)m->fields[f]->data + (size_t)i * size,
                   (const char *)n->fields[f]->data + (size_t)i * size, size) != 0)
          ++changed;
      }
    }
    CHECK(inactive > 0 && inactive < n->n_internal);
    CHECK(changed == 0);
  }
  scenario_close(&before);
  scenario_close(&after);
}

/* Disordered gas is nowhere in balance: all nodes are active, and the run is bitwise that without a
 * window. */
static void disordered_gas_is_active(void) {
  struct scenario window = {0}, whole = {0};
  const char *jitter = "regions.0.jitter=0.2 regions.1.jitter=0.2";
  if (scenario_open(&window, tube, "%s", jitter) && scenario_run(&window, 5) &&
      scenario_open(&whole, tube, "%s window=whole", jitter) && scenario_run(&whole, 5)) {
    CHECK(updates(&window) == updates(&whole));
    CHECK(scenario_difference(&whole, &window) == NULL);
  }
  scenario_close(&window);
  scenario_close(&whole);
}

static void refused(void) {
  static const char *const settings[] = {"connectivity.rebuild=displacement",
                                         "scheme.steps=block",
                                         "scheme.name=implicit",
                                         "scheme.name=arkode method.energy=thermal",
                                         "method.package=mfm method.faces=integrated",
                                         "boundaries.x=outflow",
                                         "scheme.dt=0.001",
                                         "method.package=remix",
                                         "method.viscosity.name=cullen-dehnen"};
  for (size_t k = 0; k < sizeof settings / sizeof *settings; ++k)
    CHECK_STATUS(KITH_BAD_INPUT, scenario_status(tube, settings[k]));
}

int main(void) {
  agrees_with_fewer_updates();
  arrives_late();
  inactive_nodes_stay();
  disordered_gas_is_active();
  refused();
  return check_failed();
}
