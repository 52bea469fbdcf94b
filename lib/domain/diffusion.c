/* diffusion.c - work flows from rank to rank along the slope, and takes cells of the border with it.
 *
 * One update is one wave, simulated for all ranks on the replicated map: the loads l_p of the ranks; how much work f_pq is to
 * flow between neighbors; then every rank in turn gives border cells away, those with the most neighbors at
 * the receiver first, until the flow is spent (to the nearest cell; what is left goes to its next neighbor). Only cells of
 * the border move, so nodes go to ranks that know them as ghosts already, and a far slope takes many updates.
 *
 *   willebeek     f_pq = (l_p - m_p) d_q / sum d, m_p the mean of p and its neighbors, d_q = max(0, m_p - l_q)
 *                 (Willebeek-LeMair and Reeves, IEEE Trans. Parallel Distrib. Syst. 4, 979 (1993))
 *   schornbaum    f = sum over iterations of (l_p - l_q) / (1 + the larger number of neighbors), loads following
 *                 (Schornbaum and Ruede, SIAM J. Sci. Comput. 38, C96 (2016))
 *   second-order  the same with momentum: f(t) = (beta - 1) f(t - 1) + beta (l_p - l_q) / (1 + ...), beta = 1.8
 *                 (Muthukrishnan, Ghosh and Schultz, Theory Comput. Syst. 31, 331 (1998))
 *
 * A cell goes only to a rank that has less than the giver even then, so the largest load never rises and the
 * sum of squares falls with every cell moved. A rank keeps its last cell, for a rank without one has no border. */
#include "lib/domain/diffusion.h"

#include <string.h>

#include "lib/core/key.h"

enum { ITERATIONS = 10, NO_FACE = 32, SCORES = 64 };
static const double BETA = 1.8;

/* Ranks p, q that share faces, ascending; entries first .. end - 1 are p's cells with a face to q, best first. */
struct pair {
  int32_t p, q;
  int64_t first, end;
  double flow, last_flow;
};

/* An entry is a cell and a foreign rank that it touches. */
struct border {
  int64_t n_entries, room, n_pairs;
  uint64_t
      *key; /* [n_entries] (p n_ranks + q) SCORES + score: NO_FACE, and less the more neighbors are q's */
  kith_index *cell;  /* [n_entries] */
  kith_index *order; /* [n_entries] entries by key */
  struct pair *pair; /* [n_pairs] */
};

static void border_clear(struct border *border) {
  kith_free(&border->key);
  kith_free(&border->cell);
  kith_free(&border->order);
  kith_free(&border->pair);
}

/* The entry for a pair among those of one cell, which begin at `begin`; or where a new one goes. */
static int64_t entry_of(const struct border *border, int64_t begin, uint64_t pair) {
  int64_t e = begin;
  while (e < border->n_entries && border->key[e] / SCORES != pair) ++e;
  return e;
}

/* One entry for every foreign rank beside cell c. */
static kith_status add_entries(struct border *border, const struct kith_cells *cells, const int32_t *owner,
                               int n_ranks, int64_t c) {
  if (border->n_entries + KITH_CELL_NEIGHBORS > border->room) {
    const size_t n = (size_t)border->n_entries, room = 2 * n + 1024;
    KITH_TRY(kith_resize(&border->key, n, room, sizeof *border->key));
    KITH_TRY(kith_resize(&border->cell, n, room, sizeof *border->cell));
    border->room = (int64_t)room;
  }
  struct kith_cell_image image[KITH_CELL_NEIGHBORS];
  const int n_images = kith_cells_neighbors(cells, c, image, NULL);
  const int64_t begin = border->n_entries;
  const uint64_t own = (uint64_t)owner[c] * (uint64_t)n_ranks;
  for (int k = 0; k < n_images; ++k) {
    const uint64_t q = (uint64_t)owner[image[k].cell];
    if (q == (uint64_t)owner[c]) continue;
    const int64_t e = entry_of(border, begin, own + q);
    if (e == border->n_entries) {
      border->cell[e] = (kith_index)c;
      border->key[border->n_entries++] = (own + q) * SCORES + SCORES - 1;
    }
    --border->key[e];
  }
  for (int side = 0; side < 2 * NDIM; ++side) {
    const int64_t d = kith_cells_beside(cells, c, side / 2, side % 2 == 0 ? -1 : 1);
    if (d < 0 || owner[d] == owner[c]) continue;
    border->key[entry_of(border, begin, own + (uint64_t)owner[d])] &= ~(uint64_t)NO_FACE;
  }
  return KITH_OK;
}

/* A pair for every two ranks that share faces. */
static void find_pairs(struct border *border, int n_ranks) {
  struct pair *last = NULL;
  for (int64_t i = 0; i < border->n_entries; ++i) {
    const uint64_t key = border->key[border->order[i]], pair = key / SCORES;
    if (key & NO_FACE) continue;
    const int32_t p = (int32_t)(pair / (uint64_t)n_ranks), q = (int32_t)(pair % (uint64_t)n_ranks);
    if (last == NULL || last->p != p || last->q != q) {
      last = &border->pair[border->n_pairs++];
      *last = (struct pair){.p = p, .q = q, .first = i};
    }
    last->end = i + 1;
  }
}

static kith_status sort_entries(struct border *border, int n_ranks) {
  const size_t n = (size_t)border->n_entries;
  KITH_TRY(kith_resize(&border->order, 0, n, sizeof *border->order));
  KITH_TRY(kith_key_sort(n, border->key, NULL, border->order));
  size_t most_pairs = 0;
  for (size_t i = 0; i < n; ++i)
    most_pairs +=
        i == 0 || border->key[border->order[i]] / SCORES != border->key[border->order[i - 1]] / SCORES;
  KITH_TRY(kith_resize(&border->pair, 0, most_pairs, sizeof *border->pair));
  find_pairs(border, n_ranks);
  return KITH_OK;
}

static kith_status border_find(struct border *border, const struct kith_cells *cells, const int32_t *owner,
                               int n_ranks) {
  for (int64_t c = 0; c < cells->n; ++c) KITH_TRY(add_entries(border, cells, owner, n_ranks, c));
  return sort_entries(border, n_ranks);
}

/* ---- flow ---- */

/* The pairs of one rank: row .. its end, which is returned. */
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

/* load[] follows the flow; neighbors[] is used. */
static void flow_iterated(struct border *border, int n_ranks, double beta, double *load, double *neighbors) {
  for (int p = 0; p < n_ranks; ++p) neighbors[p] = 0;
  for (int64_t e = 0; e < border->n_pairs; ++e) ++neighbors[border->pair[e].p];
  for (int t = 0; t < ITERATIONS; ++t) {
    const double now = t == 0 ? 1 : beta; /* there is no momentum yet */
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

struct wave {
  const struct kith_cells *cells;
  const struct kith_diffusion *self;
  const double *weight;
  int n_ranks;
  int32_t *owner;
  double *load;     /* [n_ranks] */
  double *cells_of; /* [n_ranks] numbers */
};

static bool is_allowed(const struct kith_diffusion *self, uint64_t pair) {
  int64_t low = 0, high = self->n_allowed;
  while (low < high) {
    const int64_t middle = (low + high) / 2;
    if (self->allowed[middle] < pair)
      low = middle + 1;
    else
      high = middle;
  }
  return low < self->n_allowed && self->allowed[low] == pair;
}

/* Would rank q with cell c have a neighbor that is not one of its own from the start? */
static bool makes_neighbors(const struct wave *wave, int32_t q, int64_t c) {
  struct kith_cell_image image[KITH_CELL_NEIGHBORS];
  const int n = kith_cells_neighbors(wave->cells, c, image, NULL);
  for (int k = 0; k < n; ++k) {
    const int32_t other = image[k].cell == c ? q : wave->owner[image[k].cell];
    if (other != q && !is_allowed(wave->self, (uint64_t)q * (uint64_t)wave->n_ranks + (uint64_t)other))
      return true;
  }
  return false;
}

/* Gives cells of a pair away for `budget` of work; returns what is left of it (a little less than nothing if the last
 * cell was rounded up). */
static double give(const struct wave *wave, const struct border *border, const struct pair *pair,
                   double budget) {
  const int32_t p = pair->p, q = pair->q;
  for (int64_t i = pair->first; i < pair->end && budget > 0 && wave->cells_of[p] > 1; ++i) {
    const kith_index c = border->cell[border->order[i]];
    const double w = wave->weight[c];
    if (wave->owner[c] != p || 0.5 * w > budget || !(wave->load[q] + w < wave->load[p])) continue;
    if (wave->self->fixed && makes_neighbors(wave, q, c)) continue;
    wave->owner[c] = q;
    wave->load[p] -= w, wave->load[q] += w;
    --wave->cells_of[p], ++wave->cells_of[q];
    budget -= w;
  }
  return budget;
}

static void measure(const struct wave *wave) {
  for (int p = 0; p < wave->n_ranks; ++p) wave->load[p] = wave->cells_of[p] = 0;
  for (int64_t c = 0; c < wave->cells->n; ++c) {
    wave->load[wave->owner[c]] += wave->weight[c];
    ++wave->cells_of[wave->owner[c]];
  }
}

static void run(const struct wave *wave, struct border *border) {
  measure(wave);
  if (wave->self->flow == KITH_WILLEBEEK) {
    flow_willebeek(border, wave->load);
  } else {
    flow_iterated(border, wave->n_ranks, wave->self->flow == KITH_SECOND_ORDER ? BETA : 1, wave->load,
                  wave->cells_of);
    measure(wave); /* both were used */
  }
  for (int64_t row = 0, end; row < border->n_pairs; row = end) {
    end = row_end(border, row);
    double left = 0;
    for (int64_t e = row; e < end; ++e)
      if (border->pair[e].flow > 0) left = give(wave, border, &border->pair[e], left + border->pair[e].flow);
  }
}

/* ---- the member ---- */

/* Who touches whom. */
static kith_status note_neighbors(struct kith_diffusion *self, const struct border *border) {
  KITH_TRY(kith_resize(&self->allowed, 0, (size_t)border->n_entries, sizeof *self->allowed));
  self->n_allowed = 0;
  for (int64_t i = 0; i < border->n_entries; ++i) {
    const uint64_t pair = border->key[border->order[i]] / SCORES;
    if (self->n_allowed == 0 || self->allowed[self->n_allowed - 1] != pair)
      self->allowed[self->n_allowed++] = pair;
  }
  return kith_resize(&self->allowed, (size_t)self->n_allowed, (size_t)self->n_allowed, sizeof *self->allowed);
}

static kith_status begin(struct kith_partition *partition, struct kith_diffusion *self, int32_t *owner) {
  const struct kith_cells *cells = partition->cells;
  struct kith_partition *map = NULL;
  KITH_TRY(kith_partition_create(&map, cells, partition->n_ranks, self->on_morton ? "morton" : "cart"));
  memcpy(owner, map->owner, (size_t)cells->n * sizeof *owner);
  kith_partition_destroy(&map);
  struct border border = {0};
  kith_status status = border_find(&border, cells, owner, partition->n_ranks);
  if (status == KITH_OK) status = note_neighbors(self, &border);
  if (status == KITH_OK) self->restart = false;
  border_clear(&border);
  return status;
}

static kith_status diffusion_first(struct kith_partition *partition, int32_t *owner) {
  return begin(partition, partition->self, owner);
}

static kith_status diffusion_update(struct kith_partition *partition, const double *weight,
                                    const double *face_weight, int32_t *owner) {
  (void)face_weight;
  struct kith_diffusion *self = partition->self;
  if (self->restart) KITH_TRY(begin(partition, self, owner));
  struct border border = {0};
  struct wave wave = {partition->cells, self, weight, partition->n_ranks, owner, NULL, NULL};
  const size_t n_ranks = (size_t)partition->n_ranks;
  kith_status status = kith_resize(&wave.load, 0, n_ranks, sizeof *wave.load);
  if (status == KITH_OK) status = kith_resize(&wave.cells_of, 0, n_ranks, sizeof *wave.cells_of);
  if (status == KITH_OK) status = border_find(&border, wave.cells, owner, wave.n_ranks);
  if (status == KITH_OK) run(&wave, &border);
  kith_free(&wave.load);
  kith_free(&wave.cells_of);
  border_clear(&border);
  return status;
}

static void diffusion_command(struct kith_partition *partition, int word) {
  struct kith_diffusion *self = partition->self;
  if (word <= KITH_SECOND_ORDER)
    self->flow = (enum kith_diffusion_flow)word;
  else if (word <= KITH_SECOND_ORDER + 2)
    self->fixed = word == KITH_SECOND_ORDER + 1;
  else
    self->on_morton = word == KITH_SECOND_ORDER + 4, self->restart = true;
}

static void diffusion_clear(struct kith_partition *partition) {
  struct kith_diffusion *self = partition->self;
  kith_free(&self->allowed);
}

/* The flows in the order of their enumeration; then the neighborhood, `fixed` to that of the start; then the start. */
static const char *const WORDS[] = {"willebeek", "schornbaum", "second-order", "fixed",
                                    "free",      "cart",       "morton",       NULL};

const struct kith_partitioner_ops kith_partitioner_diffusion = {
    .name = "diffusion",
    .doc = "cells flow to neighbor ranks that have less to do, one layer an update",
    .words = WORDS,
    .state_size = sizeof(struct kith_diffusion),
    .command = diffusion_command,
    .first = diffusion_first,
    .update = diffusion_update,
    .clear = diffusion_clear,
};
