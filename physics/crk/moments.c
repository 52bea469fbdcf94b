/* The moments of the corrected kernel: (2) and (3) of moments.h. */
#include "physics/crk/moments.h"
#include "lib/core/lanes.h"
#include "lib/core/symmetric.h"
#include "physics/passes/sweep.h"

/* Lanes of scratch: x_i - x_j; V W; V g C / H^(d + 2), the factor of x in V grad W. */
enum { SEPARATION = 0, WEIGHT = NDIM, SLOPE, LANES };

/* Sums over a row, of V W: m0, m1, m2; of V grad W x..x: the first and second, and the third, symmetric,
 * moment. */
enum {
  SYMMETRIC = KITH_SYMMETRIC_SIZE,
  CUBIC = NDIM * (NDIM + 1) * (NDIM + 2) / 6,
  M0 = 0,
  M1,
  M2 = M1 + NDIM,
  G1 = M2 + SYMMETRIC,
  G2 = G1 + NDIM,
  G3 = G2 + SYMMETRIC,
  SUMS = G3 + CUBIC
};

/* Weight of a node in its own moments, times the self weight of the kernel: (2) and (3) are exact with any.
 * With 1 a line of nodes is unstable: a uniform pressure amplifies alternating displacements. With 2 it
 * damps them. */
static const double self_weight = 2;

struct moments_pass {
  struct kith_package *package;
  const struct crk_moments *moments;
  const struct kith_rows *rows;
  double volume; /* crk_volume */
};

KITH_INLINE size_t load_row(enum kith_kernel kernel, const struct moments_pass *pass, kith_index i,
                            struct kith_scratch *s) {
  const struct kith_nodes *nodes = pass->package->hydro->nodes;
  const kith_index *restrict row = pass->rows->node + pass->rows->first[i];
  const size_t n = pass->rows->first[i + 1] - pass->rows->first[i], padded = kith_lanes_padded(n);
  const double *restrict x = nodes->position->f64, *restrict support = nodes->support->f64;
  double *restrict weight = kith_scratch_lane(s, WEIGHT), *restrict slope = kith_scratch_lane(s, SLOPE);
  for (size_t k = 0; k < padded; ++k) weight[k] = 0, slope[k] = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double xi = x[(size_t)i * NDIM + a];
    double *restrict d = kith_scratch_lane(s, SEPARATION + a);
#pragma omp simd
    for (size_t k = 0; k < n; ++k) {
      d[k] = xi - x[row[k] * NDIM + a];
      weight[k] += d[k] * d[k];
    }
    for (size_t k = n; k < padded; ++k) d[k] = 0;
  }
  const double own = 1 / support[i];
#pragma omp simd
  for (size_t k = 0; k < n; ++k) {
    double wi, gi, wj, gj;
    const double inverse = 1 / support[row[k]], r = sqrt(weight[k]), ratio = kith_pow_dim(own / inverse);
    kith_kernel_value(kernel, r * own, &wi, &gi);
    kith_kernel_value(kernel, r * inverse, &wj, &gj);
    weight[k] = 0.5 * pass->volume * (wj + ratio * wi);
    slope[k] = 0.5 * pass->volume * (gj * inverse * inverse + ratio * gi * own * own);
  }
  return padded;
}

KITH_INLINE void sum_row(size_t padded, const struct kith_scratch *s, double *sum) {
  kith_lanes total[SUMS] = {{0}};
  for (size_t k = 0; k < padded; k += KITH_LANES) {
    const kith_lanes w = *(const kith_lanes *)(kith_scratch_lane(s, WEIGHT) + k),
                     g = *(const kith_lanes *)(kith_scratch_lane(s, SLOPE) + k);
    kith_lanes x[NDIM];
    for (int a = 0; a < NDIM; ++a) x[a] = *(const kith_lanes *)(kith_scratch_lane(s, SEPARATION + a) + k);
    total[M0] += w;
    for (int a = 0, m2 = 0, m3 = 0; a < NDIM; ++a) {
      const kith_lanes wx = w * x[a], gx = g * x[a];
      total[M1 + a] += wx;
      total[G1 + a] += gx;
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

/* Positions of (a, b) and (a, b, c), in any order, in the sums. */
KITH_INLINE int pair_of(int a, int b) {
  const int low = KITH_MIN(a, b), high = KITH_MAX(a, b);
  return low * NDIM - low * (low - 1) / 2 + high - low;
}
KITH_INLINE int triple_of(int a, int b, int c) {
  const int low = KITH_MIN(KITH_MIN(a, b), c), high = KITH_MAX(KITH_MAX(a, b), c),
            middle = a + b + c - low - high;
  const int before = low == 0 ? 0 : low == 1 ? NDIM * (NDIM + 1) / 2 : CUBIC - 1; /* those that start lower */
  const int rest = NDIM - low, m = middle - low;
  return before + m * rest - m * (m - 1) / 2 + high - middle;
}

/* (2), (3) from the sums. */
static bool correct(const double *s, double *A, double *C, double *dA, double *dC) {
  double inverse[SYMMETRIC], B[NDIM], dB[NDIM][NDIM];
  const bool regular = kith_invert_symmetric(s + M2, 1e-6, inverse);
  double denominator = s[M0];
  for (int a = 0; a < NDIM; ++a) {
    B[a] = 0;
    for (int b = 0; regular && b < NDIM; ++b) B[a] -= inverse[pair_of(a, b)] * s[M1 + b];
    denominator += B[a] * s[M1 + a];
  }
  *A = 1 / denominator;
  for (int c = 0; c < NDIM; ++c) {
    double change = s[G1 + c], flux[NDIM]; /* of the denominator; dm1 + dm2 B */
    for (int a = 0; a < NDIM; ++a) {
      const double dm1 = (a == c ? s[M0] : 0) + s[G2 + pair_of(a, c)];
      flux[a] = dm1;
      for (int b = 0; b < NDIM; ++b)
        flux[a] += B[b] * ((a == c ? s[M1 + b] : 0) + (b == c ? s[M1 + a] : 0) + s[G3 + triple_of(a, b, c)]);
      change += B[a] * (dm1 + flux[a]);
    }
    dA[c] = -*A * *A * change;
    for (int b = 0; b < NDIM; ++b) {
      dB[b][c] = 0;
      for (int a = 0; regular && a < NDIM; ++a) dB[b][c] -= inverse[pair_of(a, b)] * flux[a];
      dC[b * NDIM + c] = dA[c] * B[b] + *A * dB[b][c];
    }
  }
  for (int c = 0; c < NDIM; ++c) {
    C[c] = *A * B[c];
    dA[c] += C[c];
  }
  return regular;
}

KITH_INLINE void moments_chunk(enum kith_kernel kernel, const struct moments_pass *pass, kith_index begin,
                               kith_index end, struct kith_scratch *s) {
  const struct crk_moments *moments = pass->moments;
  double w0, g0, sum[SUMS];
  kith_kernel_value(kernel, 0, &w0, &g0);
  for (kith_index i = begin; i < end; ++i) {
    const size_t padded = load_row(kernel, pass, i, s), at = (size_t)i * NDIM;
    sum_row(padded, s, sum);
    sum[M0] += pass->volume * self_weight * pass->package->self_weight * w0;
    s->count[KITH_COUNT_EVALUATIONS] += padded;
    s->count[KITH_COUNT_FALLBACKS] +=
        !correct(sum, &moments->a->f64[i], &moments->c->f64[at], &moments->a_gradient->f64[at],
                 &moments->c_gradient->f64[at * NDIM]);
  }
}

KITH_KERNEL_CHUNKS(moments_chunk)

kith_status crk_moments(struct kith_package *package, const struct kith_connectivity *connectivity,
                        const struct crk_moments *moments) {
  struct moments_pass pass = {
      .package = package, .moments = moments, .rows = &connectivity->rows, .volume = crk_volume(package)};
  const struct kith_node_sweep sweep = {.stage = "moments",
                                        .rows = &connectivity->rows,
                                        .chunk = moments_chunk_of[package->kernel],
                                        .context = &pass,
                                        .lanes = LANES,
                                        .width = kith_rows_longest(&connectivity->rows)};
  return kith_package_sweep(package, &sweep, NULL);
}
