/* Whether neighbor lists still hold every significant pair: the bound of cover.h, with exact sums. */
#include "lib/connectivity/policies/cover.h"

#include <float.h>
#include <string.h>
#include "lib/comm/sum.h"
#include "lib/connectivity/rows.h"
#include "lib/core/vec.h"

/* Where node i is, or will be `ahead`. */
static void position_of(const struct kith_cover *cover, const struct kith_nodes *nodes, kith_index i,
                        double *x) {
  for (int a = 0; a < NDIM; ++a) {
    x[a] = nodes->position->f64[(size_t)i * NDIM + a];
    if (cover->ahead > 0) x[a] += cover->ahead * cover->velocity->f64[(size_t)i * NDIM + a];
  }
}

static double support_of(const struct kith_cover *cover, const struct kith_nodes *nodes, kith_index i) {
  const double h = nodes->support->f64[i];
  return cover->ahead > 0 ? h * exp(cover->ahead * fmax(cover->velocity_divergence->f64[i], 0) / NDIM) : h;
}

/* x - x0 - drift, up to whole periods. */
static void displacement(const struct kith_cover *cover, const double *x, const double *x0,
                         const double *drift, double *d) {
  for (int a = 0; a < NDIM; ++a) {
    d[a] = x[a] - x0[a] - drift[a];
    if (cover->period[a] > 0) d[a] -= cover->period[a] * nearbyint(d[a] / cover->period[a]);
  }
}

/* The displacement of the node with the lowest id. */
static void first_drift(const struct kith_cover *cover, const struct kith_nodes *nodes, double *first) {
  const int64_t *restrict id = nodes->id->i64;
  int64_t least = INT64_MAX;
#pragma omp parallel for schedule(static) reduction(min : least) if (cover->n > KITH_FEW)
  for (kith_index i = 0; i < cover->n; ++i) least = KITH_MIN(least, id[i]);
  kith_index i = 0;
  while (i < cover->n && id[i] != least) ++i;
  struct {
    double none;
    int64_t id;
    double x[NDIM];
  } node = {.id = least};
  if (cover->n > 0) position_of(cover, nodes, i, node.x);
  for (int a = 0; cover->n > 0 && a < NDIM; ++a) node.x[a] -= cover->position[(size_t)i * NDIM + (size_t)a];
  const struct kith_shared shared = {KITH_SHARE_LEAST, sizeof node / 8, &node};
  kith_ranks_agree(nodes->ranks, KITH_OK, 1, &shared);
  memcpy(first, node.x, sizeof node.x);
}

void kith_mean_vector(const struct kith_nodes *nodes,
                      void (*vector)(const void *context, kith_index i, double *x), const void *context,
                      double mean[NDIM]) {
  struct kith_sum total[NDIM] = {0};
  uint64_t n = (uint64_t)nodes->n_internal;
#pragma omp parallel if (n > KITH_FEW)
  {
    struct kith_sum mine[NDIM] = {0};
    double x[NDIM];
#pragma omp for schedule(static) nowait
    for (kith_index i = 0; i < nodes->n_internal; ++i) {
      vector(context, i, x);
      for (int a = 0; a < NDIM; ++a) kith_sum_add(&mine[a], x[a]);
    }
#pragma omp critical(kith_mean_vector)
    for (int a = 0; a < NDIM; ++a) kith_sum_join(&total[a], &mine[a]);
  }
  struct kith_shared parts[NDIM + 1] = {{KITH_SHARE_SUM, 1, &n}};
  for (int a = 0; a < NDIM; ++a) parts[1 + a] = kith_sum_shared(&total[a]);
  kith_ranks_agree(nodes->ranks, KITH_OK, NDIM + 1, parts);
  for (int a = 0; a < NDIM; ++a) mean[a] = n > 0 ? kith_sum_value(&total[a]) / (double)n : 0;
}

struct from_first {
  const struct kith_cover *cover;
  const struct kith_nodes *nodes;
  double first[NDIM];
};

static void displacement_of(const void *context, kith_index i, double *d) {
  const struct from_first *from = context;
  double x[NDIM];
  position_of(from->cover, from->nodes, i, x);
  displacement(from->cover, x, from->cover->position + (size_t)i * NDIM, from->first, d);
}

/* The mean displacement, where it may be subtracted. The first node's comes first, so that the mean of a
 * drift beyond half a period is one drift and not two of opposite sign. */
static void common_drift(const struct kith_cover *cover, const struct kith_nodes *nodes, double *drift) {
  struct from_first from = {.cover = cover, .nodes = nodes};
  first_drift(cover, nodes, from.first);
  for (int a = 0; a < NDIM; ++a) from.first[a] = cover->drifts[a] ? from.first[a] : 0;
  kith_mean_vector(nodes, displacement_of, &from, drift);
  for (int a = 0; a < NDIM; ++a) drift[a] = cover->drifts[a] ? from.first[a] + drift[a] : 0;
}

/* How far node i moved, rounding included; 0 only if it is where it was. */
static double moved(const struct kith_cover *cover, const double *x, const double *x0, const double *drift,
                    double support) {
  double d[NDIM], largest = support;
  bool same = true;
  displacement(cover, x, x0, drift, d);
  for (int a = 0; a < NDIM; ++a) {
    same = same && x[a] == x0[a] && drift[a] == 0;
    largest = KITH_MAX(largest, fabs(x[a]) + fabs(x0[a]) + fabs(drift[a]));
  }
  return same ? 0 : kith_norm(d) + 8 * DBL_EPSILON * largest;
}

bool kith_cover_holds(const struct kith_cover *cover, const struct kith_nodes *nodes) {
  if (kith_ranks_any(nodes->ranks, cover->n != nodes->n_internal)) return false;
  if (cover->n == 0 && nodes->ranks == NULL) return true;
  double drift[NDIM], most = 0;
  common_drift(cover, nodes, drift);
#pragma omp parallel for schedule(static) reduction(max : most) if (cover->n > KITH_FEW)
  for (kith_index i = 0; i < cover->n; ++i) {
    double x[NDIM];
    position_of(cover, nodes, i, x);
    cover->moved[i] = moved(cover, x, cover->position + (size_t)i * NDIM, drift, support_of(cover, nodes, i));
    most = KITH_MAX(most, cover->moved[i]);
  }
  kith_ranks_max(nodes->ranks, &most, 1);
  int missing = 0;
#pragma omp parallel for schedule(static) reduction(| : missing) if (cover->n > KITH_FEW)
  for (kith_index i = 0; i < cover->n; ++i)
    missing |=
        !(support_of(cover, nodes, i) + cover->moved[i] + most <= cover->search_radius[i]); /* NaN: too */
  return missing == 0;
}

/* Ghosts of other ranks are nodes there, or images of nodes there: their ranks tell of mirrors. */
static void set_drifts(struct kith_cover *cover, const struct kith_nodes *nodes) {
  double still[NDIM];
  for (int a = 0; a < NDIM; ++a) {
    still[a] = 0;
    for (int b = 0; b < nodes->n_blocks; ++b) {
      const struct kith_ghost_block *block = &nodes->blocks[b];
      if (block->kind == KITH_GHOST_FROZEN || (block->kind == KITH_GHOST_IMAGE && block->image.sign[a] < 0))
        still[a] = 1;
    }
  }
  kith_ranks_max(nodes->ranks, still, NDIM);
  for (int a = 0; a < NDIM; ++a) cover->drifts[a] = still[a] == 0;
}

kith_status kith_cover_snapshot(struct kith_cover *cover, const struct kith_nodes *nodes) {
  const size_t n = (size_t)nodes->n_internal;
  const kith_status status = kith_reserve(&cover->position, &cover->capacity, n * (NDIM + 2), sizeof(double));
  KITH_TRY(kith_ranks_allreduce_status(nodes->ranks, status));
  set_drifts(cover, nodes);
  cover->n = nodes->n_internal;
  cover->search_radius = cover->position + n * NDIM;
  cover->moved = cover->search_radius + n;
  if (n > 0) memcpy(cover->position, nodes->position->f64, n * NDIM * sizeof(double));
  if (n > 0) memcpy(cover->search_radius, nodes->search_radius->f64, n * sizeof(double));
  return KITH_OK;
}

void kith_cover_clear(struct kith_cover *cover) {
  kith_free(&cover->position);
  *cover = (struct kith_cover){0};
}
