/* grid_tables.c - the tables of the grid search, made from slots in order. */
#include "lib/neighbor/grid_tables.h"

#include <string.h>

enum {
  GROUP = 12, /* most targets of a group */
  SPAN = 4,   /* most cells of a row between the first and the last of a group */
};

/* Lists the cells from the n_cells-th one on, which begins at slot `begin`. */
static kith_status list_cells(const struct kith_search *search, kith_index begin) {
  struct kith_grid *grid = search->self;
  const struct kith_keyed *item = grid->item[0];
  kith_index cells = grid->n_cells;
#pragma omp parallel for schedule(static) reduction(+ : cells)
  for (kith_index s = begin; s < search->n; ++s) cells += s == begin || item[s].key != item[s - 1].key;
  KITH_TRY(kith_grow(&grid->cell, &grid->cells_capacity, (size_t)grid->n_cells, (size_t)cells + 1,
                     sizeof *grid->cell));
  kith_index c = grid->n_cells;
  for (kith_index s = begin; s < search->n; ++s) {
    const double radius2 = search->radius2[s];
    if (s == begin || item[s].key != item[s - 1].key)
      grid->cell[c++] = (struct kith_grid_cell){(int32_t)(item[s].key & GRID_TOP), s, radius2};
    else
      grid->cell[c - 1].radius2 = KITH_MAX(grid->cell[c - 1].radius2, radius2);
  }
  grid->n_cells = cells;
  grid->cell[cells] = (struct kith_grid_cell){0, search->n, 0};
  return KITH_OK;
}

static inline uint64_t row_key(const struct kith_grid *grid, kith_index cell) {
  return grid->item[0][grid->cell[cell].slot].key >> GRID_COORDINATE_BITS;
}

/* Lists the rows from the n_rows-th one on, which begins at cell `begin`. */
static kith_status list_rows(struct kith_grid *grid, kith_index begin) {
  kith_index rows = grid->n_rows;
  for (kith_index c = begin; c < grid->n_cells; ++c)
    rows += c == begin || row_key(grid, c) != row_key(grid, c - 1);
  KITH_TRY(
      kith_grow(&grid->row, &grid->rows_capacity, (size_t)grid->n_rows, (size_t)rows + 1, sizeof *grid->row));
  for (kith_index c = begin; c < grid->n_cells; ++c) {
    const uint64_t key = row_key(grid, c);
    if (c == begin || key != grid->row[grid->n_rows - 1].key)
      grid->row[grid->n_rows++] = (struct kith_grid_row){key, c};
  }
  grid->row[grid->n_rows] = (struct kith_grid_row){0, grid->n_cells};
  return KITH_OK;
}

static kith_status hash_rows(struct kith_grid *grid) {
  uint32_t size = 64;
  while (size < 2 * (uint32_t)grid->n_rows) size *= 2;
  if (size > grid->table_size) {
    KITH_TRY(kith_resize(&grid->table, 0, size, sizeof *grid->table));
    grid->table_size = size;
  }
  memset(grid->table, -1, grid->table_size * sizeof *grid->table);
  for (kith_index r = 0; r < grid->n_rows; ++r) {
    uint32_t k = kith_grid_hash(grid->row[r].key) & (grid->table_size - 1);
    while (grid->table[k] >= 0) k = (k + 1) & (grid->table_size - 1);
    grid->table[k] = r;
  }
  return KITH_OK;
}

static void list_layers(struct kith_grid *grid) {
  memset(grid->layer, 0, sizeof grid->layer);
  for (kith_index r = 0; r < grid->n_rows; ++r) {
    const struct kith_grid_row *row = &grid->row[r];
    struct kith_grid_layer *layer = kith_grid_layer_of(grid, row->key << GRID_COORDINATE_BITS);
    if (layer->rows++ == 0) layer->row = r;
    for (kith_index c = row->cell; c < row[1].cell; ++c)
      layer->radius2 = KITH_MAX(layer->radius2, grid->cell[c].radius2);
    for (int a = 0; a < NDIM - 1; ++a) {
      const int32_t c = kith_grid_row_coordinate(row, a);
      layer->lower[a] = layer->rows == 1 ? c : KITH_MIN(layer->lower[a], c);
      layer->upper[a] = layer->rows == 1 ? c : KITH_MAX(layer->upper[a], c);
    }
  }
}

/* Cells of a row that lie close together are one group; crowded cells are several groups. */
static kith_status group_row(struct kith_search *search, const struct kith_grid_row *row) {
  const struct kith_grid *grid = search->self;
  for (kith_index c = row->cell, end; c < row[1].cell; c = end) {
    const struct kith_grid_cell *cell = &grid->cell[c];
    const kith_index first = cell->slot;
    for (end = c + 1; end < row[1].cell; ++end)
      if (grid->cell[end + 1].slot - first > GROUP || grid->cell[end].coordinate - cell->coordinate >= SPAN)
        break;
    for (kith_index s = first; s < grid->cell[end].slot; s += GROUP)
      KITH_TRY(kith_search_group(search, s, KITH_MIN(GROUP, grid->cell[end].slot - s)));
  }
  return KITH_OK;
}

kith_index kith_grid_cell_of_slot(const struct kith_grid *grid, kith_index slot) {
  kith_index first = 0, last = grid->n_cells;
  while (last - first > 1) {
    const kith_index middle = first + (last - first) / 2;
    if (grid->cell[middle].slot <= slot)
      first = middle;
    else
      last = middle;
  }
  return first;
}

kith_status kith_grid_tables(struct kith_search *search, kith_index begin) {
  struct kith_grid *grid = search->self;
  kith_index cell = 0, slot = 0;
  if (begin > 0) {
    cell = kith_grid_cell_of_slot(grid, begin - 1);
    while (grid->row[grid->n_rows - 1].cell > cell) --grid->n_rows;
    cell = grid->row[--grid->n_rows].cell;
    slot = grid->cell[cell].slot;
    while (search->n_groups > 0 && search->group[search->n_groups - 1].first >= slot) --search->n_groups;
  } else {
    grid->n_rows = search->n_groups = 0;
  }
  grid->n_cells = cell;
  const kith_index row = grid->n_rows;
  KITH_TRY(list_cells(search, slot));
  KITH_TRY(list_rows(grid, cell));
  KITH_TRY(hash_rows(grid));
  list_layers(grid);
  for (kith_index r = row; r < grid->n_rows; ++r) KITH_TRY(group_row(search, &grid->row[r]));
  return KITH_OK;
}
