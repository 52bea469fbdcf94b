/* The pass for moments and the gradient of a scalar. */
#include "physics/passes/slope.h"

#include "lib/core/lanes.h"

struct slope_pass {
  const struct kith_package *package;
  const struct kith_rows *rows;
  const struct kith_field *value;
  struct kith_field *matrix, *slope;
};

/* Lanes of scratch: x_j - x_i; the weights w; w (f_j - f_i). */
enum { SEPARATION = 0, WEIGHT = NDIM, DIFFERENCE, LANES };

/* Sums w dx dx and w dx (f_j - f_i) over the row of i. */
KITH_INLINE void sum_row(enum kith_kernel kernel, const struct slope_pass *pass, kith_index i,
                         struct kith_scratch *s, double *moment_sum, double *flux_sum) {
  const struct kith_nodes *nodes = pass->package->hydro->nodes;
  const kith_index *restrict row = pass->rows->node + pass->rows->first[i];
  const size_t n = pass->rows->first[i + 1] - pass->rows->first[i], padded = kith_lanes_padded(n);
  const double *restrict value = pass->value->f64, *restrict support = nodes->support->f64, own = support[i];
  const uint8_t *barrier = pass->package->barrier != NULL ? pass->package->barrier->u8 : NULL;
  double *restrict weight = kith_scratch_lane(s, WEIGHT);
  double *restrict difference = kith_scratch_lane(s, DIFFERENCE);
  kith_lanes moment[KITH_SYMMETRIC_SIZE] = {{0}}, flux[NDIM] = {{0}};
  kith_row_separations(nodes, pass->rows, i, kith_scratch_lane(s, SEPARATION), s->width, weight);
#pragma omp simd
  for (size_t k = 0; k < n; ++k) {
    const double other = barrier != NULL && barrier[row[k]] ? own : support[row[k]];
    weight[k] = kith_pair_weight(kernel, sqrt(weight[k]), 2 / (own + other));
    difference[k] = weight[k] * (value[row[k]] - value[i]);
  }
  for (size_t k = n; k < padded; ++k) weight[k] = difference[k] = 0;
  for (size_t k = 0; barrier != NULL && k < n; ++k)
    if (barrier[row[k]]) difference[k] = 0, weight[k] *= kith_pow_dim(support[row[k]] / own);
  for (size_t k = 0; k < padded; k += KITH_LANES) {
    const kith_lanes w = *(kith_lanes *)(weight + k), f = *(kith_lanes *)(difference + k);
    kith_lanes d[NDIM];
    for (int a = 0; a < NDIM; ++a) d[a] = *(kith_lanes *)(kith_scratch_lane(s, SEPARATION + a) + k);
    for (int a = 0, m = 0; a < NDIM; ++a) {
      flux[a] += f * d[a];
      const kith_lanes wd = w * d[a];
      for (int b = a; b < NDIM; ++b) moment[m++] += wd * d[b];
    }
  }
  for (int m = 0; m < KITH_SYMMETRIC_SIZE; ++m) moment_sum[m] = kith_lanes_total(&moment[m]);
  for (int a = 0; a < NDIM; ++a) flux_sum[a] = kith_lanes_total(&flux[a]);
}

KITH_INLINE void slope_chunk(enum kith_kernel kernel, const struct slope_pass *pass, kith_index begin,
                             kith_index end, struct kith_scratch *s) {
  const double *support = pass->package->hydro->nodes->support->f64;
  for (kith_index i = begin; i < end; ++i) {
    double moment[KITH_SYMMETRIC_SIZE], inverse[KITH_SYMMETRIC_SIZE], flux[NDIM];
    sum_row(kernel, pass, i, s, moment, flux);
    s->count[KITH_COUNT_EVALUATIONS] += pass->rows->first[i + 1] - pass->rows->first[i];
    if (!kith_invert_moments(moment, inverse)) s->count[KITH_COUNT_FALLBACKS] += 1;
    double *matrix = pass->matrix != NULL ? pass->matrix->f64 + (size_t)i * KITH_SYMMETRIC_SIZE : NULL,
           *slope = pass->slope != NULL ? pass->slope->f64 + (size_t)i * NDIM : NULL;
    const double volume = kith_ball() * kith_pow_dim(support[i]) / pass->package->neighbors;
    for (int m = 0; matrix != NULL && m < KITH_SYMMETRIC_SIZE; ++m) matrix[m] = volume * inverse[m];
    if (slope == NULL) continue;
    for (int a = 0; a < NDIM; ++a) slope[a] = 0;
    kith_symmetric_add(inverse, flux, slope);
  }
}

KITH_KERNEL_CHUNKS(slope_chunk)

kith_status kith_slope(struct kith_package *package, const struct kith_connectivity *connectivity,
                       const struct kith_field *value, struct kith_field *matrix, struct kith_field *slope) {
  struct slope_pass pass = {package, &connectivity->rows, value, matrix, slope};
  const struct kith_node_sweep sweep = {
      .stage = "slope",
      .rows = &connectivity->rows,
      .chunk = slope_chunk_of[package->kernel],
      .context = &pass,
      .lanes = LANES,
      .width = kith_rows_longest(&connectivity->rows),
      .shared = 8 * (NDIM + 2), /* x, H, f */
      .own = 8 * ((slope != NULL ? NDIM : 0) + (matrix != NULL ? KITH_SYMMETRIC_SIZE : 0))};
  return kith_package_sweep(package, &sweep, NULL);
}
