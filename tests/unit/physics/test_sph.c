/* test_sph.c - package sph: supports, densities, gradients and rates. Oracle: sums over all images of all
 * nodes (sph_world.h). Also linear velocities, whose gradient is exact, roots from any first guess, and nodes
 * that are isolated or coincident. */
#include "tests/unit/physics/sph_world.h"

/* Sums of a few hundred terms; constant, self weight and roots of the oracle are accurate to 1e-15 to
 * 1e-13. */
static const double round_off = 1e-11;

static void check_against(struct world *w, struct truth *t) {
  const int n = w->nodes->n_internal;
  const double *shear =
      w->viscosity.name == KITH_VISCOSITY_LIMITED ? kith_nodes_field_named(w->nodes, "shear")->f64 : NULL;
  double symmetric[MOST * NDIM * NDIM];
  double divergence[MOST] = {0};
  for (int i = 0; i < n; ++i) {
    CHECK_CLOSE(w->nodes->support->f64[i], t->support[i], 1e-13 * t->support[i]);
    for (int a = 0, k = 0; a < NDIM; ++a) {
      divergence[i] += t->gradient[i][a][a];
      for (int b = a; b < NDIM; ++b)
        symmetric[i * (NDIM * (NDIM + 1) / 2) + k++] = (t->gradient[i][a][b] + t->gradient[i][b][a]) / 2;
    }
  }
  CHECK_FIELD(w->hydro.density->f64, t->density, n, round_off);
  CHECK_FIELD(kith_nodes_field_named(w->nodes, "grad_h_term")->f64, t->grad_h_term, n, round_off);
  CHECK_FIELD(w->hydro.pressure->f64, t->pressure, n, round_off);
  CHECK_FIELD(w->hydro.sound_speed->f64, t->sound, n, round_off);
  CHECK_FIELD(w->package.velocity_divergence->f64, divergence, n, round_off);
  if (shear != NULL) CHECK_FIELD(shear, symmetric, n * (NDIM * (NDIM + 1) / 2), round_off);
  CHECK_FIELD(w->hydro.acceleration->f64, &t->acceleration[0][0], n * NDIM, round_off);
  CHECK_FIELD(w->hydro.energy_rate->f64, t->rate, n, round_off);
  CHECK_FIELD(kith_nodes_field_named(w->nodes, "signal")->f64, t->signal, n, round_off);
  truth_check_kick(w, t, round_off);
}

static void check_world(const struct method *m, enum side side, const int *cells, int form, uint64_t seed) {
  const bool equal_masses = (form + (int)side) % 4 == 3;
  struct world w;
  struct truth t = {0};
  world_create(&w, cells, side, 0.3, m, seed);
  if (m->balsara == KITH_BALSARA_SLOW) world_shear(&w);
  for (int i = 0; equal_masses && i < w.nodes->n_internal; ++i) w.hydro.mass->f64[i] = 3.5;
  /* In 1-D a node on a face and its image would be all the neighbors that are wanted, and close to an edge
   * all images may coincide. */
  if (side == REFLECTING && NDIM > 1 && cells[0] > 3) world_touch_face(&w);
  world_prepare(&w, &t, &seed);
  truth_all(&w, &t);
  CHECK_OK(world_evaluate(&w));
  check_against(&w, &t);
  CHECK(w.package.fallbacks == 0);
  if (side == PERIODIC) world_momentum(&w, 0, 1e-13); /* a row of 300 forces cancels to a tenth of them */
  truth_clear(&t);
  world_destroy(&w);
}

/* For v = A x + b the gradient is A at every node of an open box, also at its edge. */
static void check_linear(enum kith_kernel kernel) {
  const struct method m = {kernel, KITH_VISCOSITY_LIMITED, KITH_TRAVERSE_GATHER, false, 1,
                           2,      KITH_BALSARA_NONE};
  const double matrix[9] = {-0.7, 1.3, 0.4, -2.1, 0.9, 0.6, 1.1, -0.5, -1.6};
  struct world w;
  struct truth t = {0};
  world_create(&w, world_boxes[0], OPEN, 0.3, &m, 5);
  truth_density(&w, &t);
  world_root(&w, &t);
  for (int i = 0; i < w.nodes->n_internal; ++i)
    for (int a = 0; a < NDIM; ++a) {
      double *v = &w.hydro.velocity->f64[i * NDIM + a];
      *v = 0.5;
      for (int b = 0; b < NDIM; ++b) *v += matrix[3 * a + b] * w.nodes->position->f64[i * NDIM + b];
    }
  world_base(&w);
  CHECK_OK(world_evaluate(&w));
  const double *shear = kith_nodes_field_named(w.nodes, "shear")->f64;
  for (int i = 0; i < w.nodes->n_internal; ++i) {
    double trace = 0;
    for (int a = 0, k = i * (NDIM * (NDIM + 1) / 2); a < NDIM; ++a) {
      trace += matrix[4 * a];
      for (int b = a; b < NDIM; ++b, ++k) /* tolerance: 1e-15 |v| times a condition of 1e3, and sums */
        CHECK_CLOSE(shear[k], (matrix[3 * a + b] + matrix[3 * b + a]) / 2, 1e-10);
    }
    CHECK_CLOSE(w.package.velocity_divergence->f64[i], trace, 1e-10);
  }
  CHECK(w.package.fallbacks == 0);
  truth_clear(&t);
  world_destroy(&w);
}

/* The error of supports: the last Newton step, of at most 1e-5 in ln H, is made, and leaves its square times
 * the curvature of the sum, which is of order 10. */
static const double support_error = 1e-9;

/* Supports are found from any first guess, and densities belong to these supports. */
static void check_root(double guess, enum side side, bool equal_masses) {
  const struct method m = {KITH_KERNEL_quintic, KITH_VISCOSITY_MONAGHAN, KITH_TRAVERSE_PAIRS, true, 1, 2,
                           KITH_BALSARA_NONE};
  struct world w;
  struct truth t = {0};
  world_create(&w, world_boxes[0], side, 0.3, &m, 9);
  for (int i = 0; equal_masses && i < w.nodes->n_internal; ++i) w.hydro.mass->f64[i] = 3.5;
  truth_density(&w, &t);
  for (int i = 0; i < w.nodes->n_internal; ++i) w.nodes->support->f64[i] = guess * t.support[i];
  world_base(&w);
  if (guess < 0.9) CHECK_STATUS(KITH_OUTGROWN, world_evaluate(&w));
  if (guess < 0.9)
    CHECK(w.nodes->support->f64[3] > guess * t.support[3] && strstr(kith_failure(), "outgrew") != NULL);
  CHECK_OK(kith_integrator_rates(&w.it));
  CHECK(guess < 0.5 ? w.it.ledger.because[KITH_BECAUSE_support] > 0
                    : w.it.ledger.because[KITH_BECAUSE_support] == 0);
  for (int i = 0; i < w.nodes->n_internal; ++i) {
    const double h = w.nodes->support->f64[i];
    double slope, sum = truth_sum(&w, &t, i, h, &slope);
    CHECK_CLOSE(log(h / t.support[i]), 0, support_error);
    CHECK_CLOSE(w.package.neighbors / (oracle_ball() * w.kernel.constant * sum), 1,
                NDIM * support_error); /* d Omega ln H */
    CHECK_CLOSE(w.hydro.density->f64[i] / t.density[i], 1, 2 * NDIM * support_error);
    CHECK(h <= w.nodes->search_radius->f64[i]);
  }
  truth_clear(&t);
  world_destroy(&w);
}

/* A node far from all others has a support that reaches them. */
static void check_isolated(void) {
  const struct method m = {KITH_KERNEL_cubic, KITH_VISCOSITY_LIMITED, KITH_TRAVERSE_PAIRS, true, 1, 2,
                           KITH_BALSARA_NONE};
  struct world w;
  struct truth t = {0};
  world_create(&w, world_boxes[0], OPEN, 0.3, &m, 13);
  w.nodes->position->f64[2 * NDIM] = -50;
  truth_density(&w, &t);
  CHECK(t.support[2] > 45);
  CHECK_OK(kith_integrator_start(&w.it));
  for (int i = 0; i < w.nodes->n_internal; ++i)
    CHECK_CLOSE(log(w.nodes->support->f64[i] / t.support[i]), 0, support_error);
  for (int k = 0; k < w.nodes->n_internal * NDIM; ++k) CHECK(isfinite(w.hydro.acceleration->f64[k]));
  truth_clear(&t);
  world_destroy(&w);
  const int one[3] = {1, 1, 1};
  world_create(&w, one, PERIODIC, 0, &m, 1); /* among its own images: the cubic lattice, and no force */
  truth_density(&w, &t);
  CHECK_OK(kith_integrator_start(&w.it));
  CHECK_CLOSE(log(w.nodes->support->f64[0] / t.support[0]), 0, support_error);
  truth_clear(&t);
  world_destroy(&w);
}

/* In 1-D two nodes at one place are more than all the neighbors that are wanted: there is no support, and the
 * run stops. */
static void check_coincident(void) {
  for (int k = 0; k < KITH_N_KERNELS; ++k) {
    const struct method m = {(enum kith_kernel)k, KITH_VISCOSITY_LIMITED, KITH_TRAVERSE_PAIRS, true, 1, 2,
                             KITH_BALSARA_NONE};
    struct world w;
    world_create(&w, world_boxes[0], REFLECTING, 0.3, &m, 13);
    world_touch_face(&w);
    CHECK_STATUS(NDIM == 1 ? KITH_DIVERGED : KITH_OK, kith_integrator_start(&w.it));
    if (NDIM == 1)
      CHECK(strstr(kith_failure(), "node 100 ") != NULL &&
            strstr(kith_failure(), "does not converge") != NULL);
    world_destroy(&w);
  }
}

/* So few neighbors that the node itself suffices are refused. */
static void check_few(void) {
  const struct method m = {KITH_KERNEL_cubic, KITH_VISCOSITY_LIMITED, KITH_TRAVERSE_PAIRS, true, 1, 2,
                           KITH_BALSARA_NONE};
  const int one[3] = {1, 1, 1};
  struct world w;
  world_create(&w, one, OPEN, 0, &m, 1);
  struct kith_package few = {.ops = w.package.ops, .hydro = &w.hydro, .kernel = m.kernel};
  few.neighbors = 1.19 * oracle_ball() * w.kernel.constant * oracle_w(&w.kernel, 0);
  CHECK_STATUS(KITH_BAD_INPUT, kith_package_init(&few));
  few.neighbors = NAN;
  CHECK_STATUS(KITH_BAD_INPUT, kith_package_init(&few));
  kith_package_clear(&few);
  world_destroy(&w);
}

int main(void) {
  worlds(check_world);
  for (int k = 0; k < KITH_N_KERNELS; ++k) check_linear((enum kith_kernel)k);
  const double guesses[] = {0.3, 0.8, 1.0, 1.5, 4.0};
  for (int g = 0; g < 5; ++g)
    for (int side = OPEN; side <= REFLECTING; ++side)
      check_root(guesses[g], (enum side)side, (g + side) % 2 == 0);
  check_isolated();
  check_coincident();
  check_few();
  return check_failed();
}
