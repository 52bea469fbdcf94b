#include "app/bench_reference.h"

#include <math.h>

kith_status kith_reference_triad(double *bytes_per_second) {
  enum { N = 1 << 24 };
  double *a = NULL, *b = NULL, *c = NULL, best = INFINITY;
  kith_status status = kith_resize(&a, 0, N, sizeof *a);
  if (status == KITH_OK) status = kith_resize(&b, 0, N, sizeof *b);
  if (status == KITH_OK) status = kith_resize(&c, 0, N, sizeof *c);
  for (int repeat = 0; status == KITH_OK && repeat < 5; ++repeat) {
    const double start = kith_seconds();
#pragma omp parallel for schedule(static)
    for (int i = 0; i < N; ++i) a[i] = b[i] + 3 * c[i];
    best = KITH_MIN(best, kith_seconds() - start);
  }
  *bytes_per_second = 24.0 * N / best;
  kith_free(&a);
  kith_free(&b);
  kith_free(&c);
  return status;
}

static double plain_density(const struct kith_model *m, kith_index i) {
  const struct kith_rows *rows = &m->connectivity->rows;
  const double *x = m->nodes->position->f64, *mass = m->hydro.mass->f64,
               inverse = 1 / m->nodes->support->f64[i];
  double sum = mass[i];
  for (size_t k = rows->first[i]; k < rows->first[i + 1]; ++k) {
    const kith_index j = rows->node[k];
    const double q = sqrt(kith_distance2(x + (size_t)i * NDIM, x + (size_t)j * NDIM)) * inverse;
    if (q < 1) sum += mass[j] * (1 - q) * (1 - q) * (1 - q) * (1 - q) * (1 + 4 * q);
  }
  return sum;
}

/* (1 - q)^3 / H^(d + 2), 0 outside */
static inline double slope(double left, double inverse) {
  return left > 0 ? left * left * left * kith_pow_dim(inverse) * inverse * inverse : 0;
}

static double plain_force(const struct kith_model *m, kith_index i) {
  const struct kith_rows *rows = &m->connectivity->rows;
  const struct kith_hydro *h = &m->hydro;
  const double *x = m->nodes->position->f64, *v = h->velocity->f64, *p = h->pressure->f64,
               *rho = h->density->f64;
  double sum[NDIM] = {0}, rate = 0;
  for (size_t k = rows->first[i]; k < rows->first[i + 1]; ++k) {
    const kith_index j = rows->node[k];
    double d[NDIM], r2 = 0, vx = 0;
    for (int a = 0; a < NDIM; ++a) {
      d[a] = x[(size_t)i * NDIM + a] - x[(size_t)j * NDIM + a];
      r2 += d[a] * d[a];
      vx += (v[(size_t)i * NDIM + a] - v[(size_t)j * NDIM + a]) * d[a];
    }
    const double r = sqrt(r2), hi = 1 / m->nodes->support->f64[i], hj = 1 / m->nodes->support->f64[j];
    const double gi = slope(1 - r * hi, hi), gj = slope(1 - r * hj, hj);
    const double mu = vx < 0 ? vx / r : 0, sound = 0.5 * (h->sound_speed->f64[i] + h->sound_speed->f64[j]);
    const double viscosity = (2 * mu * mu - sound * mu) / (rho[i] + rho[j]);
    const double f = h->mass->f64[j] *
                     (p[i] / (rho[i] * rho[i]) * gi + p[j] / (rho[j] * rho[j]) * gj + viscosity * (gi + gj));
    for (int a = 0; a < NDIM; ++a) sum[a] += f * d[a];
    rate -= f * vx;
  }
  return rate + kith_norm(sum);
}

static double time_of(const struct kith_model *m, double (*node)(const struct kith_model *, kith_index)) {
  double best = INFINITY;
  for (int repeat = 0; repeat < 3; ++repeat) {
    double sink = 0;
    const double start = kith_seconds();
#pragma omp parallel for schedule(static) reduction(+ : sink)
    for (kith_index i = 0; i < m->nodes->n_internal; ++i) sink += node(m, i);
    const double seconds = kith_seconds() - start;
    if (isfinite(sink)) best = KITH_MIN(best, seconds); /* the sum is used, so the loop stays */
  }
  return best / m->nodes->n_internal;
}

void kith_reference_loops(const struct kith_model *model, double *density, double *force) {
  *density = time_of(model, plain_density);
  *force = time_of(model, plain_force);
}
