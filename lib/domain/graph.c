/* graph.c - the graph of cells that share faces, divided by Scotch: few and light faces are cut.
 *
 * Every rank divides the same replicated graph by itself, with one thread, a seed of its own and no communicator:
 * PT-Scotch on one process comes to the same routine. Parts come in no order that lasts: each is given to
 * the rank that has most of its weight already, so that little moves.
 *
 * Scotch counts in 32-bit integers: weights are scaled to a total of TOTAL, and are at least 1. */
#include "lib/domain/partition.h"

#ifdef KITH_SCOTCH
#include <stdio.h>
#include <stdlib.h>
#include <scotch.h>

#include "lib/core/key.h"

static const double TOTAL = 1 << 28, IMBALANCE = 0.05;
/* By halves: fewer faces cut than k ways at once, whose refinement in Scotch 7.0.3 loses memory besides. */
enum { SEED = 5, STRATEGY = SCOTCH_STRATRECURSIVE | SCOTCH_STRATBALANCE };

/* Compressed rows; weights of cells and of edges. */
struct graph {
  SCOTCH_Num n, n_edges;
  SCOTCH_Num *first, *neighbor, *cell_weight, *edge_weight;
};

static void graph_clear(struct graph *graph) {
  kith_free(&graph->first);
  kith_free(&graph->neighbor);
  kith_free(&graph->cell_weight);
  kith_free(&graph->edge_weight);
}

static SCOTCH_Num scaled(double weight, double scale) {
  return (SCOTCH_Num)KITH_MAX(weight * scale, 1);
}

/* The edges of cell c; a cell that is met on both sides (two on a periodic axis) is one edge with both faces. */
static void add_edges(struct graph *graph, const struct kith_cells *cells, const double *face_weight,
                      double scale, int64_t c) {
  const SCOTCH_Num begin = graph->n_edges;
  for (int a = 0; a < NDIM; ++a)
    for (int side = -1; side <= 1; side += 2) {
      const int64_t d = kith_cells_beside(cells, c, a, side);
      if (d < 0 || d == c) continue;
      const SCOTCH_Num w =
          face_weight == NULL ? 1 : scaled(face_weight[(side > 0 ? c : d) * NDIM + a], scale);
      SCOTCH_Num e = begin;
      while (e < graph->n_edges && graph->neighbor[e] != d) ++e;
      if (e == graph->n_edges) graph->edge_weight[graph->n_edges++] = 0;
      graph->neighbor[e] = (SCOTCH_Num)d;
      graph->edge_weight[e] += w;
    }
  graph->first[c + 1] = graph->n_edges;
}

static kith_status graph_build(struct graph *graph, const struct kith_cells *cells, const double *weight,
                               const double *face_weight) {
  const size_t n = (size_t)cells->n, room = 2 * NDIM * n;
  if (room > INT32_MAX / 2) KITH_FAIL(UNSUPPORTED, "%zu cells are too many for Scotch", n);
  KITH_TRY(kith_resize(&graph->first, 0, n + 1, sizeof *graph->first));
  KITH_TRY(kith_resize(&graph->cell_weight, 0, n, sizeof *graph->cell_weight));
  KITH_TRY(kith_resize(&graph->neighbor, 0, room, sizeof *graph->neighbor));
  KITH_TRY(kith_resize(&graph->edge_weight, 0, room, sizeof *graph->edge_weight));
  graph->n = (SCOTCH_Num)n;
  double total = 0, faces = 0;
  for (size_t c = 0; c < n; ++c) total += weight == NULL ? 1 : weight[c];
  for (size_t f = 0; face_weight != NULL && f < n * NDIM; ++f) faces += face_weight[f];
  for (size_t c = 0; c < n; ++c) {
    graph->cell_weight[c] = scaled(weight == NULL ? 1 : weight[c], TOTAL / total);
    add_edges(graph, cells, face_weight, faces > 0 ? TOTAL / faces : 0, (int64_t)c);
  }
  return KITH_OK;
}

/* One call of Scotch in a context of our own: the same seed and one thread every time. */
static bool divide_in_context(const struct graph *graph, int n_parts, SCOTCH_Context *context,
                              SCOTCH_Graph *plain, SCOTCH_Graph *bound, SCOTCH_Strat *strategy,
                              SCOTCH_Num *part) {
  SCOTCH_contextRandomSeed(context, SEED);
  SCOTCH_contextRandomReset(context);
  return SCOTCH_contextThreadSpawn(context, 1, NULL) == 0 &&
         SCOTCH_contextOptionSetNum(context, SCOTCH_OPTIONNUMDETERMINISTIC, 1) == 0 &&
         SCOTCH_graphBuild(plain, 0, graph->n, graph->first, NULL, graph->cell_weight, NULL, graph->n_edges,
                           graph->neighbor, graph->edge_weight) == 0 &&
         SCOTCH_contextBindGraph(context, plain, bound) == 0 &&
         SCOTCH_stratGraphMapBuild(strategy, STRATEGY, n_parts, IMBALANCE) == 0 &&
         SCOTCH_graphPart(bound, n_parts, strategy, part) == 0;
}

static kith_status divide(const struct graph *graph, int n_parts, SCOTCH_Num *part) {
  SCOTCH_Context context;
  SCOTCH_Graph plain, bound;
  SCOTCH_Strat strategy;
  SCOTCH_contextInit(&context);
  SCOTCH_contextRandomClone(&context);
  SCOTCH_graphInit(&plain);
  SCOTCH_graphInit(&bound);
  SCOTCH_stratInit(&strategy);
  const bool done = divide_in_context(graph, n_parts, &context, &plain, &bound, &strategy, part);
  SCOTCH_stratExit(&strategy);
  SCOTCH_graphExit(&bound);
  SCOTCH_graphExit(&plain);
  SCOTCH_contextExit(&context);
  if (!done) KITH_FAIL(INTERNAL, "Scotch could not divide %d cells for %d ranks", (int)graph->n, n_parts);
  return KITH_OK;
}

/* ---- which part goes to which rank ---- */

struct overlap {
  int64_t weight;
  int32_t part, rank;
};

static int heavier_first(const void *a, const void *b) {
  const struct overlap *p = a, *q = b;
  if (p->weight != q->weight) return p->weight < q->weight ? 1 : -1;
  if (p->part != q->part) return p->part < q->part ? -1 : 1;
  return (p->rank > q->rank) - (p->rank < q->rank);
}

/* The weights that part and present rank have in common, the heaviest first; returns their number. `by_pair` orders the
 * cells by (part, rank). */
static int64_t find_overlaps(const struct graph *graph, const SCOTCH_Num *part, const int32_t *owner,
                             const kith_index *by_pair, struct overlap *overlap) {
  int64_t n = 0;
  for (SCOTCH_Num k = 0; k < graph->n; ++k) {
    const kith_index c = by_pair[k];
    if (n == 0 || overlap[n - 1].part != part[c] || overlap[n - 1].rank != owner[c])
      overlap[n++] = (struct overlap){0, part[c], owner[c]};
    overlap[n - 1].weight += graph->cell_weight[c];
  }
  qsort(overlap, (size_t)n, sizeof *overlap, heavier_first);
  return n;
}

/* Heaviest overlaps first, then what is left in order: rank_of[part]; taken[rank] is used. */
static void match(int64_t n, const struct overlap *overlap, int n_ranks, int32_t *rank_of, int32_t *taken) {
  for (int r = 0; r < n_ranks; ++r) rank_of[r] = -1, taken[r] = 0;
  for (int64_t k = 0; k < n; ++k) {
    const struct overlap *o = &overlap[k];
    if (rank_of[o->part] >= 0 || taken[o->rank]) continue;
    rank_of[o->part] = o->rank;
    taken[o->rank] = 1;
  }
  for (int p = 0, r = 0; p < n_ranks; ++p) {
    if (rank_of[p] >= 0) continue;
    while (taken[r]) ++r;
    rank_of[p] = r++;
  }
}

static kith_status give_to_ranks(const struct graph *graph, const SCOTCH_Num *part, int n_ranks,
                                 int32_t *owner) {
  const size_t n = (size_t)graph->n;
  uint64_t *key = NULL;
  kith_index *by_pair = NULL;
  struct overlap *overlap = NULL;
  int32_t *rank_of = NULL, *taken = NULL;
  kith_status status = kith_resize(&key, 0, n, sizeof *key);
  if (status == KITH_OK) status = kith_resize(&by_pair, 0, n, sizeof *by_pair);
  if (status == KITH_OK) status = kith_resize(&overlap, 0, n, sizeof *overlap);
  if (status == KITH_OK) status = kith_resize(&rank_of, 0, (size_t)n_ranks, sizeof *rank_of);
  if (status == KITH_OK) status = kith_resize(&taken, 0, (size_t)n_ranks, sizeof *taken);
  for (size_t c = 0; status == KITH_OK && c < n; ++c)
    key[c] = (uint64_t)part[c] * (uint64_t)n_ranks + (uint64_t)owner[c];
  if (status == KITH_OK) status = kith_key_sort(n, key, NULL, by_pair);
  if (status == KITH_OK) {
    match(find_overlaps(graph, part, owner, by_pair, overlap), overlap, n_ranks, rank_of, taken);
    for (size_t c = 0; c < n; ++c) owner[c] = rank_of[part[c]];
  }
  kith_free(&key);
  kith_free(&by_pair);
  kith_free(&overlap);
  kith_free(&rank_of);
  kith_free(&taken);
  return status;
}

static kith_status graph_update(struct kith_partition *partition, const double *weight,
                                const double *face_weight, int32_t *owner) {
  struct graph graph = {0};
  SCOTCH_Num *part = NULL;
  kith_status status = graph_build(&graph, partition->cells, weight, face_weight);
  if (status == KITH_OK) status = kith_resize(&part, 0, (size_t)graph.n, sizeof *part);
  if (status == KITH_OK) status = divide(&graph, partition->n_ranks, part);
  if (status == KITH_OK) status = give_to_ranks(&graph, part, partition->n_ranks, owner);
  kith_free(&part);
  graph_clear(&graph);
  return status;
}

/* As if all were rank 0's. */
static kith_status graph_first(struct kith_partition *partition, int32_t *owner) {
  return graph_update(partition, NULL, NULL, owner);
}
#endif

const struct kith_partitioner_ops kith_partitioner_graph = {
    .name = "graph",
    .doc = "the graph of cells divided by Scotch: few faces cut",
#ifdef KITH_SCOTCH
    .first = graph_first,
    .update = graph_update,
#else
    .needs = "Scotch (Debian: libptscotch-dev)",
#endif
};
