#include "physics/crk/crk.h"
#include "physics/slope.h"

/* What all pairs share. */
struct crk_constants {
  double alpha, beta;
  double volume;   /* crk_volume */
  double spacings; /* H in mean node spacings */
  double limited;  /* 1: the jump is limited */
};

/* Places of y and z; where there are none they stand in for another one, and nothing reads them. */
enum { Y = NDIM > 1 ? 1 : 0, Z = NDIM > 2 ? 2 : 0 };

/* (7), from f, v_j - v_i and the pressures; q: P_i + P_j + Q. */
KITH_INLINE double share(const double *restrict i, const double *restrict j, const double *restrict out,
                         double q) {
  double work = 0, force2 = 0, speed2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double f = OUT(KITH_FORCE + a), v = J(KITH_RECORD_V + a) - i[KITH_RECORD_V + a];
    work += f * v, force2 += f * f, speed2 += v * v;
  }
  const double size = sqrt(force2 * speed2), gain = size > 0 ? work / size : -1; /* at rest: about to part */
  const double difference = J(CRK_PRESSURE) - i[CRK_PRESSURE];
  return fabs(q) > 1e-10 * fabs(difference) ? 0.5 + 0.5 * gain * difference / q : 0.5;
}

/* One pair: (4) - (7). */
KITH_INLINE void pair_crk(enum kith_kernel kernel, const void *constants, const double *restrict i,
                          const double *restrict j, double *restrict out) {
  const struct crk_constants *c = constants;
  const double x = i[KITH_RECORD_X] - J(KITH_RECORD_X), y = i[KITH_RECORD_X + Y] - J(KITH_RECORD_X + Y),
               z = i[KITH_RECORD_X + Z] - J(KITH_RECORD_X + Z);
  double r2 = 0, vx = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double d = i[KITH_RECORD_X + a] - J(KITH_RECORD_X + a);
    r2 += d * d;
    vx += d * (i[KITH_RECORD_V + a] - J(KITH_RECORD_V + a));
  }
  const double r = sqrt(r2), inverse_r = 1 / KITH_MAX(r, 1e-30);
  const double qi = r * i[CRK_INVERSE], qj = r * J(CRK_INVERSE);
  double wi, gi, wj, gj;
  kith_kernel_value(kernel, qi, &wi, &gi);
  kith_kernel_value(kernel, qj, &wj, &gj);
  /* V_i V_j W = volume w / 2, and so for its gradient, volume g x / 2. */
  const double w = i[CRK_VOLUME] * wj + J(CRK_VOLUME) * wi;
  const double g = i[CRK_VOLUME] * gj * J(CRK_INVERSE) * J(CRK_INVERSE) +
                   J(CRK_VOLUME) * gi * i[CRK_INVERSE] * i[CRK_INVERSE];

  const double limited = kith_slope_jump(vx, kith_slope_symmetric(i + CRK_SHEAR, 1, x, y, z),
                                         kith_slope_symmetric(&J(CRK_SHEAR), KITH_STRIDE, x, y, z),
                                         c->spacings * KITH_MAX(qi, qj));
  const double jump = c->limited > 0 ? limited : vx, mu = vx < 0 ? KITH_MIN(jump, 0.0) * inverse_r : 0;
  const double sound = 0.5 * (i[CRK_SOUND] + J(CRK_SOUND));
  const double density = 2 * i[CRK_DENSITY] * J(CRK_DENSITY) / (i[CRK_DENSITY] + J(CRK_DENSITY));
  const double viscosity = density * (c->beta * mu - c->alpha * sound) * mu; /* Q */

  const double pressure = i[CRK_PRESSURE] + J(CRK_PRESSURE) + viscosity,
               strength = -0.25 * c->volume * pressure;
  const double ai = i[CRK_A] + kith_slope_vector(i + CRK_C, 1, x, y, z),
               aj = J(CRK_A) - kith_slope_vector(&J(CRK_C), KITH_STRIDE, x, y, z);
  for (int a = 0; a < NDIM; ++a) {
    const double ci = i[CRK_DA + a] + kith_slope_vector(i + CRK_DC + a, NDIM, x, y, z),
                 cj = J(CRK_DA + a) - kith_slope_vector(&J(CRK_DC + a), NDIM * KITH_STRIDE, x, y, z);
    const double d = (ai + aj) * g * (i[KITH_RECORD_X + a] - J(KITH_RECORD_X + a)) + (ci - cj) * w;
    OUT(KITH_FORCE + a) = strength * d;
  }
  OUT(KITH_SHARE) = share(i, j, out, pressure);
  OUT(KITH_EXCHANGE) = 0;
  OUT(KITH_SIGNAL) = r2 > 0 && g < 0 ? KITH_MAX(c->alpha, 1.0) * sound - c->beta * mu : 0;
}

#define CHUNKS(name, ...) KITH_FORCE_CHUNKS(crk, name, CRK_MEMBERS)
KITH_KERNEL_LIST(CHUNKS)

#define PAIRS(name, ...) pairs_crk_##name,
#define NODES(name, ...) nodes_crk_##name,
static const kith_chunk_pass pairs[] = {KITH_KERNEL_LIST(PAIRS)};
static const kith_chunk_pass nodes[] = {KITH_KERNEL_LIST(NODES)};

static void pack(const struct kith_package *package, kith_index i, double *restrict record) {
  const struct kith_hydro *hydro = package->hydro;
  const struct crk *crk = package->self;
  const size_t at = (size_t)i * NDIM;
  const double support = hydro->nodes->support->f64[i];
  const double volume = kith_ball() * kith_pow_dim(support) / package->neighbors;
  kith_force_pack(hydro, i, record);
  for (int a = 0; a < NDIM; ++a) {
    record[CRK_C + a] = crk->slope->f64[at + a];
    record[CRK_DA + a] = crk->scale_gradient->f64[at + a];
    for (int b = 0; b < NDIM; ++b)
      record[CRK_DC + a * NDIM + b] = crk->slope_gradient->f64[(at + a) * NDIM + b];
  }
  record[CRK_INVERSE] = 1 / support;
  record[CRK_PRESSURE] = hydro->pressure->f64[i];
  record[CRK_DENSITY] = hydro->density->f64[i];
  record[CRK_SOUND] = hydro->sound_speed->f64[i];
  /* A frozen node has no moments: its kernel is the plain one. */
  record[CRK_A] = crk->scale->f64[i] > 0 ? crk->scale->f64[i] : 1;
  record[CRK_VOLUME] = volume;
  for (int k = 0; k < KITH_SYMMETRIC_SIZE; ++k)
    record[CRK_SHEAR + k] = crk->shear != NULL ? crk->shear->f64[(size_t)i * KITH_SYMMETRIC_SIZE + k] : 0;
}

kith_status crk_pairs(struct kith_package *package, const struct kith_connectivity *connectivity) {
  const struct crk *crk = package->self;
  const bool viscous = package->viscosity != KITH_VISCOSITY_NONE;
  const struct crk_constants constants = {.alpha = viscous ? package->alpha : 0,
                                          .beta = viscous ? package->beta : 0,
                                          .volume = crk_volume(package),
                                          .spacings = pow(package->neighbors / kith_ball(), 1.0 / NDIM),
                                          .limited = crk->shear != NULL};
  struct kith_force_pass pass = {.package = package,
                                 .pack = pack,
                                 .connectivity = connectivity,
                                 .rows = &connectivity->rows,
                                 .constants = &constants};
  return kith_force(&pass, pairs, nodes, CRK_MEMBERS, 0);
}
