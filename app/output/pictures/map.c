/* map.c - every node adds to the pixels around it. */
#include "app/output/pictures/map.h"

#include "lib/comm/ranks.h"

enum { LONG_SIDE = 480 };

static double spacing(const struct kith_profile_view *nodes, kith_index i) {
  return pow(nodes->mass[i] / nodes->density[i], 1.0 / NDIM);
}

struct kith_map kith_map_of(const struct kith_profile_view *nodes, int normal, double at) {
  struct kith_map map = {.normal = NDIM == 3 && isfinite(at) ? normal : -1, .at = at, .across = {0, 1}};
  double longest = 0;
  if (NDIM == 3) map.across[0] = normal == 0, map.across[1] = 2 - (normal == 2);
  for (int k = 0; k < 2; ++k) {
    double lower = INFINITY, upper = -INFINITY;
    for (kith_index i = 0; i < nodes->n; ++i) {
      const double x = nodes->position[(size_t)i * NDIM + map.across[k]], half = 0.5 * spacing(nodes, i);
      if (isfinite(x) && isfinite(half)) lower = KITH_MIN(lower, x - half), upper = KITH_MAX(upper, x + half);
    }
    kith_ranks_min(nodes->ranks, &lower, 1);
    kith_ranks_max(nodes->ranks, &upper, 1);
    if (!(lower < upper)) lower = 0, upper = 1;
    map.lower[k] = lower, map.size[k] = upper - lower;
    longest = KITH_MAX(longest, upper - lower);
  }
  for (int k = 0; k < 2; ++k) {
    map.pixels[k] = KITH_MAX(1, (int)rint(LONG_SIDE * map.size[k] / longest));
    map.size[k] /= map.pixels[k];
  }
  return map;
}

/* Finds the pixels whose middles are nearer to x than `reach`, along axis k of the map: first to last - 1. */
static void pixels_near(const struct kith_map *map, int k, double x, double reach, int *first, int *last) {
  const double place = (x - map->lower[k]) / map->size[k] - 0.5, near = reach / map->size[k];
  *first = (int)KITH_MAX(0, ceil(place - near));
  *last = (int)KITH_MIN(map->pixels[k], floor(place + near) + 1);
}

static void add(const struct kith_map *map, const double *x, double reach, double volume, double value,
                double *sum) {
  const double depth = map->normal >= 0 ? x[map->normal] - map->at : 0;
  int first[2], last[2];
  if (!(fabs(depth) < reach) || !isfinite(value)) return;
  for (int k = 0; k < 2; ++k) pixels_near(map, k, x[map->across[k]], reach, &first[k], &last[k]);
  for (int j = first[1]; j < last[1]; ++j)
    for (int i = first[0]; i < last[0]; ++i) {
      const double dx = map->lower[0] + (i + 0.5) * map->size[0] - x[map->across[0]],
                   dy = map->lower[1] + (j + 0.5) * map->size[1] - x[map->across[1]];
      const double q = 1 - (dx * dx + dy * dy + depth * depth) / (reach * reach);
      double *pixel = sum + 2 * ((size_t)j * (size_t)map->pixels[0] + (size_t)i);
      if (q <= 0) continue;
      pixel[0] += volume * q * q * q * value;
      pixel[1] += volume * q * q * q;
    }
}

kith_status kith_map_draw(const struct kith_map *map, const struct kith_profile_view *nodes, const double *of,
                          float *value) {
  const size_t n = (size_t)map->pixels[0] * (size_t)map->pixels[1];
  const double pixel = 0.75 * KITH_MAX(map->size[0], map->size[1]);
  double *sum = NULL;
  KITH_TRY(kith_ranks_allreduce_status(nodes->ranks, kith_resize(&sum, 0, 2 * n, sizeof *sum)));
  for (kith_index i = 0; i < nodes->n; ++i) {
    const double s = spacing(nodes, i);
    if (isfinite(s))
      add(map, nodes->position + (size_t)i * NDIM, KITH_MAX(2 * s, pixel), pow(s, NDIM), of[i], sum);
  }
  kith_ranks_sum(nodes->ranks, sum, (int)(2 * n));
  for (size_t k = 0; k < n; ++k) value[k] = sum[2 * k + 1] > 0 ? (float)(sum[2 * k] / sum[2 * k + 1]) : NAN;
  kith_free(&sum);
  return KITH_OK;
}
