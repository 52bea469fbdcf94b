#include "physics/mfm/mfm.h"

#include <math.h>
#include "lib/core/vec.h"
#include "physics/sweep.h"

enum { COUNT_EVALUATIONS, COUNT_FALLBACKS };

struct pass {
  const struct kith_package *package;
  const struct kith_connectivity *connectivity;
};

/* sum w dx dx, sum w d(rho) dx, sum w dP dx over the row of i. A barrier answers with the state of i. */
struct sums {
  double moment[KITH_SYMMETRIC_SIZE], density[NDIM], pressure[NDIM];
};

KITH_INLINE void sum_row(enum kith_kernel kernel, const struct pass *pass, kith_index i, struct sums *sums) {
  const struct kith_hydro *hydro = pass->package->hydro;
  const struct kith_rows *rows = &pass->connectivity->rows;
  const kith_index *restrict row = rows->node + rows->first[i];
  const size_t n = rows->first[i + 1] - rows->first[i];
  const double *restrict x = hydro->nodes->position->f64, *restrict density = hydro->density->f64,
                         *restrict pressure = hydro->pressure->f64;
  const uint8_t *barrier = pass->package->barrier != NULL ? pass->package->barrier->u8 : NULL;
  const double inverse = 1 / hydro->nodes->support->f64[i], *xi = x + (size_t)i * NDIM;
  double moment[KITH_SYMMETRIC_SIZE] = {0}, of_density[NDIM] = {0}, of_pressure[NDIM] = {0};
#pragma omp simd reduction(+ : moment, of_density, of_pressure)
  for (size_t k = 0; k < n; ++k) {
    const kith_index j = row[k];
    double d[NDIM], r2 = 0, w, g;
    for (int a = 0; a < NDIM; ++a) {
      d[a] = x[j * NDIM + a] - xi[a];
      r2 += d[a] * d[a];
    }
    kith_kernel_value(kernel, sqrt(r2) * inverse, &w, &g);
    const double seen = barrier != NULL && barrier[j] ? 0 : w;
    const double drho = seen * (density[j] - density[i]), dp = seen * (pressure[j] - pressure[i]);
    for (int a = 0, m = 0; a < NDIM; ++a) {
      of_density[a] += drho * d[a];
      of_pressure[a] += dp * d[a];
      for (int b = a; b < NDIM; ++b) moment[m++] += w * d[a] * d[b];
    }
  }
  for (int m = 0; m < KITH_SYMMETRIC_SIZE; ++m) sums->moment[m] = moment[m];
  for (int a = 0; a < NDIM; ++a) sums->density[a] = of_density[a], sums->pressure[a] = of_pressure[a];
}

/* out = M v of a symmetric matrix. */
KITH_INLINE void apply(const double *matrix, const double *v, double *out) {
  for (int a = 0; a < NDIM; ++a) out[a] = 0;
  for (int a = 0, m = 0; a < NDIM; ++a)
    for (int b = a; b < NDIM; ++b, ++m) {
      out[a] += matrix[m] * v[b];
      if (b != a) out[b] += matrix[m] * v[a];
    }
}

KITH_INLINE void gradients_chunk(enum kith_kernel kernel, const struct pass *pass, kith_index begin,
                                 kith_index end, struct kith_scratch *s) {
  const struct mfm *mfm = pass->package->self;
  const double *support = pass->package->hydro->nodes->support->f64;
  for (kith_index i = begin; i < end; ++i) {
    struct sums sums;
    double inverse[KITH_SYMMETRIC_SIZE];
    sum_row(kernel, pass, i, &sums);
    s->count[COUNT_EVALUATIONS] += pass->connectivity->rows.first[i + 1] - pass->connectivity->rows.first[i];
    if (!mfm_invert(sums.moment, inverse)) s->count[COUNT_FALLBACKS] += 1;
    apply(inverse, sums.density, mfm->density_slope->f64 + (size_t)i * NDIM);
    apply(inverse, sums.pressure, mfm->pressure_slope->f64 + (size_t)i * NDIM);
    const double volume = kith_ball() * kith_pow_dim(support[i]) / pass->package->neighbors;
    for (int m = 0; mfm->faces.matrix != NULL && m < KITH_SYMMETRIC_SIZE; ++m)
      mfm->faces.matrix->f64[(size_t)i * KITH_SYMMETRIC_SIZE + m] = volume * inverse[m];
  }
}

#define X(name, ...)                                                                     \
  KITH_HOT static void gradients_##name(void *context, kith_index begin, kith_index end, \
                                        struct kith_scratch *s) {                        \
    gradients_chunk(KITH_KERNEL_##name, context, begin, end, s);                         \
  }
KITH_KERNEL_LIST(X)
#undef X

kith_status mfm_gradients(struct kith_package *package, const struct kith_connectivity *connectivity) {
  static const kith_chunk_pass chunk[] = {
#define X(name, ...) gradients_##name,
      KITH_KERNEL_LIST(X)
#undef X
  };
  struct pass pass = {package, connectivity};
  const struct kith_sweep sweep = {.stage = "gradients",
                                   .rows = &connectivity->rows,
                                   .chunk = chunk[package->kernel],
                                   .context = &pass,
                                   .lanes = 1};
  uint64_t count[4];
  KITH_TRY(kith_package_sweep(package, &sweep, count));
  package->pair_evaluations += count[COUNT_EVALUATIONS];
  package->fallbacks += count[COUNT_FALLBACKS];
  return KITH_OK;
}
