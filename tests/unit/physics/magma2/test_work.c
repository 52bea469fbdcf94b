/* test_work.c - package magma2: on disordered nodes a linear velocity does exactly the work -P div v, and at
 * rest unequal pressures exchange heat, of which none is lost. */
#include "tests/unit/scenario.h"

static const char box[] =
    "dimension: {1d: 1, 2d: 2, 3d: 3}\nresolution: {1d: 40, 2d: 16, 3d: 9}\n"
    "domain: {lower: [0, 0, 0], upper: [1, 1, 1]}\nboundaries: {x: open, y: open, z: open}\n"
    "materials: {gas: {eos: ideal, gamma: 1.4}}\n"
    "regions:\n  - {material: gas, lattice: cubic, jitter: 0.2, density: 1, pressure: 1,\n"
    "     velocity: [0.3*x-0.1*y, 0.2*x+0.5*y, z]}\n"
    "until: 0.2\nmethod: {package: magma2, energy: thermal, viscosity: {name: none}}\n";

static const double divergence = NDIM == 1 ? 0.3 : NDIM == 2 ? 0.8 : 1.8;

/* du/dt = -(P / rho) div v at nodes away from the open sides. */
static void check_work(void) {
  struct scenario s = {0};
  int inside = 0;
  if (scenario_open(&s, box, "method.pressure_dissipation=0") && scenario_run(&s, 0)) {
    const struct kith_hydro *h = &s.simulation->hydro;
    for (kith_index i = 0; i < s.simulation->nodes->n_internal; ++i) {
      bool near = false;
      for (int a = 0; a < NDIM; ++a)
        near = near || fabs(s.simulation->nodes->position->f64[(size_t)i * NDIM + a] - 0.5) > 0.3;
      if (near) continue;
      const double wanted = -h->pressure->f64[i] / h->density->f64[i] * divergence;
      CHECK_CLOSE(h->energy_rate->f64[i], wanted, 1e-12 * fabs(wanted));
      ++inside;
    }
    CHECK(inside > 0);
  }
  scenario_close(&s);
}

/* Gas at rest does no work: heat flows from nodes of higher pressure to nodes of lower pressure, and its sum
 * is zero. */
static void check_pressure_exchange(void) {
  struct scenario s = {0};
  double sum = 0, size = 0, product = 0;
  if (scenario_open(&s, box, "regions.0.velocity=[0,0,0] regions.0.pressure=x<0.5?2:1") &&
      scenario_run(&s, 0)) {
    const struct kith_hydro *h = &s.simulation->hydro;
    for (kith_index i = 0; i < s.simulation->nodes->n_internal; ++i) {
      const double heat = h->mass->f64[i] * h->energy_rate->f64[i];
      sum += heat, size += fabs(heat), product += heat * (h->pressure->f64[i] - 1.5);
    }
    CHECK(size > 1e-3 && product < -0.2 * size);
    CHECK_CLOSE(sum, 0, 1e-13 * size);
  }
  scenario_close(&s);
}

int main(void) {
  check_work();
  check_pressure_exchange();
  return check_failed();
}
