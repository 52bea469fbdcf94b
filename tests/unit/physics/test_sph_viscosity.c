/* test_sph_viscosity.c - artificial viscosity of package sph: single pairs, linear flows (where the limiter
 * must find no velocity difference), and the time-step limit, against its definition. */
#include <omp.h>
#include "tests/unit/physics/sph_world.h"

static const int box[3] = {NDIM == 1 ? 14 : NDIM == 2 ? 6 : 4, NDIM == 2 ? 6 : 4, 4};

/* Heating by viscosity: the difference of rates with and without it. */
static void viscous_rates(struct world *w, double alpha, double beta, double *rate) {
  const int n = w->nodes->n_internal;
  struct kith_viscosity_settings *settings = w->settings; /* package settings begin with these */
  settings->alpha = settings->beta = 0;
  CHECK_OK(world_evaluate(w));
  for (int i = 0; i < n; ++i) rate[i] = -w->hydro.energy_rate->f64[i];
  settings->alpha = alpha, settings->beta = beta;
  CHECK_OK(world_evaluate(w));
  for (int i = 0; i < n; ++i) rate[i] += w->hydro.energy_rate->f64[i];
}

/* Only node k moves, so that each other node gains heat from one pair: it is heated if the pair approaches,
 * and unchanged if not; the limited viscosity heats no more than the other. */
static void check_pairs(const struct method *m, int k, uint64_t seed) {
  struct world w[2];
  struct truth t = {0};
  double rate[2][MOST];
  int heated = 0, untouched = 0;
  for (int limited = 0; limited < 2; ++limited) {
    struct method mine = *m;
    const uint64_t same = seed;
    uint64_t state = seed;
    mine.viscosity = limited ? KITH_VISCOSITY_LIMITED : KITH_VISCOSITY_MONAGHAN;
    world_create(&w[limited], box, OPEN, 0.3, &mine, same);
    if (limited == 0) truth_density(&w[0], &t);
    world_root(&w[limited], &t);
    for (int i = 0; i < w[0].nodes->n_internal; ++i)
      for (int a = 0; a < NDIM; ++a)
        w[limited].hydro.velocity->f64[i * NDIM + a] = i == k ? 2 * check_random(&state) - 1 : 0;
    world_base(&w[limited]);
    viscous_rates(&w[limited], m->alpha, m->beta, rate[limited]);
  }
  const double scale = largest(rate[0], w[0].nodes->n_internal),
               zero = 1e-13 * largest(w[0].hydro.energy_rate->f64, w[0].nodes->n_internal);
  for (int i = 0; i < w[0].nodes->n_internal; ++i) {
    double vx = 0, r2 = 0;
    for (int a = 0; a < NDIM; ++a) {
      const double x = w[0].nodes->position->f64[i * NDIM + a] - w[0].nodes->position->f64[k * NDIM + a];
      vx -= w[0].hydro.velocity->f64[k * NDIM + a] * x;
      r2 += x * x;
    }
    if (i == k) continue;
    const bool meets = vx < 0 && sqrt(r2) < fmax(t.support[i], t.support[k]);
    CHECK(meets ? rate[0][i] >= -zero : fabs(rate[0][i]) <= zero);
    CHECK(meets ? rate[1][i] >= -zero : fabs(rate[1][i]) <= zero);
    CHECK(rate[1][i] <= rate[0][i] + zero); /* differences of rates: their rounding is left */
    heated += rate[0][i] > 1e-3 * scale, untouched += !meets;
  }
  CHECK(heated > 0 && untouched > 0);
  truth_clear(&t);
  for (int limited = 0; limited < 2; ++limited) world_destroy(&w[limited]);
}

/* Of an approach with velocity 1 along a slope of 0.4 the limiter leaves 0.6, also in gas without a sound
 * speed, and in any units. */
static void check_limiter(void) {
  static double j[KITH_PACKED_VISCOUS * KITH_STRIDE];
  const struct kith_viscosity_constants c = {.alpha = 1, .beta = 2, .spacings = 4, .limited = 1};
  for (double unit = 0x1p80; unit > 0x1p-81; unit *= 0x1p-80)
    for (int cold = 0; cold < 2; ++cold) {
      double i[KITH_PACKED_VISCOUS] = {0};
      i[KITH_PACKED_V] = unit;
      J(KITH_PACKED_X) = 1;
      i[KITH_PACKED_INVERSE] = J(KITH_PACKED_INVERSE) = 0.5;
      i[KITH_PACKED_DENSITY] = J(KITH_PACKED_DENSITY) = 1;
      i[KITH_PACKED_SOUND] = J(KITH_PACKED_SOUND) = cold ? 0 : unit;
      i[KITH_PACKED_SHEAR] = J(KITH_PACKED_SHEAR) = -0.4 * unit;
      CHECK_CLOSE(kith_viscous_pair(&c, i, j).mu / unit, -0.6, 1e-15);
    }
}

/* Viscosity cools no node, whatever the velocities. */
static void check_heats(const struct method *m, enum side side) {
  struct world w;
  double rate[MOST];
  world_create(&w, box, side, 0.3, m, 31);
  world_base(&w);
  CHECK_OK(kith_integrator_rates(&w.it)); /* computes supports */
  viscous_rates(&w, m->alpha, m->beta, rate);
  const double zero = 1e-13 * largest(w.hydro.energy_rate->f64, w.nodes->n_internal);
  double sum = 0;
  for (int i = 0; i < w.nodes->n_internal; ++i) {
    CHECK(rate[i] >= -zero);
    sum += rate[i];
  }
  CHECK(sum > 0);
  world_destroy(&w);
}

/* Uses every other cell of 7 x 6 x 6: a face-centered lattice, whose neighbors are farther away than the mean
 * spacing. */
static void spread_out(struct world *w) {
  for (int i = 0, cell = 0; i < w->nodes->n_internal; ++cell) {
    const int place[3] = {cell % 7, cell / 7 % 6, cell / 42};
    if ((place[0] + place[1] + place[2]) % 2 != 0) continue;
    for (int a = 0; a < NDIM; ++a) w->nodes->position->f64[i * NDIM + a] = place[a] + 0.05 * sin(i + 9 * a);
    ++i;
  }
}

/* A lattice of equal masses and energies is compressed linearly: for nodes all of whose pairs are at the mean
 * spacing (that of the denser end) or beyond, the limiter leaves no velocity difference but the part by which
 * densities differ. */
static void check_linear(enum kith_traversal traversal) {
  const struct method m = {KITH_KERNEL_wendland_c2, KITH_VISCOSITY_LIMITED, traversal, false, 1, 2,
                           KITH_BALSARA_NONE};
  const double spacings = pow(kith_kernel_neighbors(m.kernel, 0) / oracle_ball(), 1.0 / NDIM);
  const double matrix[9] = {-0.7, 0.3, 0.2, -0.1, -0.9, 0.1, 0.1, -0.2, -0.6};
  struct world w;
  struct truth t = {0};
  double rate[MOST], whole[MOST];
  int away = 0, close = 0;
  world_create(&w, NDIM == 3 ? (const int[3]){7, 6, 3} : box, OPEN, 0.2, &m, 4);
  if (NDIM == 3) spread_out(&w);
  for (int k = 1; k < 3; ++k) w.hydro.material[k] = w.hydro.material[0];
  for (int i = 0; i < w.nodes->n_internal; ++i) w.hydro.energy->f64[i] = w.hydro.mass->f64[i] = 1;
  for (int i = 0; i < w.nodes->n_internal; ++i)
    for (int a = 0; a < NDIM; ++a) {
      w.hydro.velocity->f64[i * NDIM + a] = 3;
      for (int b = 0; b < NDIM; ++b)
        w.hydro.velocity->f64[i * NDIM + a] += matrix[3 * a + b] * w.nodes->position->f64[i * NDIM + b];
    }
  truth_density(&w, &t);
  world_root(&w, &t);
  world_base(&w);
  viscous_rates(&w, 1, 2, rate);
  ((struct kith_viscosity_settings *)w.settings)->name = KITH_VISCOSITY_MONAGHAN;
  viscous_rates(&w, 1, 2, whole);
  const double scale = largest(rate, w.nodes->n_internal);
  for (int i = 0; i < w.nodes->n_internal; ++i) {
    bool all = true;
    double jump = 0;
    for (size_t k = t.partners.first[i]; k < t.partners.first[i + 1]; ++k) {
      const struct partner *p = &t.partners.partner[k];
      if (p->r * spacings < fmin(t.support[i], t.support[p->node]) * (1 - 1e-9)) all = false;
      const double one = t.density[i], other = t.density[p->node];
      jump = fmax(jump, fabs(one - other) / (one + other));
    }
    if (all) /* G is exact to 1e-13, and rates are differences */
      CHECK_CLOSE(rate[i], 0, 1e-12 * scale + 4 * pow(jump, 3) * whole[i]);
    away += all, close += !all;
  }
  CHECK(away > 0 && close > 0);
  truth_clear(&t);
  world_destroy(&w);
}

/* ---- time-step limits ---- */

static const double cfl = 0.37;

/* The limit from the fields, by its definition with h = 2 sigma; names its reason and its node. */
static void expect_limit(const struct world *w, const char *reason, int node) {
  const double *signal = kith_nodes_field_named(w->nodes, "signal")->f64;
  double best = INFINITY;
  int who = -1;
  for (int i = 0; i < w->nodes->n_internal; ++i) {
    double a2 = 0;
    for (int a = 0; a < NDIM; ++a)
      a2 += w->hydro.acceleration->f64[i * NDIM + a] * w->hydro.acceleration->f64[i * NDIM + a];
    const double h = w->nodes->support->f64[i] / w->kernel.spread, u = w->hydro.energy->f64[i];
    const double loss = -w->hydro.energy_rate->f64[i];
    double dt = fmin(cfl * h / signal[i], 0.8 * cfl * sqrt(h / sqrt(a2)));
    dt = fmin(dt, cfl / fabs(w->package.velocity_divergence->f64[i]));
    const double *v = w->hydro.velocity->f64 + i * NDIM;
    double flight[NDIM];
    for (int a = 0; a < NDIM; ++a) flight[a] = v[a] - w->hydro.rest_velocity[a];
    dt = fmin(dt, 1.5 * cfl * h / kith_norm(flight));
    if (u > 1e-15 * kith_dot(v, v) && loss > 0 && w->nodes->list->u8[i] != 1) /* 1: isothermal */
      dt = fmin(dt, cfl * u / loss);
    if (dt < best) best = dt, who = i;
  }
  const struct kith_timestep_limit timestep_limit = kith_package_timestep_limit(&w->package, cfl);
  CHECK_CLOSE(timestep_limit.dt, best, 1e-6 * best); /* 2 sigma has six digits */
  CHECK(timestep_limit.node == w->nodes->id->i64[who] &&
        strcmp(kith_limit_name(timestep_limit.reason), reason) == 0);
  CHECK(who == node || node < 0);
}

static void check_limits(bool compatible) {
  const struct method m = {
      KITH_KERNEL_quartic, KITH_VISCOSITY_MONAGHAN, KITH_TRAVERSE_PAIRS, compatible, 1, 2, KITH_BALSARA_NONE};
  struct world w;
  world_create(&w, box, PERIODIC, 0.3, &m, 6);
  CHECK(kith_integrator_start(&w.it) == KITH_OK);
  const int n = w.nodes->n_internal;
  struct kith_hydro *h = &w.hydro;
  double *signal = kith_nodes_field_named(w.nodes, "signal")->f64;
  for (int i = 0; i < n; ++i) {
    for (int a = 0; a < NDIM; ++a) h->acceleration->f64[i * NDIM + a] *= 1e-3;
    h->energy_rate->f64[i] *= 1e-3, w.package.velocity_divergence->f64[i] *= 1e-3;
  }
  expect_limit(&w, "courant", -1);
  double mass = 0, momentum[NDIM] = {0};
  for (int i = 0; i < n; ++i) {
    mass += h->mass->f64[i];
    for (int a = 0; a < NDIM; ++a) momentum[a] += h->mass->f64[i] * h->velocity->f64[i * NDIM + a];
  }
  for (int a = 0; a < NDIM; ++a) CHECK_CLOSE(h->rest_velocity[a], momentum[a] / mass, 1e-14);
  const double slow = h->velocity->f64[2 * NDIM];
  h->velocity->f64[2 * NDIM] = -1e3;
  expect_limit(&w, "displacement", 2);
  h->velocity->f64[2 * NDIM] = slow;
  h->acceleration->f64[3 * NDIM + NDIM - 1] = -1e4;
  expect_limit(&w, "acceleration", 3);
  w.package.velocity_divergence->f64[5] = -1e5; /* compression or expansion: the support must follow */
  expect_limit(&w, "compression", 5);
  w.package.velocity_divergence->f64[7] = 2e5;
  expect_limit(&w, "compression", 7);
  h->energy_rate->f64[4] = 1e9; /* heating does not limit */
  expect_limit(&w, "compression", 7);
  for (int i = 0; i < n; ++i) /* the pressure of an isothermal gas does not follow its energy */
    if (w.nodes->list->u8[i] == 1) h->energy_rate->f64[i] = -1e9;
  expect_limit(&w, "compression", 7);
  int cold = 6;
  while (w.nodes->list->u8[cold] == 1) ++cold;
  h->energy_rate->f64[cold] = -1e8;
  expect_limit(&w, "cooling", cold);
  h->energy->f64[cold] = 0; /* no energy to lose */
  expect_limit(&w, "compression", 7);
  h->energy->f64[cold] = 1e-16 * kith_dot(h->velocity->f64 + cold * NDIM, h->velocity->f64 + cold * NDIM);
  CHECK(h->energy->f64[cold] > 0);
  expect_limit(&w, "compression", 7); /* nor beyond round-off */
  for (int i = 0; i < n; ++i) {       /* a tie: the smallest id wins, not the first index */
    signal[i] = 1e12, w.nodes->support->f64[i] = 1, w.nodes->id->i64[i] = 1000 - i;
    for (int a = 0; a < NDIM; ++a) h->acceleration->f64[i * NDIM + a] = 0;
    w.package.velocity_divergence->f64[i] = 0;
    h->energy_rate->f64[i] = 0;
  }
  for (int k = 1; k <= 3; ++k) {
    omp_set_num_threads(k);
    CHECK(kith_package_timestep_limit(&w.package, cfl).node == 1000 - (n - 1));
  }
  omp_set_num_threads(2);
  world_destroy(&w);
}

int main(void) {
  check_limiter();
  for (int k = 0; k < KITH_N_KERNELS; k += NDIM) {
    const struct method m = {(enum kith_kernel)k,
                             KITH_VISCOSITY_MONAGHAN,
                             k % 2 ? KITH_TRAVERSE_GATHER : KITH_TRAVERSE_PAIRS,
                             k % 2 == 0,
                             1.2,
                             2,
                             KITH_BALSARA_NONE};
    const struct method limited = {
        (enum kith_kernel)k, KITH_VISCOSITY_LIMITED, KITH_TRAVERSE_GATHER, false, 0.8, 1.5,
        KITH_BALSARA_NONE};
    for (int node = 0; node < 5; ++node) check_pairs(&m, 2 * node + 1, 60 + (uint64_t)node);
    for (int side = OPEN; side <= REFLECTING; ++side)
      check_heats(&m, (enum side)side), check_heats(&limited, (enum side)side);
  }
  check_linear(KITH_TRAVERSE_PAIRS);
  check_linear(KITH_TRAVERSE_GATHER);
  check_limits(true);
  check_limits(false);
  return check_failed();
}
