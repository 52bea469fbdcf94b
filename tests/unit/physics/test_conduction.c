/* test_conduction.c - package conduction. Oracles: the equation summed over all images of all nodes; a
 * barrier that conducts nothing; explicit steps, for implicit ones; the exact decay of a wave. */
#include "tests/unit/physics/added_world.h"
#include "tests/unit/scenario.h"

static void add_heat(const struct world *w, struct truth *t, int i, const struct partner *p) {
  static const double conductivity[3] = {3, 0.2, 0.2}, heat[3] = {0.5, 2, 2};
  const double *u = w->hydro.energy->f64;
  const uint8_t *list = w->nodes->list->u8;
  t->rate[i] +=
      truth_diffusion(w, t, i, p, conductivity) * (u[i] / heat[list[i]] - u[p->node] / heat[list[p->node]]);
}

/* ---- in runs ---- */

/* A hot and a cold half of a solid that does not move, with a barrier between them if `barrier`. */
static const char halves[] =
    "resolution: 20\narrangement: equal-spacing\n"
    "domain: {lower: [-0.6, 0, 0], upper: [0.5, 0.2, 0.2]}\n"
    "boundaries: {x: reflecting, y: periodic, z: periodic}\n"
    "materials: {solid: {eos: isothermal}}\n"
    "regions:\n"
    "  - {material: solid, lattice: cubic, where: {x: [-0.6, -0.05]}, density: 1, energy: 2}\n"
    "  - {material: solid, lattice: cubic, where: {x: [-0.05, 0]}, density: 1, energy: 2,\n"
    "     spacing: 0.025, barrier: true}\n"
    "  - {material: solid, lattice: cubic, where: {x: [0, 0.5]}, density: 1, energy: 1}\n"
    "packages: [{name: conduction, conductivity: 0.5}]\n"
    "scheme: {dt: 0.0002}\nuntil: 0.02\n";

/* The internal energy of the cold half at the end. */
static double cold_energy(bool barrier, double conductivity) {
  struct scenario s = {0};
  double sum = 0;
  if (scenario_open(&s, halves, "regions.1.barrier=%s packages.0.conductivity=%g", barrier ? "true" : "false",
                    conductivity) &&
      scenario_run(&s, 10000)) {
    const struct kith_nodes *nodes = s.simulation->nodes;
    const struct kith_hydro *hydro = &s.simulation->hydro;
    for (kith_index i = 0; i < nodes->n_internal; ++i)
      if (nodes->position->f64[i * NDIM] > 0) sum += hydro->mass->f64[i] * hydro->energy->f64[i];
  }
  scenario_close(&s);
  return sum;
}

/* A barrier conducts nothing: each half has, to round-off, the energy that it has without conduction, since
 * neither the motion nor its work depends on the energy. */
static void check_wall(void) {
  const double alone = cold_energy(true, 0);
  CHECK_CLOSE(cold_energy(true, 0.5), alone, 1e-13 * alone);
  CHECK(cold_energy(false, 0.5) > 1.05 * cold_energy(false, 0));
}

static const char wave[] =
    "resolution: 16\ndomain: {lower: [0, 0, 0], upper: [1, 0.25, 0.25]}\n"
    "boundaries: {x: periodic, y: periodic, z: periodic}\n"
    "materials: {solid: {eos: isothermal}}\n"
    "regions: [{material: solid, lattice: cubic, density: 1, energy: \"2 + sin(2*pi*x)\"}]\n"
    "method: {energy: thermal, kernel: wendland-c4}\n"
    "packages: [{name: conduction, conductivity: 0.1}]\n"
    "until: 0.1\n";

/* Returns the largest energy at the end, and counts steps. */
static double peak(const char *settings, uint64_t *steps) {
  struct scenario s = {0};
  double most = 0;
  if (scenario_open(&s, wave, "%s", settings) && scenario_run(&s, 10000)) {
    most = largest(s.simulation->hydro.energy->f64, s.simulation->nodes->n_internal);
    *steps = s.simulation->integrator.step;
    CHECK(s.simulation->integrator.time == s.scene->until);
  }
  scenario_close(&s);
  return most;
}

/* With steps of up to ten times the explicit limit, the result is the same within the error of the steps. */
static void check_implicit(void) {
  uint64_t explicit_steps = 0, implicit_steps = 0;
  const double wanted = peak("scheme.name=rk2", &explicit_steps),
               got = peak("scheme.name=implicit scheme.cfl=6", &implicit_steps);
  CHECK_CLOSE(got, wanted, 2e-4); /* measured: 5e-5 */
  CHECK(implicit_steps > 0 && 3 * implicit_steps < explicit_steps);
}

/* The wave decays at the exact rate; the error is of second order in the support, and in 2-D and 3-D sums of
 * a square lattice also differ from those of the ideal one. */
static void check_decay(void) {
  uint64_t steps;
  const double decay =
      log(sin(M_PI * 15 / 32) / (peak("resolution=32 method.kernel=wendland-c2", &steps) - 2));
  CHECK_CLOSE(decay / (0.1 * 4 * M_PI * M_PI * 0.1), 1, NDIM == 1 ? 0.01 : 0.02);
}

int main(void) {
  added_check_sums("conduction", "conductivity=3,0.2 specific_heat=0.5,2", add_heat);
  check_wall();
  check_implicit();
  if (NDIM < 3) check_decay(); /* in 3-D it takes seconds, and tests nothing else */
  return check_failed();
}
