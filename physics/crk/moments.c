/* Moments of the neighbors, and the coefficients of corrected kernels that follow from them. */
#include "physics/crk/moments.h"

#include "lib/core/lanes.h"

/* Lanes of scratch: x_j - x_i; V W; V g C / H^(d + 2), the factor of x_i - x_j in V grad W;
 * g(r / H_i) (H_i - H_j) / (H_i + H_j), and after the sums the factor of V grad W times f_i - f_j. */
enum { SEPARATION = 0, WEIGHT = NDIM, SLOPE, GROWTH, LANES };

/* Sums over a row, of V W: m0, m1, m2; of V grad W x..x: the first and second, and the third, symmetric,
 * moment; of g x (H_i - H_j) / (H_i + H_j), g of H_i. */
enum {
  SYMMETRIC = KITH_SYMMETRIC_SIZE,
  CUBIC = NDIM * (NDIM + 1) * (NDIM + 2) / 6,
  M0 = 0,
  M1,
  M2 = M1 + NDIM,
  G1 = M2 + SYMMETRIC,
  G2 = G1 + NDIM,
  G3 = G2 + SYMMETRIC,
  H1 = G3 + CUBIC,
  SUMS = H1 + NDIM
};

/* Weight of a node in its own moments, times the self weight of the kernel: (2) and (3) are exact with any.
 * With 1, that of the paper, a line of nodes is unstable: a uniform pressure amplifies alternating
 * displacements. More damps them, and smears: L1 of the density with 1, 1.5, 2 in 1-D
 *     Sod, 800 of equal spacing   .0506 .0017 .0018     two blasts, 400   .137 .0216 .0267
 *     Toro 3, 200                 .113 .0218 .0314      Sod, 200 of equal masses   .0384 .0087 .0098
 * and 2-D and 3-D hardly depend on it: Sedov 60^2 .128 .127 .127, Noh 50^2 .709 .699 .682, Sedov 26^3 .237
 * .234 .233. There a cubic spline with its default neighbors takes 1.8 to damp them. */
static const double moment_weight = NDIM < 3 ? 1.5 : 2;

struct moments_pass {
  const struct kith_package *package;
  const struct crk_moments *moments;
  const struct kith_rows *rows;
  double constant; /* of the kernel */
};

/* A barrier has the support of i, as in forces, where kernels have the coefficients of i on both ends. */
KITH_INLINE size_t load_kernels(enum kith_kernel kernel, const struct moments_pass *pass, kith_index i,
                                struct kith_scratch *s) {
  const struct kith_nodes *nodes = pass->package->hydro->nodes;
  const kith_index *restrict row = pass->rows->node + pass->rows->first[i];
  const size_t n = pass->rows->first[i + 1] - pass->rows->first[i], padded = kith_lanes_padded(n);
  const double *restrict support = nodes->support->f64, *restrict mass = pass->package->hydro->mass->f64,
                         *restrict density = pass->package->hydro->density->f64, half = 0.5 * pass->constant;
  double *restrict weight = kith_scratch_lane(s, WEIGHT), *restrict slope = kith_scratch_lane(s, SLOPE),
                   *restrict growth = kith_scratch_lane(s, GROWTH);
  const uint8_t *barrier = pass->package->barrier != NULL ? pass->package->barrier->u8 : NULL;
  kith_row_separations(nodes, pass->rows, i, kith_scratch_lane(s, SEPARATION), s->width, weight);
  for (size_t k = 0; k < n; ++k)
    growth[k] = barrier != NULL && barrier[row[k]] ? support[i] : support[row[k]];
  const double own = 1 / support[i];
#pragma omp simd
  for (size_t k = 0; k < n; ++k) {
    double wi, gi, wj, gj;
    const double other = growth[k], inverse = 1 / other, r = sqrt(weight[k]),
                 ratio = kith_pow_dim(own * other),
                 volume = half * mass[row[k]] / density[row[k]] * kith_pow_dim(inverse);
    kith_kernel_value(kernel, r * own, &wi, &gi);
    kith_kernel_value(kernel, r * inverse, &wj, &gj);
    weight[k] = volume * (wj + ratio * wi);
    slope[k] = volume * (gj * inverse * inverse + ratio * gi * own * own);
    growth[k] = gi * (support[i] - other) / (support[i] + other);
  }
  for (size_t k = n; k < padded; ++k) weight[k] = slope[k] = growth[k] = 0;
  return padded;
}

KITH_INLINE void sum_row(size_t padded, const struct kith_scratch *s, double *sum) {
  kith_lanes total[SUMS] = {{0}};
  for (size_t k = 0; k < padded; k += KITH_LANES) {
    const kith_lanes w = *(const kith_lanes *)(kith_scratch_lane(s, WEIGHT) + k),
                     g = *(const kith_lanes *)(kith_scratch_lane(s, SLOPE) + k),
                     h = *(const kith_lanes *)(kith_scratch_lane(s, GROWTH) + k);
    kith_lanes x[NDIM];
    for (int a = 0; a < NDIM; ++a) x[a] = -*(const kith_lanes *)(kith_scratch_lane(s, SEPARATION + a) + k);
    total[M0] += w;
    for (int a = 0, m2 = 0, m3 = 0; a < NDIM; ++a) {
      const kith_lanes wx = w * x[a], gx = g * x[a];
      total[M1 + a] += wx;
      total[G1 + a] += gx;
      total[H1 + a] += h * x[a];
      for (int b = a; b < NDIM; ++b, ++m2) {
        const kith_lanes gxx = gx * x[b];
        total[M2 + m2] += wx * x[b];
        total[G2 + m2] += gxx;
        for (int c = b; c < NDIM; ++c) total[G3 + m3++] += gxx * x[c];
      }
    }
  }
  for (int k = 0; k < SUMS; ++k) sum[k] = kith_lanes_total(&total[k]);
}

/* Returns where (a, b, c), in any order, stands in the third moment. */
KITH_INLINE int triple_of(int a, int b, int c) {
  const int low = KITH_MIN(KITH_MIN(a, b), c), high = KITH_MAX(KITH_MAX(a, b), c),
            middle = a + b + c - low - high;
  const int before = low == 0   ? 0
                     : low == 1 ? NDIM * (NDIM + 1) / 2
                                : CUBIC - 1; /* triples with a lower first index */
  const int rest = NDIM - low, m = middle - low;
  return before + m * rest - m * (m - 1) / 2 + high - middle;
}

/* Computes the coefficients by (2), (3) from the sums; false if there are no neighbors. */
static bool correct(const double *s, double *A, double *C, double *dA, double *dC) {
  double inverse[SYMMETRIC], B[NDIM], dB[NDIM][NDIM];
  const bool regular = kith_invert_moments(s + M2, inverse);
  double denominator = s[M0];
  for (int a = 0; a < NDIM; ++a) {
    B[a] = 0;
    for (int b = 0; b < NDIM; ++b) B[a] -= inverse[kith_symmetric_at(a, b)] * s[M1 + b];
    denominator += B[a] * s[M1 + a];
  }
  *A = 1 / denominator;
  for (int c = 0; c < NDIM; ++c) {
    double change = s[G1 + c], flux[NDIM]; /* derivative of the denominator; dm1 + dm2 B */
    for (int a = 0; a < NDIM; ++a) {
      const double dm1 = (a == c ? s[M0] : 0) + s[G2 + kith_symmetric_at(a, c)];
      flux[a] = dm1;
      for (int b = 0; b < NDIM; ++b)
        flux[a] += B[b] * ((a == c ? s[M1 + b] : 0) + (b == c ? s[M1 + a] : 0) + s[G3 + triple_of(a, b, c)]);
      change += B[a] * (dm1 + flux[a]);
    }
    dA[c] = -*A * *A * change;
    for (int b = 0; b < NDIM; ++b) {
      dB[b][c] = 0;
      for (int a = 0; a < NDIM; ++a) dB[b][c] -= inverse[kith_symmetric_at(a, b)] * flux[a];
      dC[b * NDIM + c] = dA[c] * B[b] + *A * dB[b][c];
    }
  }
  for (int c = 0; c < NDIM; ++c) {
    C[c] = *A * B[c];
    dA[c] += C[c];
  }
  return regular;
}

/* Computes the gradient of `value` at node i; second: sum of V g x x. */
KITH_HOT static void set_slope(const struct moments_pass *pass, kith_index i, const double *second,
                               const struct kith_scratch *s) {
  const kith_index *restrict row = pass->rows->node + pass->rows->first[i];
  const size_t n = pass->rows->first[i + 1] - pass->rows->first[i];
  const uint8_t *barrier = pass->package->barrier != NULL ? pass->package->barrier->u8 : NULL;
  const double *restrict value = pass->moments->value->f64, *restrict weight = kith_scratch_lane(s, SLOPE);
  double *restrict difference = kith_scratch_lane(s, GROWTH);
  double moment[SYMMETRIC], inverse[SYMMETRIC], sum[NDIM];
  kith_lanes total[NDIM] = {{0}};
#pragma omp simd
  for (size_t k = 0; k < n; ++k) difference[k] = weight[k] * (value[i] - value[row[k]]);
  for (size_t k = 0; barrier != NULL && k < n; ++k)
    if (barrier[row[k]]) difference[k] = 0;
  for (size_t k = 0; k < n; k += KITH_LANES)
    for (int a = 0; a < NDIM; ++a)
      total[a] += *(const kith_lanes *)(difference + k) *
                  *(const kith_lanes *)(kith_scratch_lane(s, SEPARATION + a) + k);
  for (int k = 0; k < SYMMETRIC; ++k) moment[k] = -second[k];
  kith_invert_moments(moment, inverse);
  double *slope = pass->moments->slope->f64 + (size_t)i * NDIM;
  for (int a = 0; a < NDIM; ++a) sum[a] = kith_lanes_total(&total[a]), slope[a] = 0;
  kith_symmetric_add(inverse, sum, slope);
}

/* Returns the change of the spacing from node to node, from sum g x (H_i - H_j) / (H_i + H_j) = - (1 / 2)
 * grad ln H sum g r^2 / d of even neighbors, where Omega is C V / H^d sum g r^2. */
static double change_of_spacing(const struct moments_pass *pass, kith_index i, const double *sum) {
  const double even = kith_ball() / pass->package->neighbors, spacings = kith_root_dim(1 / even);
  double sum2 = 0;
  for (int a = 0; a < NDIM; ++a) sum2 += sum[a] * sum[a];
  return 2 * pass->constant * even * sqrt(sum2) /
         (pass->moments->omega->f64[i] * pass->package->hydro->nodes->support->f64[i] * spacings);
}

KITH_INLINE void moments_chunk(enum kith_kernel kernel, const struct moments_pass *pass, kith_index begin,
                               kith_index end, struct kith_scratch *s) {
  const struct crk_moments *m = pass->moments;
  const struct kith_hydro *hydro = pass->package->hydro;
  double w0, g0, sum[SUMS];
  kith_kernel_value(kernel, 0, &w0, &g0);
  for (kith_index i = begin; i < end; ++i) {
    const size_t padded = load_kernels(kernel, pass, i, s), at = (size_t)i * NDIM;
    sum_row(padded, s, sum);
    const double own = pass->package->self_weight * w0 * pass->constant * hydro->mass->f64[i] /
                       (hydro->density->f64[i] * kith_pow_dim(hydro->nodes->support->f64[i]));
    if (m->kernel_sum != NULL) m->kernel_sum->f64[i] = sum[M0] + own;
    sum[M0] += moment_weight * own;
    s->count[KITH_COUNT_EVALUATIONS] += padded;
    s->count[KITH_COUNT_FALLBACKS] +=
        !correct(sum, &m->a->f64[i], &m->c->f64[at], &m->a_gradient->f64[at], &m->c_gradient->f64[at * NDIM]);
    if (m->slope != NULL) set_slope(pass, i, sum + G2, s);
    m->change->f64[i] = change_of_spacing(pass, i, sum + H1);
  }
}

KITH_KERNEL_CHUNKS(moments_chunk)

kith_status kith_crk_moments_evaluate(struct kith_package *package, const struct crk_moments *moments,
                                      const struct kith_connectivity *connectivity) {
  struct moments_pass pass = {package, moments, &connectivity->rows, kith_kernel_constant(package->kernel)};
  const struct kith_node_sweep sweep = {
      .stage = "moments",
      .rows = &connectivity->rows,
      .chunk = moments_chunk_of[package->kernel],
      .context = &pass,
      .lanes = LANES,
      .width = kith_rows_longest(&connectivity->rows),
      .shared = 8 * (NDIM + 3 + (moments->slope != NULL)), /* x, H, m, rho */
      .own = 8 * (CRK_COEFFICIENTS + 1 + (moments->slope != NULL ? NDIM : 0))};
  return kith_package_sweep(package, &sweep, NULL);
}

kith_status kith_crk_moments_init(struct crk_moments *moments, struct kith_nodes *nodes) {
  const struct kith_field_row fields[] = {
      {true, KITH_SPEC(SCALAR, WORK, "omega", "grad-h factor Omega"), &moments->omega},
      {true, KITH_SPEC(SCALAR, WORK, "kernel_scale", "A of the corrected kernel"), &moments->a},
      {true, KITH_SPEC(VECTOR, WORK, "kernel_slope", "C"), &moments->c},
      {true, KITH_SPEC(VECTOR, WORK, "kernel_scale_gradient", "dA + C"), &moments->a_gradient},
      {true, KITH_SPEC(TENSOR, WORK, "kernel_slope_gradient", "dC_b/dx_c"), &moments->c_gradient},
      {true, KITH_SPEC(SCALAR, KEPT, "spacing_change", "of the spacing from node to node"), &moments->change},
      {0}};
  return kith_nodes_fields(nodes, fields);
}
