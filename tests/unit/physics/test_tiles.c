/* test_tiles.c - traversal pairs on more nodes than a tile holds. Oracle: traversal gather, to round-off. It
 * must also be bitwise identical for 1 and 3 threads, and evaluate fewer pairs. With images that are ghosts
 * or shifts, walls, inflow and outflow, a window, and block time steps. */
#include <omp.h>
#include "tests/unit/scenario.h"

static const char box[] = SCENARIO_PERIODIC
    "resolution: {1d: 1200, 2d: 36, 3d: 11}\n"
    "materials: {gas: {gamma: 1.4}}\n"
    "regions:\n"
    "  - {material: gas, jitter: 0.2, lattice: cubic, density: '1 + 0.5 * sin(2 * _pi * x)', pressure: 1,\n"
    "     velocity: ['sin(2 * _pi * x)', 0.2, 0]}\n"
    "until: 1\n";

static void check(const char *settings) {
  static const char *const rates[] = {"acceleration", "energy_rate", "signal",
                                      "velocity",     "energy",      "support"};
  const int before = check_failures;
  struct scenario gather = {0}, pairs = {0}, alone = {0};
  if (scenario_open(&gather, box, "%s traversal=gather", settings) &&
      scenario_open(&pairs, box, "%s traversal=pairs", settings) &&
      scenario_open(&alone, box, "%s traversal=pairs", settings)) {
    CHECK(gather.simulation->nodes->n_internal > 1000); /* a tile holds 128 */
    omp_set_num_threads(1);
    scenario_run(&alone, 3);
    omp_set_num_threads(3);
    scenario_run(&gather, 3);
    scenario_run(&pairs, 3);
    const char *different = scenario_difference(&pairs, &alone);
    if (different != NULL) fprintf(stderr, "threads: %s differs\n", different);
    CHECK(different == NULL);
    for (size_t k = 0; k < sizeof rates / sizeof *rates; ++k)
      CHECK(scenario_distance(&pairs, &gather, rates[k]) < 1e-11);
    CHECK(pairs.simulation->package.pair_evaluations < gather.simulation->package.pair_evaluations);
    scenario_close(&gather);
    scenario_close(&pairs);
    scenario_close(&alone);
  }
  if (check_failures > before) fprintf(stderr, "%d-D, %s\n", NDIM, settings);
}

int main(void) {
  char text[128];
  for (const struct kith_package_ops *const *p = kith_package_all(); *p != NULL; ++p) {
    snprintf(text, sizeof text, "method.package=%s", (*p)->name);
    check(text);
  }
  check("method.package=sph boundaries.x=reflecting");
  check("method.package=sph method.energy=thermal");
  check("method.package=crk boundaries={\"x\":{\"kind\":\"periodic\",\"images\":\"shifts\"}}");
  check(
      "method.package=mfm boundaries.x=[inflow,outflow] regions.0.velocity=[2,0,0] "
      "regions.0.pressure=1+0.3*x "
      "regions.0.jitter=0");
  check(
      "method.package=mfm window=follow regions.0.velocity=[0,0,0] regions.0.density=1 regions.0.jitter=0 "
      "regions.0.pressure=x>0.5?1:0.1");
  check("method.package=mfm method.faces=integrated");
  check("method.package=sph scheme.steps=block scheme.random_steps=7");
  check("method.package=crk scheme.steps=block scheme.random_steps=8 boundaries.x=reflecting");
  check("method.package=mfm scheme.steps=block regions.0.pressure=x>0.5?1:0.1");
  return check_failed();
}
