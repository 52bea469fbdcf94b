/* test_mfm_images.c - integrated faces with periodic images that are shifts. Oracle: the run with images that
 * are ghosts; in a box of several supports, and in one thinner than a support, where nodes are neighbors of
 * their own images and of several images of another. Only the order of sums differs. */
#include "tests/unit/scenario.h"

static const char noisy[] = SCENARIO_UNIT
    "resolution: {1d: 24, 2d: 12, 3d: 5}\n"
    "materials: {gas: {gamma: 1.4}}\n"
    "regions:\n"
    "  - {material: gas, jitter: 0.3, lattice: cubic, density: 1, pressure: 'x * (1 - x)',\n"
    "     velocity: [0.2, 0.1, 0]}\n"
    "method: {package: mfm, faces: integrated}\n"
    "until: 1\n";

static void check(const char *settings) {
  static const char images[] = "{\"kind\":\"periodic\",\"images\":\"shifts\"}";
  static const char *const fields[] = {"position", "velocity", "energy", "density"};
  struct scenario ghosts = {0}, shifts = {0};
  if (scenario_open(&ghosts, noisy,
                    "boundaries={\"x\":\"periodic\",\"y\":\"periodic\",\"z\":\"periodic\"} %s", settings) &&
      scenario_open(&shifts, noisy, "boundaries={\"x\":%s,\"y\":%s,\"z\":%s} %s", images, images, images,
                    settings) &&
      scenario_run(&ghosts, 2) && scenario_run(&shifts, 2)) {
    CHECK(ghosts.simulation->nodes->n_ghost > 0 && shifts.simulation->nodes->n_ghost == 0);
    for (size_t f = 0; f < sizeof fields / sizeof *fields; ++f)
      CHECK(scenario_distance(&ghosts, &shifts, fields[f]) < 1e-13);
    CHECK(scenario_momentum_error(&shifts) < 1e-14);
  }
  scenario_close(&ghosts);
  scenario_close(&shifts);
}

int main(void) {
  check("reproducible=true");
  check(NDIM == 1   ? "domain.upper=[0.09]"
        : NDIM == 2 ? "domain.upper=[1,0.1667]"
                    : "domain.upper=[1,0.6,0.4]");
  return check_failed();
}
