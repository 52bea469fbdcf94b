/* test_viscosity.c - package viscosity. Oracles: the equation summed over all images of all nodes; and
 * the exact decay of flow in a channel. */
#include "tests/unit/physics/added_world.h"
#include "tests/unit/scenario.h"

/* Force and heat per mass. */
static void add_drag(const struct world *w, struct truth *t, int i, const struct partner *p) {
  static const double dynamic[3] = {3, 0.2, 0.2};
  const double *v = w->hydro.velocity->f64, drag = truth_diffusion(w, t, i, p, dynamic);
  for (int a = 0; a < NDIM; ++a) {
    const double d = v[i * NDIM + a] - p->sign[a] * v[p->node * NDIM + a];
    t->acceleration[i][a] += drag * d;
    t->rate[i] -= 0.5 * drag * d * d;
  }
}

/* A fluid that moves along a channel between barriers at rest. */
static const char channel[] =
    "resolution: 20\narrangement: equal-spacing\n"
    "domain: {lower: [-0.15, 0, 0], upper: [0.65, 0.3, 0.3]}\n"
    "boundaries: {x: open, y: periodic, z: periodic}\n"
    "materials: {fluid: {eos: isothermal}}\n"
    "regions:\n"
    "  - {material: fluid, lattice: cubic, where: {x: [-0.15, 0]}, density: 1, energy: 1, barrier: true}\n"
    "  - {material: fluid, lattice: cubic, where: {x: [0, 0.5]}, density: 1, energy: 1,\n"
    "     velocity: [0, 0.1, 0]}\n"
    "  - {material: fluid, lattice: cubic, where: {x: [0.5, 0.65]}, density: 1, energy: 1, barrier: true}\n"
    "method: {viscosity: {name: none}, kernel: wendland-c4}\n"
    "packages: [{name: viscosity, dynamic: 0.1}]\n"
    "until: 0.5\n";

/* Without slip, v = sum over odd n of 4 / (n pi) sin(n pi x / L) exp(-nu (n pi / L)^2 t) of the start; and
 * the kinetic energy that the walls take becomes heat. */
static void check_channel(void) {
  struct scenario s = {0};
  double mean = 0, wanted = 0;
  if (scenario_open(&s, channel, "resolution=20") && scenario_run(&s, 10000)) {
    const struct kith_hydro *hydro = &s.simulation->hydro;
    const struct kith_totals now = kith_hydro_totals(hydro);
    for (kith_index i = 0; i < hydro->nodes->n_internal; ++i)
      mean += hydro->velocity->f64[(size_t)i * NDIM + (NDIM > 1)] / hydro->nodes->n_internal;
    for (int n = 1; n < 20; n += 2)
      wanted += 8 / (n * n * M_PI * M_PI) * exp(-0.1 * n * n * M_PI * M_PI / 0.25 * 0.5);
    /* A barrier reverses velocities for each node by itself, which is a wall to first order: half a spacing
     * of 1/20 more between the walls, 20 % of what is left. With slip there would be nine times as much. */
    CHECK_CLOSE(mean, 0.1 * wanted, 0.22 * 0.1 * wanted);
    CHECK_CLOSE((now.kinetic + now.internal) / (s.start.kinetic + s.start.internal), 1, 1e-13);
  }
  scenario_close(&s);
}

int main(void) {
  added_check_sums("viscosity", "dynamic=3,0.2", add_drag);
  if (NDIM == 2) check_channel(); /* in 3-D it takes a minute, and tests nothing else */
  return check_failed();
}
