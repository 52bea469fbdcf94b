/* test_block_steps.c - block time steps: conservation with any steps (round-off), one level against global
 * steps, energies and updates of a blast against those of global steps, failure without limits, other units
 * of time, a thin plate (with a window, too), bodies that meet, cold gas onto a wall, and settings that are
 * refused. Lists of active nodes are tested by test_connectivity.c, threads by test_lifecycle.c, ranks and
 * restarts by tests/mpi. */
#include "integrator/block_lengths.h"
#include "tests/unit/scenario.h"

#define BLOCK "scheme: {steps: block}\n"

/* A blast beside a wall in disordered gas that conducts heat, in contact with a lighter gas. */
static const char blast[] = SCENARIO_UNIT
    "resolution: {1d: 60, 2d: 16, 3d: 8}\n"
    "boundaries: {x: reflecting, y: periodic, z: periodic}\n"
    "materials: {gas: {gamma: 1.4}, light: {gamma: 1.6666666666666667}}\n"
    "regions:\n"
    "  - {material: gas, where: {x: [0, 0.7]}, jitter: 0.2, seed: 3, lattice: cubic, density: 1, "
    "pressure: 0.01}\n"
    "  - {material: light, where: {x: [0.7, 1]}, lattice: cubic, density: 0.5, pressure: 0.01}\n"
    "energy: {energy: 1, center: [0.4, 0.55, 0.6], over: kernel, spacings: 2}\n"
    "packages: [{name: conduction, conductivity: 0.001}]\n" BLOCK "until: 0.1\n";

static const char wave[] =
    "dimension: 1\nscene: wave\n"
    "resolution: {1d: 64, 2d: 16, 3d: 10}\n"
    "domain: {lower: [0, 0, 0], upper: [1, 1, 1], across: 7}\n"
    "boundaries: {x: periodic, y: periodic, z: periodic}\n"
    "materials: {gas: {gamma: 1.4}}\n"
    "regions:\n"
    "  - {material: gas, lattice: cubic, density: 1 + 0.01*sin(2*pi*x), pressure: 0.6*(1 + "
    "0.014*sin(2*pi*x)), velocity: [0.01*sin(2*pi*x), 0, 0]}\n"
    "until: 0.2\n";

static uint64_t updates(const struct scenario *s) {
  return s->simulation->integrator.ledger.updates;
}

/* Energy relative to what there was, momentum relative to the sum of magnitudes now; round-off of thousands
 * of sums. */
static void check_conserved(const struct scenario *s, bool momentum_too) {
  const struct kith_totals a = s->start, b = kith_hydro_totals(&s->simulation->hydro);
  CHECK_CLOSE(b.kinetic + b.internal + b.potential, a.kinetic + a.internal + a.potential,
              1e-12 * (a.kinetic + a.internal + fabs(a.potential)));
  for (int d = 0; momentum_too && d < NDIM; ++d) /* along x the wall takes momentum */
    if (d > 0) CHECK_CLOSE(b.momentum[d], a.momentum[d], 1e-12 * b.momentum_scale);
}

/* Levels count each update and each tick once, and the steps of a node fill the time without gaps. */
static void check_levels(const struct scenario *s) {
  const struct kith_integrator *it = &s->simulation->integrator;
  const struct kith_level sum = kith_levels_sum(&it->levels);
  const double nodes = s->simulation->nodes->n_internal;
  CHECK_CLOSE(sum.held, nodes * it->levels.time, 1e-9 * sum.held);
  CHECK_CLOSE(it->levels.time, it->time, 1e-12 * it->time);
  CHECK(sum.updates == (double)it->ledger.updates - 2 * nodes); /* the start evaluates twice */
  CHECK(sum.ticks == (double)it->ledger.evaluations - 2);
  CHECK(it->levels.level[0].ticks == (double)it->step && it->levels.base_steps == (double)it->step);
  CHECK(kith_levels_ideal(&it->levels) > 1 && kith_levels_achieved(&it->levels) > 0);
}

/* Random steps and wake-ups: energy and momentum are conserved to round-off. */
static void check_random_steps(const char *settings) {
  for (int seed = 0; seed < 2; ++seed) {
    struct scenario s = {0};
    if (scenario_open(&s, blast, "%s scheme.random_steps=%d", settings, 7 * seed) && scenario_run(&s, 6)) {
      check_conserved(&s, true);
      const struct kith_ledger *ledger = &s.simulation->integrator.ledger;
      const uint64_t nodes = (uint64_t)s.simulation->nodes->n_internal;
      CHECK(ledger->updates < ledger->evaluations * nodes); /* some nodes were inactive at times */
      check_levels(&s);
    }
    scenario_close(&s);
  }
}

static void conservation(void) {
  char package[64];
  for (const struct kith_package_ops *const *p = kith_package_all(); *p != NULL; ++p) {
    snprintf(package, sizeof package, "method.package=%s", (*p)->name);
    check_random_steps(package);
  }
  check_random_steps("traversal=gather");
  check_random_steps("method.viscosity.name=cullen-dehnen");
  check_random_steps("scheme.ratio=2");
  check_random_steps("method.package=crk regions.1.porosity=0.3 regions.0.damage=0.5*x");
}

/* With a fixed step there is one level, and the run is that of a global step, except for the prediction of
 * energies, which is of second order in dt in both. Measured in 1-D to 3-D: 5e-6 of velocities, 2e-8 of
 * energies. */
static void one_level(void) {
  struct scenario block = {0}, global = {0};
  if (scenario_open(&block, wave, "scheme.steps=block scheme.dt=0.002") && scenario_run(&block, 200) &&
      scenario_open(&global, wave, "scheme.dt=0.002") && scenario_run(&global, 200)) {
    CHECK(scenario_distance(&block, &global, "velocity") < 2e-5);
    CHECK(scenario_distance(&block, &global, "energy") < 1e-7);
    CHECK(updates(&block) <= updates(&global) + 2 * (uint64_t)block.simulation->nodes->n_internal);
    check_conserved(&block, false);
  }
  scenario_close(&block);
  scenario_close(&global);
}

/* The blast needs less than half of the updates in 1-D, and its kinetic energy is that of global steps within
 * 0.5 % of the total (measured: 0.23 % in 3-D, less in 1-D and 2-D). */
static void fewer_updates(void) {
  struct scenario block = {0}, global = {0};
  if (scenario_open(&block, blast, "scheme.levels=10") && scenario_run(&block, 100000) &&
      scenario_open(&global, blast, "scheme.steps=global") && scenario_run(&global, 100000)) {
    const struct kith_totals a = kith_hydro_totals(&block.simulation->hydro),
                             b = kith_hydro_totals(&global.simulation->hydro);
    CHECK_CLOSE(a.kinetic, b.kinetic, 0.005 * (b.kinetic + b.internal));
    CHECK(2 * updates(&block) < updates(&global) || NDIM > 1); /* in 2-D and 3-D the blast fills this box */
    CHECK(updates(&block) < updates(&global));
  }
  scenario_close(&block);
  scenario_close(&global);
}

/* If steps are not limited by those of neighbors, a strong blast runs into nodes with long steps, and the run
 * fails. */
static void blast_needs_limits(void) {
  static const char cold[] =
      "dimension: 3\nscene: cold\n"
      "resolution: {1d: 200, 2d: 40, 3d: 20}\n"
      "domain: {lower: [-0.5, -0.5, -0.5], upper: [0.5, 0.5, 0.5]}\n"
      "boundaries: {x: periodic, y: periodic, z: periodic}\n"
      "materials: {gas: {gamma: 1.6666666666666667}}\n"
      "regions:\n"
      "  - {material: gas, lattice: cubic, density: 1, pressure: 1e-6}\n"
      "energy: {energy: 1, center: [0, 0, 0], over: kernel, spacings: 2}\n" BLOCK "until: 0.05\n";
  for (int limited = 0; limited < 2; ++limited) {
    struct scenario s = {0};
    if (scenario_open(&s, cold, "scheme.ratio=%s", limited ? "4" : "none")) {
      CHECK_OK(scenario_start(&s));
      CHECK_STATUS(limited ? KITH_OK : KITH_DIVERGED, scenario_steps(&s, 100000));
    }
    scenario_close(&s);
  }
}

/* Base steps in a row are equal parts of one time, so a step that may double is as long as the next base step
 * but for round-off, which is another one in other units of time. */
static void round_off_decides_no_step(void) {
  struct scenario one = {0}, other = {0};
  if (scenario_open(&one, blast, "until=0.1") && scenario_run(&one, 100000) &&
      scenario_open(&other, blast,
                    "until=0.02 energy.energy=25 packages.0.conductivity=0.005 regions.0.pressure=0.25 "
                    "regions.1.pressure=0.25") &&
      scenario_run(&other, 100000))
    CHECK(updates(&one) == updates(&other));
  scenario_close(&one);
  scenario_close(&other);
}

/* A plate thinner than a support: with block steps and with a window the gas on both sides is where it is
 * with global steps, and no energy is lost. Measured with block steps: 0.4 to 1.2 % of the largest velocity,
 * 0.06 to 0.2 % of the density. */
static void plate(void) {
  static const char scene[] =
      "dimension: 3\nscene: plate\nresolution: {1d: 50, 2d: 20, 3d: 20}\narrangement: equal-spacing\n"
      "domain: {lower: [-1, 0, 0], upper: [0.5, 1, 1], across: 6}\n"
      "boundaries: {x: reflecting, y: periodic, z: periodic}\nmaterials: {gas: {gamma: 1.4}}\n"
      "regions:\n"
      "  - {material: gas, lattice: cubic, where: {x: [-1, -0.5]}, density: 1, pressure: 3}\n"
      "  - {material: gas, lattice: cubic, where: {x: [-0.5, 0]}, density: 1, pressure: 1}\n"
      "  - {material: gas, lattice: cubic, where: {x: [0, 0.05]}, density: 1, pressure: 1, barrier: true,\n"
      "     spacing: {1d: 0.01, 2d: 0.025, 3d: 0.025}}\n"
      "  - {material: gas, lattice: cubic, where: {x: [0.05, 0.5]}, density: 1, pressure: 1}\n"
      "until: 0.25\n";
  static const char *const settings[] = {"scheme.steps=block", "window=follow"};
  struct scenario whole = {0};
  const bool ran = scenario_open(&whole, scene, "scene=plate") && scenario_run(&whole, 100000);
  for (int k = 0; ran && k < 2; ++k) {
    struct scenario part = {0};
    if (scenario_open(&part, scene, "%s", settings[k]) && scenario_run(&part, 100000)) {
      CHECK(scenario_distance(&whole, &part, "velocity") < (k == 0 ? 0.02 : 1e-11));
      CHECK(scenario_distance(&whole, &part, "density") < (k == 0 ? 0.01 : 1e-12));
      CHECK(NDIM == 1 || part.simulation->integrator.ledger.pairs_cut > 0);
      CHECK(updates(&part) < updates(&whole));
      check_conserved(&part, true);
    }
    scenario_close(&part);
  }
  scenario_close(&whole);
}

/* Two lengths of the base step may cost the same but for round-off, in other units of time the other way
 * round. In 1-D this gas falls at a point so that they do; `time` is the unit. */
static void equal_costs_are_equal(void) {
  static const double time[] = {1, 1.1, 0.3};
  uint64_t first = 0;
  for (int k = 0; k < 3; ++k) {
    struct scenario s = {0};
    char yaml[1024];
    const double v = 1 / time[k], p = v * v;
    snprintf(yaml, sizeof yaml,
             "dimension: 1\nscene: fall\nresolution: {1d: 60, 2d: 12, 3d: 8}\n"
             "domain: {lower: [0, 0, 0], upper: [1, 1, 1]}\n"
             "boundaries: {x: reflecting, y: reflecting, z: reflecting}\nmaterials: {gas: {}}\n"
             "gravity: [%.17g, 0, 0]\n"
             "potential: {center: [-0.3, 0, 0], mass: %.17g, softening: 0.05}\n"
             "regions:\n  - {material: gas, lattice: cubic, density: 1 + 0.3*sin(2*pi*x), "
             "pressure: %.17g*(1 + 0.2*cos(2*pi*x)), velocity: [%.17g*sin(2*pi*x), 0, 0]}\n" BLOCK
             "until: %.17g\n",
             -0.5 * p, 0.2 * p, p, 0.3 * v, 0.1 * time[k]);
    if (scenario_open(&s, yaml, " ") && scenario_run(&s, 100000)) {
      if (k == 0) first = updates(&s);
      CHECK(updates(&s) == first);
    }
    scenario_close(&s);
  }
}

/* A heavy node beside a light one must end steps early, also if it is frozen and makes no steps itself. */
static void heavy_nodes_are_noticed(void) {
  static const struct {
    const char *settings;
    bool even;
  } runs[] = {{"", true},
              {"arrangement=equal-spacing regions.1.density=10", false},
              {"regions.1.frozen=true", true},
              {"arrangement=equal-spacing regions.1.density=10 regions.1.frozen=true", false}};
  for (size_t k = 0; k < sizeof runs / sizeof *runs; ++k) {
    struct scenario s = {0};
    if (scenario_open(&s, blast, "%s", runs[k].settings) && scenario_run(&s, 1))
      CHECK(kith_blocks_of(&s.simulation->integrator)->even == runs[k].even);
    scenario_close(&s);
  }
}

/* A hot body flies into a cold one at eight times its speed of sound. Pairs that meet at the end of a base
 * step must not begin the next one with a long step. Velocities are those of short global steps: the largest
 * difference, over the largest velocity, is 0.017, 0.030 and 0.126 in 1-D to 3-D (with long steps 0.038,
 * 0.114 and 0.278). */
static void bodies_meet(void) {
  static const char scene[] =
      "dimension: 2\nscene: bodies\nresolution: {1d: 40, 2d: 20, 3d: 12}\n"
      "domain: {lower: [-0.5, 0, 0], upper: [1, 1, 1], across: 8}\n"
      "boundaries: {y: periodic, z: periodic}\nmaterials: {gas: {gamma: 1.4}}\n"
      "method: {package: crk}\n"
      "regions:\n"
      "  - {material: gas, lattice: cubic, where: {x: [-0.5, -0.25]}, density: 1, pressure: 0.01,\n"
      "     velocity: [1, 0, 0]}\n"
      "  - {material: gas, lattice: cubic, where: {x: [0, 0.25]}, density: 1, pressure: 1e-8}\n"
      "until: 0.3\n";
  static const char *const places[] = {"regions.1.where.x=[0,0.25] until=0.3",
                                       "regions.1.where.x=[0.0167,0.2667] until=0.3167"};
  static const double most[] = {0.025, 0.05, 0.18};
  for (int k = 0; k < 2; ++k) {
    struct scenario block = {0}, global = {0};
    if (scenario_open(&block, scene, "scheme.steps=block %s", places[k]) && scenario_run(&block, 100000) &&
        scenario_open(&global, scene, "scheme.cfl=0.1 %s", places[k]) && scenario_run(&global, 100000)) {
      CHECK(scenario_distance(&block, &global, "velocity") < most[NDIM - 1]);
      check_conserved(&block, true);
    }
    scenario_close(&block);
    scenario_close(&global);
  }
}

/* Cold gas of gamma 1.05 onto a wall, with mfm: between nodes that meet head on reconstruction must leave a
 * difference ((5a) of mfm.c), or the step collapses, with one step for all nodes or steps of their own. */
static void head_on(void) {
  static const char scene[] =
      "dimension: 1\nscene: wall\nresolution: {1d: 100, 2d: 20, 3d: 12}\n"
      "domain: {lower: [0, 0, 0], upper: [0.3, 1, 1], across: 8}\n"
      "boundaries: {x: [reflecting, open], y: periodic, z: periodic}\nmaterials: {gas: {gamma: 1.05}}\n"
      "method: {package: mfm}\n"
      "regions:\n  - {material: gas, lattice: cubic, density: 1, pressure: 1e-6, velocity: [-1, 0, 0]}\n"
      "until: 0.02\n";
  for (int k = 0; k < 2; ++k) {
    struct scenario s = {0};
    if (scenario_open(&s, scene, "scheme.steps=%s", k == 0 ? "global" : "block") && scenario_run(&s, 100000))
      check_conserved(&s, true);
    scenario_close(&s);
  }
}

static void refused(void) {
  static const char *const settings[] = {"connectivity.rebuild=displacement",
                                         "method.package=mfm method.faces=integrated"};
  for (size_t k = 0; k < sizeof settings / sizeof *settings; ++k)
    CHECK_STATUS(KITH_BAD_INPUT, scenario_status(blast, settings[k]));
}

int main(void) {
  conservation();
  one_level();
  fewer_updates();
  blast_needs_limits();
  round_off_decides_no_step();
  plate();
  equal_costs_are_equal();
  heavy_nodes_are_noticed();
  bodies_meet();
  head_on();
  refused();
  return check_failed();
}
