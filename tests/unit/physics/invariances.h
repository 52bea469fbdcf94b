/* invariances.h - for conformance tests of packages: what they must conserve, and what must not change it. */
#ifndef KITH_TEST_PHYSICS_INVARIANCES_H
#define KITH_TEST_PHYSICS_INVARIANCES_H

#include <omp.h>
#include "tests/unit/physics/sph_world.h"

/* Evaluates rates, after the supports. Kicks start from the present velocity. */
static inline void evaluate(struct world *w) {
  world_base(w);
  CHECK_OK(kith_integrator_rates(&w->it));
}

/* The results of packages, by global id, since nodes may be reordered. */
struct rates {
  int n;
  uint64_t evaluations;
  double acceleration[MOST * NDIM], rate[MOST], signal[MOST], density[MOST];
};

static inline void store_rates(struct rates *r, const struct world *w) {
  memset(r, 0, sizeof *r);
  r->n = w->nodes->n_internal;
  r->evaluations = w->package.pair_evaluations;
  for (int i = 0; i < r->n; ++i) {
    const int at = (int)w->nodes->id->i64[i] - 100;
    for (int a = 0; a < NDIM; ++a) r->acceleration[at * NDIM + a] = w->hydro.acceleration->f64[i * NDIM + a];
    r->rate[at] = w->hydro.energy_rate->f64[i];
    r->signal[at] = w->package.signal->f64[i];
    r->density[at] = w->hydro.density->f64[i];
  }
}

/* sum m a = 0, if no wall takes momentum, and sum m (du/dt + v . a) = 0. */
static inline void check_rates_conserve(const struct world *w) {
  double rate = 0, size = 0;
  if (w->side != REFLECTING) world_momentum(w, 1, 1e-12);
  for (int i = 0; i < w->nodes->n_internal; ++i) {
    const double mass = w->hydro.mass->f64[i], *v = w->hydro.velocity->f64 + i * NDIM;
    rate += mass * w->hydro.energy_rate->f64[i], size += mass * fabs(w->hydro.energy_rate->f64[i]);
    for (int a = 0; a < NDIM; ++a) {
      const double power = mass * v[a] * w->hydro.acceleration->f64[i * NDIM + a];
      rate += power, size += fabs(power);
    }
  }
  CHECK_CLOSE(rate, 0, 1e-13 * size);
}

/* With compatible energies, steps of a scheme conserve energy and momentum. */
static inline void check_steps_conserve(struct world *w, const char *scheme) {
  w->it.scheme = kith_scheme_find(scheme);
  CHECK_OK(kith_integrator_start(&w->it));
  const struct kith_totals before = kith_hydro_totals(&w->hydro);
  for (int k = 0; k < (NDIM == 3 ? 3 : 8); ++k) CHECK_OK(kith_integrator_step(&w->it, 10));
  const struct kith_totals after = kith_hydro_totals(&w->hydro);
  const double energy = before.kinetic + before.internal;
  CHECK_CLOSE((after.kinetic + after.internal) / energy, 1, 1e-13);
  CHECK(fabs(after.kinetic - before.kinetic) > 1e-6 * energy); /* the nodes were accelerated */
  for (int a = 0; a < NDIM && w->side != REFLECTING; ++a)
    CHECK_CLOSE(after.momentum[a], before.momentum[a], 1e-13 * before.momentum_scale);
}

/* After whole steps of two equal worlds, nodes are bitwise identical for 1 and 2 threads. */
static inline void check_threads_agree(struct world w[2]) {
  const int threads = omp_get_max_threads();
  for (int k = 0; k < 2; ++k) {
    omp_set_num_threads(k + 1);
    CHECK_OK(kith_integrator_start(&w[k].it));
    for (int step = 0; step < 2; ++step) CHECK_OK(kith_integrator_step(&w[k].it, 10));
  }
  omp_set_num_threads(threads);
  const size_t n = (size_t)w[0].nodes->n_internal;
  CHECK(memcmp(w[0].nodes->position->f64, w[1].nodes->position->f64, n * NDIM * sizeof(double)) == 0);
  CHECK(memcmp(w[0].hydro.acceleration->f64, w[1].hydro.acceleration->f64, n * NDIM * sizeof(double)) == 0);
  CHECK(memcmp(w[0].hydro.energy->f64, w[1].hydro.energy->f64, n * sizeof(double)) == 0);
}

#endif
