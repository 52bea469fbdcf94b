/* sweep.c - the walk over the cells of a spacetree, parents before their children. */
#include "lib/neighbor/spacetree_cells.h"

#include <string.h>

/* A cell on the way from level 0 to the present one, and its local set, which is part of the active set. */
struct step {
  int64_t cell[NDIM];
  int n, runs; /* how many vertices of it have nodes; where their runs begin in the active set */
  kith_index vertex[2 << NDIM]; /* [n] these vertices */
  int run[2 << NDIM];           /* [n] where the runs of each begin */
};

struct walk {
  const struct kith_search *search;
  const struct kith_sweep *sweep; /* NULL: to count how often vertices are entered */
  void *context;
  struct kith_keyed *item[2]; /* slots by the cell that they are in; scratch */
  size_t items_capacity;
  kith_index *target;
  /* [n_vertices] how many cells that have the vertex are still to be left; negative until it is touched. */
  int *left;
  struct kith_runs active;
  int depth; /* levels on the way */
  struct step way[KITH_SPACETREE_LEVELS];
};

/* A key by which parents come before their children: the first of the finest cells in the cell, then the
 * level. */
static uint64_t cell_key(const struct kith_spacetree *tree, const int64_t *cell, int level) {
  uint64_t first[NDIM];
  for (int a = 0; a < NDIM; ++a) first[a] = (uint64_t)cell[a] << (tree->deepest - level);
  return kith_sfc_key_of_cell(first) << KITH_LEVEL_BITS | (uint64_t)level;
}

static void cell_of(const struct kith_search *search, kith_index slot, int level, int64_t *cell) {
  for (int a = 0; a < NDIM; ++a)
    cell[a] = kith_spacetree_cell(search->self, level, a, search->coordinate[a][slot]);
}

static kith_status list_cells(struct walk *w) {
  const struct kith_search *search = w->search;
  const struct kith_spacetree *tree = search->self;
  kith_index n = 0;
  KITH_TRY(kith_keyed_grow(w->item, &w->items_capacity, (size_t)search->n));
  for (kith_index v = 0; v < tree->n_vertices; ++v) {
    const int level = kith_spacetree_layer(tree->vertex[v].key) % KITH_SPACETREE_LEVELS;
    for (kith_index r = tree->vertex[v].run; r < tree->vertex[v + 1].run; ++r)
      for (kith_index slot = tree->run[r].first; slot < tree->run[r].first + tree->run[r].count; ++slot) {
        int64_t cell[NDIM];
        cell_of(search, slot, level, cell);
        w->item[0][n++] = (struct kith_keyed){cell_key(tree, cell, level), slot};
      }
  }
  KITH_TRY(kith_keyed_sort(w->item[0], w->item[1], (size_t)search->n));
  for (kith_index k = 0; k < search->n; ++k) w->target[k] = w->item[0][k].node;
  return KITH_OK;
}

/* The runs of a vertex, at the end of the active set. */
static kith_status add_runs(struct walk *w, kith_index v) {
  const struct kith_spacetree *tree = w->search->self;
  const kith_index first = tree->vertex[v].run, end = tree->vertex[v + 1].run;
  struct kith_runs *runs = &w->active;
  const size_t n = (size_t)runs->n, more = (size_t)(end - first);
  KITH_TRY(kith_grow(&runs->run, &runs->capacity, n, n + more, sizeof *runs->run));
  memcpy(runs->run + n, tree->run + first, more * sizeof *runs->run);
  runs->n += end - first;
  return KITH_OK;
}

static kith_status touch(const struct walk *w, const struct step *step, int k,
                         kith_status (*event)(void *, const struct kith_run *, int)) {
  const int end = k + 1 < step->n ? step->run[k + 1] : w->active.n;
  return event != NULL ? event(w->context, w->active.run + step->run[k], end - step->run[k]) : KITH_OK;
}

/* Goes down to a cell: adds its local set, the nodes of its 2^d vertices, internal ones and ghosts. */
static kith_status enter(struct walk *w, int level, const int64_t *cell) {
  const struct kith_spacetree *tree = w->search->self;
  struct step *step = &w->way[w->depth++];
  *step = (struct step){.runs = w->active.n};
  for (int a = 0; a < NDIM; ++a) step->cell[a] = cell[a];
  for (int k = 0; k < 2 << NDIM; ++k) {
    const struct kith_layer *layer = &tree->layer[(k >> NDIM) * KITH_SPACETREE_LEVELS + level];
    const kith_index end = layer->vertex + layer->vertices;
    uint64_t corner[NDIM];
    for (int a = 0; a < NDIM; ++a) corner[a] = (uint64_t)(cell[a] + (k >> a & 1));
    const uint64_t key =
        (uint64_t)(k >> NDIM << KITH_LEVEL_BITS | level) << KITH_VERTEX_BITS | kith_sfc_key_of_cell(corner);
    const kith_index v = kith_key_bound(tree->vertex, sizeof *tree->vertex, layer->vertex, end, key);
    if (v == end || tree->vertex[v].key != key) continue;
    step->vertex[step->n] = v, step->run[step->n++] = w->active.n;
    if (w->sweep == NULL) {
      w->left[v] -= 1;
      continue;
    }
    KITH_TRY(add_runs(w, v));
    if (w->left[v] >= 0) continue;
    w->left[v] = -w->left[v];
    KITH_TRY(touch(w, step, step->n - 1, w->sweep->touch_first));
  }
  return KITH_OK;
}

static kith_status leave(struct walk *w) {
  const struct step *step = &w->way[--w->depth];
  for (int k = step->n - 1; k >= 0 && w->sweep != NULL; --k) {
    if (--w->left[step->vertex[k]] == 0) KITH_TRY(touch(w, step, k, w->sweep->touch_last));
    w->active.n = step->run[k];
  }
  return KITH_OK;
}

/* Goes from the present cell to another one: up to a common ancestor, and down. */
static kith_status go(struct walk *w, int level, const int64_t *cell) {
  for (bool is_ancestor = false; w->depth > 0 && !is_ancestor;) {
    const int up = level - (w->depth - 1);
    is_ancestor = up > 0;
    for (int a = 0; a < NDIM && is_ancestor; ++a) is_ancestor = cell[a] >> up == w->way[w->depth - 1].cell[a];
    if (!is_ancestor) KITH_TRY(leave(w));
  }
  while (w->depth <= level) {
    int64_t on_the_way[NDIM];
    for (int a = 0; a < NDIM; ++a) on_the_way[a] = cell[a] >> (level - w->depth);
    KITH_TRY(enter(w, w->depth, on_the_way));
  }
  return KITH_OK;
}

static kith_status walk(struct walk *w) {
  const struct kith_search *search = w->search;
  const struct kith_keyed *item = w->item[0];
  for (kith_index k = 0, end; k < search->n; k = end) {
    const int level = (int)(item[k].key & ((1 << KITH_LEVEL_BITS) - 1));
    int64_t cell[NDIM];
    cell_of(search, item[k].node, level, cell);
    for (end = k + 1; end < search->n && item[end].key == item[k].key;) ++end;
    KITH_TRY(go(w, level, cell));
    if (w->sweep == NULL) continue;
    const struct kith_cell event = {.target = w->target + k,
                                    .targets = end - k,
                                    .active = w->active.run,
                                    .n_active = w->active.n,
                                    .n_coarser = w->way[level].runs};
    KITH_TRY(w->sweep->cell(w->context, &event));
  }
  while (w->depth > 0) KITH_TRY(leave(w));
  return KITH_OK;
}

kith_status kith_spacetree_sweep(const struct kith_search *search, const struct kith_sweep *sweep,
                                 void *context) {
  const struct kith_spacetree *tree = search->self;
  struct walk w = {.search = search, .context = context};
  for (int l = 0; l < 2 * KITH_SPACETREE_LEVELS; ++l)
    if (4 * tree->layer[l].radius2 > pow(ldexp(tree->edge, -(l % KITH_SPACETREE_LEVELS)), 2))
      KITH_FAIL(UNSUPPORTED, "search radius %g is too large for cells", sqrt(tree->layer[l].radius2));
  kith_status status = kith_resize(&w.target, 0, (size_t)search->n, sizeof *w.target);
  if (status == KITH_OK) status = kith_resize(&w.left, 0, (size_t)tree->n_vertices, sizeof *w.left);
  if (status == KITH_OK) status = list_cells(&w);
  if (status == KITH_OK) status = walk(&w);
  w.sweep = sweep;
  if (status == KITH_OK) status = walk(&w);
  kith_runs_clear(&w.active);
  KITH_FREE(&w.item[0], &w.item[1], &w.target, &w.left);
  return status;
}
