/* diffusion.c - load diffuses between neighboring ranks: cells at their border change owner. And
 * hybrid, which begins with a graph.
 *
 * One update is one step of diffusion, simulated for all ranks on the replicated map: the loads l_p of the
 * ranks; the work f_pq that is to flow between neighbors; then every rank in turn gives border cells away,
 * those with the most neighbors at the receiver first, until the flow is used up (to the nearest cell; the
 * rest is added to the flow to its next neighbor). Only border cells move, so nodes go to ranks that already
 * know them as ghosts, and a large-scale gradient of load takes many updates.
 *
 *   schornbaum    f = sum over iterations of (l_p - l_q) / (1 + the larger number of neighbors), with loads
 *                 updated; the default, as it needs the fewest updates (Schornbaum and Ruede, SIAM J. Sci.
 *                 Comput. 38, C96 (2016))
 *   willebeek     f_pq = (l_p - m_p) d_q / sum d, m_p the mean of p and its neighbors, d_q = max(0, m_p -
 *                 l_q) (Willebeek-LeMair and Reeves, IEEE Trans. Parallel Distrib. Syst. 4, 979 (1993))
 *   second-order  as schornbaum, with momentum: f(t) = (beta - 1) f(t - 1) + beta (l_p - l_q) / (1 + ...),
 *                 beta = momentum (Muthukrishnan, Ghosh and Schultz, Theory Comput. Syst. 31, 331 (1998))
 *
 * A cell goes only to a rank that has less load than the giver even afterwards, so the largest load never
 * rises and the sum of squares falls with every moved cell. A rank keeps its last cell, since a rank without
 * cells has no border. */
#include "lib/domain/partition/partition.h"

#include <stdlib.h>
#include <string.h>

enum { NO_FACE = 32, SCORES = 64 };

enum flow { SCHORNBAUM, WILLEBEEK, SECOND_ORDER };

struct flow_settings {
  int flow, iterations;
  double momentum;
  int start;  /* by position in its row */
  bool fixed; /* no new neighbor ranks */
};
#define IN(member) KITH_INTO(struct flow_settings, member)
static const struct kith_param diffusion_params[] = {
    {"start", KITH_PARAM_CHOICE, "cart", "cart|morton", "the map to start from", IN(start)},
    {"neighbors", KITH_PARAM_CHOICE, "free", "free|fixed",
     "which ranks may become neighbors: any, or those of the first map", IN(fixed)},
    {"flow", KITH_PARAM_CHOICE, "schornbaum", "schornbaum|willebeek|second-order",
     "rule for how much work flows", IN(flow)},
    {"iterations", KITH_PARAM_INTEGER, "10", "[1, 1000]", "iterations of the flow (schornbaum, second-order)",
     IN(iterations)},
    {"momentum", KITH_PARAM_NUMBER, "1.8", "[1, 2)", "beta of second-order", IN(momentum),
     .needs = "flow=second-order"},
    {0}};

/* Private state. */
struct diffusion {
  int64_t n_allowed;
  uint64_t *allowed; /* [n_allowed] neighbors p, q in the start map, as p n_ranks + q, ascending; owned */
  bool diffuse;      /* of hybrid: at the next update */
};

/* Ranks p, q that share faces, ascending; entries first .. end - 1 are p's cells with a face to q, best
 * first. */
struct pair {
  int32_t p, q;
  int64_t first, end;
  double flow, last_flow;
};

/* A cell and another rank that it touches. */
struct entry {
  uint64_t key; /* (p n_ranks + q) SCORES + score: NO_FACE, and lower the more neighbors belong to q */
  int64_t cell;
};

/* The border between the ranks of a map. */
struct border {
  const struct kith_partition *partition;
  int32_t *owner; /* [cells] the map */
  size_t n_entries, capacity;
  int64_t n_pairs;
  struct entry *entry; /* [n_entries] ascending */
  struct pair *pair;   /* [n_pairs] */
};

static void border_clear(struct border *border) {
  KITH_FREE(&border->entry, &border->pair);
}

/* Ranks p and q as one number. */
static uint64_t ranks_code(const struct border *border, int32_t p, int32_t q) {
  return (uint64_t)p * (uint64_t)border->partition->n_ranks + (uint64_t)q;
}

/* The entry of a cell for rank q, among those from `begin` on; made if there is none. */
static struct entry *entry_of(struct border *border, size_t begin, int64_t c, int32_t q) {
  const uint64_t ranks = ranks_code(border, border->owner[c], q);
  size_t e = begin;
  while (e < border->n_entries && border->entry[e].key / SCORES != ranks) ++e;
  if (e == border->n_entries)
    border->entry[border->n_entries++] = (struct entry){ranks * SCORES + SCORES - 1, c};
  return &border->entry[e];
}

/* One entry for every other rank beside cell c. */
static kith_status add_entries(struct border *border, int64_t c) {
  const struct kith_cells *cells = border->partition->cells;
  const int32_t *owner = border->owner;
  const size_t begin = border->n_entries;
  KITH_TRY(kith_grow(&border->entry, &border->capacity, begin, begin + KITH_CELL_NEIGHBORS,
                     sizeof *border->entry));
  struct kith_cell_image neighbor[KITH_CELL_NEIGHBORS];
  const int n = kith_cells_neighbors(cells, c, neighbor, NULL);
  for (int k = 0; k < n; ++k)
    if (owner[neighbor[k].cell] != owner[c]) --entry_of(border, begin, c, owner[neighbor[k].cell])->key;
  for (int side = 0; side < 2 * NDIM; ++side) {
    const int64_t d = kith_cells_beside(cells, c, side / 2, side % 2 == 0 ? -1 : 1);
    if (d >= 0 && owner[d] != owner[c]) entry_of(border, begin, c, owner[d])->key &= ~(uint64_t)NO_FACE;
  }
  return KITH_OK;
}

static int ascending(const void *a, const void *b) {
  const struct entry *p = a, *q = b;
  if (p->key != q->key) return p->key < q->key ? -1 : 1;
  return (p->cell > q->cell) - (p->cell < q->cell);
}

/* All entries, and a pair for every two ranks that share faces. */
static kith_status border_find(struct border *border) {
  const uint64_t n_ranks = (uint64_t)border->partition->n_ranks;
  for (int64_t c = 0; c < border->partition->cells->n; ++c) KITH_TRY(add_entries(border, c));
  if (border->n_entries > 0) qsort(border->entry, border->n_entries, sizeof *border->entry, ascending);
  KITH_TRY(kith_resize(&border->pair, 0, border->n_entries, sizeof *border->pair));
  uint64_t last = UINT64_MAX;
  for (size_t i = 0; i < border->n_entries; ++i) {
    const uint64_t ranks = border->entry[i].key / SCORES;
    if (border->entry[i].key & NO_FACE) continue;
    if (ranks != last)
      border->pair[border->n_pairs++] = (struct pair){
          .p = (int32_t)(ranks / n_ranks), .q = (int32_t)(ranks % n_ranks), .first = (int64_t)i};
    border->pair[border->n_pairs - 1].end = (int64_t)i + 1;
    last = ranks;
  }
  return KITH_OK;
}

/* ---- flow ---- */

/* The pairs of one rank are row .. end - 1; returns end. */
static int64_t row_end(const struct border *border, int64_t row) {
  int64_t end = row;
  while (end < border->n_pairs && border->pair[end].p == border->pair[row].p) ++end;
  return end;
}

static void flow_willebeek(struct border *border, const double *load) {
  for (int64_t row = 0, end; row < border->n_pairs; row = end) {
    end = row_end(border, row);
    struct pair *pair = border->pair;
    const double own = load[pair[row].p];
    double mean = own, deficit = 0;
    for (int64_t e = row; e < end; ++e) mean += load[pair[e].q];
    mean /= (double)(end - row + 1);
    for (int64_t e = row; e < end; ++e) deficit += KITH_MAX(mean - load[pair[e].q], 0);
    if (own <= mean || deficit <= 0) continue;
    for (int64_t e = row; e < end; ++e)
      pair[e].flow = (own - mean) * KITH_MAX(mean - load[pair[e].q], 0) / deficit;
  }
}

/* load[] follows the flow; neighbors[] is scratch. */
static void flow_iterated(struct border *border, int iterations, double beta, double *load,
                          double *neighbors) {
  for (int p = 0; p < border->partition->n_ranks; ++p) neighbors[p] = 0;
  for (int64_t e = 0; e < border->n_pairs; ++e) ++neighbors[border->pair[e].p];
  for (int t = 0; t < iterations; ++t) {
    const double now = t == 0 ? 1 : beta; /* no momentum yet */
    for (int64_t e = 0; e < border->n_pairs; ++e) {
      struct pair *pair = &border->pair[e];
      const double alpha = 1 / (1 + KITH_MAX(neighbors[pair->p], neighbors[pair->q]));
      pair->last_flow = (now - 1) * pair->last_flow + now * alpha * (load[pair->p] - load[pair->q]);
      pair->flow += pair->last_flow;
    }
    for (int64_t e = 0; e < border->n_pairs; ++e) load[border->pair[e].p] -= border->pair[e].last_flow;
  }
}

/* ---- cells ---- */

static int compare_codes(const void *a, const void *b) {
  const uint64_t p = *(const uint64_t *)a, q = *(const uint64_t *)b;
  return (p > q) - (p < q);
}

/* Would rank q with cell c have a neighboring rank that it did not have in the first map? */
static bool makes_neighbors(const struct border *border, int32_t q, int64_t c) {
  const struct diffusion *self = border->partition->self;
  struct kith_cell_image neighbor[KITH_CELL_NEIGHBORS];
  const int n = kith_cells_neighbors(border->partition->cells, c, neighbor, NULL);
  for (int k = 0; k < n; ++k) {
    const int64_t d = neighbor[k].cell;
    const int32_t other = d == c ? q : border->owner[d];
    const uint64_t code = ranks_code(border, q, other);
    if (other != q &&
        bsearch(&code, self->allowed, (size_t)self->n_allowed, sizeof code, compare_codes) == NULL)
      return true;
  }
  return false;
}

/* Moves cells from p to q for `budget` of work; returns what is left of it (slightly negative if the last
 * cell was rounded up). cells_of[]: numbers of the cells of the ranks. */
static double give(const struct border *border, const struct pair *pair, double budget, const double *weight,
                   double *load, double *cells_of) {
  const struct flow_settings *settings = border->partition->settings;
  const int32_t p = pair->p, q = pair->q;
  for (int64_t i = pair->first; i < pair->end && budget > 0 && cells_of[p] > 1; ++i) {
    const int64_t c = border->entry[i].cell;
    const double w = weight[c];
    if (border->owner[c] != p || 0.5 * w > budget || !(load[q] + w < load[p])) continue;
    if (settings->fixed && makes_neighbors(border, q, c)) continue;
    border->owner[c] = q;
    load[p] -= w, load[q] += w;
    --cells_of[p], ++cells_of[q];
    budget -= w;
  }
  return budget;
}

/* One step. load[], cells_of[]: [n_ranks], scratch. */
static void diffuse(struct border *border, const double *weight, double *load, double *cells_of) {
  const struct flow_settings *settings = border->partition->settings;
  kith_partition_loads(border->partition, border->owner, weight, load);
  if (settings->flow == WILLEBEEK)
    flow_willebeek(border, load);
  else
    flow_iterated(border, settings->iterations, settings->flow == SECOND_ORDER ? settings->momentum : 1, load,
                  cells_of);
  kith_partition_loads(border->partition, border->owner, weight, load);
  kith_partition_loads(border->partition, border->owner, NULL, cells_of);
  for (int64_t row = 0, end; row < border->n_pairs; row = end) {
    end = row_end(border, row);
    double left = 0;
    for (const struct pair *pair = &border->pair[row]; pair < &border->pair[end]; ++pair)
      if (pair->flow > 0) left = give(border, pair, left + pair->flow, weight, load, cells_of);
  }
}

/* ---- the member ---- */

/* The start map, and its neighborhood: the pairs of ranks that touch. */
static kith_status diffusion_first(struct kith_partition *partition, int32_t *owner) {
  static const char *const starts[] = {"cart", "morton"};
  const struct flow_settings *settings = partition->settings;
  struct diffusion *self = partition->self;
  struct kith_partition *map = NULL;
  KITH_TRY(kith_partition_create(&map, partition->cells, partition->n_ranks, starts[settings->start]));
  memcpy(owner, map->owner, (size_t)partition->cells->n * sizeof *owner);
  kith_partition_destroy(&map);
  struct border border = {.partition = partition, .owner = owner};
  kith_status status = border_find(&border);
  if (status == KITH_OK) status = kith_resize(&self->allowed, 0, border.n_entries, sizeof *self->allowed);
  for (size_t i = 0; status == KITH_OK && i < border.n_entries; ++i) {
    const uint64_t code = border.entry[i].key / SCORES;
    if (self->n_allowed == 0 || self->allowed[self->n_allowed - 1] != code)
      self->allowed[self->n_allowed++] = code;
  }
  border_clear(&border);
  return status;
}

static kith_status diffusion_update(struct kith_partition *partition, const double *weight, int32_t *owner) {
  const size_t n = (size_t)partition->n_ranks;
  struct border border = {.partition = partition, .owner = owner};
  double *load = NULL;
  KITH_TRY(kith_resize(&load, 0, 2 * n, sizeof *load));
  const kith_status status = border_find(&border);
  if (status == KITH_OK) diffuse(&border, weight, load, load + n);
  kith_free(&load);
  border_clear(&border);
  return status;
}

static void diffusion_clear(struct kith_partition *partition) {
  struct diffusion *self = partition->self;
  kith_free(&self->allowed);
}

const struct kith_partitioner_ops kith_partitioner_diffusion = {
    .name = "diffusion",
    .doc = "cells flow to neighbor ranks that have less to do, one layer an update",
    KITH_SETTINGS(diffusion_params, flow_settings),
    .state_size = sizeof(struct diffusion),
    .first = diffusion_first,
    .update = diffusion_update,
    .clear = diffusion_clear,
};

/* ---- hybrid: the first map and the first update are those of the graph, later ones diffuse ---- */

static kith_status as_graph(struct kith_partition *partition, const double *weight, int32_t *owner) {
  struct kith_partition graph = *partition;
  KITH_TRY(kith_settings_create(&graph.settings, KITH_MEMBER(&kith_partitioner_graph), NULL));
  const kith_status status = kith_partitioner_graph.update(&graph, weight, owner);
  kith_free(&graph.settings);
  return status;
}

static kith_status hybrid_update(struct kith_partition *partition, const double *weight, int32_t *owner) {
  struct diffusion *self = partition->self;
  if (self->diffuse) return diffusion_update(partition, weight, owner);
  KITH_TRY(as_graph(partition, weight, owner));
  self->diffuse = true;
  return KITH_OK;
}

static kith_status hybrid_first(struct kith_partition *partition, int32_t *owner) {
  return as_graph(partition, NULL, owner);
}

static size_t hybrid_state(const struct kith_partition *partition, int64_t *word) {
  const struct diffusion *self = partition->self;
  if (word != NULL) *word = self->diffuse;
  return 1;
}

static kith_status hybrid_restore(struct kith_partition *partition, const int64_t *word) {
  struct diffusion *self = partition->self;
  if (*word != 0 && *word != 1) KITH_FAIL(BAD_FILE, "partitioner 'hybrid': its state is damaged");
  self->diffuse = *word == 1;
  return KITH_OK;
}

const struct kith_partitioner_ops kith_partitioner_hybrid = {
    .name = "hybrid",
    .doc = "partitioned as a graph once, then diffusion",
    .seconds_per_cell = 2e-5, /* as graph */
#ifndef KITH_SCOTCH
    .needs = "Scotch (Debian: libptscotch-dev)", /* as graph */
#endif
    KITH_SETTINGS(diffusion_params + 2, flow_settings), /* those of the flow: a graph is the first map */
    .state_size = sizeof(struct diffusion),
    .first = hybrid_first,
    .update = hybrid_update,
    .state = hybrid_state,
    .restore = hybrid_restore,
};
