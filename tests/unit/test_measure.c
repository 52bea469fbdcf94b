/* Measures of flows that are known. */
#include <string.h>
#include "tests/check.h"
#include "validation/measure.h"

enum { SIDE = NDIM == 3 ? 16 : 40, MOST = 4096 };

struct cloud {
  double position[MOST * NDIM], velocity[MOST * NDIM], mass[MOST], density[MOST], other[MOST];
  struct kith_profile_view view;
  struct kith_measured m;
};

/* A lattice of cubes in a unit box, away from the origin; masses differ, volumes do not. */
static void lattice(struct cloud *c) {
  memset(c, 0, sizeof *c);
  const int n = NDIM == 1 ? SIDE : NDIM == 2 ? SIDE * SIDE : SIDE * SIDE * SIDE;
  c->view = (struct kith_profile_view){n, c->position, c->velocity, c->mass, c->density, c->other, c->other};
  c->m = (struct kith_measured){.nodes = &c->view, .time = 2};
  for (int a = 0; a < NDIM; ++a) c->m.domain.lower[a] = 3 + a, c->m.domain.upper[a] = 4 + a;
  for (int i = 0; i < n; ++i) {
    for (int a = 0, k = i; a < NDIM; ++a, k /= SIDE)
      c->position[i * NDIM + a] = 3 + a + (k % SIDE + 0.5) / SIDE;
    c->density[i] = 1 + 0.3 * (i % 3);
    c->mass[i] = c->density[i] / n;
  }
}

static double taken(const struct cloud *c, enum kith_measure which) {
  double value = -7;
  CHECK_OK(kith_measure_take(which, &c->m, &value));
  return value;
}

/* Modes that have decayed with nu = 0.01, and noise along x that is in no mode. */
static void viscosities(struct cloud *c) {
  const double k = 2 * M_PI, nu = 0.01, time = 2;
  for (int vortex = 0; vortex < 2; ++vortex) {
    lattice(c);
    const double a = exp(-nu * (vortex ? 2 : 1) * k * k * time);
    double mass = 0;
    for (kith_index i = 0; i < c->view.n; ++i) {
      const double x = k * (c->position[i * NDIM] - 3), y = k * (c->position[i * NDIM + (NDIM > 1)] - 4);
      double *v = &c->velocity[i * NDIM];
      v[0] = vortex ? a * sin(x) * cos(y) : 0.5;
      v[NDIM > 1] = vortex ? -a * cos(x) * sin(y) : a * sin(x);
      mass += c->mass[i];
    }
    c->m.kinetic_start = mass / 4; /* of amplitude 1 */
    const enum kith_measure which = vortex ? KITH_MEASURE_vortex_viscosity : KITH_MEASURE_shear_viscosity;
    if (NDIM == 1)
      CHECK(isnan(taken(c, which)));
    else
      CHECK_CLOSE(taken(c, which), nu, 1e-14);
  }
}

/* v_y = A sin(4 pi x + phase) everywhere: whatever the weights are, the amplitude is A. */
static void mcnally(struct cloud *c) {
  lattice(c);
  for (kith_index i = 0; i < c->view.n; ++i)
    c->velocity[i * NDIM + (NDIM > 1)] = 0.17 * sin(4 * M_PI * c->position[i * NDIM] + 0.4);
  if (NDIM == 1) CHECK(isnan(taken(c, KITH_MEASURE_mcnally)));
  if (NDIM == 1) return;
  CHECK_CLOSE(taken(c, KITH_MEASURE_mcnally), 0.17, 1e-13);
  /* What moves between the layers weighs less: only there, it counts e^-pi / (e^-pi + ...) of all. */
  for (kith_index i = 0; i < c->view.n; ++i)
    if (fabs(fabs(c->position[i * NDIM + 1] - 4.5) - 0.25) > 0.125) c->velocity[i * NDIM + 1] = 0;
  const double kept =
      (1 - exp(-M_PI / 2)) / (1 - exp(-M_PI)); /* integrals of the weight, up to the rows of nodes */
  CHECK_CLOSE(taken(c, KITH_MEASURE_mcnally), 0.17 * kept, NDIM == 2 ? 0.001 : 0.003);
}

static void separation(struct cloud *c) {
  lattice(c);
  CHECK_CLOSE(taken(c, KITH_MEASURE_separation), 1, 1e-12);
  c->position[5 * NDIM] = c->position[6 * NDIM] - 0.1 / SIDE; /* two near each other, side by side along x */
  CHECK_CLOSE(taken(c, KITH_MEASURE_separation), 0.1, 1e-11);
  c->mass[6] *= kith_pow_dim(2); /* twice the spacing: the mean is 1.5 */
  CHECK_CLOSE(taken(c, KITH_MEASURE_separation), 0.1 / 1.5, 1e-11);
  lattice(c);
  memcpy(&c->position[7 * NDIM], &c->position[20 * NDIM], NDIM * sizeof(double)); /* at one place */
  CHECK(taken(c, KITH_MEASURE_separation) == 0);
  c->view.n = 1;
  CHECK(isnan(taken(c, KITH_MEASURE_separation)));
  c->view.n = 0;
  CHECK(isnan(taken(c, KITH_MEASURE_separation)));
}

int main(void) {
  static struct cloud c;
  viscosities(&c);
  mcnally(&c);
  separation(&c);
  return check_failed();
}
