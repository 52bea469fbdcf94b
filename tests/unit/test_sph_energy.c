/* Where the forces of package sph come from: they are the gradient of the internal energy at constant
 * entropy, their work is what the nodes gain, and a kick trades one for the other without loss. */
#include "sph_world.h"

static const int box[3] = {NDIM == 1 ? 14 : NDIM == 2 ? 6 : 4, NDIM == 2 ? 6 : 4, 3};

/* ---- the energy itself ---- */

/* u of node i at density rho on the isentrope through (t->density, energy): P = A rho^gamma - P0, or c0^2 ln
 * rho for an isothermal gas. */
static double isentropic_energy(const struct world *w, const struct truth *t, int i, double rho) {
  const struct kith_eos_parameters *p = &w->hydro.material[w->nodes->list->u8[i]].parameters;
  const double compression = rho / t->density[i], u = w->hydro.energy->f64[i];
  if (p->sound_speed > 0) return p->sound_speed * p->sound_speed * log(compression);
  const double cold = p->stiffness / t->density[i];
  return (u - cold) * pow(compression, p->gamma - 1) + cold / compression;
}

/* Internal energy of all nodes where they stand, from supports up. density[i], written, if not NULL. */
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

/* Differences of fourth order: (8 (f(d) - f(-d)) - (f(2d) - f(-2d))) / (12 d). Kernels with four or more
 * continuous derivatives are exact to d^4 ~ 1e-13 and to cancellation, 1e-16 / 1e-3 of the energy; where the
 * third derivative jumps (cubic, C2) within the stencil d^2 is left: 1e-6 of w'''. */
static const double step = 1e-3;
static double difference(const double f[4]) {
  return (8 * (f[1] - f[0]) - (f[3] - f[2])) / (12 * step);
}
static const double stencil[] = {-1, 1, -2, 2};

/* m dv/dt = - dU/dx, node by node: tests X, with masses 1 to 8 and three materials. */
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

/* du/dt = P / rho^2 drho/dt as all nodes move with their velocities. */
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
  CHECK_CLOSE(total + power, 0, 1e-13 * size); /* two orders of the same sum */
}

static void check_variation(enum kith_kernel kernel, enum side side, bool compatible) {
  const struct method m = {
      kernel, KITH_VISCOSITY_MONAGHAN, compatible ? KITH_TRAVERSE_PAIRS : KITH_TRAVERSE_GATHER, compatible, 0,
      0};
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

/* ---- compatible energy ---- */

static long double mechanical_energy(const struct world *w) {
  long double sum = 0;
  for (int i = 0; i < w->nodes->n_internal; ++i) {
    long double v2 = 0;
    for (int a = 0; a < NDIM; ++a)
      v2 += (long double)w->hydro.velocity->f64[i * NDIM + a] * w->hydro.velocity->f64[i * NDIM + a];
    sum += w->hydro.mass->f64[i] * (v2 / 2 + w->hydro.energy->f64[i]);
  }
  return sum;
}

/* sum (m v^2 / 2 + m u) is kept through kicks of any length, from a base that the force does not know, in one
 * kick or in several. */
static void check_kick(enum kith_viscosity viscosity, enum side side, double dt) {
  const struct method m = {KITH_KERNEL_wendland_c2, viscosity, KITH_TRAVERSE_PAIRS, true, 1, 2};
  struct world w;
  uint64_t seed = 44;
  world_create(&w, box, side, 0.3, &m, 21);
  world_base(&w);
  CHECK_OK(kith_integrator_rates(&w.it));
  const int n = w.nodes->n_internal;
  for (int k = 0; k < n * NDIM; ++k)
    w.hydro.velocity->f64[k] = w.package.velocity_base->f64[k] + 0.5 * (check_random(&seed) - 0.5);
  CHECK_OK(world_evaluate(&w)); /* forces at one velocity, work at another */
  kith_field_copy(w.nodes, w.hydro.velocity, w.package.velocity_base);
  w.package.kicked = 0;
  double rate = 0, size = 0;
  long double scale = 0;
  for (int i = 0; i < n; ++i) {
    const double mass = w.hydro.mass->f64[i];
    rate += mass * w.hydro.energy_rate->f64[i];
    for (int a = 0; a < NDIM; ++a) {
      const double acceleration = w.hydro.acceleration->f64[i * NDIM + a],
                   v = w.hydro.velocity->f64[i * NDIM + a];
      rate += mass * v * acceleration;
      size += mass * fabs(v * acceleration);
      scale += mass * ((fabs(v) + dt * fabs(acceleration)) * (fabs(v) + dt * fabs(acceleration)) +
                       w.hydro.energy->f64[i]);
    }
  }
  CHECK_CLOSE(rate, 0, 1e-13 * size);
  const long double before = mechanical_energy(&w);
  const double parts[] = {0.5, 0.2, 0.3};
  for (int k = 0; k < 3; ++k) {
    kith_kick_energy(&w.it, parts[k] * dt);
    kith_kick_velocity(&w.it, parts[k] * dt);
    /* Each node rounds v, u and two sums of a row: some 1e-15 of each, of either sign. */
    CHECK_CLOSE((double)((mechanical_energy(&w) - before) / scale), 0, 1e-14);
  }
  CHECK_CLOSE(w.package.kicked, dt, 1e-15 * dt);
  world_destroy(&w);
}

/* Whole steps of the scheme keep it too, where no force comes from outside. */
static void check_steps(const char *scheme, enum side side) {
  const struct method m = {KITH_KERNEL_wendland_c4, KITH_VISCOSITY_LIMITED, KITH_TRAVERSE_PAIRS, true, 1, 2};
  struct world w;
  world_create(&w, box, side, 0.2, &m, 8);
  w.it.scheme = kith_scheme_find(scheme);
  CHECK_OK(kith_integrator_init(&w.it));
  CHECK_OK(kith_integrator_start(&w.it));
  const long double before = mechanical_energy(&w);
  for (int k = 0; k < 10; ++k) CHECK_OK(kith_integrator_step(&w.it, 10));
  CHECK_CLOSE((double)(mechanical_energy(&w) / before), 1, 1e-13); /* 10 steps of 1e-15 to 1e-14 */
  CHECK(w.it.time > 0);
  world_destroy(&w);
}

/* ---- frozen nodes ---- */

/* A lattice in balance stays in balance, nearly, when some of its nodes are frozen: they push as the others
 * do, but for X, which is a hundredth of m. */
static void check_frozen(void) {
  const struct method m = {KITH_KERNEL_quintic, KITH_VISCOSITY_MONAGHAN, KITH_TRAVERSE_GATHER, false, 1, 2};
  struct world w;
  uint8_t frozen[MOST] = {0};
  world_create(&w, box, PERIODIC, 0, &m, 8);
  const int n = w.nodes->n_internal;
  for (int i = 0; i < n; ++i) {
    w.hydro.mass->f64[i] = 4;
    w.hydro.density->f64[i] = 4;
    w.hydro.energy->f64[i] = w.hydro.material[w.nodes->list->u8[i]].eos->energy(
        &w.hydro.material[w.nodes->list->u8[i]].parameters, 4, 4 * 1.44);
    for (int a = 0; a < NDIM; ++a) w.hydro.velocity->f64[i * NDIM + a] = 0;
    frozen[i] = w.nodes->position->f64[i * NDIM] < 2;
  }
  CHECK_OK(kith_integrator_start(&w.it)); /* supports */
  kith_hydro_close(&w.hydro);
  struct kith_boundaries with = {0}; /* frozen nodes first: the images include them */
  CHECK_OK(kith_boundaries_add(&with, &kith_boundary_constant, 0, 0, 1, false, false));
  kith_nodes_drop_ghosts(w.nodes);
  struct kith_field *excess = kith_nodes_field_named(w.nodes, "excess");
  kith_package_clear(&w.package);
  memset(excess->f64, 0, (size_t)n * sizeof(double));
  CHECK_OK(kith_package_init(&w.package)); /* as in a run: made, then some of its nodes are frozen */
  CHECK_OK(kith_constant_take(with.boundary[0], w.nodes, frozen));
  for (int a = 0; a < NDIM; ++a)
    CHECK_OK(kith_boundaries_add(&with, &kith_boundary_periodic, a, 0, w.length[a], true, true));
  kith_boundaries_clear(&w.boundaries);
  w.boundaries = with;
  world_base(&w);
  CHECK_OK(kith_integrator_rates(&w.it));
  CHECK(w.nodes->n_internal > 0 && w.nodes->n_internal < n);
  /* A one-sided push is of order P / (rho spacing) = 1.4. */
  for (int k = 0; k < w.nodes->n_internal * NDIM; ++k) CHECK_CLOSE(w.hydro.acceleration->f64[k], 0, 0.03);
  world_destroy(&w);
}

int main(void) {
  for (int k = 0; k < KITH_N_KERNELS; ++k)
    for (int side = OPEN; side <= REFLECTING; ++side)
      if (NDIM < 3 || (side + k) % 3 == 0 || (k == KITH_KERNEL_wendland_c2 && side == REFLECTING))
        check_variation((enum kith_kernel)k, (enum side)side, (k + side) % 2 == 0);
  check_variation(KITH_KERNEL_quintic, PERIODIC, false);
  for (int side = OPEN; side <= REFLECTING; ++side)
    for (int viscosity = 0; viscosity < 2; ++viscosity) {
      check_kick(viscosity ? KITH_VISCOSITY_LIMITED : KITH_VISCOSITY_MONAGHAN, (enum side)side, 1e-3);
      check_kick(viscosity ? KITH_VISCOSITY_LIMITED : KITH_VISCOSITY_MONAGHAN, (enum side)side, 0.7);
    }
  check_steps("leapfrog", PERIODIC);
  check_steps("rk2", OPEN);
  check_steps("cheap-rk2", REFLECTING);
  check_frozen();
  return check_failed();
}
