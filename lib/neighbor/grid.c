/* grid.c - nested levels of cells by radius.
 *
 * Level l holds the nodes with radius in (b / 2, b], b = b_0 / 2^l, b_0 the largest radius of the last
 * update; larger ones that come later go to level 0 and the smallest ones to the last level. Its cells are
 * EDGE b wide. Ghosts have levels of their own. So a small node never meets the large cells of a large one,
 * nor a large node more of the small cells than it covers.
 *
 * Slots ascend by (ghost, level, row, cell): a row is a line of cells along the last axis, and the part of it
 * within range is one run. Only rows that hold nodes exist, and are found by their keys: space has no edge;
 * cells beyond 2^GRID_COORDINATE_BITS are clamped to the last one: still correct, but slow.
 *
 * update   O(n): keys, sort, tables; for selected nodes their keys, a merge, tables
 * coarse   O(rows within range, and log rows for each line of them) for each level */
#include <string.h>

#include "lib/core/keyed.h"
#include "lib/neighbor/search.h"

#define EDGE 0.5 /* of a cell, in largest radii of its level */

enum {
  GROUP = 12, /* most targets of a group */
  SPAN = 4,   /* most cells of a row between the first and the last of a group */
};

enum {
  GRID_LEVELS = 24,
  GRID_LEVEL_BITS = 5,
  GRID_COORDINATE_BITS = NDIM == 3 ? 19 : 29,
  GRID_TOP = (1 << GRID_COORDINATE_BITS) - 1, /* largest coordinate of a cell */
};

/* A line of cells: from `cell` to before that of the next row. */
struct row {
  uint64_t key; /* of its cells, without their last coordinate */
  kith_index cell;
};

struct cell {
  int32_t coordinate; /* along the row */
  kith_index slot;    /* its first one */
  double radius2;     /* the largest squared radius of its nodes */
};

/* The nodes of one level, internal or ghosts. */
struct layer {
  kith_index row, rows; /* the first one, and how many */
  double radius2;       /* the largest squared radius of its nodes */
};

struct grid {
  double origin[NDIM], bound;     /* bound: of the radii of level 0 */
  double per_length[GRID_LEVELS]; /* cells of a level in a unit of length */
  kith_index n_cells, n_rows;
  size_t items_capacity, cells_capacity, rows_capacity;
  struct kith_keyed *item[2]; /* [n] by slot; scratch */
  struct cell *cell;          /* [n_cells + 1] */
  struct row *row;            /* [n_rows + 1] */
  struct layer layer[2 * GRID_LEVELS];
};

/* Coordinate of a row along axis a < NDIM - 1. */
static inline int32_t row_coordinate(const struct row *row, int a) {
  return (int32_t)(row->key >> (NDIM - 2 - a) * GRID_COORDINATE_BITS & GRID_TOP);
}

static void grid_clear(struct kith_search *search) {
  struct grid *grid = search->self;
  KITH_FREE(&grid->item[0], &grid->item[1], &grid->cell, &grid->row);
}

/* Keys. */

static inline int level_of(const struct grid *grid, double radius) {
  int level = 0;
  for (double bound = 0.5 * grid->bound; radius <= bound && level < GRID_LEVELS - 1; bound *= 0.5) ++level;
  return level;
}

static inline int64_t clamp(double u) {
  return u > 0 ? (int64_t)(u < GRID_TOP ? u : GRID_TOP) : 0;
}

/* Position in units of cells; the origin of the grid is in the middle of all coordinates. */
static inline double in_cells(const struct grid *grid, int a, double x, double per_length) {
  return (x - grid->origin[a]) * per_length + 0.5 * GRID_TOP;
}

static inline uint64_t key_of(const struct kith_search *search, kith_index i) {
  const struct grid *grid = search->self;
  const int level = level_of(grid, search->radius->f64[i]);
  uint64_t key = (uint64_t)(i >= search->n_internal) << GRID_LEVEL_BITS | (uint64_t)level;
  for (int a = 0; a < NDIM; ++a) {
    const double u = in_cells(grid, a, search->position->f64[(size_t)i * NDIM + a], grid->per_length[level]);
    key = key << GRID_COORDINATE_BITS | (uint64_t)clamp(u);
  }
  return key;
}

static void choose_frame(struct kith_search *search) {
  struct grid *grid = search->self;
  double lower[NDIM], upper[NDIM], bound = kith_search_largest_radius(search);
  kith_search_cube(search->position->f64, search->n, lower, upper);
  /* Nodes without a radius: about one for each cell. */
  if (!(bound > 0 && bound < INFINITY)) bound = (upper[0] - lower[0]) / kith_root_dim(1 + search->n);
  grid->bound = bound;
  for (int l = 0; l < GRID_LEVELS; ++l) grid->per_length[l] = ldexp(1 / (EDGE * bound), l);
  for (int a = 0; a < NDIM; ++a) grid->origin[a] = 0.5 * (lower[a] + upper[a]);
}

/* Tables. */

static kith_status list_cells(const struct kith_search *search) {
  struct grid *grid = search->self;
  const struct kith_keyed *item = grid->item[0];
  kith_index cells = 0;
  KITH_TRY(kith_reserve(&grid->cell, &grid->cells_capacity, (size_t)search->n + 1, sizeof *grid->cell));
  for (kith_index s = 0; s < search->n; ++s) {
    const double radius2 = search->radius2[s];
    if (s == 0 || item[s].key != item[s - 1].key)
      grid->cell[cells++] = (struct cell){(int32_t)(item[s].key & GRID_TOP), s, radius2};
    else
      grid->cell[cells - 1].radius2 = KITH_MAX(grid->cell[cells - 1].radius2, radius2);
  }
  grid->n_cells = cells;
  grid->cell[cells] = (struct cell){0, search->n, 0};
  return KITH_OK;
}

static inline uint64_t row_key(const struct grid *grid, kith_index cell) {
  return grid->item[0][grid->cell[cell].slot].key >> GRID_COORDINATE_BITS;
}

static kith_status list_rows(struct grid *grid) {
  KITH_TRY(kith_reserve(&grid->row, &grid->rows_capacity, (size_t)grid->n_cells + 1, sizeof *grid->row));
  grid->n_rows = 0;
  for (kith_index c = 0; c < grid->n_cells; ++c)
    if (c == 0 || row_key(grid, c) != row_key(grid, c - 1))
      grid->row[grid->n_rows++] = (struct row){row_key(grid, c), c};
  grid->row[grid->n_rows] = (struct row){0, grid->n_cells};
  return KITH_OK;
}

static void list_layers(struct grid *grid) {
  memset(grid->layer, 0, sizeof grid->layer);
  for (kith_index r = 0; r < grid->n_rows; ++r) {
    const struct row *row = &grid->row[r];
    const uint64_t top = row->key >> (NDIM - 1) * GRID_COORDINATE_BITS; /* ghost or not, level */
    struct layer *layer =
        &grid->layer[(top >> GRID_LEVEL_BITS) * GRID_LEVELS + (top & ((1 << GRID_LEVEL_BITS) - 1))];
    if (layer->rows++ == 0) layer->row = r;
    for (kith_index c = row->cell; c < row[1].cell; ++c)
      layer->radius2 = KITH_MAX(layer->radius2, grid->cell[c].radius2);
  }
}

/* Cells of a row that lie close together are one group; crowded cells are several groups. */
static kith_status group_row(struct kith_search *search, const struct row *row) {
  const struct grid *grid = search->self;
  for (kith_index c = row->cell, end; c < row[1].cell; c = end) {
    const struct cell *cell = &grid->cell[c];
    const kith_index first = cell->slot;
    for (end = c + 1; end < row[1].cell; ++end)
      if (grid->cell[end + 1].slot - first > GROUP || grid->cell[end].coordinate - cell->coordinate >= SPAN)
        break;
    for (kith_index s = first; s < grid->cell[end].slot; s += GROUP)
      KITH_TRY(kith_search_group(search, s, KITH_MIN(GROUP, grid->cell[end].slot - s)));
  }
  return KITH_OK;
}

/* Slots. */

/* Orders the slots as the items are, and makes cells, rows, layers and groups anew. */
static kith_status take_order(struct kith_search *search) {
  struct grid *grid = search->self;
  search->n_groups = 0;
#pragma omp parallel for schedule(static)
  for (kith_index s = 0; s < search->n; ++s) search->node[s] = grid->item[0][s].node;
  kith_search_pack(search, 0, search->n);
  KITH_TRY(list_cells(search));
  KITH_TRY(list_rows(grid));
  list_layers(grid);
  for (kith_index r = 0; r < grid->n_rows; ++r) KITH_TRY(group_row(search, &grid->row[r]));
  return KITH_OK;
}

static kith_status grid_update(struct kith_search *search) {
  struct grid *grid = search->self;
  const size_t n = (size_t)search->n;
  KITH_TRY(kith_keyed_grow(grid->item, &grid->items_capacity, n));
  choose_frame(search);
#pragma omp parallel for schedule(static) if (search->n > KITH_FEW_COPIES)
  for (kith_index i = 0; i < search->n; ++i) grid->item[0][i] = (struct kith_keyed){key_of(search, i), i};
  KITH_TRY(kith_keyed_sort(grid->item[0], grid->item[1], n));
  return take_order(search);
}

static kith_status grid_update_selected(struct kith_search *search, const kith_index *nodes,
                                        kith_index count) {
  struct grid *grid = search->self;
  struct kith_keyed *item = grid->item[0], *in = grid->item[1];
  uint8_t *selected = search->near; /* by node, in the scratch memory of kith_search_near */
  kith_index left = 0;
  if (search->n > 0) memset(selected, 0, (size_t)search->n);
  for (kith_index k = 0; k < count; ++k) selected[nodes[k]] = 1;
  for (kith_index s = 0; s < search->n; ++s) {
    const kith_index i = item[s].node;
    if (!selected[i]) continue;
    const uint64_t key = key_of(search, i);
    if (key == item[s].key) continue;
    in[left++] = (struct kith_keyed){key, i};
    item[s].node = -1;
  }
  if (left > 0) kith_keyed_replace(item, search->n, in, left);
  return take_order(search);
}

/* Queries. */

/* The box of the targets in units of the cells of a level, and the search radius around it. */
struct query {
  double lower[NDIM], upper[NDIM], search_radius;
  double targets2;                 /* squared radius of the targets; 0: does not count */
  double cells2;                   /* factor of the squared radii of cells; 0: they do not count */
  int64_t first[NDIM], last[NDIM]; /* coordinates of cells within range */
};

static inline double square_gap(const struct query *q, int a, int64_t c) {
  const double below = q->lower[a] - (double)(c + 1), above = (double)c - q->upper[a];
  const double gap = KITH_MAX(below, above);
  return gap > 0 ? gap * gap : 0;
}

/* The first cell of a row whose coordinate is at least c, or the end of the row. */
static inline kith_index cell_from(const struct grid *grid, const struct row *row, int64_t c) {
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
static inline bool out_of_range(const struct cell *cell, const struct query *q, double gap2) {
  return gap2 + square_gap(q, NDIM - 1, cell->coordinate) > KITH_MAX(q->cells2 * cell->radius2, q->targets2);
}

/* The cells of a row within range: fewer for a row at some distance. */
static inline kith_status take_row(const struct grid *grid, const struct row *row, const struct query *q,
                                   double gap2, struct kith_runs *runs) {
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

/* The smallest key, not below `key`, of a row that may lie within range. */
static inline uint64_t next_key(uint64_t key, const struct query *q) {
  for (int a = 0; a < NDIM - 1; ++a) {
    const int shift = (NDIM - 2 - a) * GRID_COORDINATE_BITS;
    const int64_t c = (int64_t)(key >> shift & GRID_TOP);
    if (c >= q->first[a] && c <= q->last[a]) continue;
    const uint64_t before = (key >> shift >> GRID_COORDINATE_BITS) + (c > q->last[a]);
    return (before << GRID_COORDINATE_BITS | (uint64_t)q->first[a]) << shift;
  }
  return key;
}

static inline kith_status take_rows(const struct grid *grid, const struct layer *layer, const struct query *q,
                                    struct kith_runs *runs) {
  const kith_index end = layer->row + layer->rows;
  for (kith_index r = layer->row; r < end;) {
    const struct row *row = &grid->row[r];
    const uint64_t key = next_key(row->key, q);
    double gap2 = 0;
    if (key != row->key) {
      r = kith_key_bound(grid->row, sizeof *row, r, end, key);
      continue;
    }
    for (int a = 0; a < NDIM - 1; ++a) gap2 += square_gap(q, a, row_coordinate(row, a));
    KITH_TRY(take_row(grid, row, q, gap2, runs));
    ++r;
  }
  return KITH_OK;
}

KITH_HOT static kith_status query_layer(const struct grid *grid, int number, const struct kith_box *box,
                                        double radius, enum kith_search_mode mode, struct kith_runs *runs) {
  const struct layer *layer = &grid->layer[number];
  const double per_length = grid->per_length[number % GRID_LEVELS];
  const double scale = per_length * (1 + KITH_SEARCH_SLACK), own = radius * scale,
               largest = sqrt(layer->radius2) * scale;
  struct query q = {.search_radius = mode == KITH_GATHER    ? own
                                     : mode == KITH_SCATTER ? largest
                                                            : KITH_MAX(own, largest),
                    .targets2 = mode == KITH_SCATTER ? 0 : own * own,
                    .cells2 = mode == KITH_GATHER ? 0 : scale * scale};
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
    q.first[a] = clamp(q.lower[a] - q.search_radius);
    q.last[a] = clamp(q.upper[a] + q.search_radius);
  }
  return take_rows(grid, layer, &q, runs);
}

static kith_status grid_coarse(const struct kith_search *search, const struct kith_box *box, double radius,
                               enum kith_search_mode mode, struct kith_runs *runs) {
  const struct grid *grid = search->self;
  for (int l = 0; l < 2 * GRID_LEVELS; ++l) {
    if (grid->layer[l].rows == 0) continue;
    KITH_TRY(query_layer(grid, l, box, radius, mode, runs));
  }
  return KITH_OK;
}

static size_t grid_bytes(const struct kith_search *search) {
  const struct grid *grid = search->self;
  return 2 * grid->items_capacity * sizeof **grid->item + grid->cells_capacity * sizeof *grid->cell +
         grid->rows_capacity * sizeof *grid->row;
}

const struct kith_search_ops kith_search_grid = {
    .name = "grid",
    .doc = "nested levels of cells by radius: for radii that differ much",
    .state_size = sizeof(struct grid),
    .clear = grid_clear,
    .update = grid_update,
    .update_selected = grid_update_selected,
    .coarse = grid_coarse,
    .bytes = grid_bytes,
};
