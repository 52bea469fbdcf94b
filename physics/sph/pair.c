#include "physics/sph/sph.h"
#include "physics/slope.h"

/* C / H^(d + 2) g(q): the factor of x_ij in grad_i W. */
KITH_INLINE double gradient_factor(enum kith_kernel kernel, double constant, double q,
                                   double inverse_support) {
  double w, g;
  kith_kernel_value(kernel, q, &w, &g);
  return constant * g * kith_pow_dim(inverse_support) * inverse_support * inverse_support;
}

/* The jump v_ij . x_ij between velocities extrapolated to the middle of the pair; never more than the whole jump vx. */
KITH_INLINE double limited_jump(const struct sph_constants *c, const double *restrict i,
                                const double *restrict j, double vx, double q) {
  enum { Y = NDIM > 1 ? 1 : 0, Z = NDIM > 2 ? 2 : 0 };
  const double x = i[KITH_RECORD_X] - J(KITH_RECORD_X), y = i[KITH_RECORD_X + Y] - J(KITH_RECORD_X + Y),
               z = i[KITH_RECORD_X + Z] - J(KITH_RECORD_X + Z);
  const double limited =
      kith_slope_jump(vx, kith_slope_symmetric(i + SPH_GRADIENT, 1, x, y, z),
                      kith_slope_symmetric(&J(SPH_GRADIENT), KITH_STRIDE, x, y, z), c->spacings * q);
  return c->limited > 0 ? limited : vx;
}

/* One pair: (3) - (5), (7). */
KITH_INLINE void sph_pair(enum kith_kernel kernel, bool full, const struct sph_constants *c,
                          const double *restrict i, const double *restrict j, double *restrict out) {
  double r2 = 0, vx = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double x = i[KITH_RECORD_X + a] - J(KITH_RECORD_X + a);
    r2 += x * x;
    vx += x * (i[KITH_RECORD_V + a] - J(KITH_RECORD_V + a));
  }
  const double r = sqrt(r2), inverse_r = 1 / KITH_MAX(r, 1e-30);
  const double qi = r * i[SPH_INVERSE], qj = r * J(SPH_INVERSE);
  const double gi = gradient_factor(kernel, c->kernel, qi, i[SPH_INVERSE]);
  const double gj = gradient_factor(kernel, c->kernel, qj, J(SPH_INVERSE));

  const double jump = limited_jump(c, i, j, vx, KITH_MAX(qi, qj));
  const double mu = vx < 0 ? KITH_MIN(jump, 0.0) * inverse_r : 0;
  const double sound = 0.5 * (i[SPH_SOUND] + J(SPH_SOUND)), densities = i[SPH_DENSITY] + J(SPH_DENSITY);
  double viscosity = (c->beta * mu - c->alpha * sound) * mu / densities; /* Pi / 2 */
  if (full) viscosity *= 0.5 * (i[SPH_SWITCH] + J(SPH_SWITCH));

  const double masses = i[SPH_MASS] * J(SPH_MASS);
  const double fi = -i[SPH_PSI] * (J(SPH_MASS) - i[SPH_EXCESS]) * gi,
               fj = -J(SPH_PSI) * (i[SPH_MASS] - J(SPH_EXCESS)) * gj, fq = -masses * viscosity * (gi + gj);
  const double force = fi + fj + fq;
  for (int a = 0; a < NDIM; ++a) OUT(KITH_FORCE + a) = force * (i[KITH_RECORD_X + a] - J(KITH_RECORD_X + a));

  /* (4) is the share fi + fq / 2 of the work; what cannot be said so, forces that cancel, is exchanged. */
  const double heat = fi + 0.5 * fq, total = fabs(fi) + fabs(fj) + fq;
  const double share = fabs(force) > 1e-10 * total ? heat / force : 0.5;
  double exchange = (share * force - heat) * vx;
  if (full) {
    const double pi = i[SPH_PSI] * i[SPH_DENSITY] * i[SPH_DENSITY] / i[SPH_MASS],
                 pj = J(SPH_PSI) * J(SPH_DENSITY) * J(SPH_DENSITY) / J(SPH_MASS);
    const double speed = sqrt(2 * fabs(pi - pj) / densities);
    exchange += c->conduction * masses * speed * (i[SPH_ENERGY] - J(SPH_ENERGY)) * r * (gi + gj) / densities;
  }
  OUT(KITH_SHARE) = share;
  OUT(KITH_EXCHANGE) = exchange;
  OUT(KITH_SIGNAL) = r2 > 0 && gi + gj < 0 ? KITH_MAX(c->alpha, 1.0) * sound - c->beta * mu : 0;
}

KITH_INLINE void pair_simple(enum kith_kernel kernel, const void *constants, const double *restrict i,
                             const double *restrict j, double *restrict out) {
  sph_pair(kernel, false, constants, i, j, out);
}
KITH_INLINE void pair_full(enum kith_kernel kernel, const void *constants, const double *restrict i,
                           const double *restrict j, double *restrict out) {
  sph_pair(kernel, true, constants, i, j, out);
}

#define SIMPLE(name, ...) KITH_FORCE_CHUNKS(simple, name, SPH_SIMPLE)
#define FULL(name, ...) KITH_FORCE_CHUNKS(full, name, SPH_FULL)
KITH_KERNEL_LIST(SIMPLE)
KITH_KERNEL_LIST(FULL)

/* [full][kernel] */
#define PAIRS_SIMPLE(name, ...) pairs_simple_##name,
#define PAIRS_FULL(name, ...) pairs_full_##name,
#define NODES_SIMPLE(name, ...) nodes_simple_##name,
#define NODES_FULL(name, ...) nodes_full_##name,
static const kith_chunk_pass pairs[][KITH_N_KERNELS] = {{KITH_KERNEL_LIST(PAIRS_SIMPLE)},
                                                        {KITH_KERNEL_LIST(PAIRS_FULL)}};
static const kith_chunk_pass nodes[][KITH_N_KERNELS] = {{KITH_KERNEL_LIST(NODES_SIMPLE)},
                                                        {KITH_KERNEL_LIST(NODES_FULL)}};

static void pack(const struct kith_package *package, kith_index i, double *restrict record) {
  const struct kith_hydro *hydro = package->hydro;
  const struct sph *sph = package->self;
  const double density = hydro->density->f64[i], mass = hydro->mass->f64[i];
  kith_force_pack(hydro, i, record);
  record[SPH_INVERSE] = 1 / hydro->nodes->support->f64[i];
  record[SPH_PSI] = mass * hydro->pressure->f64[i] / (density * density);
  record[SPH_EXCESS] = sph->excess->f64[i];
  record[SPH_MASS] = mass;
  record[SPH_DENSITY] = density;
  record[SPH_SOUND] = hydro->sound_speed->f64[i];
  for (int k = 0; k < KITH_SYMMETRIC_SIZE; ++k)
    record[SPH_GRADIENT + k] = sph->shear != NULL ? sph->shear->f64[(size_t)i * KITH_SYMMETRIC_SIZE + k] : 0;
  if (!sph->full) return;
  record[SPH_SWITCH] = sph->factor != NULL ? sph->factor->f64[i] : 1;
  record[SPH_ENERGY] = hydro->energy->f64[i];
}

kith_status sph_pairs(struct kith_package *package, const struct kith_connectivity *connectivity) {
  const struct sph *sph = package->self;
  const int size = sph->full ? SPH_FULL : SPH_SIMPLE;
  const bool viscous = package->viscosity != KITH_VISCOSITY_NONE;
  const struct sph_constants constants = {.alpha = viscous ? package->alpha : 0,
                                          .beta = viscous ? package->beta : 0,
                                          .conduction = package->conduction,
                                          .kernel = kith_kernel_constant(package->kernel),
                                          .spacings = pow(package->neighbors / kith_ball(), 1.0 / NDIM),
                                          .limited = package->viscosity == KITH_VISCOSITY_LIMITED};
  struct kith_force_pass pass = {.package = package,
                                 .pack = pack,
                                 .connectivity = connectivity,
                                 .rows = &connectivity->rows,
                                 .constants = &constants};
  return kith_force(&pass, pairs[sph->full], nodes[sph->full], size, 0);
}
