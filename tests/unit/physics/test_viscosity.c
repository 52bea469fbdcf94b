/* test_viscosity.c - package viscosity. Oracles: the equation summed over all images of all nodes
 * (sph_world.h), with the normalization of kernel.h, which test_kernel.c tests; and the exact decay of flow
 * in a channel. */
#include "tests/unit/physics/added_world.h"
#include "tests/unit/scenario.h"

/* Sums of a few hundred terms, as for package sph. */
static const double round_off = 1e-11;

/* Adds force and heat per mass of node i by the equation. */
static void add_drag(const struct world *w, struct truth *t, int i, const double *mu) {
  const double *v = w->hydro.velocity->f64, *m = w->hydro.mass->f64;
  const uint8_t *list = w->nodes->list->u8;
  const double flow = kith_kernel_gradient_sum(w->package.kernel, w->package.neighbors);
  for (size_t e = t->partners.first[i]; e < t->partners.first[i + 1]; ++e) {
    const struct partner *p = &t->partners.partner[e];
    const int j = p->node;
    const double hi = t->support[i], hj = t->support[j], mi = mu[list[i]], mj = mu[list[j]];
    double slope = 0; /* (dW/dr) / r, the mean of both supports */
    if (p->r < hi) slope += 0.5 * w->kernel.constant / pow(hi, NDIM + 2) * oracle_g(&w->kernel, p->r / hi);
    if (p->r < hj) slope += 0.5 * w->kernel.constant / pow(hj, NDIM + 2) * oracle_g(&w->kernel, p->r / hj);
    const double drag = 4 * mi * mj / (mi + mj) * m[j] / (t->density[i] * t->density[j]) * slope / flow;
    for (int a = 0; a < NDIM; ++a) {
      const double d = v[i * NDIM + a] - p->sign[a] * v[j * NDIM + a];
      t->acceleration[i][a] += drag * d;
      t->rate[i] -= 0.5 * drag * d * d;
    }
  }
}

static void check_sums(enum side side, enum kith_traversal traversal) {
  const int cells[3] = {NDIM == 1 ? 14 : NDIM == 2 ? 7 : 5, NDIM == 2 ? 6 : 4, 3};
  const struct method m = {KITH_KERNEL_wendland_c2, KITH_VISCOSITY_NONE, traversal, true, 0, 0};
  const double mu[3] = {3, 0.2, 0.2};
  struct added added;
  struct world w;
  struct truth t = {0};
  world_create(&w, cells, side, 0.3, &m, 5);
  added_attach(&added, &w, "viscosity", "dynamic=3,0.2");
  truth_density(&w, &t);
  world_root(&w, &t);
  world_base(&w);
  truth_all(&w, &t);
  for (int i = 0; i < w.nodes->n_internal; ++i) add_drag(&w, &t, i, mu);
  CHECK_OK(world_evaluate(&w));
  CHECK_OK(kith_package_evaluate(&w.package, w.connectivity, &w.it.kick));
  CHECK_FIELD(w.hydro.acceleration->f64, &t.acceleration[0][0], w.nodes->n_internal * NDIM, round_off);
  CHECK_FIELD(w.hydro.energy_rate->f64, t.rate, w.nodes->n_internal, round_off);
  truth_clear(&t);
  added_detach(&w, 1, &added);
  world_destroy(&w);
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
  for (int side = OPEN; side <= REFLECTING; ++side) {
    check_sums((enum side)side, KITH_TRAVERSE_GATHER);
    check_sums((enum side)side, KITH_TRAVERSE_PAIRS);
  }
  if (NDIM == 2) check_channel(); /* in 3-D it takes a minute, and tests nothing else */
  return check_failed();
}
