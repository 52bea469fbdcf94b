/* ghost_candidates.c - boxes against boxes first, then nodes. */
#include "lib/domain/ghost_candidates.h"

#include <omp.h>

enum { GROUP_SIZE = 64 };

static inline void include(struct kith_bounds *to, const struct kith_bounds *from) {
  if (!(from->search_radius >= 0)) return;
  if (!(to->search_radius >= 0)) to->box = kith_box_empty();
  kith_box_join(&to->box, &from->box);
  to->search_radius = KITH_MAX(to->search_radius, from->search_radius);
}

static inline struct kith_bounds bounds_of(const struct kith_nodes *nodes, kith_index i) {
  struct kith_bounds node = {.search_radius = nodes->search_radius->f64[i]};
  for (int a = 0; a < NDIM; ++a)
    node.box.lower[a] = node.box.upper[a] = nodes->position->f64[(size_t)i * NDIM + (size_t)a];
  return node;
}

/* Bounds of nodes begin .. end - 1 without those that are marked (mark may be NULL). */
static inline struct kith_bounds bounds_of_run(const struct kith_nodes *nodes, kith_index begin,
                                               kith_index end, const uint8_t *mark) {
  const double *restrict x = nodes->position->f64, *restrict radius = nodes->search_radius->f64;
  struct kith_bounds run = {.search_radius = -1, .box = kith_box_empty()};
  for (kith_index i = begin; i < end; ++i) {
    if (mark != NULL && mark[i]) continue;
    run.search_radius = KITH_MAX(run.search_radius, radius[i]);
    kith_box_include(&run.box, x + (size_t)i * NDIM);
  }
  return run.search_radius >= 0 ? run : kith_nowhere;
}

/* Square of the distance between boxes, or images of them along axes with a period (0: none). */
static inline double box_distance2(const double period[NDIM], const struct kith_box *a,
                                   const struct kith_box *b) {
  double s = 0;
  for (int k = 0; k < NDIM; ++k) {
    const double gap = kith_gap(b->lower[k] - a->upper[k], a->lower[k] - b->upper[k], period[k]);
    s += gap * gap;
  }
  return s;
}

/* d^2 <= (factor r)^2, no tighter than rounding could make it. */
static inline bool is_within(double d2, double factor, double r) {
  return d2 <= factor * factor * r * r * (1 + 1e-14);
}

/* Is a node, or may one of a group be, near the cell? */
static inline bool is_near(const struct kith_candidates *c, const struct kith_bounds *group,
                           const struct kith_bounds *cell, double factor) {
  return group->search_radius >= 0 && is_within(box_distance2(c->period, &group->box, &cell->box), factor,
                                                KITH_MAX(group->search_radius, cell->search_radius));
}

double kith_bounds_widest(const struct kith_bounds *own, const struct kith_cells *cells,
                          const struct kith_bounds *all, size_t n) {
  double search_radius = own->search_radius, period[NDIM];
  for (int a = 0; a < NDIM; ++a) period[a] = kith_cells_period(cells, a);
  for (size_t k = 0; k < n; ++k)
    if (all[k].search_radius > search_radius &&
        is_within(box_distance2(period, &own->box, &all[k].box), 1, all[k].search_radius))
      search_radius = all[k].search_radius;
  return search_radius;
}

/* --- candidates --- */

static void mark_frozen(const struct kith_nodes *nodes, uint8_t *frozen) {
  for (int b = 0; b < nodes->n_blocks; ++b) {
    const struct kith_ghost_block *block = &nodes->blocks[b];
#pragma omp parallel for schedule(static) if (block->count > 10000)
    for (kith_index k = 0; k < block->count; ++k)
      frozen[block->first + k] = block->control == NULL || frozen[block->control[k]];
  }
}

kith_status kith_candidates_gather(struct kith_candidates *c, const struct kith_nodes *nodes) {
  c->n = kith_nodes_count(nodes);
  c->groups = (c->n + GROUP_SIZE - 1) / GROUP_SIZE;
  c->all = kith_nowhere;
  c->period = nodes->shifts.length;
  KITH_TRY(kith_resize(&c->hit, 0, (size_t)c->groups, 1));
  KITH_TRY(kith_resize(&c->mark, 0, (size_t)c->n, 1));
  KITH_TRY(kith_resize(&c->group, 0, (size_t)c->groups, sizeof *c->group));
  mark_frozen(nodes, c->mark);
#pragma omp parallel for schedule(static) if (c->groups > 64)
  for (int g = 0; g < c->groups; ++g)
    c->group[g] = bounds_of_run(nodes, g * GROUP_SIZE, KITH_MIN(c->n, (g + 1) * GROUP_SIZE), c->mark);
  for (int g = 0; g < c->groups; ++g) include(&c->all, &c->group[g]);
  return KITH_OK;
}

/* --- bounds of cells --- */

/* Bounds of internal nodes begin .. end - 1, from those of whole groups if c is not NULL. */
static struct kith_bounds bounds_between(const struct kith_candidates *c, const struct kith_nodes *nodes,
                                         kith_index begin, kith_index end) {
  const kith_index first = (begin + GROUP_SIZE - 1) / GROUP_SIZE, stop = end / GROUP_SIZE;
  if (c == NULL || first >= stop) return bounds_of_run(nodes, begin, end, NULL);
  struct kith_bounds all = bounds_of_run(nodes, begin, first * GROUP_SIZE, NULL);
  const struct kith_bounds rest = bounds_of_run(nodes, stop * GROUP_SIZE, end, NULL);
  for (kith_index g = first; g < stop; ++g) include(&all, &c->group[g]);
  include(&all, &rest);
  return all;
}

/* Each thread has bounds of its own; the order in which boxes and maxima are joined does not matter.
 * Nodes that follow each other are mostly in the same cell. */
kith_status kith_bounds_find(const struct kith_candidates *candidates, const struct kith_nodes *nodes,
                             const int64_t *home, size_t n, struct kith_bounds **bounds) {
  const int threads = nodes->n_internal > 10000 ? omp_get_max_threads() : 1;
  const size_t all = n * (size_t)threads;
  struct kith_bounds *cell = NULL;
  KITH_TRY(kith_resize(&cell, 0, all, sizeof *cell));
  for (size_t c = 0; c < all; ++c) cell[c] = kith_nowhere;
#pragma omp parallel num_threads(threads)
  {
    const int me = omp_get_thread_num(), team = omp_get_num_threads();
    const kith_index end = kith_part_start(nodes->n_internal, me + 1, team);
    struct kith_bounds *mine = cell + n * (size_t)me;
    for (kith_index i = kith_part_start(nodes->n_internal, me, team), next; i < end; i = next) {
      for (next = i + 1; next < end && home[next] == home[i];) ++next;
      const struct kith_bounds run = bounds_between(candidates, nodes, i, next);
      include(&mine[home[i]], &run);
    }
#pragma omp barrier
#pragma omp for schedule(static)
    for (size_t c = 0; c < n; ++c)
      for (size_t other = c + n; other < all; other += n) include(&cell[c], &cell[other]);
  }
  *bounds = cell;
  return KITH_OK;
}

/* --- candidates near cells --- */

/* `whole`: bounds of all cells, which spare most nodes the test against each cell. */
static void mark_group(const struct kith_candidates *c, const struct kith_nodes *nodes, int g,
                       const struct kith_bounds *whole, const struct kith_bounds *cell, int n,
                       double factor) {
  const kith_index begin = g * GROUP_SIZE, end = KITH_MIN(c->n, begin + GROUP_SIZE);
  kith_index open[GROUP_SIZE]; /* nodes that may be near a cell, and are not marked yet */
  int left = 0;
  c->hit[g] = 0;
  if (!is_near(c, &c->group[g], whole, factor)) return;
  for (kith_index i = begin; i < end; ++i) {
    const struct kith_bounds node = bounds_of(nodes, i);
    if (c->mark[i] == 0 && is_near(c, &node, whole, factor)) open[left++] = i;
  }
  for (int k = 0; k < n && left > 0; ++k) {
    if (!is_near(c, &c->group[g], &cell[k], factor)) continue;
    for (int m = left - 1; m >= 0; --m) {
      const struct kith_bounds node = bounds_of(nodes, open[m]);
      if (is_near(c, &node, &cell[k], factor)) c->mark[open[m]] = 2, c->hit[g] = 1, open[m] = open[--left];
    }
  }
}

/* Counts the marked ones of each list (send NULL), or stores them: next[list] is where the next one goes. */
static void sweep(const struct kith_candidates *c, const struct kith_nodes *nodes, int64_t *next,
                  kith_index *send) {
  for (int g = 0; g < c->groups; ++g)
    for (kith_index i = g * GROUP_SIZE; c->hit[g] && i < KITH_MIN(c->n, (g + 1) * GROUP_SIZE); ++i) {
      if (c->mark[i] != 2) continue;
      const int64_t at = next[nodes->list->u8[i]]++;
      if (send == NULL) continue;
      send[at] = i;
      c->mark[i] = 0;
    }
}

/* The marked ones, list by list; the marks go. */
static kith_status collect(struct kith_candidates *c, const struct kith_nodes *nodes, kith_index **send,
                           kith_index *n_send, int64_t *count) {
  int64_t next[KITH_MAX_LISTS], total = 0;
  sweep(c, nodes, count, NULL);
  for (int l = 0; l < nodes->n_lists; ++l) next[l] = total, total += count[l];
  KITH_TRY(kith_resize(send, 0, (size_t)total, sizeof **send));
  sweep(c, nodes, next, *send);
  *n_send = (kith_index)total;
  return KITH_OK;
}

/* Cells that are far from all candidates are skipped, and groups that are far from all cells. */
kith_status kith_candidates_near(struct kith_candidates *c, const struct kith_nodes *nodes,
                                 struct kith_bounds *cell, size_t n, double factor, kith_index **send,
                                 kith_index *n_send, int64_t *count) {
  int near = 0;
  struct kith_bounds whole = kith_nowhere;
  for (size_t k = 0; k < n; ++k)
    if (cell[k].search_radius >= 0 && is_near(c, &c->all, &cell[k], factor))
      include(&whole, &cell[k]), cell[near++] = cell[k];
  *n_send = 0;
  if (near == 0) return KITH_OK;
#pragma omp parallel for schedule(dynamic, 16) if (c->groups > 64)
  for (int g = 0; g < c->groups; ++g) mark_group(c, nodes, g, &whole, cell, near, factor);
  return collect(c, nodes, send, n_send, count);
}

void kith_candidates_clear(struct kith_candidates *c) {
  KITH_FREE(&c->mark, &c->hit, &c->group);
}
