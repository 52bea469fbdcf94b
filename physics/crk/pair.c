#include "physics/crk/crk.h"

/* What all pairs share. */
struct crk_constants {
  double alpha, beta;
  double volume;   /* crk_volume */
  double spacings; /* H in mean node spacings */
};

/* Van Leer's limiter of two slopes, 4 r / (1 + r)^2 with r their ratio: 0 if they differ in sign, 1 if they are equal. */
static inline double limiter(double slope_i, double slope_j) {
  const double product = slope_i * slope_j, sum = slope_i + slope_j;
  return product > 0 ? 4 * product / (sum * sum) : 0;
}

/* Places of y and z in vectors; nothing is read twice where there are none, for they are multiplied away. */
enum { Y = NDIM > 1 ? 1 : 0, Z = NDIM > 2 ? 2 : 0 };

/* x.G.x of a symmetric G given by its upper triangle, `stride` apart. No loop: what calls it vectorizes. */
KITH_INLINE double slope(const double *restrict g, int stride, double x, double y, double z) {
  return NDIM == 1   ? g[0] * x * x
         : NDIM == 2 ? g[0] * x * x + g[2 * stride] * y * y + 2 * (g[stride] * x * y)
                     : g[0] * x * x + g[3 * stride] * y * y + g[5 * stride] * z * z +
                           2 * (g[stride] * x * y + g[2 * stride] * x * z + g[4 * stride] * y * z);
}

/* The jump v_ij . x_ij between velocities extrapolated to the middle of the pair; never more than the whole jump vx. */
KITH_INLINE double limited_jump(const struct crk_constants *c, const double *restrict i,
                                const double *restrict j, double vx, double q) {
  const double x = i[KITH_RECORD_X] - J(KITH_RECORD_X), y = i[KITH_RECORD_X + Y] - J(KITH_RECORD_X + Y),
               z = i[KITH_RECORD_X + Z] - J(KITH_RECORD_X + Z);
  const double slope_i = slope(i + CRK_SHEAR, 1, x, y, z),
               slope_j = slope(&J(CRK_SHEAR), KITH_STRIDE, x, y, z);
  const double closer = 5 * KITH_MIN(c->spacings * q - 1, 0.0); /* than the mean spacing, in fifths of it */
  const double phi = limiter(slope_i, slope_j) * KITH_MAX(1 - closer * closer, 0.0);
  return KITH_MAX(vx - 0.5 * phi * (slope_i + slope_j), vx);
}

/* g . x of a vector g, `stride` apart. */
KITH_INLINE double along(const double *restrict g, int stride, double x, double y, double z) {
  return NDIM == 1 ? g[0] * x : NDIM == 2 ? g[0] * x + g[stride] * y : g[0] * x + g[stride] * y + g[2 * stride] * z;
}

/* One pair: (4) - (7). */
KITH_INLINE void crk_pair(enum kith_kernel kernel, bool limited, const struct crk_constants *c,
                          const double *restrict i, const double *restrict j, double *restrict out) {
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
  const double w = i[CRK_VOLUME] * wj + J(CRK_VOLUME) * wi;
  const double g = i[CRK_VOLUME] * gj * J(CRK_INVERSE) * J(CRK_INVERSE) +
                   J(CRK_VOLUME) * gi * i[CRK_INVERSE] * i[CRK_INVERSE];

  const double jump = limited ? limited_jump(c, i, j, vx, KITH_MAX(qi, qj)) : vx;
  const double mu = vx < 0 ? KITH_MIN(jump, 0.0) * inverse_r : 0;
  const double sound = 0.5 * (i[CRK_SOUND] + J(CRK_SOUND));
  const double density = 2 * i[CRK_DENSITY] * J(CRK_DENSITY) / (i[CRK_DENSITY] + J(CRK_DENSITY));
  const double viscosity = density * (c->beta * mu - c->alpha * sound) * mu; /* Q */

  const double pressure = i[CRK_PRESSURE] + J(CRK_PRESSURE) + viscosity, strength = -0.25 * c->volume * pressure;
  const double central =
      (i[CRK_A] + along(i + CRK_C, 1, x, y, z) + J(CRK_A) - along(&J(CRK_C), KITH_STRIDE, x, y, z)) * g;
  for (int a = 0; a < NDIM; ++a) {
    const double ci = i[CRK_DA + a] + (i[CRK_DC + a] * x + (NDIM > 1) * i[CRK_DC + Y * NDIM + a] * y +
                                       (NDIM > 2) * i[CRK_DC + Z * NDIM + a] * z),
                 cj = J(CRK_DA + a) - (J(CRK_DC + a) * x + (NDIM > 1) * J(CRK_DC + Y * NDIM + a) * y +
                                       (NDIM > 2) * J(CRK_DC + Z * NDIM + a) * z);
    OUT(KITH_FORCE + a) =
        strength * (central * (i[KITH_RECORD_X + a] - J(KITH_RECORD_X + a)) + (ci - cj) * w);
  }
  double work = 0, force2 = 0, speed2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double f = OUT(KITH_FORCE + a), v = J(KITH_RECORD_V + a) - i[KITH_RECORD_V + a];
    work += f * v, force2 += f * f, speed2 += v * v;
  }
  const double scale = sqrt(force2 * speed2), gain = scale > 0 ? work / scale : 0;
  const double heat = 0.5 * (pressure + gain * (J(CRK_PRESSURE) - i[CRK_PRESSURE]));
  OUT(KITH_SHARE) =
      fabs(pressure) > 1e-10 * (fabs(i[CRK_PRESSURE]) + fabs(J(CRK_PRESSURE))) ? heat / pressure : 0.5;
  OUT(KITH_EXCHANGE) = 0;
  OUT(KITH_SIGNAL) = r2 > 0 && g < 0 ? KITH_MAX(c->alpha, 1.0) * sound - c->beta * mu : 0;
}

KITH_INLINE void pair_plain(enum kith_kernel kernel, const void *constants, const double *restrict i,
                            const double *restrict j, double *restrict out) {
  crk_pair(kernel, false, constants, i, j, out);
}
KITH_INLINE void pair_sloped(enum kith_kernel kernel, const void *constants, const double *restrict i,
                             const double *restrict j, double *restrict out) {
  crk_pair(kernel, true, constants, i, j, out);
}

/* Each kernel, each form. */
#define CHUNKS(name, form, members)                                                                         \
  KITH_HOT static void pairs_##form##_##name(void *pass, kith_index begin, kith_index end,                  \
                                             struct kith_scratch *s) {                                      \
    kith_force_pairs_chunk(pair_##form, KITH_KERNEL_##name, members, pass, begin, end, s);                  \
  }                                                                                                         \
  KITH_HOT static void nodes_##form##_##name(void *pass, kith_index begin, kith_index end,                  \
                                             struct kith_scratch *s) {                                      \
    kith_force_nodes_chunk(pair_##form, KITH_KERNEL_##name, members, 0, pass, begin, end, s);               \
  }
#define X(name, ...) CHUNKS(name, plain, CRK_PLAIN) CHUNKS(name, sloped, CRK_SLOPED)
KITH_KERNEL_LIST(X)
#undef X

static const kith_chunk_pass pairs[][KITH_N_KERNELS] = {
#define X(name, ...) pairs_plain_##name,
    {KITH_KERNEL_LIST(X)},
#undef X
#define X(name, ...) pairs_sloped_##name,
    {KITH_KERNEL_LIST(X)},
#undef X
};
static const kith_chunk_pass nodes[][KITH_N_KERNELS] = {
#define X(name, ...) nodes_plain_##name,
    {KITH_KERNEL_LIST(X)},
#undef X
#define X(name, ...) nodes_sloped_##name,
    {KITH_KERNEL_LIST(X)},
#undef X
};

static void pack(const struct kith_package *package, kith_index i, double *restrict record) {
  const struct kith_hydro *hydro = package->hydro;
  const struct crk *crk = package->self;
  const size_t at = (size_t)i * NDIM;
  const double support = hydro->nodes->support->f64[i];
  const double volume = kith_ball() * kith_pow_dim(support) / package->neighbors;
  for (int a = 0; a < NDIM; ++a) {
    record[KITH_RECORD_X + a] = hydro->nodes->position->f64[at + a];
    record[KITH_RECORD_V + a] = hydro->velocity->f64[at + a];
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
  if (crk->shear == NULL) return;
  for (int k = 0; k < KITH_SYMMETRIC_SIZE; ++k)
    record[CRK_SHEAR + k] = crk->shear->f64[(size_t)i * KITH_SYMMETRIC_SIZE + k];
}

kith_status crk_pairs(struct kith_package *package, const struct kith_connectivity *connectivity) {
  const struct crk *crk = package->self;
  const int form = crk->shear != NULL, size = form ? CRK_SLOPED : CRK_PLAIN;
  const bool viscous = package->viscosity != KITH_VISCOSITY_NONE;
  const struct crk_constants constants = {.alpha = viscous ? package->alpha : 0,
                                          .beta = viscous ? package->beta : 0,
                                          .volume = crk_volume(package),
                                          .spacings = pow(package->neighbors / kith_ball(), 1.0 / NDIM)};
  KITH_TRY(kith_force_records(package, size));
  kith_profile_begin(package->profile, "records");
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < kith_nodes_count(package->hydro->nodes); ++i)
    pack(package, i, package->record + (size_t)i * (size_t)size);
  kith_profile_end(package->profile);
  struct kith_force_pass pass = {
      .package = package, .connectivity = connectivity, .rows = &connectivity->rows, .constants = &constants};
  return kith_force(&pass, pairs[form], nodes[form], size, 0);
}
