/* Package `crk`: conservative reproducing kernels (Frontiere, Raskin and Owen 2017, JCoPh 332, 160).
 *
 * Volumes V_i = ball H_i^d / neighbors (density.h), density m_i / V_i: exact where masses jump on an even
 * lattice. The corrected kernel W^R and its gradient, (1) - (4), are those of moments.h.
 * Forces are those of the antisymmetric part of the gradient: they conserve momentum, but not angular
 * momentum, for they are not central.
 *     m_i dv_i/dt = - sum_j (1/2) V_i V_j (P_i + P_j + Q_ij) D,  D = grad W^R_ij - grad W^R_ji        (5)
 *     Q_ij = 2 rho_i rho_j / (rho_i + rho_j) (-alpha c_mean mu + beta mu^2),
 *     mu as in viscosity.h                                                                            (6)
 * The work f . (v_j - v_i) of a pair is shared evenly except for the pressures: where it heats the pair, the
 * node of lower pressure gets the larger part, as in the paper; where it cools the pair, the node of higher
 * pressure gives the larger part, so that a cold node does not lose energy to a hot one.
 * With t the cosine between f and v_j - v_i,
 *     e_ij = 1/2 + t (P_j - P_i) / (2 (P_i + P_j + Q_ij))                                             (7)
 *
 * Passes: density -> equation of state -> ghosts -> moments -> ghosts -> packing -> force [pairs] -> ghosts
 * -> work. */
#include "physics/crk/moments.h"
#include "physics/passes/density.h"
#include "physics/passes/viscosity.h"

struct crk_settings {
  struct kith_viscosity_settings viscosity; /* first: tests read it */
  int balsara;                              /* none: settings that sph shares with crk may say so */
};
static const struct kith_param viscosity_params[] = {
    KITH_VISCOSITY_PARAMS(struct crk_settings, "|none|monaghan|limited"),
    {"balsara", KITH_PARAM_CHOICE, "none", "none", "only sph has the factor",
     KITH_INTO(struct crk_settings, balsara)},
    {0}};
static const struct kith_param params[] = {
    {"viscosity", KITH_PARAM_MAP, "", "", "artificial viscosity", KITH_BELOW(viscosity_params, MAP)}, {0}};

/* The fields of a packed particle. */
enum {
  CRK_PRESSURE = KITH_PACKED_VISCOUS,
  CRK_VOLUME,
  CRK_A,
  CRK_C,
  CRK_DA = CRK_C + NDIM,  /* dA + C */
  CRK_DC = CRK_DA + NDIM, /* dC_b / dx_c, [b][c] */
  CRK_PACKED = CRK_DC + NDIM * NDIM
};

struct crk {
  struct crk_moments moments;
  struct kith_field *shear; /* NULL unless the viscosity is limited */
};

/* What all pairs share. */
struct crk_constants {
  struct kith_viscosity_constants viscosity;
  double volume; /* crk_volume */
};

/* g . x of a vector g, its entries `stride` apart. */
KITH_INLINE double dot(const double *restrict g, int stride, double x, double y, double z) {
  return NDIM == 1   ? g[0] * x
         : NDIM == 2 ? g[0] * x + g[stride] * y
                     : g[0] * x + g[stride] * y + g[2 * stride] * z;
}

/* (7), from f, v_j - v_i and the pressures; q: P_i + P_j + Q. */
KITH_INLINE double share(const double *restrict i, const double *restrict j, const double *restrict out,
                         double q) {
  double work = 0, force2 = 0, speed2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double f = OUT(KITH_FORCE + a), v = J(KITH_PACKED_V + a) - i[KITH_PACKED_V + a];
    work += f * v, force2 += f * f, speed2 += v * v;
  }
  const double size = sqrt(force2 * speed2),
               gain = size > 0 ? work / size : -1; /* at rest: about to separate */
  const double difference = J(CRK_PRESSURE) - i[CRK_PRESSURE];
  return fabs(q) > 1e-10 * fabs(difference) ? 0.5 + 0.5 * gain * difference / q : 0.5;
}

/* One pair: (4) - (7). */
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
  const double viscosity =
      density * (c->viscosity.beta * p.mu - c->viscosity.alpha * p.sound) * p.mu; /* Q of (6) */

  const double pressure = i[CRK_PRESSURE] + J(CRK_PRESSURE) + viscosity,
               factor = -0.25 * c->volume * pressure;
  const double ai = i[CRK_A] + dot(i + CRK_C, 1, p.x, p.y, p.z),
               aj = J(CRK_A) - dot(&J(CRK_C), KITH_STRIDE, p.x, p.y, p.z);
  for (int a = 0; a < NDIM; ++a) { /* (5), with D from (4) */
    const double ci = i[CRK_DA + a] + dot(i + CRK_DC + a, NDIM, p.x, p.y, p.z),
                 cj = J(CRK_DA + a) - dot(&J(CRK_DC + a), NDIM * KITH_STRIDE, p.x, p.y, p.z);
    const double d = (ai + aj) * g * (i[KITH_PACKED_X + a] - J(KITH_PACKED_X + a)) + (ci - cj) * w;
    OUT(KITH_FORCE + a) = factor * d;
  }
  OUT(KITH_ENERGY_SHARE) = share(i, j, out, pressure);
  OUT(KITH_EXCHANGE) = 0;
  OUT(KITH_SIGNAL) = g < 0 ? p.signal : 0;
}

KITH_FORCE_BLOCKS(pair_crk)

static void pack(const struct kith_package *package, kith_index i, double *restrict packed) {
  const struct kith_hydro *hydro = package->hydro;
  const struct crk *crk = package->self;
  const size_t at = (size_t)i * NDIM;
  kith_viscosity_pack(hydro, crk->shear, i, packed);
  for (int a = 0; a < NDIM; ++a) {
    packed[CRK_C + a] = crk->moments.c->f64[at + a];
    packed[CRK_DA + a] = crk->moments.a_gradient->f64[at + a];
    for (int b = 0; b < NDIM; ++b)
      packed[CRK_DC + a * NDIM + b] = crk->moments.c_gradient->f64[(at + a) * NDIM + b];
  }
  packed[CRK_PRESSURE] = hydro->pressure->f64[i];
  /* A frozen node has no moments: its kernel is the plain one. */
  packed[CRK_A] = crk->moments.a->f64[i] > 0 ? crk->moments.a->f64[i] : 1;
  packed[CRK_VOLUME] = kith_ball() * kith_pow_dim(hydro->nodes->support->f64[i]) / package->neighbors;
}

static kith_status forces(struct kith_package *package, const struct kith_connectivity *connectivity,
                          const struct kith_kick *kick) {
  const struct crk_settings *settings = package->settings;
  const struct crk_constants constants = {
      .viscosity = kith_viscosity_constants(&settings->viscosity, package->neighbors),
      .volume = crk_volume(package)};
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
  struct crk_moments *m = &crk->moments;
  const struct crk_settings *settings = package->settings;
  const struct kith_field_row fields[] = {
      {true, {"kernel_scale", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "A of the corrected kernel"}, &m->a},
      {true, {"kernel_slope", KITH_VECTOR, KITH_F64, KITH_WORK, NULL, "C"}, &m->c},
      {true, {"kernel_scale_gradient", KITH_VECTOR, KITH_F64, KITH_WORK, NULL, "dA + C"}, &m->a_gradient},
      {true, {"kernel_slope_gradient", KITH_TENSOR, KITH_F64, KITH_WORK, NULL, "dC_b/dx_c"}, &m->c_gradient},
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
  const struct kith_density_wanted wanted = {.shear = crk->shear};
  KITH_TRY(kith_density(package, connectivity, &wanted));
  kith_package_start_refresh(package, 1, &(struct kith_field *){hydro->nodes->support});
  KITH_TRY(crk_moments(package, connectivity, &crk->moments));
  kith_hydro_evaluate_eos(hydro);
  struct kith_field *const between[] = {hydro->density,          hydro->pressure, hydro->sound_speed,
                                        crk->moments.a,          crk->moments.c,  crk->moments.a_gradient,
                                        crk->moments.c_gradient, crk->shear};
  kith_package_start_refresh(package, crk->shear != NULL ? 8 : 7, between);
  return forces(package, connectivity, kick);
}

const struct kith_package_ops kith_package_crk = {
    .name = "crk",
    .doc = "conservative reproducing kernels: linear fields exactly, forces and energy conserved",
    .self_size = sizeof(struct crk),
    .create = crk_create,
    .evaluate = crk_evaluate,
    KITH_SETTINGS(params, crk_settings),
};
