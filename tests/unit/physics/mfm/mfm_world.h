/* mfm_world.h - for tests of faces: nodes in a box of unit cells with reflecting or periodic sides, their
 * connectivity, and all images of all nodes, enumerated here for slow sums. */
#ifndef KITH_TEST_PHYSICS_MFM_WORLD_H
#define KITH_TEST_PHYSICS_MFM_WORLD_H

#include <stdlib.h>
#include <string.h>
#include "boundaries/boundary.h"
#include "tests/unit/physics/kernel_oracle.h"
#include "physics/mfm/faces.h"
#include "tests/check.h"

enum side { OPEN, PERIODIC, REFLECTING };

/* An image of a node: x = sign x_node + shift. */
struct point {
  int node;
  double x[NDIM], sign[NDIM];
};

struct cells {
  struct kith_nodes *nodes;
  struct kith_boundaries boundaries;
  struct kith_search *search;
  struct kith_connectivity *connectivity;
  enum side side[NDIM];
  double length[NDIM], neighbors;
  enum kith_kernel kernel;
  struct oracle_kernel oracle;
  int n, n_points;
  struct point *point; /* the first n are the nodes */
};

static inline double cells_image(const struct cells *c, int a, double x, int image) {
  const double moved = c->side[a] == REFLECTING && image % 2 != 0 ? c->length[a] - x : x;
  return moved + image * c->length[a];
}

/* Lists all images within `range` of the box. */
static inline void cells_points(struct cells *c, double range) {
  int most[3] = {0}, count = 1;
  for (int a = 0; a < NDIM; ++a) {
    most[a] = c->side[a] == OPEN ? 0 : (int)ceil(range / c->length[a]) + 1;
    count *= 2 * most[a] + 1;
  }
  free(c->point);
  c->point = malloc((size_t)(count * c->n) * sizeof *c->point);
  c->n_points = 0;
  for (int pass = 0; pass < 2; ++pass) /* nodes come first */
    for (int i = 0; i < c->n; ++i)
      for (int k0 = -most[0]; k0 <= most[0]; ++k0)
        for (int k1 = -most[1]; k1 <= most[1]; ++k1)
          for (int k2 = -most[2]; k2 <= most[2]; ++k2) {
            const int image[3] = {k0, k1, k2};
            struct point p = {.node = i};
            bool near = (k0 == 0 && k1 == 0 && k2 == 0) == (pass == 0);
            for (int a = 0; a < NDIM; ++a) {
              p.x[a] = cells_image(c, a, c->nodes->position->f64[i * NDIM + a], image[a]);
              p.sign[a] = c->side[a] == REFLECTING && image[a] % 2 != 0 ? -1 : 1;
              near = near && p.x[a] > -range && p.x[a] < c->length[a] + range;
            }
            if (near) c->point[c->n_points++] = p;
          }
}

static inline double cells_distance(const struct cells *c, int p, int q) {
  return sqrt(kith_distance2(c->point[p].x, c->point[q].x));
}

/* Computes supports from sum w = neighbors / (ball C) over all images, by bisection. */
static inline void cells_supports(struct cells *c) {
  const double mean = pow(c->neighbors / oracle_ball(), 1.0 / NDIM); /* one node per unit volume */
  const double self = kith_kernel_self_weight(c->kernel, c->neighbors) * oracle_w(&c->oracle, 0);
  cells_points(c, 3 * mean);
  for (int i = 0; i < c->n; ++i) {
    double lower = 0, upper = 3 * mean;
    for (int k = 0; k < 60; ++k) {
      const double h = 0.5 * (lower + upper);
      double sum = self;
      for (int p = 0; p < c->n_points; ++p)
        if (p != i && cells_distance(c, i, p) < h) sum += oracle_w(&c->oracle, cells_distance(c, i, p) / h);
      if (sum < c->neighbors / (oracle_ball() * c->oracle.constant))
        lower = h;
      else
        upper = h;
    }
    c->nodes->support->f64[i] = 0.5 * (lower + upper);
  }
}

static inline double cells_volume(const struct cells *c, int node) {
  return oracle_ball() * kith_pow_dim(c->nodes->support->f64[node]) / c->neighbors;
}

/* Builds ghosts, search and neighbor lists. */
static inline void cells_connect(struct cells *c, struct kith_requirements need, double reach) {
  for (int i = 0; i < c->n; ++i) c->nodes->search_radius->f64[i] = reach * c->nodes->support->f64[i];
  ++c->nodes->positions;
  CHECK_OK(kith_boundaries_ghosts(&c->boundaries, c->nodes, need.overlap ? 2 : 1, NULL));
  CHECK_OK(kith_search_update(c->search));
  CHECK_OK(kith_connectivity_build(c->connectivity, c->nodes, c->search, need, NULL, NULL));
}

/* Creates count[a] unit cells along axis a with one node each, at most `jitter` off its center along each
 * axis. */
static inline void cells_create(struct cells *c, const int *count, const enum side *side, double jitter,
                                enum kith_kernel kernel, double neighbors, uint64_t seed) {
  static const char *const names[] = {"gas"};
  memset(c, 0, sizeof *c);
  c->kernel = kernel, c->neighbors = neighbors, c->oracle = oracle_kernel(kernel), c->n = 1;
  CHECK_OK(kith_nodes_create(&c->nodes, 1, names));
  CHECK_OK(kith_search_create(&c->search, kith_search_find("tree"), c->nodes));
  CHECK_OK(kith_connectivity_create(&c->connectivity));
  for (int a = 0; a < NDIM; ++a) {
    c->n *= count[a], c->length[a] = count[a], c->side[a] = side[a];
    if (side[a] != OPEN)
      CHECK_OK(kith_boundaries_add(&c->boundaries,
                                   kith_boundary_find(side[a] == PERIODIC ? "periodic" : "reflecting"), a, 0,
                                   count[a], true, true));
  }
  CHECK_OK(kith_nodes_append(c->nodes, 0, c->n, NULL));
  for (int i = 0; i < c->n; ++i) {
    int cell = i;
    for (int a = 0; a < NDIM; cell /= count[a], ++a)
      c->nodes->position->f64[i * NDIM + a] = cell % count[a] + 0.5 + jitter * (2 * check_random(&seed) - 1);
    c->nodes->id->i64[i] = 100 + i;
  }
  cells_supports(c);
}

static inline void cells_destroy(struct cells *c) {
  free(c->point);
  kith_boundaries_clear(&c->boundaries);
  kith_connectivity_destroy(&c->connectivity);
  kith_search_destroy(&c->search);
  kith_nodes_destroy(&c->nodes);
}

/* Returns the point that is the position of node or ghost j. */
static inline int cells_point_of(const struct cells *c, kith_index j) {
  const double *x = c->nodes->position->f64 + (size_t)j * NDIM;
  const int node = (int)(c->nodes->id->i64[j] - 100);
  for (int p = 0; p < c->n_points; ++p)
    if (c->point[p].node == node && kith_distance2(c->point[p].x, x) < 1e-20) return p;
  CHECK(false);
  return 0;
}

#endif
