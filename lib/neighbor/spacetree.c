/* spacetree.c - levels of cells by search radius, sorted by what has moved (spacetree_cells.h).
 *
 * An update reads the positions of the nodes: until the next one all sets of cells are those of these
 * positions. The nodes that have left their vertex are sorted and merged with the others, O(n). If they are
 * many, or nodes have been reordered, or the frame does not suit any more, all are sorted from scratch, O(n).
 *
 * Counters tell how nodes left their vertices, as if each were lifted from parent to parent until its old and
 * new place are at the same or at adjacent vertices, and then dropped to its level. A node that needs no lift
 * has moved; one that went farther than to an adjacent vertex of its level has tunnelled.
 *
 * contiguous   slots follow the items: a vertex is a run of slots. A node that moves changes its slot
 * scattered    slots are nodes, vertices hold lists of them: a vertex is as many runs as its nodes are apart
 *
 * coarse O(levels log n + found); update_selected O(n), but O(selected) if none leaves its vertex, now and
 * the last time. */
#include "lib/neighbor/spacetree_cells.h"

#include <stdlib.h>
#include <string.h>

enum {
  GROUP = 12, /* most targets of a group */
  BLOCK = 8,  /* vertices: fewer are tested one by one */
  MANY = 8,   /* if more than n / MANY have left, all are sorted from scratch */
};
/* Relative margins: of a cell over two search radii, beyond rounding; of the frame, so that it lasts. */
static const double loose = 1e-9, growth = 1.05, room = 1.25;

enum { SORTS, MOVES, LIFTS, DROPS, TUNNELS };
static const char *const counters[] = {
    [SORTS] = "sorts from scratch", [MOVES] = "moves to an adjacent vertex", [LIFTS] = "levels lifted",
    [DROPS] = "levels dropped",     [TUNNELS] = "nodes that tunnelled",      NULL};

struct spacetree_settings {
  bool scattered;
};
static const struct kith_param params[] = {
    {"layout", KITH_PARAM_CHOICE, "contiguous", "contiguous|scattered",
     "the nodes of a vertex follow one another in memory, or stay where they are",
     KITH_INTO(struct spacetree_settings, scattered), .restart_may_change = true},
    {0}};

static bool is_scattered(const struct kith_search *search) {
  return search->settings != NULL && ((const struct spacetree_settings *)search->settings)->scattered;
}

static void spacetree_clear(struct kith_search *search) {
  struct kith_spacetree *tree = search->self;
  KITH_FREE(&tree->item[0], &tree->item[1], &tree->vertex, &tree->run, &tree->place);
}

/* Keys. */

static inline int finest_level(const struct kith_spacetree *tree, double radius) {
  int level = 0;
  for (double half = 0.25 * tree->edge; level < tree->deepest && radius * (1 + loose) <= half; half *= 0.5)
    ++level;
  return level;
}

static inline uint64_t item_key(const struct kith_search *search, kith_index i) {
  const struct kith_spacetree *tree = search->self;
  const double *x = search->position->f64 + (size_t)i * NDIM;
  const int level = finest_level(tree, search->radius->f64[i]);
  uint64_t vertex[NDIM];
  for (int a = 0; a < NDIM; ++a) vertex[a] = (uint64_t)kith_spacetree_vertex(tree, level, a, x[a]);
  return (uint64_t)(i >= search->n_internal) << (KITH_LEVEL_BITS + KITH_VERTEX_BITS) |
         (uint64_t)level << KITH_VERTEX_BITS | kith_sfc_key_of_cell(vertex);
}

/* Chooses the frame and the widths of cells, unless the present ones still suit. Are they new? */
static bool choose_frame(struct kith_search *search) {
  struct kith_spacetree *tree = search->self;
  const struct kith_box box = kith_box_around(search->position->f64, search->n);
  const double *least = box.lower, *most = box.upper, bound = kith_search_largest_radius(search);
  double extent = 0;
  bool within = tree->edge > 0;
  for (int a = 0; a < NDIM; ++a) {
    extent = KITH_MAX(extent, most[a] - least[a]);
    within = within && least[a] >= tree->lower[a] && most[a] <= tree->lower[a] + tree->width;
  }
  if (!(extent < INFINITY)) extent = 0; /* everything in the outermost cells */
  /* Nodes without a radius: about one for each cell. */
  const bool any = bound > 0 && bound < INFINITY;
  const double edge = any ? 2 * bound * (1 + 2 * loose) : extent / kith_root_dim(1 + search->n);
  if (within && edge <= tree->edge && edge > 0.25 * tree->edge && extent > 0.25 * tree->width) return false;
  int bits;
  tree->width = extent > 0 ? room * extent : 1;
  tree->edge = KITH_MAX(growth * edge, ldexp(tree->width, -KITH_CELL_BITS));
  frexp(tree->width / tree->edge, &bits); /* 2^bits cells of level 0 are wider than the frame */
  tree->deepest = any ? KITH_MIN(KITH_CELL_BITS - KITH_MAX(bits, 0), KITH_SPACETREE_LEVELS - 1) : 0;
  tree->deepest = KITH_MAX(tree->deepest, 0);
  for (int l = 0; l <= tree->deepest; ++l) tree->per_length[l] = ldexp(1 / tree->edge, l);
  for (int a = 0; a < NDIM; ++a)
    tree->lower[a] = extent > 0 ? 0.5 * (least[a] + most[a] - tree->width) : search->n > 0 ? least[a] : 0;
  return true;
}

/* Sorting. */

/* Counts how the node of a slot left its vertex: from level `from` and the packed coordinates to level `to`
 * and its present position. */
static void count_move(const struct kith_search *search, kith_index slot, int from, int to,
                       uint64_t count[KITH_SEARCH_COUNTERS]) {
  const struct kith_spacetree *tree = search->self;
  const double *x = search->position->f64 + (size_t)search->node[slot] * NDIM;
  for (int level = from;; --level) {
    bool adjacent = true;
    for (int a = 0; a < NDIM; ++a) {
      const int64_t hop = kith_spacetree_vertex(tree, level, a, x[a]) -
                          kith_spacetree_vertex(tree, level, a, search->coordinate[a][slot]);
      adjacent = adjacent && hop >= -1 && hop <= 1;
    }
    count[TUNNELS] += level == from && !adjacent;
    if (level > 0 && (level > to || !adjacent)) continue;
    count[MOVES] += level == from && level == to;
    count[LIFTS] += (uint64_t)(from - level);
    count[DROPS] += (uint64_t)(to - level);
    return;
  }
}

static inline int level_of_key(uint64_t key) {
  return (int)(key >> KITH_VERTEX_BITS) & ((1 << KITH_LEVEL_BITS) - 1);
}

static inline kith_index slot_of(const struct kith_search *search, kith_index item) {
  const struct kith_spacetree *tree = search->self;
  return is_scattered(search) ? tree->item[0][item].node : item;
}

/* Makes items of nodes first .. n - 1, in the places of these numbers, and sorts them. */
static kith_status sort_all(struct kith_search *search, kith_index first) {
  struct kith_spacetree *tree = search->self;
  if (first == search->n) return KITH_OK;
#pragma omp parallel for schedule(static) if (search->n > KITH_FEW_COPIES)
  for (kith_index i = first; i < search->n; ++i)
    tree->item[0][i] = (struct kith_keyed){item_key(search, i), i};
  return kith_keyed_sort(tree->item[0] + first, tree->item[1] + first, (size_t)(search->n - first));
}

/* Sorts the items of internal nodes again after the nodes have moved. Returns false, with nothing sorted, if
 * too many have left their vertices. */
static bool sort_moved(struct kith_search *search) {
  struct kith_spacetree *tree = search->self;
  const kith_index n = search->n_internal;
  struct kith_keyed *item = tree->item[0], *in = tree->item[1];
  kith_index left = 0;
  uint64_t count[KITH_SEARCH_COUNTERS] = {0};
#pragma omp parallel for schedule(static) reduction(+ : left, count[:KITH_SEARCH_COUNTERS])
  for (kith_index k = 0; k < n; ++k) {
    in[k] = (struct kith_keyed){item_key(search, item[k].node), item[k].node};
    if (in[k].key == item[k].key) continue;
    count_move(search, slot_of(search, k), level_of_key(item[k].key), level_of_key(in[k].key), count);
    left += 1;
  }
  memcpy(search->count, count, sizeof count);
  if (left > n / MANY) return false;
  left = 0;
  for (kith_index k = 0; k < n; ++k)
    if (in[k].key != item[k].key) in[left++] = in[k], item[k].node = -1;
  kith_keyed_replace(item, n, in, left);
  return true;
}

/* Lists the vertices, their runs of slots, and the layers, from the sorted items. */
static kith_status list_vertices(struct kith_search *search) {
  struct kith_spacetree *tree = search->self;
  const struct kith_keyed *item = tree->item[0];
  const size_t n = (size_t)search->n;
  KITH_TRY(kith_reserve(&tree->vertex, &tree->vertices_capacity, n + 1, sizeof *tree->vertex));
  KITH_TRY(kith_reserve(&tree->run, &tree->runs_capacity, n, sizeof *tree->run));
  memset(tree->layer, 0, sizeof tree->layer);
  tree->n_vertices = 0;
  struct kith_layer *layer = tree->layer;
  kith_index runs = 0;
  for (kith_index k = 0; k < search->n; ++k) {
    const kith_index slot = slot_of(search, k);
    const bool first = k == 0 || item[k].key != item[k - 1].key;
    if (first) {
      layer = &tree->layer[kith_spacetree_layer(item[k].key)];
      if (layer->vertices++ == 0) layer->vertex = tree->n_vertices;
      tree->vertex[tree->n_vertices++] = (struct kith_vertex){item[k].key, runs};
    }
    layer->radius2 = KITH_MAX(layer->radius2, search->radius2[slot]);
    if (first || tree->run[runs - 1].first + tree->run[runs - 1].count != slot)
      tree->run[runs++] = (struct kith_run){slot, 1};
    else
      ++tree->run[runs - 1].count;
  }
  tree->vertex[tree->n_vertices] = (struct kith_vertex){UINT64_MAX, runs};
  return KITH_OK;
}

/* Groups of consecutive slots: contiguous ones are of one vertex; scattered ones are of any nodes, which are
 * close together because nodes are ordered along a curve. */
static kith_status list_groups(struct kith_search *search) {
  const struct kith_keyed *item = ((struct kith_spacetree *)search->self)->item[0];
  const bool scattered = is_scattered(search);
  search->n_groups = 0;
  for (kith_index s = 0, group = 0; s < search->n; ++s) {
    const bool last = s + 1 == search->n || s + 1 - group == GROUP || s + 1 == search->n_internal ||
                      (!scattered && item[s + 1].key != item[s].key);
    if (!last) continue;
    KITH_TRY(kith_search_group(search, group, s + 1 - group));
    group = s + 1;
  }
  return KITH_OK;
}

/* Makes slots, groups, vertices, runs and layers from the sorted items. */
static kith_status list_all(struct kith_search *search) {
  struct kith_spacetree *tree = search->self;
  const bool scattered = is_scattered(search);
#pragma omp parallel for schedule(static)
  for (kith_index s = 0; s < search->n; ++s) search->node[s] = scattered ? s : tree->item[0][s].node;
  kith_search_pack(search, 0, search->n);
  tree->placed = false;
  KITH_TRY(list_groups(search));
  return list_vertices(search);
}

static kith_status spacetree_update(struct kith_search *search) {
  struct kith_spacetree *tree = search->self;
  const size_t capacity = tree->items_capacity;
  KITH_TRY(kith_keyed_grow(tree->item, &tree->items_capacity, (size_t)search->n));
  const bool kept = tree->items_capacity == capacity; /* new room holds no items */
  const bool same =
      !choose_frame(search) && kept && tree->order == search->nodes->order && search->n_internal > 0;
  tree->order = UINT64_MAX; /* until all is sorted */
  const bool sorted = same && sort_moved(search);
  KITH_TRY(sort_all(search, sorted ? search->n_internal : 0));
  search->count[SORTS] += !sorted;
  tree->order = search->nodes->order;
  return list_all(search);
}

/* Selected updates. */

/* The place of each node among the items, unless it is known. */
static kith_status find_places(struct kith_search *search) {
  struct kith_spacetree *tree = search->self;
  if (tree->placed) return KITH_OK;
  KITH_TRY(kith_reserve(&tree->place, &tree->places_capacity, (size_t)search->n + 1, sizeof *tree->place));
#pragma omp parallel for schedule(static)
  for (kith_index k = 0; k < search->n; ++k) tree->place[tree->item[0][k].node] = k;
  tree->placed = true;
  return KITH_OK;
}

static void drop_ghosts(struct kith_search *search) {
  struct kith_spacetree *tree = search->self;
  struct kith_layer *ghosts = tree->layer + KITH_SPACETREE_LEVELS;
  for (int l = 0; l < KITH_SPACETREE_LEVELS; ++l) {
    tree->n_vertices -= ghosts[l].vertices;
    ghosts[l] = (struct kith_layer){0};
  }
}

/* Packs node i where it is now. If it has left its vertex, its new item goes to item[1], which holds
 * *left. */
static void repack(struct kith_search *search, kith_index i, kith_index *left) {
  struct kith_spacetree *tree = search->self;
  struct kith_keyed *item = &tree->item[0][tree->place[i]];
  const kith_index slot = is_scattered(search) ? i : tree->place[i];
  const uint64_t key = item_key(search, i);
  if (item->node < 0) return; /* it has left already */
  if (key != item->key) {
    count_move(search, slot, level_of_key(item->key), level_of_key(key), search->count);
    tree->item[1][(*left)++] = (struct kith_keyed){key, i};
    item->node = -1;
  }
  kith_search_pack_slot(search, slot);
  struct kith_layer *layer = &tree->layer[kith_spacetree_layer(key)];
  layer->radius2 = KITH_MAX(layer->radius2, search->radius2[slot]);
}

static kith_status spacetree_update_selected(struct kith_search *search, const kith_index *nodes,
                                             kith_index count) {
  struct kith_spacetree *tree = search->self;
  kith_index left = 0;
  for (kith_index k = 0; k < count; ++k)
    if (!(2 * search->radius->f64[nodes[k]] * (1 + loose) <= tree->edge)) return spacetree_update(search);
  if (search->n == search->n_internal) drop_ghosts(search);
  KITH_TRY(find_places(search));
  for (kith_index k = 0; k < count; ++k) repack(search, nodes[k], &left);
  if (left == 0) return KITH_OK;
  kith_keyed_replace(tree->item[0], search->n, tree->item[1], left);
  return list_all(search);
}

/* Queries. */

/* Vertices first[a] .. last[a] along each axis, in the bits of that axis of a Morton code. */
struct vertex_range {
  uint64_t axis[NDIM], first[NDIM], last[NDIM];
};

/* Of the vertices between two codes, in each axis: 1 if all are in the range, -1 if none is, 0 if some
 * are. */
static inline int range_holds(const struct vertex_range *range, uint64_t least, uint64_t most) {
  int holds = 1;
  for (int a = 0; a < NDIM; ++a) {
    const uint64_t low = least & range->axis[a], high = most & range->axis[a];
    if (high < range->first[a] || low > range->last[a]) return -1;
    if (low < range->first[a] || high > range->last[a]) holds = 0;
  }
  return holds;
}

static kith_status take_runs(const struct kith_spacetree *tree, kith_index first, kith_index end,
                             struct kith_runs *runs) {
  for (kith_index r = tree->vertex[first].run; r < tree->vertex[end].run; ++r)
    KITH_TRY(kith_runs_add(runs, tree->run[r].first, tree->run[r].count));
  return KITH_OK;
}

/* Adds the runs of those of vertices first .. end - 1 that are in the range. They are all the vertices with
 * nodes of a cube, which has 2^bits vertices along each axis. */
static kith_status visit_cube(const struct kith_spacetree *tree, kith_index first, kith_index end, int bits,
                              const struct vertex_range *range, struct kith_runs *runs) {
  const struct kith_vertex *vertex = tree->vertex;
  const uint64_t size = UINT64_C(1) << NDIM * bits, least = vertex[first].key & ~(size - 1);
  const int holds = range_holds(range, least, least | (size - 1));
  if (holds < 0) return KITH_OK;
  if (holds > 0) return take_runs(tree, first, end, runs);
  if (end - first <= BLOCK) {
    for (kith_index v = first; v < end; ++v)
      if (range_holds(range, vertex[v].key, vertex[v].key) > 0) KITH_TRY(take_runs(tree, v, v + 1, runs));
    return KITH_OK;
  }
  for (uint64_t child = least, part = size >> NDIM; child < least + size; child += part) {
    if (range_holds(range, child, child | (part - 1)) < 0) continue;
    first = kith_key_bound(vertex, sizeof *vertex, first, end, child);
    const kith_index stop = kith_key_bound(vertex, sizeof *vertex, first, end, child + part);
    if (first < stop) KITH_TRY(visit_cube(tree, first, stop, bits - 1, range, runs));
  }
  return KITH_OK;
}

/* Adds the runs of the vertices of layer `number` within `radius` of the box. */
static kith_status query_vertices(const struct kith_search *search, int number, const struct kith_box *box,
                                  double radius, struct kith_runs *runs) {
  const struct kith_spacetree *tree = search->self;
  const struct kith_layer *layer = &tree->layer[number];
  const kith_index end = layer->vertex + layer->vertices;
  const int level = number % KITH_SPACETREE_LEVELS;
  struct vertex_range range;
  for (int a = 0; a < NDIM; ++a) {
    const int shift = NDIM - 1 - a;
    const int64_t first = kith_spacetree_vertex(tree, level, a, box->lower[a] - radius),
                  last = kith_spacetree_vertex(tree, level, a, box->upper[a] + radius);
    range.axis[a] = kith_sfc_key_spread((UINT64_C(1) << (KITH_CELL_BITS + 1)) - 1) << shift;
    range.first[a] = kith_sfc_key_spread((uint64_t)first) << shift;
    range.last[a] = kith_sfc_key_spread((uint64_t)last) << shift;
  }
  /* The smallest cube that has them all. */
  const uint64_t differing = tree->vertex[layer->vertex].key ^ tree->vertex[end - 1].key;
  const int bits = differing == 0 ? 0 : (64 - __builtin_clzll(differing) + NDIM - 1) / NDIM;
  return visit_cube(tree, layer->vertex, end, bits, &range, runs);
}

static int compare_runs(const void *a, const void *b) {
  const struct kith_run *p = a, *q = b;
  return (p->first > q->first) - (p->first < q->first);
}

/* Sorts runs, and merges adjacent ones. */
static kith_status order_runs(struct kith_runs *runs) {
  const int n = runs->n;
  if (n == 0) return KITH_OK;
  qsort(runs->run, (size_t)n, sizeof *runs->run, compare_runs);
  runs->n = 0;
  for (int r = 0; r < n; ++r) KITH_TRY(kith_runs_add(runs, runs->run[r].first, runs->run[r].count));
  return KITH_OK;
}

static kith_status spacetree_coarse(const struct kith_search *search, const struct kith_box *box,
                                    double radius, enum kith_search_mode mode, struct kith_runs *runs) {
  const struct kith_spacetree *tree = search->self;
  for (int l = 0; l < 2 * KITH_SPACETREE_LEVELS; ++l) {
    if (tree->layer[l].vertices == 0) continue;
    const double own = mode == KITH_SCATTER ? 0 : radius,
                 largest = mode == KITH_GATHER ? 0 : sqrt(tree->layer[l].radius2);
    KITH_TRY(query_vertices(search, l, box, KITH_MAX(own, largest) * (1 + KITH_SEARCH_SLACK), runs));
  }
  return is_scattered(search) ? order_runs(runs) : KITH_OK;
}

static size_t spacetree_bytes(const struct kith_search *search) {
  const struct kith_spacetree *tree = search->self;
  return 2 * tree->items_capacity * sizeof **tree->item + tree->vertices_capacity * sizeof *tree->vertex +
         tree->runs_capacity * sizeof *tree->run + tree->places_capacity * sizeof *tree->place;
}

const struct kith_search_ops kith_search_spacetree = {
    .name = "spacetree",
    .doc = "cells of levels by search radius, with local and active sets that passes can sweep over",
    KITH_SETTINGS(params, spacetree_settings),
    .state_size = sizeof(struct kith_spacetree),
    .counters = counters,
    .clear = spacetree_clear,
    .update = spacetree_update,
    .update_selected = spacetree_update_selected,
    .coarse = spacetree_coarse,
    .sweep = kith_spacetree_sweep,
    .bytes = spacetree_bytes,
};
