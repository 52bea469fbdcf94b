/* grid.c - nested levels of cells by radius.
 *
 * Level l holds the nodes with radius in (b / 2, b], b = b_0 / 2^l, b_0 the largest radius of the last
 * update; larger ones that come later go to level 0 and the smallest ones to the last level. Its cells are
 * EDGE b wide. Ghosts have levels of their own. So a small node never meets the large cells of a large one,
 * nor a large node more of the small cells than it covers.
 *
 * Slots ascend by (ghost, level, row, cell): a row is a line of cells along the last axis, and the part of it
 * within range is one run. Rows are found through a hash table, so space has no edge; cells beyond
 * 2^GRID_COORDINATE_BITS are clamped to the last one: still correct, but slow.
 *
 * update            O(n): keys, sort, tables
 * append            merges the sorted new nodes in: O(n), about a third of an update
 * update_selected   O(selected) if no node left its cell; else the slots between the first and the last
 *                   change are merged, and the tables made again: about a third of an update, less if motion
 *                   is local
 * coarse            O(rows within range), at most O(rows of a level) for each level */
#include "lib/neighbor/grid_tables.h"

#define EDGE 0.5 /* of a cell, in largest radii of its level */

static void grid_clear(struct kith_search *search) {
  struct kith_grid *grid = search->self;
  for (int k = 0; k < 2; ++k) kith_free(&grid->item[k]), kith_free(&grid->entering[k]);
  kith_free(&grid->slot_of);
  kith_free(&grid->cell);
  kith_free(&grid->row);
  kith_free(&grid->table);
}

/* Keys. */

static inline int level_of(const struct kith_grid *grid, double radius) {
  int level = 0;
  for (double bound = 0.5 * grid->bound; radius <= bound && level < GRID_LEVELS - 1; bound *= 0.5) ++level;
  return level;
}

static inline int64_t clamp(double u) {
  return u > 0 ? (int64_t)(u < GRID_TOP ? u : GRID_TOP) : 0;
}

/* Position in units of cells; the origin of the grid is in the middle of all coordinates. */
static inline double in_cells(const struct kith_grid *grid, int a, double x, double per_length) {
  return (x - grid->origin[a]) * per_length + 0.5 * GRID_TOP;
}

static inline uint64_t key_of(const struct kith_search *search, kith_index i) {
  const struct kith_grid *grid = search->self;
  const int level = level_of(grid, search->nodes->search_radius->f64[i]);
  uint64_t key = (uint64_t)(i >= search->n_internal) << GRID_LEVEL_BITS | (uint64_t)level;
  for (int a = 0; a < NDIM; ++a) {
    const double u =
        in_cells(grid, a, search->nodes->position->f64[(size_t)i * NDIM + a], grid->per_length[level]);
    key = key << GRID_COORDINATE_BITS | (uint64_t)clamp(u);
  }
  return key;
}

static void choose_frame(struct kith_search *search) {
  struct kith_grid *grid = search->self;
  const double *search_radius = search->nodes->search_radius->f64;
  double lower[NDIM], upper[NDIM], bound = 0;
  kith_search_cube(search->nodes->position->f64, search->n, lower, upper);
#pragma omp parallel for schedule(static) reduction(max : bound)
  for (kith_index i = 0; i < search->n; ++i) bound = KITH_MAX(bound, search_radius[i]);
  /* Nodes without a radius: about one for each cell. */
  if (!(bound > 0 && bound < INFINITY)) bound = (upper[0] - lower[0]) / pow(1 + search->n, 1.0 / NDIM);
  grid->bound = bound;
  for (int l = 0; l < GRID_LEVELS; ++l) grid->per_length[l] = ldexp(1 / (EDGE * bound), l);
  for (int a = 0; a < NDIM; ++a) grid->origin[a] = 0.5 * (lower[a] + upper[a]);
}

/* Slots. */

static kith_status grow_items(struct kith_grid *grid, kith_index old_n, kith_index n) {
  KITH_TRY(kith_keyed_grow(grid->item, &grid->items_capacity, (size_t)old_n, (size_t)n));
  return kith_grow(&grid->slot_of, &grid->slots_capacity, (size_t)old_n, (size_t)n, sizeof *grid->slot_of);
}

static void fill_slots(struct kith_search *search, kith_index begin, kith_index end) {
  struct kith_grid *grid = search->self;
#pragma omp parallel for schedule(static) if (end - begin > 10000)
  for (kith_index s = begin; s < end; ++s) {
    search->node[s] = grid->item[0][s].node;
    grid->slot_of[search->node[s]] = s;
  }
  kith_search_pack(search, begin, end - begin);
}

static void find_items(const struct kith_search *search, kith_index first, kith_index n,
                       struct kith_keyed *item) {
#pragma omp parallel for schedule(static) if (n > 10000)
  for (kith_index k = 0; k < n; ++k) item[k] = (struct kith_keyed){key_of(search, first + k), first + k};
}

static kith_status grid_update(struct kith_search *search) {
  struct kith_grid *grid = search->self;
  KITH_TRY(grow_items(grid, 0, search->n));
  choose_frame(search);
  find_items(search, 0, search->n, grid->item[0]);
  KITH_TRY(kith_keyed_sort(grid->item[0], grid->item[1], (size_t)search->n));
  fill_slots(search, 0, search->n);
  return kith_grid_tables(search, 0);
}

static kith_status grid_append(struct kith_search *search, kith_index old_n) {
  struct kith_grid *grid = search->self;
  const kith_index more = search->n - old_n;
  KITH_TRY(grow_items(grid, old_n, search->n));
  KITH_TRY(kith_keyed_grow(grid->entering, &grid->entering_capacity, 0, (size_t)more));
  find_items(search, old_n, more, grid->entering[0]);
  KITH_TRY(kith_keyed_sort(grid->entering[0], grid->entering[1], (size_t)more));
  const kith_index begin = kith_keyed_place(grid->item[0], old_n, grid->entering[0][0].key);
  kith_keyed_merge(grid->item[0] + begin, old_n - begin, grid->entering[0], more, grid->item[1] + begin);
  fill_slots(search, begin, search->n);
  return kith_grid_tables(search, begin);
}

/* Refreshes the slots of nodes that stay in their cells and collects the others. Returns the number of these;
 * extends begin .. end to the slots they leave. */
static kith_index collect_leaving(struct kith_search *search, const kith_index *nodes, kith_index count,
                                  kith_index *begin, kith_index *end) {
  struct kith_grid *grid = search->self;
  kith_index leaving = 0;
  for (kith_index k = 0; k < count; ++k) {
    const kith_index s = grid->slot_of[nodes[k]];
    struct kith_keyed *item = &grid->item[0][s];
    if (item->node < 0) continue; /* was named before */
    const uint64_t key = key_of(search, nodes[k]);
    if (key == item->key) {
      kith_search_pack(search, s, 1);
      struct kith_grid_layer *layer = kith_grid_layer_of(grid, key);
      struct kith_grid_cell *cell = &grid->cell[kith_grid_cell_of_slot(grid, s)];
      layer->radius2 = KITH_MAX(layer->radius2, search->radius2[s]);
      cell->radius2 = KITH_MAX(cell->radius2, search->radius2[s]);
      continue;
    }
    grid->entering[0][leaving++] = (struct kith_keyed){(uint64_t)nodes[k], nodes[k]};
    item->node = -1;
    *begin = KITH_MIN(*begin, s), *end = KITH_MAX(*end, s + 1);
  }
  return leaving;
}

/* Sorts the nodes that leave by key, equal keys by index. */
static kith_status sort_entering(struct kith_search *search, kith_index n) {
  struct kith_grid *grid = search->self;
  struct kith_keyed *item = grid->entering[0];
  KITH_TRY(kith_keyed_sort(item, grid->entering[1], (size_t)n));
#pragma omp parallel for schedule(static) if (n > 10000)
  for (kith_index k = 0; k < n; ++k) item[k].key = key_of(search, item[k].node);
  return kith_keyed_sort(item, grid->entering[1], (size_t)n);
}

static kith_status grid_update_selected(struct kith_search *search, const kith_index *nodes,
                                        kith_index count) {
  struct kith_grid *grid = search->self;
  KITH_TRY(kith_keyed_grow(grid->entering, &grid->entering_capacity, 0, (size_t)count));
  kith_index begin = search->n, end = 0;
  const kith_index leaving = collect_leaving(search, nodes, count, &begin, &end);
  if (leaving == 0) return KITH_OK;
  if (leaving > search->n / 4) return grid_update(search);
  KITH_TRY(sort_entering(search, leaving));
  begin = KITH_MIN(begin, kith_keyed_place(grid->item[0], search->n, grid->entering[0][0].key));
  end = KITH_MAX(end, kith_keyed_place(grid->item[0], search->n, grid->entering[0][leaving - 1].key + 1));
  kith_keyed_merge(grid->item[0] + begin, end - begin, grid->entering[0], leaving, grid->item[1] + begin);
  fill_slots(search, begin, end);
  return kith_grid_tables(search, begin);
}

/* Queries. */

/* The box of the targets in units of the cells of a level, and the search radius around it. */
struct query {
  double lower[NDIM], upper[NDIM], search_radius;
  double targets2,
      cells2; /* squared radius of the targets, and factor of the squared radii of cells; 0: does not count */
  int64_t first[NDIM], last[NDIM]; /* coordinates of cells within range */
};

static inline double square_gap(const struct query *q, int a, int64_t c) {
  const double below = q->lower[a] - (double)(c + 1), above = (double)c - q->upper[a];
  const double gap = KITH_MAX(below, above);
  return gap > 0 ? gap * gap : 0;
}

/* Cells of a row whose coordinates are at least c. */
static inline kith_index cell_from(const struct kith_grid *grid, const struct kith_grid_row *row, int64_t c) {
  kith_index first = row->cell, n = row[1].cell - first;
  const int64_t lowest = grid->cell[first].coordinate;
  if (grid->cell[first + n - 1].coordinate - lowest == n - 1) /* no gaps */
    return first + (kith_index)KITH_MIN(KITH_MAX(c - lowest, 0), n);
  while (n > 0) {
    const kith_index half = n / 2;
    if (grid->cell[first + half].coordinate < c)
      first += half + 1, n -= half + 1;
    else
      n = half;
  }
  return first;
}

/* A cell within range by the largest radius of its level may be out of range by its own. */
static inline bool out_of_range(const struct kith_grid_cell *cell, const struct query *q, double gap2) {
  return gap2 + square_gap(q, NDIM - 1, cell->coordinate) > KITH_MAX(q->cells2 * cell->radius2, q->targets2);
}

/* The cells of a row within range: fewer for a row at some distance. */
static inline kith_status take_row(const struct kith_grid *grid, const struct kith_grid_row *row,
                                   const struct query *q, double gap2, struct kith_runs *runs) {
  const double left = q->search_radius * q->search_radius - gap2;
  if (left < 0) return KITH_OK;
  const double along = sqrt(left) * (1 + KITH_SEARCH_SLACK);
  kith_index first = cell_from(grid, row, clamp(q->lower[NDIM - 1] - along));
  kith_index last = cell_from(grid, row, clamp(q->upper[NDIM - 1] + along) + 1);
  while (first < last && out_of_range(&grid->cell[first], q, gap2)) ++first;
  while (first < last && out_of_range(&grid->cell[last - 1], q, gap2)) --last;
  const kith_index slot = grid->cell[first].slot, count = grid->cell[last].slot - slot;
  return count > 0 ? kith_runs_add(runs, slot, count) : KITH_OK;
}

static inline bool next_row(const struct query *q, int64_t *c) {
  for (int a = NDIM - 2; a >= 0; --a) {
    if (c[a]++ < q->last[a]) return true;
    c[a] = q->first[a];
  }
  return false;
}

/* Looks up each row that may exist. */
static inline kith_status find_rows(const struct kith_grid *grid, uint64_t layer, const struct query *q,
                                    struct kith_runs *runs) {
  int64_t c[NDIM];
  for (int a = 0; a < NDIM; ++a) c[a] = q->first[a];
  do {
    uint64_t key = layer;
    double gap2 = 0;
    for (int a = 0; a < NDIM - 1; ++a) {
      key = key << GRID_COORDINATE_BITS | (uint64_t)c[a];
      gap2 += square_gap(q, a, c[a]);
    }
    const struct kith_grid_row *row =
        gap2 <= q->search_radius * q->search_radius ? kith_grid_find_row(grid, key) : NULL;
    if (row) KITH_TRY(take_row(grid, row, q, gap2, runs));
  } while (next_row(q, c));
  return KITH_OK;
}

/* Tests each row that exists. */
static inline kith_status test_rows(const struct kith_grid *grid, const struct kith_grid_layer *layer,
                                    const struct query *q, struct kith_runs *runs) {
  for (const struct kith_grid_row *row = grid->row + layer->row; row < grid->row + layer->row + layer->rows;
       ++row) {
    double gap2 = 0;
    for (int a = 0; a < NDIM - 1; ++a) gap2 += square_gap(q, a, kith_grid_row_coordinate(row, a));
    KITH_TRY(take_row(grid, row, q, gap2, runs));
  }
  return KITH_OK;
}

KITH_HOT static kith_status query_layer(const struct kith_grid *grid, int number, const struct kith_box *box,
                                        double radius, enum kith_search_mode mode, struct kith_runs *runs) {
  const struct kith_grid_layer *layer = &grid->layer[number];
  const int level = number % GRID_LEVELS;
  const double per_length = grid->per_length[level];
  const double scale = per_length * (1 + KITH_SEARCH_SLACK), own = radius * scale,
               largest = sqrt(layer->radius2) * scale;
  struct query q = {.search_radius = mode == KITH_GATHER    ? own
                                     : mode == KITH_SCATTER ? largest
                                                            : KITH_MAX(own, largest),
                    .targets2 = mode == KITH_SCATTER ? 0 : own * own,
                    .cells2 = mode == KITH_GATHER ? 0 : scale * scale};
  double rows = 1;
  for (int a = 0; a < NDIM; ++a) {
    /* Rounding moves a node of the box or of a cell by no more than this. */
    const double far =
        (fabs(box->lower[a]) + fabs(box->upper[a]) + fabs(grid->origin[a])) * per_length + GRID_TOP;
    const double lower = in_cells(grid, a, box->lower[a], per_length) - KITH_SEARCH_SLACK * far;
    const double upper = in_cells(grid, a, box->upper[a], per_length) + KITH_SEARCH_SLACK * far;
    /* The outermost cells hold all nodes that lie beyond them. */
    q.lower[a] = KITH_MIN(lower, GRID_TOP + 1.0);
    q.upper[a] = KITH_MAX(upper, 0.0);
    if (a == NDIM - 1) break;
    q.first[a] = KITH_MAX(clamp(q.lower[a] - q.search_radius), layer->lower[a]);
    q.last[a] = KITH_MIN(clamp(q.upper[a] + q.search_radius), layer->upper[a]);
    if (q.first[a] > q.last[a]) return KITH_OK;
    rows *= (double)(q.last[a] - q.first[a] + 1);
  }
  if (rows > layer->rows) return test_rows(grid, layer, &q, runs);
  return find_rows(grid, (uint64_t)(number / GRID_LEVELS) << GRID_LEVEL_BITS | (uint64_t)level, &q, runs);
}

static kith_status grid_coarse(const struct kith_search *search, const struct kith_box *box, double radius,
                               enum kith_search_mode mode, struct kith_runs *runs) {
  const struct kith_grid *grid = search->self;
  for (int l = 0; l < 2 * GRID_LEVELS; ++l) {
    if (grid->layer[l].rows == 0) continue;
    KITH_TRY(query_layer(grid, l, box, radius, mode, runs));
  }
  return KITH_OK;
}

static size_t grid_bytes(const struct kith_search *search) {
  const struct kith_grid *grid = search->self;
  return 2 * (grid->items_capacity + grid->entering_capacity) * sizeof **grid->item +
         grid->slots_capacity * sizeof *grid->slot_of + grid->cells_capacity * sizeof *grid->cell +
         grid->rows_capacity * sizeof *grid->row + grid->table_size * sizeof *grid->table;
}

const struct kith_search_ops kith_search_grid = {
    .name = "grid",
    .doc = "nested levels of cells by radius: for radii that differ much; cheap updates of a few moved nodes",
    .state_size = sizeof(struct kith_grid),
    .clear = grid_clear,
    .update = grid_update,
    .append = grid_append,
    .update_selected = grid_update_selected,
    .coarse = grid_coarse,
    .bytes = grid_bytes,
};
