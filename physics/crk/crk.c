/* Package `crk`: conservative reproducing kernels (Frontiere, Raskin and Owen 2017, JCoPh 332, 160).
 *
 * Volumes V_i = ball H_i^d / neighbors (density.h), density m_i / V_i: exact where masses jump on an even
 * lattice.
 * Kernels W^R that reproduce linear functions with these volumes: (1) to (4) of moments.h.
 * Forces are those of the antisymmetric part of the gradient: they conserve momentum, but not angular
 * momentum, for they are not central.
 *     m_i dv_i/dt = - sum_j (1/2) V_i V_j (P_i + P_j + Q_ij) D,  D = grad W^R_ij - grad W^R_ji        (5)
 *     Q_ij = 2 rho_i rho_j / (rho_i + rho_j) q_ij,
 *     q_ij = -s alpha c_mean mu + beta mu^2, less in shear: see viscosity.h                           (6)
 * Negative pressures are multiplied by t of tension.h.
 * alpha is 1.5, half more than in the other packages: behind shocks velocities scatter 1.7 times less than
 * with 1, noise dies out twice as fast, and more values of `kith stress` pass (methods.md: the price).
 * The work f . (v_j - v_i) of a pair is shared evenly except for the pressures: where it heats the pair, the
 * node of lower pressure gets the larger part, as in the paper; where it cools the pair, the node of higher
 * pressure gives the larger part, so that a cold node does not lose energy to a hot one.
 * With t the cosine between f and v_j - v_i,
 *     e_ij = 1/2 + d t / (2 (|t| + (1 - |t|) (1 - d^2))),   d = (P_j - P_i) / (P_i + P_j + Q_ij):       (7)
 * which is 1/2 + d t / 2 where pressures are alike. Where they jump that would let a node of next to no
 * pressure give (1 - |t|) / 2 of the work of a large one, in 2-D and 3-D, and have a negative energy. Nor is
 * Q in d where a pair is cooled, as may be while it closes in, since D does not point along it.
 * This work is not that of the volumes V. Where the spacing of the nodes changes fast, and linear functions
 * are no guide, the difference is large. So (5) has the weight s in the force, and
 *     f_ij = - P_i V_i^2 / Omega_i grad W(H_i) - P_j V_j^2 / Omega_j grad W(H_j) - V_i V_j Q_ij grad W    (8)
 * has the weight 1 - s, with the heat P_i V_i^2 / Omega_i v_ij . grad W(H_i) for i, the work on its volume,
 * and half of the heat of Q:
 *     s = min(s_i, s_j), s_i = 1 / (1 + (change_i / 0.4)^4),
 *     change_i: of the spacing, |grad ln H|, from node to node                                        (9)
 * P / rho^gamma stays within 0.97 and 1.05 of its start in the 1-2-3 problem; with s = 1 it is 0.58 to 1.32.
 *
 * Passes: density -> ghosts -> moments -> equation of state -> ghosts -> packing -> force [pairs]. */
#include "physics/crk/moments.h"

struct crk_settings {
  struct kith_viscosity_settings viscosity; /* first: tests read it */
};
static const struct kith_param viscosity_params[] = {
    KITH_VISCOSITY_PARAMS(struct crk_settings, KITH_VISCOSITY_STEADY_LIST, "1.5"), {0}};
static const struct kith_param params[] = {
    {"viscosity", KITH_PARAM_MAP, "", "", "artificial viscosity", KITH_BELOW(viscosity_params, MAP)}, {0}};

/* The fields of a packed particle. */
enum {
  CRK_PRESSURE = KITH_PACKED_VISCOUS,
  CRK_VOLUME,
  CRK_RATE,   /* V / Omega */
  CRK_SMOOTH, /* s of (9) */
  CRK_SWITCH, /* s of (6) */
  CRK_KERNEL, /* moments.h */
  CRK_PACKED = CRK_KERNEL + CRK_COEFFICIENTS
};

struct crk {
  struct crk_moments moments;
  struct kith_viscosity_fields viscosity;
};

/* --- the pair function --- */

static const double steep = 0.4; /* change_i of (9) at which half of a force is (8) */

/* What all pairs share. */
struct crk_constants {
  struct kith_viscosity_constants viscosity;
  double volume; /* V_j W(r, H_j) / w(r / H_j): the volume cancels that of the kernel */
};

/* Computes the heats by (7), from f, v_j - v_i and the pressures; q: P_i + P_j + Q, close to 0 in tension. */
KITH_INLINE void heat(const double *restrict i, const double *restrict j, double pi, double pj, double q,
                      double *restrict out) {
  double work = 0, force2 = 0, speed2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double f = OUT(KITH_FORCE + a), v = J(KITH_PACKED_V + a) - i[KITH_PACKED_V + a];
    work += f * v, force2 += f * f, speed2 += v * v;
  }
  const double size = sqrt(force2 * speed2),
               gain = size > 0 ? work / size : -1; /* at rest: about to separate */
  const double difference = pj - pi, sum = work < 0 ? pi + pj : q;
  const double jump = fabs(sum) > 1e-10 * fabs(difference) ? difference / sum : 0;
  const double even = KITH_MAX(0, 1 - jump * jump), oblique = 1 - fabs(gain);
  const double share = 0.5 + 0.5 * jump * gain / KITH_MAX(fabs(gain) + oblique * even, DBL_MIN);
  OUT(KITH_HEAT) = share * work;
  OUT(KITH_PARTNER_HEAT) = (1 - share) * work;
}

/* Evaluates a pair: (4) - (9). */
KITH_INLINE void pair_crk(enum kith_kernel kernel, const void *constants, const double *restrict i,
                          const double *restrict j, double *restrict out) {
  const struct crk_constants *c = constants;
  const struct kith_viscous_pair p = kith_viscous_pair(&c->viscosity, i, j);
  double wi, gi, wj, gj;
  kith_kernel_value(kernel, p.qi, &wi, &gi);
  kith_kernel_value(kernel, p.qj, &wj, &gj);
  /* V_i V_j W = volume w / 2, and its gradient is volume g x / 2. */
  const double w = i[CRK_VOLUME] * wj + J(CRK_VOLUME) * wi;
  const double g = i[CRK_VOLUME] * gj * J(KITH_PACKED_INVERSE) * J(KITH_PACKED_INVERSE) +
                   J(CRK_VOLUME) * gi * i[KITH_PACKED_INVERSE] * i[KITH_PACKED_INVERSE];

  const double viscosity = /* Q of (6) */
      kith_viscous_pressure(&c->viscosity, &p, i[KITH_PACKED_DENSITY], J(KITH_PACKED_DENSITY),
                            0.5 * (i[CRK_SWITCH] + J(CRK_SWITCH)));

  const double pi = kith_tension(p.closer, i[CRK_PRESSURE]), pj = kith_tension(p.closer, J(CRK_PRESSURE)),
               pressure = pi + pj + viscosity, smooth = KITH_MIN(i[CRK_SMOOTH], J(CRK_SMOOTH)),
               factor = -0.25 * c->volume * smooth * pressure;
  double d[NDIM];
  crk_gradient(&p, w, g, i + CRK_KERNEL, &J(CRK_KERNEL), d);
  for (int a = 0; a < NDIM; ++a) OUT(KITH_FORCE + a) = factor * d[a]; /* (5) */
  heat(i, j, pi, pj, pressure, out);

  /* V^2 / Omega grad W = volume V / Omega g x / H^2; its work is that of each node's own pressure. */
  const double rest = (smooth - 1) * c->volume, inverse_i = i[KITH_PACKED_INVERSE],
               inverse_j = J(KITH_PACKED_INVERSE);
  const double fi = rest * pi * i[CRK_RATE] * gi * inverse_i * inverse_i,
               fj = rest * pj * J(CRK_RATE) * gj * inverse_j * inverse_j, fq = 0.5 * rest * viscosity * g;
  for (int a = 0; a < NDIM; ++a)
    OUT(KITH_FORCE + a) += (fi + fj + fq) * (i[KITH_PACKED_X + a] - J(KITH_PACKED_X + a));
  OUT(KITH_HEAT) -= (fi + 0.5 * fq) * p.vx, OUT(KITH_PARTNER_HEAT) -= (fj + 0.5 * fq) * p.vx;
  OUT(KITH_SIGNAL) = KITH_HAS_SIGNAL(p.qi, p.qj) ? p.signal : 0;
}

static void pack(const struct kith_package *package, kith_index i, double *restrict packed) {
  const struct kith_hydro *hydro = package->hydro;
  const struct crk *crk = package->self;
  kith_viscosity_pack(hydro, &crk->viscosity, i, packed);
  kith_crk_moments_pack(&crk->moments, i, packed + CRK_KERNEL);
  packed[CRK_SWITCH] = kith_viscosity_factor(&crk->viscosity, i);
  packed[CRK_PRESSURE] = hydro->pressure->f64[i];
  const bool frozen = crk->moments.omega->f64[i] == 0;
  packed[CRK_SMOOTH] = 1 / (1 + pow(crk->moments.change->f64[i] / steep, 4));
  packed[CRK_VOLUME] = kith_ball() * kith_pow_dim(hydro->nodes->support->f64[i]) / package->neighbors;
  packed[CRK_RATE] = packed[CRK_VOLUME] / (frozen ? 1 : crk->moments.omega->f64[i]);
}

static void copy_corrections(const double *restrict i, double *restrict j) {
  for (int k = CRK_KERNEL; k < CRK_PACKED; ++k) J(k) = i[k];
  J(CRK_SMOOTH) = i[CRK_SMOOTH];
  J(CRK_RATE) = i[CRK_RATE] * J(CRK_VOLUME) / i[CRK_VOLUME];
}

KITH_FORCE_FORM(pair_crk, CRK_PACKED, pack, copy_corrections)

static kith_status crk_create(struct kith_package *package) {
  struct crk *crk = package->self;
  const struct crk_settings *settings = package->settings;
  KITH_TRY(kith_viscosity_create(package, &settings->viscosity, &crk->viscosity));
  return kith_crk_moments_init(&crk->moments, package->hydro->nodes);
}

static kith_status crk_evaluate(struct kith_package *package, struct kith_connectivity *connectivity,
                                const struct kith_kick *kick) {
  const struct kith_hydro *hydro = package->hydro;
  const struct crk *crk = package->self;
  const struct crk_moments *m = &crk->moments;
  const struct crk_settings *settings = package->settings;
  const struct kith_density_wanted wanted = {
      .omega = m->omega, .curl = crk->viscosity.curl, .shear = crk->viscosity.shear};
  KITH_TRY(kith_density(package, connectivity, &wanted));
  kith_package_start_refresh(package, 2, (struct kith_field *[]){hydro->nodes->support, hydro->density});
  KITH_TRY(kith_crk_moments_evaluate(package, m, connectivity));
  kith_hydro_evaluate_eos(hydro);
  struct kith_field *between[10] = {hydro->pressure, hydro->sound_speed, m->a,     m->c,
                                    m->a_gradient,   m->c_gradient,      m->omega, m->change};
  const int n = kith_viscosity_exchanged(&crk->viscosity, 8, between);
  kith_balsara_factors(package, &settings->viscosity, &crk->viscosity, 0, hydro->nodes->n_internal);
  const struct crk_constants constants = {
      .viscosity = kith_viscosity_constants(&settings->viscosity, package->neighbors),
      .volume = kith_kernel_constant(package->kernel) * kith_ball() / package->neighbors};
  return kith_force(
      package, connectivity, kick,
      &(struct kith_force_pass){
          .form = &pair_crk_form, .constants = &constants, .exchanged = between, .n_exchanged = n});
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
