/* The Riemann problem of a pair, and the records it reads. */
#include <math.h>
#include "lib/core/vec.h"
#include "physics/mfm/mfm.h"
#include "physics/mfm/riemann.h"

/* L of (4). */
KITH_INLINE double limited(double slope, double difference) {
  const double most = fabs(difference), sign = difference > 0 ? 1 : -1;
  return sign * KITH_MAX(KITH_MIN(sign * slope, 1.5 * most), -most);
}

/* The same of what must stay positive: no more than half of it, q / 2, is taken away. */
KITH_INLINE double limited_down(double q, double slope, double difference) {
  return KITH_MAX(limited(slope, difference), -q);
}

/* The state of one end at the middle of the pair, from the slopes and differences towards the other end; u: velocity along the face. */
KITH_INLINE struct mfm_side reconstruct(double density, double pressure, double bulk, double gamma, double u,
                                        const double *slope, const double *difference) {
  struct mfm_side s = {.gamma = gamma};
  const double more = 0.5 * limited_down(bulk / gamma, slope[1], difference[1]);
  s.density = density + 0.5 * limited_down(density, slope[0], difference[0]);
  s.pressure = pressure + more;
  s.velocity = u + 0.5 * limited(slope[2], difference[2]);
  s.sound = sqrt((bulk + gamma * more) /
                 s.density); /* of ideal, stiffened and isothermal gases rho c^2 = gamma P + a constant */
  return s;
}

/* (3), which who loses `heat` gets back. In a stiffened gas all pressures count from -p0, where its sound speed is 0. */
KITH_INLINE double spared(double pressure, double own, double face, double heat) {
  const double total = face + own - pressure;
  return total > 4 * own ? KITH_MAX(-heat, 0.0) * (1 - 4 * own / total) : 0;
}

KITH_INLINE void mfm_pair(enum kith_kernel kernel, const void *constants, const double *restrict i,
                          const double *restrict j, double *restrict out) {
  double d[NDIM], n[NDIM], area2 = 0, slope_i[3] = {0}, slope_j[3] = {0}, du = 0;
  (void)kernel, (void)constants;
  for (int a = 0; a < NDIM; ++a) {
    d[a] = J(KITH_RECORD_X + a) - i[KITH_RECORD_X + a];
    area2 += J(MFM_AREA + a) * J(MFM_AREA + a);
  }
  const double area = sqrt(area2), per_area = 1 / KITH_MAX(area, 1e-300);
  for (int a = 0; a < NDIM; ++a) n[a] = J(MFM_AREA + a) * per_area;
  for (int a = 0; a < NDIM; ++a) {
    slope_i[0] += i[MFM_DENSITY_SLOPE + a] * d[a], slope_j[0] -= J(MFM_DENSITY_SLOPE + a) * d[a];
    slope_i[1] += i[MFM_PRESSURE_SLOPE + a] * d[a], slope_j[1] -= J(MFM_PRESSURE_SLOPE + a) * d[a];
    du += n[a] * (J(KITH_RECORD_V + a) - i[KITH_RECORD_V + a]);
    for (int b = 0; b < NDIM; ++b) {
      slope_i[2] += i[MFM_VELOCITY_SLOPE + a * NDIM + b] * n[a] * d[b];
      slope_j[2] -= J(MFM_VELOCITY_SLOPE + a * NDIM + b) * n[a] * d[b];
    }
  }
  const double drho = J(MFM_DENSITY) - i[MFM_DENSITY], dp = J(MFM_PRESSURE) - i[MFM_PRESSURE];
  const double there[] = {drho, dp, du}, back[] = {-drho, -dp, -du};
  const struct mfm_side l =
      reconstruct(i[MFM_DENSITY], i[MFM_PRESSURE], i[MFM_BULK], i[MFM_GAMMA], -0.5 * du, slope_i, there);
  const struct mfm_side r =
      reconstruct(J(MFM_DENSITY), J(MFM_PRESSURE), J(MFM_BULK), J(MFM_GAMMA), 0.5 * du, slope_j, back);
  const struct mfm_star star = mfm_riemann(l, r);
  for (int a = 0; a < NDIM; ++a) OUT(KITH_FORCE + a) = -star.pressure * J(MFM_AREA + a);
  OUT(KITH_SHARE) = 0.5;
  const double push = star.pressure * area, face = star.pressure;
  OUT(KITH_EXCHANGE) =
      -push * star.velocity +
      spared(i[MFM_PRESSURE], i[MFM_BULK] / i[MFM_GAMMA], face, -push * (0.5 * du + star.velocity)) -
      spared(J(MFM_PRESSURE), J(MFM_BULK) / J(MFM_GAMMA), face, -push * (0.5 * du - star.velocity));
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
  kith_force_pack(hydro, i, record);
  for (int a = 0; a < NDIM; ++a) {
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
  if (package->traversal == KITH_TRAVERSE_GATHER) KITH_TRY(mfm_faces_edges(&mfm->faces));
  struct kith_force_pass pass = {.package = package,
                                 .pack = pack,
                                 .connectivity = &mfm->faces.graph,
                                 .rows = &mfm->faces.graph.rows,
                                 .edge = mfm->faces.edge,
                                 .walls_known = true};
  return kith_force(&pass, pairs_of, nodes_of, MFM_MEMBERS, NDIM);
}
