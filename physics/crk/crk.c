/* Package `crk`: conservative reproducing kernels (Frontiere, Raskin and Owen 2017, JCoPh 332, 160).
 *
 * Volumes V_i = ball H_i^d / neighbors (density.h), density m_i / V_i: exact where masses jump on an even
 * lattice.
 * With x = x_i - x_j, V_j = ball H_j^d / neighbors and W the mean of W(|x|, H_i) and W(|x|, H_j), the
 * corrected kernel
 *     W^R_ij = (A_i + C_i . x) W                                                                      (1)
 * interpolates linear functions exactly, sum_j V_j f_j W^R_ij = f_i with i itself included, for the moments
 *     m0 = sum_j V_j W, m1 = sum_j V_j x W, m2 = sum_j V_j x x W:
 *     B = -m2^-1 m1, A = 1 / (m0 + B . m1), C = A B                                                   (2)
 * and so does its gradient, with the gradients of A and C from those of the moments:
 *     dB = -m2^-1 (dm1 + dm2 B), dA = -A^2 (dm0 + 2 dm1 . B + B . dm2 B), dC = dA B + A dB            (3)
 *     grad W^R_ij = (dA + C + dC . x) W + (A + C . x) grad W                                          (4)
 * A node whose m2 has no inverse keeps A = 1 / m0, C = 0, and is counted as a fallback.
 * Forces are those of the antisymmetric part of the gradient: they conserve momentum, but not angular
 * momentum, for they are not central.
 *     m_i dv_i/dt = - sum_j (1/2) V_i V_j (P_i + P_j + Q_ij) D,  D = grad W^R_ij - grad W^R_ji        (5)
 *     Q_ij = 2 rho_i rho_j / (rho_i + rho_j) (-s_mean alpha c_mean mu + beta mu^2),
 *     mu and Balsara's factor s as in viscosity.h                                                     (6)
 * The work f . (v_j - v_i) of a pair is shared evenly except for the pressures: where it heats the pair, the
 * node of lower pressure gets the larger part, as in the paper; where it cools the pair, the node of higher
 * pressure gives the larger part, so that a cold node does not lose energy to a hot one.
 * With t the cosine between f and v_j - v_i,
 *     e_ij = 1/2 + t (P_j - P_i) / (2 (P_i + P_j + Q_ij))                                             (7)
 * This work is not that of the volumes V. Where the spacing of the nodes changes fast, and linear functions
 * are no guide, the difference is large. So (5) counts as the part s of a force, and
 *     f_ij = - P_i V_i^2 / Omega_i grad W(H_i) - P_j V_j^2 / Omega_j grad W(H_j) - V_i V_j Q_ij grad W    (8)
 * as the rest, with the heat P_i V_i^2 / Omega_i v_ij . grad W(H_i) for i, which is that of its volume, and
 * half of the heat of Q:
 *     s = min(s_i, s_j), s_i = 1 / (1 + (change_i / 0.4)^4),
 *     change_i: of the spacing, |grad ln H|, from node to node                                        (9)
 * P / rho^gamma stays within 0.97 and 1.05 of its start in the 1-2-3 problem; with s = 1 it is 0.58 to 1.32.
 *
 * Passes: density -> equation of state -> ghosts -> moments -> ghosts -> packing -> force [pairs]. */
#include "lib/core/lanes.h"
#include "lib/core/symmetric.h"
#include "physics/passes/density.h"
#include "physics/passes/viscosity.h"

struct crk_settings {
  struct kith_viscosity_settings viscosity; /* first: tests read it */
};
static const struct kith_param viscosity_params[] = {
    KITH_VISCOSITY_PARAMS(struct crk_settings, "|none|monaghan|limited"), {0}};
static const struct kith_param params[] = {
    {"viscosity", KITH_PARAM_MAP, "", "", "artificial viscosity", KITH_BELOW(viscosity_params, MAP)}, {0}};

/* The fields of a packed particle. */
enum {
  CRK_PRESSURE = KITH_PACKED_VISCOUS,
  CRK_VOLUME,
  CRK_RATE,   /* V / Omega */
  CRK_SMOOTH, /* s */
  CRK_SWITCH, /* s of (6) */
  CRK_A,
  CRK_C,
  CRK_DA = CRK_C + NDIM,  /* dA + C */
  CRK_DC = CRK_DA + NDIM, /* dC_b / dx_c, [b][c] */
  CRK_PACKED = CRK_DC + NDIM * NDIM
};

struct crk {
  struct kith_field *a, *c, *a_gradient, *c_gradient; /* A, C, dA + C, dC_b / dx_c */
  struct kith_field *omega, *smooth;                  /* of (8), (9) */
  struct kith_field *curl, *factor;                   /* NULL without Balsara's factor; it */
  struct kith_field *shear;                           /* NULL unless the viscosity is limited */
};

/* --- the moments --- */

/* V_j W(r, H_j) = this times w(r / H_j): the volume cancels that of the kernel. */
static double volume_factor(const struct kith_package *package) {
  return kith_kernel_constant(package->kernel) * kith_ball() / package->neighbors;
}

/* Lanes of scratch: x_j - x_i; V W; V g C / H^(d + 2), the factor of x_i - x_j in V grad W;
 * g(r / H_i) (H_i - H_j) / (H_i + H_j). */
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

static const double steep = 0.4; /* the change of (9) at which half of a force is (8) */

struct moments_pass {
  struct kith_package *package;
  const struct kith_rows *rows;
  double volume;   /* volume_factor */
  double spacings; /* H in mean node spacings */
};

KITH_INLINE size_t load_kernels(enum kith_kernel kernel, const struct moments_pass *pass, kith_index i,
                                struct kith_scratch *s) {
  const struct kith_nodes *nodes = pass->package->hydro->nodes;
  const kith_index *restrict row = pass->rows->node + pass->rows->first[i];
  const size_t n = pass->rows->first[i + 1] - pass->rows->first[i], padded = kith_lanes_padded(n);
  const double *restrict support = nodes->support->f64;
  double *restrict weight = kith_scratch_lane(s, WEIGHT), *restrict slope = kith_scratch_lane(s, SLOPE),
                   *restrict growth = kith_scratch_lane(s, GROWTH);
  kith_lanes_separations(nodes->position->f64, i, row, n, kith_scratch_lane(s, SEPARATION), s->width, weight);
  const double own = 1 / support[i];
#pragma omp simd
  for (size_t k = 0; k < n; ++k) {
    double wi, gi, wj, gj;
    const double inverse = 1 / support[row[k]], r = sqrt(weight[k]),
                 ratio = kith_pow_dim(own * support[row[k]]);
    kith_kernel_value(kernel, r * own, &wi, &gi);
    kith_kernel_value(kernel, r * inverse, &wj, &gj);
    weight[k] = 0.5 * pass->volume * (wj + ratio * wi);
    slope[k] = 0.5 * pass->volume * (gj * inverse * inverse + ratio * gi * own * own);
    growth[k] = gi * (support[i] - support[row[k]]) / (support[i] + support[row[k]]);
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

/* (9), from sum g x (H_i - H_j) / (H_i + H_j) = - (1 / 2) grad ln H sum g r^2 / d of even neighbors, where
 * Omega is sum g r^2. */
static double smoothness(const struct moments_pass *pass, kith_index i, const double *sum) {
  const struct crk *crk = pass->package->self;
  const double h = pass->package->hydro->nodes->support->f64[i];
  double sum2 = 0;
  for (int a = 0; a < NDIM; ++a) sum2 += sum[a] * sum[a];
  const double change = 2 * pass->volume * sqrt(sum2) / (crk->omega->f64[i] * h * pass->spacings);
  return 1 / (1 + pow(change / steep, 4));
}

KITH_INLINE void moments_chunk(enum kith_kernel kernel, const struct moments_pass *pass, kith_index begin,
                               kith_index end, struct kith_scratch *s) {
  const struct crk *crk = pass->package->self;
  double w0, g0, sum[SUMS];
  kith_kernel_value(kernel, 0, &w0, &g0);
  for (kith_index i = begin; i < end; ++i) {
    const size_t padded = load_kernels(kernel, pass, i, s), at = (size_t)i * NDIM;
    sum_row(padded, s, sum);
    sum[M0] += pass->volume * moment_weight * pass->package->self_weight * w0;
    s->count[KITH_COUNT_EVALUATIONS] += padded;
    s->count[KITH_COUNT_FALLBACKS] += !correct(sum, &crk->a->f64[i], &crk->c->f64[at],
                                               &crk->a_gradient->f64[at], &crk->c_gradient->f64[at * NDIM]);
    crk->smooth->f64[i] = smoothness(pass, i, sum + H1);
  }
}

KITH_KERNEL_CHUNKS(moments_chunk)

/* (2), (3), (9) of internal nodes, from positions and supports of all nodes and ghosts. */
static kith_status moments(struct kith_package *package, const struct kith_connectivity *connectivity) {
  struct moments_pass pass = {package, &connectivity->rows, volume_factor(package),
                              pow(package->neighbors / kith_ball(), 1.0 / NDIM)};
  const struct kith_node_sweep sweep = {.stage = "moments",
                                        .rows = &connectivity->rows,
                                        .chunk = moments_chunk_of[package->kernel],
                                        .context = &pass,
                                        .lanes = LANES,
                                        .width = kith_rows_longest(&connectivity->rows),
                                        .shared = 8 * (NDIM + 1),                 /* x, H */
                                        .own = 8 * (2 + 2 * NDIM + NDIM * NDIM)}; /* A, C, dA, dC, s */
  return kith_package_sweep(package, &sweep, NULL);
}

/* --- the pair function --- */

/* What all pairs share. */
struct crk_constants {
  struct kith_viscosity_constants viscosity;
  double volume; /* volume_factor */
};

/* g . x of a vector g, its entries `stride` apart. */
KITH_INLINE double dot(const double *restrict g, int stride, double x, double y, double z) {
  return NDIM == 1   ? g[0] * x
         : NDIM == 2 ? g[0] * x + g[stride] * y
                     : g[0] * x + g[stride] * y + g[2 * stride] * z;
}

/* (8), from f, v_j - v_i and the pressures; q: P_i + P_j + Q. */
KITH_INLINE void heat(const double *restrict i, const double *restrict j, double q, double *restrict out) {
  double work = 0, force2 = 0, speed2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double f = OUT(KITH_FORCE + a), v = J(KITH_PACKED_V + a) - i[KITH_PACKED_V + a];
    work += f * v, force2 += f * f, speed2 += v * v;
  }
  const double size = sqrt(force2 * speed2),
               gain = size > 0 ? work / size : -1; /* at rest: about to separate */
  const double difference = J(CRK_PRESSURE) - i[CRK_PRESSURE];
  const double share = fabs(q) > 1e-10 * fabs(difference) ? 0.5 + 0.5 * gain * difference / q : 0.5;
  OUT(KITH_HEAT) = share * work;
  OUT(KITH_PARTNER_HEAT) = (1 - share) * work;
}

/* One pair: (4) - (9). */
KITH_INLINE void pair_crk(enum kith_kernel kernel, const void *constants, const double *restrict i,
                          const double *restrict j, double *restrict out) {
  const struct crk_constants *c = constants;
  const struct kith_viscous_pair p = kith_viscous_pair(&c->viscosity, i, j);
  double wi, gi, wj, gj;
  kith_kernel_value(kernel, p.qi, &wi, &gi);
  kith_kernel_value(kernel, p.qj, &wj, &gj);
  /* V_i V_j W = volume w / 2, and so for its gradient, volume g x / 2. */
  const double w = i[CRK_VOLUME] * wj + J(CRK_VOLUME) * wi;
  const double g = i[CRK_VOLUME] * gj * J(KITH_PACKED_INVERSE) * J(KITH_PACKED_INVERSE) +
                   J(CRK_VOLUME) * gi * i[KITH_PACKED_INVERSE] * i[KITH_PACKED_INVERSE];

  const double di = i[KITH_PACKED_DENSITY], dj = J(KITH_PACKED_DENSITY), density = 2 * di * dj / (di + dj);
  const double s = 0.5 * (i[CRK_SWITCH] + J(CRK_SWITCH)), alpha = c->viscosity.alpha * s,
               beta = c->viscosity.factored > 0 ? c->viscosity.beta * s : c->viscosity.beta;
  const double viscosity = density * (beta * p.mu - alpha * p.sound) * p.mu; /* Q of (6) */

  const double pressure = i[CRK_PRESSURE] + J(CRK_PRESSURE) + viscosity,
               smooth = KITH_MIN(i[CRK_SMOOTH], J(CRK_SMOOTH)),
               factor = -0.25 * c->volume * smooth * pressure;
  const double ai = i[CRK_A] + dot(i + CRK_C, 1, p.x, p.y, p.z),
               aj = J(CRK_A) - dot(&J(CRK_C), KITH_STRIDE, p.x, p.y, p.z);
  for (int a = 0; a < NDIM; ++a) { /* (5), with D from (4) */
    const double ci = i[CRK_DA + a] + dot(i + CRK_DC + a, NDIM, p.x, p.y, p.z),
                 cj = J(CRK_DA + a) - dot(&J(CRK_DC + a), NDIM * KITH_STRIDE, p.x, p.y, p.z);
    const double d = (ai + aj) * g * (i[KITH_PACKED_X + a] - J(KITH_PACKED_X + a)) + (ci - cj) * w;
    OUT(KITH_FORCE + a) = factor * d;
  }
  heat(i, j, pressure, out);

  /* V^2 / Omega grad W = volume V / Omega g x / H^2; its work is that of each node's own pressure. */
  const double rest = (smooth - 1) * c->volume, inverse_i = i[KITH_PACKED_INVERSE],
               inverse_j = J(KITH_PACKED_INVERSE);
  const double fi = rest * i[CRK_PRESSURE] * i[CRK_RATE] * gi * inverse_i * inverse_i,
               fj = rest * J(CRK_PRESSURE) * J(CRK_RATE) * gj * inverse_j * inverse_j,
               fq = 0.5 * rest * viscosity * g;
  for (int a = 0; a < NDIM; ++a)
    OUT(KITH_FORCE + a) += (fi + fj + fq) * (i[KITH_PACKED_X + a] - J(KITH_PACKED_X + a));
  OUT(KITH_HEAT) -= (fi + 0.5 * fq) * p.vx, OUT(KITH_PARTNER_HEAT) -= (fj + 0.5 * fq) * p.vx;
  OUT(KITH_SIGNAL) = g < 0 ? p.signal : 0;
}

KITH_FORCE_BLOCKS(pair_crk, CRK_PACKED)

static void pack(const struct kith_package *package, kith_index i, double *restrict packed) {
  const struct kith_hydro *hydro = package->hydro;
  const struct crk *crk = package->self;
  const size_t at = (size_t)i * NDIM;
  kith_viscosity_pack(hydro, crk->shear, i, packed);
  for (int a = 0; a < NDIM; ++a) {
    packed[CRK_C + a] = crk->c->f64[at + a];
    packed[CRK_DA + a] = crk->a_gradient->f64[at + a];
    for (int b = 0; b < NDIM; ++b) packed[CRK_DC + a * NDIM + b] = crk->c_gradient->f64[(at + a) * NDIM + b];
  }
  packed[CRK_SWITCH] = crk->factor != NULL ? crk->factor->f64[i] : 1;
  packed[CRK_PRESSURE] = hydro->pressure->f64[i];
  /* A frozen node has no moments: its kernel is the plain one. */
  const bool frozen = crk->a->f64[i] == 0;
  packed[CRK_A] = frozen ? 1 : crk->a->f64[i];
  packed[CRK_SMOOTH] = frozen ? 1 : crk->smooth->f64[i];
  packed[CRK_VOLUME] = kith_ball() * kith_pow_dim(hydro->nodes->support->f64[i]) / package->neighbors;
  packed[CRK_RATE] = packed[CRK_VOLUME] / (frozen ? 1 : crk->omega->f64[i]);
}

static kith_status forces(struct kith_package *package, const struct kith_connectivity *connectivity,
                          const struct kith_kick *kick) {
  const struct crk_settings *settings = package->settings;
  const struct crk_constants constants = {
      .viscosity = kith_viscosity_constants(&settings->viscosity, package->neighbors),
      .volume = volume_factor(package)};
  return kith_force(&(struct kith_force_pass){.package = package,
                                              .kick = kick,
                                              .connectivity = connectivity,
                                              .pack = pack,
                                              .evaluate = pair_crk_of[package->kernel],
                                              .n_packed = CRK_PACKED,
                                              .constants = &constants});
}

static kith_status crk_create(struct kith_package *package) {
  struct crk *crk = package->self;
  const struct crk_settings *settings = package->settings;
  const bool balsara = kith_viscosity_balsara(&settings->viscosity);
  const struct kith_field_row fields[] = {
      {true, {"kernel_scale", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "A of the corrected kernel"}, &crk->a},
      {true, {"kernel_slope", KITH_VECTOR, KITH_F64, KITH_WORK, NULL, "C"}, &crk->c},
      {true, {"kernel_scale_gradient", KITH_VECTOR, KITH_F64, KITH_WORK, NULL, "dA + C"}, &crk->a_gradient},
      {true,
       {"kernel_slope_gradient", KITH_TENSOR, KITH_F64, KITH_WORK, NULL, "dC_b/dx_c"},
       &crk->c_gradient},
      {true, {"omega", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "grad-h factor Omega"}, &crk->omega},
      {true, {"smooth", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "s of the forces"}, &crk->smooth},
      {balsara, {"curl", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "|curl v|"}, &crk->curl},
      {balsara,
       {"viscosity_factor", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "what multiplies the viscosity"},
       &crk->factor},
      {settings->viscosity.name == KITH_VISCOSITY_LIMITED,
       {"shear", KITH_SYMMETRIC, KITH_F64, KITH_WORK, NULL, "symmetric part of dv_a/dx_b"},
       &crk->shear},
      {0}};
  return kith_nodes_fields(package->hydro->nodes, fields);
}

static kith_status crk_evaluate(struct kith_package *package, struct kith_connectivity *connectivity,
                                const struct kith_kick *kick) {
  const struct kith_hydro *hydro = package->hydro;
  const struct crk *crk = package->self;
  const struct kith_density_wanted wanted = {.omega = crk->omega, .curl = crk->curl, .shear = crk->shear};
  KITH_TRY(kith_density(package, connectivity, &wanted));
  kith_package_start_refresh(package, 1, &(struct kith_field *){hydro->nodes->support});
  KITH_TRY(moments(package, connectivity));
  kith_hydro_evaluate_eos(hydro);
  const struct crk_settings *settings = package->settings;
  struct kith_field *between[11] = {hydro->density,  hydro->pressure, hydro->sound_speed, crk->a,     crk->c,
                                    crk->a_gradient, crk->c_gradient, crk->omega,         crk->smooth};
  int n = 9;
  if (crk->shear != NULL) between[n++] = crk->shear;
  if (crk->factor != NULL) {
    between[n++] = crk->factor;
#pragma omp parallel for schedule(static)
    for (kith_index i = 0; i < hydro->nodes->n_internal; ++i)
      if (kith_node_active(hydro->nodes, i))
        crk->factor->f64[i] = kith_balsara(package, &settings->viscosity, crk->curl, i);
  }
  kith_package_start_refresh(package, n, between);
  return forces(package, connectivity, kick);
}

const struct kith_package_ops kith_package_crk = {
    .name = "crk",
    .doc = "conservative reproducing kernels: linear fields exactly, forces and energy conserved",
    .self_size = sizeof(struct crk),
    .create = crk_create,
    .evaluate = crk_evaluate,
    .spacings = NDIM == 2 ? 1.33 : 0, /* 20 neighbors: half of the noise of 18 */
    .cfl = NDIM == 3 ? 0.4 : 0.3,     /* two blasts in 3-D stop at 0.45 */
    KITH_SETTINGS(params, crk_settings),
};
