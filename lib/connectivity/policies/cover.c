/* Whether neighbor lists still hold every significant pair: the bound of cover.h, with exact sums. */
#include "lib/connectivity/policies/cover.h"

#include <float.h>
#include <string.h>
#include "lib/comm/sum.h"
#include "lib/core/vec.h"

/* Indices of cover->measured. MOVED: max |d_i|. LACKING: max of H_i + |d_i| - R_i. CHANGED: 1 if the number
 * of nodes changed. FAR: 1 if the common drift is beyond half a period. */
enum { MOVED, LACKING, CHANGED, FAR, MEASURED };

/* Where node i is, or will be `ahead`. */
static void position_of(const struct kith_cover *cover, const struct kith_nodes *nodes, kith_index i,
                        double *x) {
  for (int a = 0; a < NDIM; ++a) {
    x[a] = nodes->position->f64[(size_t)i * NDIM + a];
    if (cover->ahead > 0) x[a] += cover->ahead * cover->velocity->f64[(size_t)i * NDIM + a];
  }
}

/* Adds the vectors of n nodes. */
static void sum_vectors(kith_index n, void (*vector)(const void *context, kith_index i, double *x),
                        const void *context, struct kith_sum total[NDIM]) {
#pragma omp parallel if (n > KITH_FEW)
  {
    struct kith_sum mine[NDIM] = {0};
    double x[NDIM];
#pragma omp for schedule(static) nowait
    for (kith_index i = 0; i < n; ++i) {
      vector(context, i, x);
      for (int a = 0; a < NDIM; ++a) kith_sum_add(&mine[a], x[a]);
    }
#pragma omp critical(kith_mean_vector)
    for (int a = 0; a < NDIM; ++a) kith_sum_join(&total[a], &mine[a]);
  }
}

void kith_mean_vector(const struct kith_nodes *nodes,
                      void (*vector)(const void *context, kith_index i, double *x), const void *context,
                      double mean[NDIM]) {
  struct kith_sum total[NDIM] = {0};
  uint64_t n = (uint64_t)nodes->n_internal;
  struct kith_shared parts[NDIM + 1] = {{KITH_SHARE_SUM, 1, &n}};
  sum_vectors(nodes->n_internal, vector, context, total);
  for (int a = 0; a < NDIM; ++a) parts[1 + a] = kith_sum_shared(&total[a]);
  kith_ranks_agree(nodes->ranks, KITH_OK, NDIM + 1, parts);
  for (int a = 0; a < NDIM; ++a) mean[a] = n > 0 ? kith_sum_value(&total[a]) / (double)n : 0;
}

struct measured {
  const struct kith_cover *cover;
  const struct kith_nodes *nodes;
};

/* x - x0 of node i, up to the whole periods that bring it near the reference: one node's when it was last
 * measured. So the mean of a drift beyond half a period is one drift, and not two of opposite sign. */
static void path_of(const void *context, kith_index i, double *d) {
  const struct kith_cover *cover = ((const struct measured *)context)->cover;
  position_of(cover, ((const struct measured *)context)->nodes, i, d);
  for (int a = 0; a < NDIM; ++a) {
    d[a] -= cover->position[(size_t)i * NDIM + (size_t)a];
    if (cover->period[a] > 0)
      d[a] -= cover->period[a] * nearbyint((d[a] - cover->reference[a]) / cover->period[a]);
  }
}

/* The mean displacement of n nodes, where it may be subtracted, and the next reference: the displacement of
 * the node with the lowest id. Collective. */
static void common_drift(struct kith_cover *cover, const struct kith_nodes *nodes, kith_index n,
                         double *drift) {
  const struct measured at = {cover, nodes};
  const int64_t *restrict id = nodes->id->i64;
  struct kith_sum total[NDIM] = {0};
  struct {
    double none;
    int64_t id;
    double path[NDIM];
  } node = {.id = INT64_MAX};
  uint64_t count = (uint64_t)n;
  struct kith_shared parts[NDIM + 2] = {{KITH_SHARE_SUM, 1, &count},
                                        {KITH_SHARE_LEAST, sizeof node / 8, &node}};
  kith_index first = 0;
  for (kith_index i = 1; i < n; ++i) first = id[i] < id[first] ? i : first;
  if (n > 0) node.id = id[first], path_of(&at, first, node.path);
  sum_vectors(n, path_of, &at, total);
  for (int a = 0; a < NDIM; ++a) parts[2 + a] = kith_sum_shared(&total[a]);
  kith_ranks_agree(nodes->ranks, KITH_OK, NDIM + 2, parts);
  memcpy(cover->reference, node.path, sizeof node.path);
  for (int a = 0; a < NDIM; ++a)
    drift[a] = cover->still[a] == 0 && count > 0 ? kith_sum_value(&total[a]) / (double)count : 0;
}

/* The length of x - x0 - drift, up to whole periods, and its rounding; 0 only if the node is where it was. */
static double moved(const struct kith_cover *cover, const double *x, const double *x0, const double *drift,
                    double support) {
  double d[NDIM], largest = support;
  bool same = true;
  for (int a = 0; a < NDIM; ++a) {
    d[a] = x[a] - x0[a] - drift[a];
    if (cover->period[a] > 0) d[a] -= cover->period[a] * nearbyint(d[a] / cover->period[a]);
    same = same && x[a] == x0[a] && drift[a] == 0;
    largest = KITH_MAX(largest, fabs(x[a]) + fabs(x0[a]) + fabs(drift[a]));
  }
  return same ? 0 : kith_norm(d) + 8 * DBL_EPSILON * largest;
}

void kith_cover_measure(struct kith_cover *cover, const struct kith_nodes *nodes) {
  const bool same = cover->n == nodes->n_internal;
  const kith_index n = same ? cover->n : 0;
  double drift[NDIM], farthest = 0, lacking = -INFINITY;
  common_drift(cover, nodes, n, drift);
#pragma omp parallel for schedule(static) reduction(max : farthest, lacking) if (n > KITH_FEW)
  for (kith_index i = 0; i < n; ++i) {
    double x[NDIM], h = nodes->support->f64[i];
    if (cover->ahead > 0) h *= exp(cover->ahead * fmax(cover->velocity_divergence->f64[i], 0) / NDIM);
    position_of(cover, nodes, i, x);
    const double far = moved(cover, x, cover->position + (size_t)i * NDIM, drift, h),
                 lack = h + far - cover->search_radius[i];
    farthest = KITH_MAX(farthest, far);
    lacking = KITH_MAX(lacking, isnan(lack) ? INFINITY : lack); /* NaN covers nothing */
  }
  cover->measured[MOVED] = farthest, cover->measured[LACKING] = lacking;
  cover->measured[CHANGED] = !same, cover->measured[FAR] = 0;
  for (int a = 0; a < NDIM; ++a) /* nodes must be put back into the box: images reach only so far */
    if (cover->period[a] > 0 && fabs(drift[a]) > 0.5 * cover->period[a]) cover->measured[FAR] = 1;
}

struct kith_shared kith_cover_shared(struct kith_cover *cover) {
  return (struct kith_shared){KITH_SHARE_MAX, MEASURED, cover->measured};
}

bool kith_cover_holds(const struct kith_cover *cover) {
  return cover->measured[CHANGED] == 0 && cover->measured[MOVED] + cover->measured[LACKING] <= 0;
}

bool kith_cover_far(const struct kith_cover *cover) {
  return cover->measured[FAR] != 0;
}

/* Ghosts of other ranks are nodes there, or images of nodes there: their ranks tell of mirrors. */
static void find_mirrors(struct kith_cover *cover, const struct kith_nodes *nodes) {
  for (int a = 0; a < NDIM; ++a) {
    cover->still[a] = 0;
    for (int b = 0; b < nodes->n_blocks; ++b) {
      const struct kith_ghost_block *block = &nodes->blocks[b];
      if (block->kind == KITH_GHOST_FROZEN || (block->kind == KITH_GHOST_IMAGE && block->image.sign[a] < 0))
        cover->still[a] = 1;
    }
  }
}

kith_status kith_cover_snapshot(struct kith_cover *cover, const struct kith_nodes *nodes) {
  const size_t n = (size_t)nodes->n_internal;
  KITH_TRY(kith_reserve(&cover->position, &cover->capacity, n * (NDIM + 1), sizeof(double)));
  find_mirrors(cover, nodes);
  memset(cover->reference, 0, sizeof cover->reference);
  cover->n = nodes->n_internal;
  cover->search_radius = cover->position + n * NDIM;
  if (n > 0) memcpy(cover->position, nodes->position->f64, n * NDIM * sizeof(double));
  if (n > 0) memcpy(cover->search_radius, nodes->search_radius->f64, n * sizeof(double));
  return KITH_OK;
}

void kith_cover_clear(struct kith_cover *cover) {
  kith_free(&cover->position);
  *cover = (struct kith_cover){0};
}
