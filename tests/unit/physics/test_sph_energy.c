/* test_sph_energy.c - forces of package sph are the gradient of the internal energy at constant entropy, and
 * their work is the change of energies. Oracle: differences of energies and densities of the sums in
 * sph_world.h, for nodes that are displaced. */
#include "tests/unit/physics/sph_world.h"

static const int box[3] = {NDIM == 1 ? 14 : NDIM == 2 ? 6 : 4, NDIM == 2 ? 6 : 4, 3};

/* ---- the energy itself ---- */

/* u of node i at density rho on the isentrope through (t->density, energy): P = A rho^gamma - P0, or c0^2 ln
 * rho for an isothermal gas. */
static double isentropic_energy(const struct world *w, const struct truth *t, int i, double rho) {
  const struct kith_material *m = &w->hydro.material[w->nodes->list->u8[i]];
  const double c0 = material_value(m, "sound_speed");
  const double compression = rho / t->density[i], u = w->hydro.energy->f64[i];
  if (c0 > 0) return c0 * c0 * log(compression);
  const double cold = material_value(m, "stiffness") / t->density[i];
  return (u - cold) * pow(compression, material_value(m, "gamma") - 1) + cold / compression;
}

/* The internal energy of all nodes at their present positions, with new supports. Writes density[i] if not
 * NULL. */
static double total_energy(const struct world *w, const struct truth *from, double *density) {
  struct truth t = {0};
  double sum = 0;
  truth_density(w, &t);
  for (int i = 0; i < w->nodes->n_internal; ++i)
    sum += w->hydro.mass->f64[i] * isentropic_energy(w, from, i, t.density[i]);
  if (density != NULL) memcpy(density, t.density, sizeof t.density);
  truth_clear(&t);
  return sum;
}

/* Differences of fourth order: (8 (f(d) - f(-d)) - (f(2d) - f(-2d))) / (12 d). For kernels with four or more
 * continuous derivatives the error is d^4 ~ 1e-13 and cancellation, 1e-16 / 1e-3 of the energy; where the
 * third derivative jumps within the stencil (cubic, C2) it is of order d^2: 1e-6 of w'''. */
static const double step = 1e-3;
static double difference(const double f[4]) {
  return (8 * (f[1] - f[0]) - (f[3] - f[2])) / (12 * step);
}
static const double stencil[] = {-1, 1, -2, 2};

/* m dv/dt = -dU/dx, node by node, which tests the factor X, with masses 1 to 8 and three materials. */
static void check_gradient(struct world *w, const struct truth *t, double tolerance) {
  const int n = w->nodes->n_internal;
  const double scale = largest(w->hydro.acceleration->f64, n * NDIM);
  for (int i = 0; i < n; i += NDIM < 3 ? n / 4 : n / 2 + 4) {
    for (int a = 0; a < NDIM; ++a) {
      double *x = &w->nodes->position->f64[i * NDIM + a], energy[4];
      const double x0 = *x;
      for (int k = 0; k < 4; ++k) {
        *x = x0 + stencil[k] * step;
        energy[k] = total_energy(w, t, NULL);
      }
      *x = x0;
      const double force = w->hydro.mass->f64[i] * w->hydro.acceleration->f64[i * NDIM + a];
      CHECK_CLOSE(force, -difference(energy), tolerance * scale);
    }
  }
}

/* du/dt = P / rho^2 drho/dt if all nodes move with their velocities. */
static void check_work(struct world *w, const struct truth *t, double tolerance) {
  static double density[4][MOST];
  const int n = w->nodes->n_internal;
  const double scale = largest(w->hydro.energy_rate->f64, n);
  double *x = w->nodes->position->f64, before[MOST * NDIM];
  memcpy(before, x, (size_t)(n * NDIM) * sizeof *x);
  for (int k = 0; k < 4; ++k) {
    for (int c = 0; c < n * NDIM; ++c) x[c] = before[c] + stencil[k] * step * w->hydro.velocity->f64[c];
    total_energy(w, t, density[k]);
  }
  memcpy(x, before, (size_t)(n * NDIM) * sizeof *x);
  double total = 0, power = 0, size = 0;
  for (int i = 0; i < n; ++i) {
    const double f[4] = {density[0][i], density[1][i], density[2][i], density[3][i]};
    const double rate = t->pressure[i] / (t->density[i] * t->density[i]) * difference(f);
    CHECK_CLOSE(w->hydro.energy_rate->f64[i], rate, tolerance * scale);
    total += w->hydro.mass->f64[i] * w->hydro.energy_rate->f64[i];
    for (int a = 0; a < NDIM; ++a) {
      const double p = w->hydro.mass->f64[i] * w->hydro.velocity->f64[i * NDIM + a] *
                       w->hydro.acceleration->f64[i * NDIM + a];
      power += p, size += fabs(p);
    }
  }
  CHECK_CLOSE(total + power, 0, 1e-13 * size); /* the same sum in two orders */
}

static void check_variation(enum kith_kernel kernel, enum side side, bool compatible) {
  const struct method m = {
      kernel, KITH_VISCOSITY_MONAGHAN, compatible ? KITH_TRAVERSE_PAIRS : KITH_TRAVERSE_GATHER, compatible, 0,
      0,      KITH_BALSARA_NONE};
  const double tolerance = kernel == KITH_KERNEL_cubic || kernel == KITH_KERNEL_wendland_c2 ? 1e-5 : 1e-7;
  struct world w;
  struct truth t = {0};
  world_create(&w, box, side, 0.25, &m, 3 + (uint64_t)kernel);
  truth_density(&w, &t);
  truth_close(&w, &t);
  world_root(&w, &t);
  world_base(&w);
  CHECK_OK(world_evaluate(&w));
  check_gradient(&w, &t, tolerance);
  if (!compatible) check_work(&w, &t, tolerance);
  truth_clear(&t);
  world_destroy(&w);
}

int main(void) {
  for (int k = 0; k < KITH_N_KERNELS; ++k)
    for (int side = OPEN; side <= REFLECTING; ++side)
      if (NDIM < 3 || (side + k) % 3 == 0 || (k == KITH_KERNEL_wendland_c2 && side == REFLECTING))
        check_variation((enum kith_kernel)k, (enum side)side, (k + side) % 2 == 0);
  check_variation(KITH_KERNEL_quintic, PERIODIC, false);
  return check_failed();
}
