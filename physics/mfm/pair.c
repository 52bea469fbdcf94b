/* The Riemann problem of a pair, and the records it reads. */
#include <math.h>
#include <stdlib.h>
#include "lib/core/vec.h"
#include "physics/mfm/mfm.h"
#include "physics/mfm/riemann.h"

extern int mfm_limiter_experiment;
int mfm_limiter_experiment;

/* L of (3). */
KITH_INLINE double limited(double a, double d, int kind) {
  const double b = 2 * a - d; /* behind */
  const double vl = b * d > 0 ? 2 * b * d / (b + d) : 0;
  const double sign = d > 0 ? 1 : -1, mc0 = KITH_MIN(KITH_MIN(sign * a, 2 * sign * b), 2 * sign * d),
               mc = sign * KITH_MAX(mc0, 0.0);
  const double mm = b * d > 0 ? sign * KITH_MIN(sign * b, sign * d) : 0;
  const double va = b * d > 0 ? b * d * (b + d) / (b * b + d * d) : 0;
  const double cl = sign * KITH_MAX(KITH_MIN(sign * a, sign * d), 0.0); /* clamp to the pair */
  const double cl2 = sign * KITH_MAX(KITH_MIN(sign * a, 1.5 * sign * d), -0.5 * sign * d);
  return kind == 0   ? vl
         : kind == 1 ? mc
         : kind == 2 ? mm
         : kind == 3 ? va
         : kind == 4 ? cl
         : kind == 5 ? a
         : kind == 6 ? cl2
                     : 0;
}

KITH_INLINE void mfm_pair(enum kith_kernel kernel, const void *constants, const double *restrict i,
                          const double *restrict j, double *restrict out) {
  const int kind = *(const int *)constants;
  (void)kernel;
  double d[NDIM], n[NDIM], area2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    d[a] = J(KITH_RECORD_X + a) - i[KITH_RECORD_X + a];
    area2 += J(MFM_AREA + a) * J(MFM_AREA + a);
  }
  const double area = sqrt(area2), per_area = 1 / KITH_MAX(area, 1e-300);
  for (int a = 0; a < NDIM; ++a) n[a] = J(MFM_AREA + a) * per_area;

  double drho_i = 0, drho_j = 0, dp_i = 0, dp_j = 0, du_i = 0, du_j = 0, du = 0;
  for (int a = 0; a < NDIM; ++a) {
    drho_i += i[MFM_DENSITY_SLOPE + a] * d[a], drho_j += J(MFM_DENSITY_SLOPE + a) * d[a];
    dp_i += i[MFM_PRESSURE_SLOPE + a] * d[a], dp_j += J(MFM_PRESSURE_SLOPE + a) * d[a];
    du += n[a] * (J(KITH_RECORD_V + a) - i[KITH_RECORD_V + a]);
    for (int b = 0; b < NDIM; ++b) {
      const double nd = n[a] * d[b];
      du_i += i[MFM_VELOCITY_SLOPE + a * NDIM + b] * nd, du_j += J(MFM_VELOCITY_SLOPE + a * NDIM + b) * nd;
    }
  }
  const double drho = J(MFM_DENSITY) - i[MFM_DENSITY], dp = J(MFM_PRESSURE) - i[MFM_PRESSURE];
  const double rho_l = i[MFM_DENSITY] + 0.5 * limited(drho_i, drho, kind),
               rho_r = J(MFM_DENSITY) - 0.5 * limited(drho_j, drho, kind);
  const double more_l = 0.5 * limited(dp_i, dp, kind), more_r = -0.5 * limited(dp_j, dp, kind);
  const double bulk_l = i[MFM_BULK] + i[MFM_GAMMA] * more_l, bulk_r = J(MFM_BULK) + J(MFM_GAMMA) * more_r;
  const struct mfm_side l = {rho_l, 0.5 * (limited(du_i, du, kind) - du), i[MFM_PRESSURE] + more_l,
                             sqrt(KITH_MAX(bulk_l, 0.0) / rho_l), i[MFM_GAMMA]};
  const struct mfm_side r = {rho_r, 0.5 * (du - limited(du_j, du, kind)), J(MFM_PRESSURE) + more_r,
                             sqrt(KITH_MAX(bulk_r, 0.0) / rho_r), J(MFM_GAMMA)};
  const struct mfm_star star = mfm_riemann(l, r);
  for (int a = 0; a < NDIM; ++a) OUT(KITH_FORCE + a) = -star.pressure * J(MFM_AREA + a);
  OUT(KITH_SHARE) = 0.5;
  OUT(KITH_EXCHANGE) = -star.pressure * area * star.velocity;
  OUT(KITH_SIGNAL) = area > 0 ? 0.5 * (l.sound + r.sound) + KITH_MAX(-du, 0.0) : 0;
}

/* Pairs with their faces, as kith_force_pairs_chunk without. */
KITH_HOT static void pairs(void *context, kith_index begin, kith_index end, struct kith_scratch *s) {
  const struct kith_force_pass *pass = context;
  const struct mfm *mfm = pass->package->self;
  const struct kith_pairs *list = &pass->connectivity->pairs;
  const double *restrict out = kith_lane(s, MFM_MEMBERS + NDIM);
  for (kith_index i = begin; i < end; ++i)
    for (size_t p = list->first[i]; p < list->first[i + 1]; p += KITH_BLOCK) {
      const size_t n = KITH_MIN(list->first[i + 1] - p, (size_t)KITH_BLOCK);
      kith_force_load(pass, MFM_MEMBERS, NDIM, i, &list->node[p][1], 2, n, mfm->faces.area + p * NDIM, s);
      kith_force_evaluate(mfm_pair, KITH_N_KERNELS, MFM_MEMBERS, NDIM, pass, i, n, s);
      double *restrict value = pass->package->pair.value + p * KITH_PAIR_VALUES;
      for (size_t k = 0; k < n; ++k)
        for (int m = 0; m < KITH_PAIR_VALUES; ++m)
          value[k * KITH_PAIR_VALUES + m] = out[(size_t)m * KITH_STRIDE + k];
    }
}

KITH_HOT static void nodes(void *pass, kith_index begin, kith_index end, struct kith_scratch *s) {
  kith_force_nodes_chunk(mfm_pair, KITH_N_KERNELS, MFM_MEMBERS, NDIM, pass, begin, end, s);
}

/* (gamma + 1) / 2 is how steep a shock is; of an isothermal gas 1. */
static double gamma_of(const struct kith_material *material) {
  return material->eos == &kith_eos_isothermal ? 1 : material->parameters.gamma;
}

static void pack(const struct kith_package *package, kith_index i, double *restrict record) {
  const struct kith_hydro *hydro = package->hydro;
  const struct mfm *mfm = package->self;
  const double c = hydro->sound_speed->f64[i];
  const size_t at = (size_t)i * NDIM;
  for (int a = 0; a < NDIM; ++a) {
    record[KITH_RECORD_X + a] = hydro->nodes->position->f64[at + a];
    record[KITH_RECORD_V + a] = hydro->velocity->f64[at + a];
    record[MFM_DENSITY_SLOPE + a] = mfm->density_slope->f64[at + a];
    record[MFM_PRESSURE_SLOPE + a] = mfm->pressure_slope->f64[at + a];
  }
  for (int k = 0; k < NDIM * NDIM; ++k)
    record[MFM_VELOCITY_SLOPE + k] = mfm->velocity_slope->f64[at * NDIM + k];
  record[MFM_DENSITY] = hydro->density->f64[i];
  record[MFM_PRESSURE] = hydro->pressure->f64[i];
  record[MFM_BULK] = hydro->density->f64[i] * c * c;
  record[MFM_GAMMA] = gamma_of(&hydro->material[hydro->nodes->list->u8[i]]);
}

kith_status mfm_pairs(struct kith_package *package) {
  static const kith_chunk_pass pairs_of[] = {
#define X(name, ...) pairs,
      KITH_KERNEL_LIST(X)};
#undef X
  static const kith_chunk_pass nodes_of[] = {
#define X(name, ...) nodes,
      KITH_KERNEL_LIST(X)
#undef X
  };
  struct mfm *mfm = package->self;
  KITH_TRY(kith_force_records(package, MFM_MEMBERS));
  kith_profile_begin(package->profile, "records");
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < kith_nodes_count(package->hydro->nodes); ++i)
    pack(package, i, package->record + (size_t)i * MFM_MEMBERS);
  kith_profile_end(package->profile);
  if (getenv("LIM")) mfm_limiter_experiment = atoi(getenv("LIM"));
  if (package->traversal == KITH_TRAVERSE_GATHER) KITH_TRY(mfm_faces_edges(&mfm->faces));
  struct kith_force_pass pass = {.package = package,
                                 .connectivity = &mfm->faces.graph,
                                 .rows = &mfm->faces.graph.rows,
                                 .constants = &mfm_limiter_experiment,
                                 .edge = mfm->faces.edge};
  return kith_force(&pass, pairs_of, nodes_of, MFM_MEMBERS, NDIM);
}
