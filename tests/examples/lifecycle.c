/* lifecycle.c - the stages of the lifecycle in their order, and what each does for one node. Prints a line
 * `stage x y what` for each node or ghost; app/manual/lifecycle.gp draws them for the manual. */
#include <stdio.h>
#include "boundaries/boundary.h"
#include "lib/connectivity/connectivity.h"
#include "lib/neighbor/search.h"

enum { N = 12, SEEN = 1 }; /* nodes along an axis; index of the node that is shown, near a corner */

/* A cubic lattice with fixed displacements, and supports that grow with x. */
static kith_status place_nodes(struct kith_nodes *nodes) {
  kith_index first, count = 1;
  for (int a = 0; a < NDIM; ++a) count *= N;
  KITH_TRY(kith_nodes_append(nodes, 0, count, &first));
  for (kith_index i = 0; i < count; ++i) {
    for (int a = 0, k = i; a < NDIM; ++a, k /= N)
      nodes->position->f64[i * NDIM + a] = (k % N + 0.5 + 0.02 * ((7 * i + 3 * a) % 13 - 6)) / N;
    nodes->support->f64[i] = nodes->search_radius->f64[i] = (1.5 + nodes->position->f64[i * NDIM]) / N;
    nodes->id->i64[i] = i;
  }
  ++nodes->positions;
  return KITH_OK;
}

static void print_node(const char *stage, const struct kith_nodes *nodes, kith_index i, const char *what) {
  const double *x = &nodes->position->f64[i * NDIM];
  printf("%s %.5f %.5f %s\n", stage, x[0], NDIM > 1 ? x[1] : 0, what);
}

static void print_nodes(const char *stage, const struct kith_nodes *nodes) {
  for (kith_index i = 0; i < kith_nodes_count(nodes); ++i)
    print_node(stage, nodes, i, i < nodes->n_internal ? "node" : "ghost");
  print_node(stage, nodes, SEEN, "self");
}

/* The candidates for the group of cells that has the node. */
static kith_status print_candidates(const struct kith_nodes *nodes, const struct kith_search *search) {
  struct kith_runs runs = {0};
  struct kith_box box;
  const double *x = &nodes->position->f64[SEEN * NDIM];
  for (int a = 0; a < NDIM; ++a) box.lower[a] = box.upper[a] = x[a];
  print_nodes("neighbors", nodes);
  KITH_TRY(search->ops->coarse(search, &box, nodes->search_radius->f64[SEEN], KITH_GATHER_SCATTER, &runs));
  for (int r = 0; r < runs.n; ++r)
    for (kith_index s = runs.run[r].first; s < runs.run[r].first + runs.run[r].count; ++s)
      print_node("neighbors", nodes, search->node[s], "candidate");
  kith_runs_clear(&runs);
  return KITH_OK;
}

static void print_row(const char *stage, const struct kith_nodes *nodes,
                      const struct kith_connectivity *map) {
  const kith_index i = SEEN;
  print_nodes(stage, nodes);
  for (size_t e = map->rows.first[i]; e < map->rows.first[i + 1]; ++e)
    print_node(stage, nodes, map->rows.node[e], "neighbor");
}

static kith_status cull(struct kith_nodes *nodes, struct kith_connectivity *map) {
  const kith_index before = kith_nodes_count(nodes);
  uint8_t *keep = NULL;
  kith_index *renumber = NULL;
  KITH_TRY(kith_resize(&keep, 0, (size_t)nodes->n_ghost + 1, 1));
  kith_status status = kith_resize(&renumber, 0, (size_t)before, sizeof *renumber);
  kith_connectivity_mark_ghosts(map, nodes, keep);
  print_nodes("cull", nodes);
  for (kith_index g = 0; g < nodes->n_ghost; ++g)
    if (!keep[g]) print_node("cull", nodes, nodes->n_internal + g, "culled");
  if (status == KITH_OK) status = kith_nodes_cull_ghosts(nodes, keep, renumber);
  if (status == KITH_OK) status = kith_connectivity_patch(map, nodes, renumber, before);
  kith_free(&keep);
  kith_free(&renumber);
  return status;
}

static kith_status run(struct kith_nodes *nodes, struct kith_boundaries *box, struct kith_search **search,
                       struct kith_connectivity *map) {
  KITH_TRY(place_nodes(nodes));
  print_nodes("nodes", nodes);
  for (int a = 0; a < NDIM; ++a)
    KITH_TRY(kith_boundaries_add(box, a == 0 ? &kith_boundary_reflecting : &kith_boundary_periodic, a, 0, 1,
                                 true, true));
  KITH_TRY(kith_boundaries_ghosts(box, nodes, 1, NULL));
  print_nodes("ghosts", nodes);
  KITH_TRY(kith_search_create(search, kith_search_find("tree"), nodes));
  KITH_TRY(kith_search_update(*search));
  KITH_TRY(print_candidates(nodes, *search));
  KITH_TRY(kith_connectivity_build(map, nodes, *search,
                                   (struct kith_requirements){.rows = true, .pairs = true}, NULL, NULL));
  print_row("connectivity", nodes, map);
  KITH_TRY(cull(nodes, map));
  KITH_TRY(kith_connectivity_valid(map, nodes));
  print_row("patch", nodes, map);
  return KITH_OK;
}

int main(void) {
  struct kith_nodes *nodes = NULL;
  struct kith_search *search = NULL;
  struct kith_connectivity *map = NULL;
  struct kith_boundaries box = {0};
  kith_status status = kith_nodes_create(&nodes, 1, (const char *const[]){"gas"});
  if (status == KITH_OK) status = kith_connectivity_create(&map);
  if (status == KITH_OK) status = run(nodes, &box, &search, map);
  if (status != KITH_OK) fprintf(stderr, "%s\n", kith_failure());
  kith_connectivity_destroy(&map);
  kith_search_destroy(&search);
  kith_boundaries_clear(&box);
  kith_nodes_destroy(&nodes);
  return status == KITH_OK ? 0 : 1;
}
