/* test_measure.c - measures of flows whose values are known: modes of given amplitude, lattices, shells. */
#include <string.h>
#include "tests/check.h"
#include "validation/measure.h"

enum { SIDE = NDIM == 3 ? 16 : 40, MOST = 4096 };

struct cloud {
  double position[MOST * NDIM], velocity[MOST * NDIM], mass[MOST], density[MOST], other[MOST];
  struct kith_profile_view view;
  struct kith_measured m;
};

/* A cubic lattice in a unit box, away from the origin; masses differ, volumes do not. */
static void lattice(struct cloud *c) {
  memset(c, 0, sizeof *c);
  const int n = NDIM == 1 ? SIDE : NDIM == 2 ? SIDE * SIDE : SIDE * SIDE * SIDE;
  c->view = (struct kith_profile_view){n,        c->position, c->velocity, c->mass, c->density,
                                       c->other, c->other,    NULL,        NULL};
  c->m = (struct kith_measured){.nodes = &c->view, .time = 2};
  for (int a = 0; a < NDIM; ++a) c->m.domain.lower[a] = 3 + a, c->m.domain.upper[a] = 4 + a;
  for (int i = 0; i < n; ++i) {
    for (int a = 0, k = i; a < NDIM; ++a, k /= SIDE)
      c->position[i * NDIM + a] = 3 + a + (k % SIDE + 0.5) / SIDE;
    c->density[i] = 1 + 0.3 * (i % 3);
    c->mass[i] = c->density[i] / n;
  }
}

static double measure(const struct cloud *c, enum kith_measure which) {
  double value = -7;
  value = kith_measure_take(which, &c->m);
  return value;
}

/* Sets velocities to a mode of amplitude a and any phase, beside motion that belongs to no mode. */
static void set_mode(struct cloud *c, bool vortex, double wave, double a) {
  for (kith_index i = 0; i < c->view.n; ++i) {
    const double x = wave * 2 * M_PI * c->position[i * NDIM] + 0.3,
                 y = wave * 2 * M_PI * c->position[i * NDIM + (NDIM > 1)] + 0.8;
    double *v = &c->velocity[i * NDIM];
    v[0] = vortex ? a * sin(x) * cos(y) - 0.2 : 0.5;
    v[NDIM > 1] = vortex ? -a * cos(x) * sin(y) : a * sin(x) + 0.1;
  }
}

/* Modes that have decayed with nu = 0.01; waves that are half as long as the domain are none. */
static void viscosities(struct cloud *c) {
  const double k = 2 * M_PI, nu = 0.01, time = 2;
  double start[KITH_N_MEASURES] = {0};
  for (int vortex = 0; vortex < 2; ++vortex) {
    const enum kith_measure which = vortex ? KITH_MEASURE_vortex_viscosity : KITH_MEASURE_shear_viscosity;
    lattice(c);
    set_mode(c, vortex, 1, 1);
    start[which] = measure(c, which);
    set_mode(c, vortex, 1, exp(-nu * (vortex ? 2 : 1) * k * k * time));
    c->m.start = start;
    if (NDIM == 1) {
      CHECK(isnan(measure(c, which)));
    } else {
      CHECK_CLOSE(start[which], 1, 1e-14);
      CHECK_CLOSE(measure(c, which), nu, 1e-14);
    }
    set_mode(c, vortex, 2, 1);
    CHECK(isnan(measure(c, which)));
  }
}

/* v_y = A sin(4 pi x + phase) everywhere has amplitude A, whatever the weights. */
static void mcnally(struct cloud *c) {
  lattice(c);
  for (kith_index i = 0; i < c->view.n; ++i)
    c->velocity[i * NDIM + (NDIM > 1)] = 0.17 * sin(4 * M_PI * c->position[i * NDIM] + 0.4);
  if (NDIM == 1) CHECK(isnan(measure(c, KITH_MEASURE_mcnally)));
  if (NDIM == 1) return;
  CHECK_CLOSE(measure(c, KITH_MEASURE_mcnally), 0.17, 1e-13);
  /* Without motion between the layers, what is left is weighted by the integral of the weight. */
  for (kith_index i = 0; i < c->view.n; ++i)
    if (fabs(fabs(c->position[i * NDIM + 1] - 4.5) - 0.25) > 0.125) c->velocity[i * NDIM + 1] = 0;
  /* sums over rows of nodes, whose terms are a geometric series, have the ratio of the integrals */
  const double kept = (1 - exp(-M_PI / 2)) / (1 - exp(-M_PI));
  CHECK_CLOSE(measure(c, KITH_MEASURE_mcnally), 0.17 * kept, 1e-13);
  /* The waves and the layers are those of the domain, whatever its size. */
  for (int a = 0; a < NDIM; ++a) c->m.domain.upper[a] = c->m.domain.lower[a] + 3;
  for (kith_index i = 0; i < c->view.n; ++i)
    for (int a = 0; a < NDIM; ++a)
      c->position[i * NDIM + a] = 3 * (c->position[i * NDIM + a] - 3 - a) + 3 + a, c->mass[i] *= 3;
  CHECK_CLOSE(measure(c, KITH_MEASURE_mcnally), 0.17 * kept, 1e-13);
}

/* A jump of the density at 30 degrees; none in gas whose densities differ by round-off or noise. */
static void shock_angle(struct cloud *c) {
  const double behind[] = {1.5, 1 + 1e-15, 1.01};
  for (int k = 0; k < 3; ++k) {
    lattice(c);
    for (kith_index i = 0; i < c->view.n; ++i) {
      const double *x = &c->position[i * NDIM];
      c->density[i] = NDIM > 1 && x[NDIM > 1] - 4 < tan(M_PI / 6) * (x[0] - 3) ? behind[k] : 1;
      c->mass[i] = c->density[i] / (double)c->view.n;
    }
    const double angle = measure(c, KITH_MEASURE_shock_angle);
    if (NDIM > 1 && k == 0)
      CHECK_CLOSE(angle, 30, 2);
    else
      CHECK(isnan(angle));
  }
}

static void separation(struct cloud *c) {
  lattice(c);
  CHECK_CLOSE(measure(c, KITH_MEASURE_separation), 1, 1e-12);
  c->position[5 * NDIM] = c->position[6 * NDIM] - 0.1 / SIDE; /* two close together along x */
  CHECK_CLOSE(measure(c, KITH_MEASURE_separation), 0.1, 1e-11);
  c->mass[6] *= kith_pow_dim(2); /* twice the spacing, so the mean is 1.5 */
  CHECK_CLOSE(measure(c, KITH_MEASURE_separation), 0.1 / 1.5, 1e-11);
  lattice(c);
  memcpy(&c->position[7 * NDIM], &c->position[20 * NDIM], NDIM * sizeof(double)); /* at one place */
  CHECK(measure(c, KITH_MEASURE_separation) == 0);
  c->view.n = 1;
  CHECK(isnan(measure(c, KITH_MEASURE_separation)));
  c->view.n = 0;
  CHECK(isnan(measure(c, KITH_MEASURE_separation)));
}

/* A lattice is its own mirror image in the diagonal, until one node moves. */
static void asymmetry(struct cloud *c) {
  lattice(c);
  if (NDIM == 1) CHECK(isnan(measure(c, KITH_MEASURE_asymmetry)));
  if (NDIM == 1) return;
  CHECK_CLOSE(measure(c, KITH_MEASURE_asymmetry), 0, 1e-12);
  c->position[3 * NDIM] += 0.2 / SIDE;
  CHECK_CLOSE(measure(c, KITH_MEASURE_asymmetry), 0.2, 1e-11);
  c->position[3 * SIDE * NDIM + 1] += 0.2 / SIDE; /* its image, too */
  CHECK_CLOSE(measure(c, KITH_MEASURE_asymmetry), 0, 1e-11);
}

/* A mode that has grown by cosh(sigma t), beside other motion along y. */
static void growth(struct cloud *c) {
  double start[KITH_N_MEASURES] = {0};
  lattice(c);
  for (int grown = 0; grown < 2; ++grown) {
    for (kith_index i = 0; i < c->view.n; ++i)
      c->velocity[i * NDIM + (NDIM > 1)] =
          (grown ? cosh(0.7 * 2) : 1) * 0.02 * cos(2 * M_PI * c->position[i * NDIM]) +
          0.3 * sin(4 * M_PI * c->position[i * NDIM]) + 0.1;
    if (!grown) start[KITH_MEASURE_growth] = measure(c, KITH_MEASURE_growth);
  }
  c->m.start = start;
  if (NDIM == 1) CHECK(isnan(measure(c, KITH_MEASURE_growth)));
  if (NDIM == 1) return;
  CHECK_CLOSE(start[KITH_MEASURE_growth], 0.02, 1e-14);
  CHECK_CLOSE(measure(c, KITH_MEASURE_growth), 0.7, 1e-12);
  start[KITH_MEASURE_growth] = 1e-14; /* round-off of speeds of 0.3 */
  CHECK(isnan(measure(c, KITH_MEASURE_growth)));
  start[KITH_MEASURE_growth] = 1e-9;
  CHECK(measure(c, KITH_MEASURE_growth) > 0);
  start[KITH_MEASURE_growth] = 0.02;
  for (kith_index i = 0; i < c->view.n; ++i) {
    const double *x = c->position + (size_t)i * NDIM;
    c->velocity[i * NDIM + 1] = 0.02 * sin(2 * M_PI * x[0] + 0.3) * exp(-2 * M_PI * fabs(x[1] - 4.5));
  }
  CHECK_CLOSE(measure(c, KITH_MEASURE_ripple), 0.02, 1e-14);
  start[KITH_MEASURE_growth] *= 3; /* it has shrunk */
  CHECK(isnan(measure(c, KITH_MEASURE_growth)));
}

/* Two shells of masses 1 and 3 at radii 1 and 2 have the deviation 3^(1/2) / 4; twice as far apart, twice
 * that. */
static void spread(struct cloud *c) {
  double start[KITH_N_MEASURES] = {0};
  lattice(c);
  c->view.n = 2;
  for (int far = 0; far < 2; ++far) {
    for (int a = 0; a < NDIM; ++a)
      c->m.center[a] = 5, c->position[a] = 5 + (a == 0),
      c->position[NDIM + a] = 5 - (far + 2) * (a == NDIM - 1);
    c->mass[0] = 1, c->mass[1] = 3;
    if (!far) start[KITH_MEASURE_spread] = measure(c, KITH_MEASURE_spread);
  }
  CHECK_CLOSE(start[KITH_MEASURE_spread], sqrt(3) / 4, 1e-15);
  c->m.start = start;
  CHECK_CLOSE(measure(c, KITH_MEASURE_spread), 2, 1e-15);
}

/* A layer of nodes on the middle is half beyond it, also if round-off has moved it since the start. */
static void transmitted(struct cloud *c) {
  double start[KITH_N_MEASURES] = {0};
  lattice(c);
  const double layer = 1. / SIDE;
  for (int i = 0; i < c->view.n; ++i) {
    c->position[i * NDIM] -= 0.5 * layer;
    c->mass[i] = 1. / c->view.n, c->other[i] = 1;
  }
  start[KITH_MEASURE_transmitted] = measure(c, KITH_MEASURE_transmitted);
  CHECK_CLOSE(start[KITH_MEASURE_transmitted], 0.5 - 0.5 * layer, 1e-14);
  c->m.start = start;
  for (int side = -1; side <= 1; side += 2) {
    for (int i = 0; i < c->view.n; ++i) c->position[i * NDIM] += side * 1e-14;
    CHECK_CLOSE(measure(c, KITH_MEASURE_transmitted), 0, 1e-14);
  }
  c->m.start = NULL;
}

int main(void) {
  static struct cloud c;
  viscosities(&c);
  mcnally(&c);
  shock_angle(&c);
  separation(&c);
  asymmetry(&c);
  growth(&c);
  spread(&c);
  transmitted(&c);
  return check_failed();
}
