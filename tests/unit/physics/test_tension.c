/* test_tension.c - tension that fades between nodes close to each other: the factor, and shaken water in
 * tension, whose nodes stay apart with every package (oracle: all distances). */
#include "physics/passes/tension.h"
#include "tests/unit/scenario.h"

static void check_factor(void) {
  const double spacings = 2; /* H in mean spacings: s = 2 q */
  CHECK(kith_closer(spacings, 0.5) == 0 && kith_closer(spacings, 3) == 0);
  CHECK_CLOSE(kith_tension(kith_closer(spacings, 0.5 * 0.95), -2), -2 * 0.65, 1e-14);
  CHECK(kith_tension(kith_closer(spacings, 0.5 * 0.8), -2) == 0);
  CHECK(kith_tension(kith_closer(spacings, 0.5 * 0.8), 2) == 2);
  CHECK(kith_tension(0, -2) == -2);
}

/* The smallest distance of two nodes in a periodic box of side 1. */
static double smallest_distance(const struct kith_nodes *nodes) {
  double smallest = 1;
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    for (kith_index j = 0; j < i; ++j) {
      double d[NDIM];
      for (int a = 0; a < NDIM; ++a) {
        d[a] = nodes->position->f64[(size_t)i * NDIM + a] - nodes->position->f64[(size_t)j * NDIM + a];
        d[a] -= round(d[a]);
      }
      smallest = fmin(smallest, kith_norm(d));
    }
  return smallest;
}

/* Without t the smallest distance is 0.43 to 0.85 spacings. */
static void check_stays_apart(const char *package) {
  static const char box[] = SCENARIO_PERIODIC
      "resolution: {1d: 32, 2d: 16, 3d: 8}\n"
      "materials: {water: {eos: stiffened, gamma: 4.4, stiffness: 0.6}}\n"
      "regions:\n  - {material: water, lattice: cubic, jitter: 0.05, density: 1, pressure: -0.1}\n"
      "until: 3\n";
  struct scenario s = {0};
  if (scenario_open(&s, box, "method.package=%s", package) && scenario_run(&s, 2000)) {
    const double resolution = NDIM == 1 ? 32 : NDIM == 2 ? 16 : 8;
    CHECK_CLOSE(s.simulation->integrator.time, 3, 1e-9);
    CHECK(smallest_distance(s.simulation->nodes) * resolution > 0.9);
    if (check_failures > 0)
      fprintf(stderr, "%s: %g\n", package, smallest_distance(s.simulation->nodes) * resolution);
  }
  scenario_close(&s);
}

int main(void) {
  check_factor();
#define X(name) check_stays_apart(#name);
  KITH_PACKAGE_LIST(X)
#undef X
  return check_failed();
}
