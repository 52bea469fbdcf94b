/* test_displacement.c - regions whose lattice is displaced: positions and masses by formulas, and
 * displacements that are refused. */
#include "tests/unit/scenario.h"

static const char box[] = SCENARIO_UNIT
    "resolution: {1d: 40, 2d: 20, 3d: 10}\n"
    "boundaries: {x: reflecting, y: reflecting, z: reflecting}\n"
    "materials: {gas: {gamma: 1.4}}\n"
    "regions: [{material: gas, lattice: cubic, density: 1 + x, pressure: 1}]\n"
    "until: 1\n";

/* x -> x^2, y -> y + x (1 - y) / 2, z -> z stretches volumes by 2 x (1 - x / 2). The program uses differences
 * over 1e-3 of a spacing, which are exact for quadratic polynomials, except for rounding. */
static void stretched(void) {
  struct scenario plain = {0}, moved = {0};
  if (scenario_open(&plain, box, "connectivity.reorder=0") &&
      scenario_open(&moved, box, "connectivity.reorder=0 regions.0.displacement=[x*x-x,x*(1-y)/2,0]")) {
    const kith_index n = plain.simulation->nodes->n_internal;
    const double *x = scenario_field(&plain, "position")->f64, *y = scenario_field(&moved, "position")->f64;
    const double *m = scenario_field(&plain, "mass")->f64, *w = scenario_field(&moved, "mass")->f64;
    CHECK(n == moved.simulation->nodes->n_internal);
    for (kith_index i = 0; i < n; ++i) {
      const double *p = x + i * NDIM, *q = y + i * NDIM, across = NDIM > 1 ? p[NDIM > 1] : 0;
      CHECK_CLOSE(q[0], p[0] * p[0], 1e-15);
      if (NDIM > 1) CHECK_CLOSE(q[NDIM > 1], across + p[0] * (1 - across) / 2, 1e-15);
      const double stretch = 2 * p[0] * (NDIM > 1 ? 1 - p[0] / 2 : 1);
      CHECK_CLOSE(w[i] / m[i], stretch * (1 + q[0]) / (1 + p[0]), 1e-10);
    }
  }
  scenario_close(&moved);
  scenario_close(&plain);
}

static void refused(const char *displacement, const char *message) {
  char settings[64];
  snprintf(settings, sizeof settings, "regions.0.displacement=%s", displacement);
  scenario_refused(box, settings, message);
  CHECK(check_says("scenario.yaml:7: "));
}

int main(void) {
  stretched();
  refused("[-2*x,0,0]", "displacement folds the lattice");
  refused("[0.5,0,0]", "displacement leaves the domain");
  refused("[1/(x-x),0,0]", "displacement");
  return check_failed();
}
