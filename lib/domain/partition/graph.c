/* graph.c - the graph of cells that share faces, partitioned by Scotch: few faces are cut.
 *
 * Every rank partitions the same replicated graph by itself, with one thread, from the same seed and without
 * a communicator: PT-Scotch on one process ends in the same routine. The first map is made from scratch;
 * later ones start from the present map, and moving a cell has a small cost. Scotch aims at an imbalance of
 * `tolerance` but does not guarantee it.
 *
 * Scotch counts in 32-bit integers: weights are scaled to a total of TOTAL, and are at least 1. */
#include "lib/domain/partition/partition.h"

struct graph_settings {
  double tolerance, move;
};
static const struct kith_param graph_params[] = {
    {"tolerance", KITH_PARAM_NUMBER, "0.05", "(0, 1)", "imbalance that Scotch aims at",
     KITH_INTO(struct graph_settings, tolerance)},
    {"move", KITH_PARAM_NUMBER, "0.001", "[0, 1000]", "cost of moving a cell, relative to a mean face",
     KITH_INTO(struct graph_settings, move)},
    {0}};

#ifdef KITH_SCOTCH
#include <stdio.h> /* before scotch.h, which needs it */
#include <scotch.h>

static const double TOTAL = 1 << 28;
enum { SEED = 5, STRATEGY = SCOTCH_STRATRECURSIVE | SCOTCH_STRATBALANCE };

/* Compressed rows; weights of cells and of edges. One block of memory, at `first`. */
struct graph {
  SCOTCH_Num n, n_edges;
  SCOTCH_Num *first, *neighbor, *cell_weight, *edge_weight;
  double mean_edge;
};

static SCOTCH_Num scaled(double weight, double scale) {
  return (SCOTCH_Num)KITH_MAX(weight * scale, 1);
}

/* The edges of cell c. A cell that is a neighbor on both sides (two cells on a periodic axis) has one edge,
 * with the weight of both faces. */
static void add_edges(struct graph *graph, const struct kith_cells *cells, int64_t c) {
  const SCOTCH_Num begin = graph->n_edges;
  for (int a = 0; a < NDIM; ++a)
    for (int side = -1; side <= 1; side += 2) {
      const int64_t d = kith_cells_beside(cells, c, a, side);
      if (d < 0 || d == c) continue;
      SCOTCH_Num e = begin;
      while (e < graph->n_edges && graph->neighbor[e] != d) ++e;
      if (e == graph->n_edges) graph->edge_weight[graph->n_edges++] = 0;
      graph->neighbor[e] = (SCOTCH_Num)d;
      graph->edge_weight[e] += scaled(1, graph->mean_edge);
    }
  graph->first[c + 1] = graph->n_edges;
}

static kith_status graph_build(struct graph *graph, const struct kith_cells *cells, const double *weight) {
  const size_t n = (size_t)cells->n, capacity = 2 * NDIM * n;
  if (capacity > INT32_MAX / 2) KITH_FAIL(UNSUPPORTED, "%zu cells are too many for Scotch", n);
  KITH_TRY(kith_resize(&graph->first, 0, 2 * n + 1 + 2 * capacity, sizeof *graph->first));
  graph->cell_weight = graph->first + n + 1;
  graph->neighbor = graph->cell_weight + n;
  graph->edge_weight = graph->neighbor + capacity;
  graph->n = (SCOTCH_Num)n;
  graph->mean_edge = TOTAL / (double)(n * NDIM);
  double total = 0;
  for (size_t c = 0; c < n; ++c) total += weight == NULL ? 1 : weight[c];
  for (size_t c = 0; c < n; ++c) {
    graph->cell_weight[c] = scaled(weight == NULL ? 1 : weight[c], TOTAL / total);
    add_edges(graph, cells, (int64_t)c);
  }
  return KITH_OK;
}

/* In a context of its own, because the default context uses as many threads as there are cores, and its
 * results depend on their timing. */
static kith_status partition_graph(const struct graph *graph, const struct graph_settings *settings,
                                   int n_parts, SCOTCH_Num *from, SCOTCH_Num *part) {
  SCOTCH_Context context;
  SCOTCH_Graph made, bound;
  SCOTCH_Strat strategy;
  SCOTCH_contextInit(&context);
  SCOTCH_graphInit(&made);
  SCOTCH_graphInit(&bound);
  SCOTCH_stratInit(&strategy);
  bool done = SCOTCH_contextRandomClone(&context) == 0 && SCOTCH_contextThreadSpawn(&context, 1, NULL) == 0 &&
              SCOTCH_contextOptionSetNum(&context, SCOTCH_OPTIONNUMDETERMINISTIC, 1) == 0;
  SCOTCH_contextRandomSeed(&context, SEED);
  SCOTCH_contextRandomReset(&context);
  done = done &&
         SCOTCH_graphBuild(&made, 0, graph->n, graph->first, NULL, graph->cell_weight, NULL, graph->n_edges,
                           graph->neighbor, graph->edge_weight) == 0 &&
         SCOTCH_contextBindGraph(&context, &made, &bound) == 0 &&
         SCOTCH_stratGraphMapBuild(&strategy, STRATEGY, n_parts, settings->tolerance) == 0 &&
         (from == NULL ? SCOTCH_graphPart(&bound, n_parts, &strategy, part)
                       : SCOTCH_graphRepart(&bound, n_parts, from, settings->move * graph->mean_edge, NULL,
                                            &strategy, part)) == 0;
  SCOTCH_stratExit(&strategy);
  SCOTCH_graphExit(&bound);
  SCOTCH_graphExit(&made);
  SCOTCH_contextExit(&context);
  if (!done) KITH_FAIL(INTERNAL, "Scotch could not partition %d cells for %d ranks", (int)graph->n, n_parts);
  return KITH_OK;
}

/* Starts from the present map, but makes the first one (`owner` is that of the partition) from scratch. */
static kith_status graph_update(struct kith_partition *partition, const double *weight, int32_t *owner) {
  int32_t *from = owner == partition->owner ? NULL : partition->owner;
  struct graph graph = {0};
  kith_status status = graph_build(&graph, partition->cells, weight);
  if (status == KITH_OK)
    status = partition_graph(&graph, partition->settings, partition->n_ranks, from, owner);
  kith_free(&graph.first);
  return status;
}

#endif

const struct kith_partitioner_ops kith_partitioner_graph = {
    .name = "graph",
    .doc = "the graph of cells partitioned by Scotch: few faces are cut",
    .seconds_per_cell = 2e-5,
    KITH_SETTINGS(graph_params, graph_settings),
#ifdef KITH_SCOTCH
    .update = graph_update,
#else
    .needs = "Scotch (Debian: libptscotch-dev)",
#endif
};
