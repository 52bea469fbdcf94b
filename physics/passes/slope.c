/* The pass for the gradient of a scalar. */
#include "physics/passes/slope.h"

struct slope_pass {
  const struct kith_package *package;
  const struct kith_rows *rows;
  const struct kith_field *value, *matrix;
  struct kith_field *slope;
};

/* Lanes of scratch: x_j - x_i; w (f_j - f_i). */
enum { SEPARATION = 0, DIFFERENCE = NDIM, LANES };

KITH_INLINE void slope_chunk(enum kith_kernel kernel, const struct slope_pass *pass, kith_index begin,
                             kith_index end, struct kith_scratch *s) {
  const struct kith_nodes *nodes = pass->package->hydro->nodes;
  const uint8_t *barrier = pass->package->barrier != NULL ? pass->package->barrier->u8 : NULL;
  const double *restrict value = pass->value->f64;
  double *restrict difference = kith_scratch_lane(s, DIFFERENCE);
  for (kith_index i = begin; i < end; ++i) {
    const kith_index *restrict row = pass->rows->node + pass->rows->first[i];
    const size_t n = pass->rows->first[i + 1] - pass->rows->first[i], at = (size_t)i * NDIM;
    const double inverse = 1 / nodes->support->f64[i];
    double sum[NDIM] = {0}, *slope = pass->slope->f64 + at;
    kith_row_separations(nodes, pass->rows, i, kith_scratch_lane(s, SEPARATION), s->width, difference);
#pragma omp simd
    for (size_t k = 0; k < n; ++k) {
      double w, g;
      kith_kernel_value(kernel, sqrt(difference[k]) * inverse, &w, &g);
      difference[k] = -g * (value[row[k]] - value[i]);
    }
    for (size_t k = 0; barrier != NULL && k < n; ++k)
      if (barrier[row[k]]) difference[k] = 0;
    for (int a = 0; a < NDIM; ++a) {
      const double *restrict x = kith_scratch_lane(s, SEPARATION + a);
      double total = 0;
#pragma omp simd reduction(+ : total)
      for (size_t k = 0; k < n; ++k) total += difference[k] * x[k];
      sum[a] = total, slope[a] = 0;
    }
    kith_symmetric_add(pass->matrix->f64 + (size_t)i * KITH_SYMMETRIC_SIZE, sum, slope);
    s->count[KITH_COUNT_EVALUATIONS] += n;
  }
}

KITH_KERNEL_CHUNKS(slope_chunk)

kith_status kith_slope(struct kith_package *package, const struct kith_connectivity *connectivity,
                       const struct kith_field *value, const struct kith_field *matrix,
                       struct kith_field *slope) {
  struct slope_pass pass = {package, &connectivity->rows, value, matrix, slope};
  const struct kith_node_sweep sweep = {.stage = "slope",
                                        .rows = &connectivity->rows,
                                        .chunk = slope_chunk_of[package->kernel],
                                        .context = &pass,
                                        .lanes = LANES,
                                        .width = kith_rows_longest(&connectivity->rows),
                                        .shared = 8 * (NDIM + 1),
                                        .own = 8 * (1 + NDIM + KITH_SYMMETRIC_SIZE)};
  return kith_package_sweep(package, &sweep, NULL);
}
