/* test_restart.c - restarts. Oracle: the uninterrupted run, to which a run that is stopped, written, read and
 * continued must be bitwise identical, with all schemes, rebuild policies and packages. */
#include <omp.h>
#include "app/output/output.h"
#include "tests/unit/files.h"
#include "tests/unit/scenario.h"

/* Fast nodes that cross periodic faces and meet walls; two materials, one of which may be frozen. */
static const char box[] = SCENARIO_UNIT
    "resolution: {1d: 40, 2d: 12, 3d: 6}\n"
    "boundaries: {x: periodic, y: reflecting, z: periodic}\n"
    "materials: {gas: {gamma: 1.4}, other: {gamma: 1.6666666666666667}}\n"
    "regions:\n"
    "  - {material: gas, where: {x: [0, 0.5]}, jitter: 0.3, seed: 5, lattice: cubic, density: 1, "
    "pressure: 0.1, velocity: [0.7, -0.4, 0.2]}\n"
    "  - {material: other, where: {x: [0.5, 1]}, jitter: 0.3, seed: 6, lattice: cubic, density: 1, "
    "pressure: 0.2, velocity: [0.7, -0.4, 0.2]}\n"
    "energy: {energy: 1, center: [0.4, 0.55, 0.6], over: ball, radius: 0.25}\n"
    "until: 1\n";

/* Cold gas that streams through itself, so that nodes hit walls at every step. */
static const char streams[] = SCENARIO_UNIT
    "resolution: {1d: 40, 2d: 12, 3d: 6}\n"
    "boundaries: {x: reflecting, y: reflecting, z: reflecting}\n"
    "materials: {gas: {eos: isothermal, sound_speed: 0.05}}\n"
    "regions:\n"
    "  - {material: gas, lattice: cubic, jitter: 0.3, density: 1, energy: 1, velocity: [sin(40*x), "
    "cos(50*y), sin(60*z)]}\n"
    "method: {viscosity: {name: monaghan, alpha: 0, beta: 0}}\n"
    "until: 10\n";

/* Makes `steps` steps without a stop, and a run that is written after `stop` steps and continued by another
 * simulation. */
static void check_restart(const char *yaml, const char *settings, int steps, int stop) {
  struct scenario whole = {0}, first = {0}, second = {0};
  struct kith_output output = {0}, later = {0};
  struct kith_conservation_baseline baseline = {0}, back = {0};
  const char *const path = path_in("checkpoint.kith");
  if (scenario_open(&whole, yaml, "%s", settings)) scenario_run(&whole, steps);
  if (scenario_open(&first, yaml, "%s", settings) && scenario_run(&first, stop)) {
    baseline.totals = first.start;
    kith_conservation_baseline_update(&baseline, first.simulation, &first.start);
    CHECK_OK(kith_output_open(&output, first.simulation, directory, NULL, true));
    CHECK_OK(kith_output_checkpoint(&output, first.simulation, &baseline));
    CHECK_OK(kith_output_close(&output));
  }
  scenario_close(&first);
  if (scenario_open(&second, yaml, "%s", settings)) {
    CHECK_OK(kith_output_restore(&later, path, second.simulation, &back));
    CHECK(memcmp(&baseline, &back, sizeof baseline) == 0);
    CHECK(second.simulation->integrator.step == (uint64_t)stop);
    CHECK_OK(scenario_steps(&second, steps - stop));
    scenario_identical(&whole, &second, settings);
    kith_free(&later.times);
  }
  scenario_close(&second);
  scenario_close(&whole);
}

/* The setting that a scheme needs, if any. */
static const char *energy(int scheme) {
  return kith_scheme_all()[scheme]->thermal_only ? "method.energy=thermal" : "";
}

static void all_policies(void) {
  static const char *const rebuild[] = {"always", "displacement", "entity-change|displacement"};
  static const int reorder[] = {1, 5, 0};
  char settings[256];
  for (int p = 0; p < 3; ++p)
    for (int s = 0; kith_scheme_all()[s] != NULL; ++s)
      for (int r = 0; r < 3; ++r)
        for (int frozen = 0; frozen < 2; ++frozen) {
          snprintf(settings, sizeof settings,
                   "connectivity.rebuild=%s scheme.name=%s connectivity.reorder=%d regions.1.frozen=%s %s",
                   rebuild[p], kith_scheme_all()[s]->name, reorder[r],
                   frozen ? "true regions.1.velocity=[0,0,0]" : "false", energy(s));
          if (kith_scheme_all()[s]->implicit && r != p) continue;   /* it is slow */
          if (NDIM == 3 && (p + s + r + frozen) % 2 != 0) continue; /* half of them, to save time */
          check_restart(box, settings, 10, 5);
        }
}

/* Nodes that were reflected since lists were built. Where the run stops matters, so every step is tried, in
 * 3-D every third. */
static void after_reflections(void) {
  char settings[256];
  for (int s = 0; kith_scheme_all()[s] != NULL; ++s)
    for (int stop = 1; stop < 12; stop += kith_scheme_all()[s]->implicit || NDIM == 3 ? 3 : 1) {
      snprintf(settings, sizeof settings,
               "connectivity.rebuild=displacement connectivity.skin=0.5 scheme.dt=%g scheme.name=%s %s",
               kith_scheme_all()[s]->implicit ? 0.005 : 0.01, kith_scheme_all()[s]->name, energy(s));
      check_restart(streams, settings, 12, stop);
    }
}

/* Other settings of a run. */
static void other_settings(void) {
  static const char *const settings[] = {
      "method.energy=thermal",
      "method.energy=thermal traversal=pairs connectivity.rebuild=displacement",
      "traversal=gather",
      "connectivity.cull=false connectivity.rebuild=displacement",
      "neighbor.search=grid",
      "neighbor.search=brute",
      "neighbor.search=spacetree neighbor.layout=scattered",
      "method.viscosity.name=monaghan connectivity.rebuild=displacement",
      "method.viscosity.name=cullen-dehnen method.viscosity.balsara=squared",
      "method.package=crk",
      "method.package=crk connectivity.rebuild=displacement",
      "method.package=mfm",
      "method.package=magma2",
      "method.package=remix connectivity.rebuild=displacement",
      "method.package=mfm method.faces=integrated connectivity.rebuild=displacement",
      "scheme.dt=0.002",
      "connectivity.rebuild=displacement connectivity.skin=0.05",
      "boundaries.x=[open,reflecting] connectivity.rebuild=displacement",
      ("scheme.steps=block arrangement=equal-spacing regions.1.density=10 regions.1.frozen=true "
       "regions.1.velocity=[0,0,0]"),
      "connectivity.rebuild=never connectivity.skin=0.5 scheme.cfl=0.3",
      "scheme.name=arkode method.energy=thermal scheme.rtol=1e-6 scheme.atol=1e-7",
      "scheme.name=arkode method.energy=thermal scheme.rtol=1e-6 connectivity.rebuild=displacement",
      "scheme.name=arkode method.energy=thermal scheme.table=dormand-prince-7-4-5 scheme.adaptive=no",
      "scheme.name=implicit method.energy=thermal scheme.method=backward-euler scheme.cfl=1.5"};
  for (size_t k = 0; k < sizeof settings / sizeof *settings; ++k) check_restart(box, settings[k], 10, 5);
  check_restart(box, "connectivity.rebuild=displacement", 10, 0); /* before the first step */
  check_restart(box, "connectivity.rebuild=displacement", 10, 9);
}

int main(void) {
  static const char *const files[] = {"checkpoint.kith", "checkpoint.kith.previous", "history.csv"};
  omp_set_num_threads(1);
  directory_make();
  all_policies();
  after_reflections();
  other_settings();
  directory_remove(sizeof files / sizeof *files, files);
  return check_failed();
}
