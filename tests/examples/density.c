/* density.c - the library alone: nodes of a periodic box, their ghosts, a neighbor search, rows and pairs,
 * and a sum over pairs. Prints the density of node 0, which is 1. For any dimension; see
 * app/manual/library.md. */
#include <math.h>
#include <stdio.h>
#include "boundaries/boundary.h"
#include "lib/connectivity/connectivity.h"
#include "lib/core/version.h"
#include "lib/neighbor/search.h"
#include "physics/kernel.h"

enum { N = 12, KERNEL = KITH_KERNEL_wendland_c2 }; /* nodes along an axis of the unit box */

static kith_status place_nodes(struct kith_nodes *nodes) {
  kith_index first, count = 1;
  for (int a = 0; a < NDIM; ++a) count *= N;
  KITH_TRY(kith_nodes_append(nodes, 0, count, &first));
  for (kith_index i = 0; i < count; ++i) {
    for (int a = 0, k = i; a < NDIM; ++a, k /= N) nodes->position->f64[i * NDIM + a] = (k % N + 0.5) / N;
    nodes->support->f64[i] = nodes->search_radius->f64[i] = 2.5 / N;
    nodes->id->i64[i] = i;
  }
  ++nodes->positions; /* must be changed whenever nodes move */
  return KITH_OK;
}

/* rho_i = sum_j m W(x_ij, H), each pair once: a pair of a node with a ghost counts for the node. */
static void sum_density(const struct kith_nodes *nodes, const struct kith_pairs *pairs, double *density) {
  const double constant = kith_kernel_constant(KERNEL), mass = pow(N, -NDIM);
  const double *x = nodes->position->f64, h = nodes->support->f64[0];
  double w, g;
  kith_kernel_value(KERNEL, 0, &w, &g);
  for (kith_index i = 0; i < nodes->n_internal; ++i) density[i] = mass * constant * w * pow(h, -NDIM);
  for (size_t p = 0; p < pairs->n; ++p) {
    const kith_index i = pairs->node[p][0], j = pairs->node[p][1];
    kith_kernel_value(KERNEL, sqrt(kith_distance2(&x[i * NDIM], &x[j * NDIM])) / h, &w, &g);
    density[i] += mass * constant * w * pow(h, -NDIM);
    if (j < nodes->n_internal) density[j] += mass * constant * w * pow(h, -NDIM);
  }
}

static kith_status run(struct kith_nodes *nodes, struct kith_boundaries *box, struct kith_search **search,
                       struct kith_connectivity *map, double **density) {
  KITH_TRY(place_nodes(nodes));
  for (int a = 0; a < NDIM; ++a)
    KITH_TRY(kith_boundaries_add(box, &kith_boundary_periodic, a, 0, 1, true, true));
  KITH_TRY(kith_boundaries_ghosts(box, nodes, 1, NULL));
  KITH_TRY(kith_search_create(search, kith_search_find("tree"), nodes));
  KITH_TRY(kith_search_update(*search));
  KITH_TRY(
      kith_connectivity_build(map, nodes, *search, (struct kith_requirements){.pairs = true}, NULL, NULL));
  KITH_TRY(kith_connectivity_valid(map, nodes));
  KITH_TRY(kith_resize(density, 0, (size_t)nodes->n_internal, sizeof **density));
  sum_density(nodes, &map->pairs, *density);
  printf("kith %s, %d-D: %d nodes, %d ghosts, %zu pairs, density %.4f\n", kith_version(), NDIM,
         (int)nodes->n_internal, (int)nodes->n_ghost, map->pairs.n, (*density)[0]);
  return KITH_OK;
}

int main(void) {
  struct kith_nodes *nodes = NULL;
  struct kith_search *search = NULL;
  struct kith_connectivity *map = NULL;
  struct kith_boundaries box = {0};
  double *density = NULL;
  kith_status status = kith_nodes_create(&nodes, 1, (const char *const[]){"gas"});
  if (status == KITH_OK) status = kith_connectivity_create(&map);
  if (status == KITH_OK) status = run(nodes, &box, &search, map, &density);
  if (status != KITH_OK) fprintf(stderr, "%s\n", kith_failure());
  const bool good = status == KITH_OK && fabs(density[0] - 1) < 0.05;
  kith_free(&density);
  kith_connectivity_destroy(&map);
  kith_search_destroy(&search);
  kith_boundaries_clear(&box);
  kith_nodes_destroy(&nodes);
  return good ? 0 : 1;
}
