/* grid_tables.h - the tables of the grid search: cells, rows of cells and levels of rows, as ranges of slots.
 * Private to lib/neighbor. */
#ifndef KITH_NEIGHBOR_GRID_TABLES_H
#define KITH_NEIGHBOR_GRID_TABLES_H

#include "lib/core/keyed.h"
#include "lib/neighbor/search.h"

enum {
  GRID_LEVELS = 24,
  GRID_LEVEL_BITS = 5,
  GRID_COORDINATE_BITS = NDIM == 3 ? 19 : 29,
  GRID_GHOST_BIT = GRID_LEVEL_BITS + NDIM * GRID_COORDINATE_BITS,
  GRID_TOP = (1 << GRID_COORDINATE_BITS) - 1, /* largest coordinate of a cell */
};
/* A line of cells: cell[r.cell] .. cell[(r + 1).cell]. */
struct kith_grid_row {
  uint64_t key; /* of its cells, without their last coordinate */
  kith_index cell;
};

struct kith_grid_cell {
  int32_t coordinate; /* along the row */
  kith_index slot;    /* its first one */
  double radius2;     /* largest */
};

/* The nodes of one level, internal or ghosts. */
struct kith_grid_layer {
  kith_index row, rows;
  double radius2;                   /* largest */
  int32_t lower[NDIM], upper[NDIM]; /* coordinates of cells; those along rows are not kept */
};

struct kith_grid {
  double origin[NDIM], bound;     /* of level 0 */
  double per_length[GRID_LEVELS]; /* cells */
  kith_index n_cells, n_rows;
  size_t items_capacity, slots_capacity, entering_capacity, cells_capacity, rows_capacity;
  struct kith_keyed *item[2];     /* [n] by slot; scratch */
  struct kith_keyed *entering[2]; /* items on their way into the slots; scratch */
  kith_index *slot_of;            /* [n] by node */
  struct kith_grid_cell *cell;    /* [n_cells + 1] */
  struct kith_grid_row *row;      /* [n_rows + 1] */
  kith_index *table;              /* [table_size] rows by hash, -1: none */
  uint32_t table_size;            /* a power of two, at least twice the rows */
  struct kith_grid_layer layer[2 * GRID_LEVELS];
};

/* Makes the tables of all slots from item[0] and the packed radii. The slots before `begin` have not changed
 * since the tables were made last: their entries are kept, but for the row that may go on. O(slots from
 * that row on). */
kith_status kith_grid_tables(struct kith_search *search, kith_index begin);
/* The cell that holds a slot. O(log n). */
kith_index kith_grid_cell_of_slot(const struct kith_grid *grid, kith_index slot);

static inline uint32_t kith_grid_hash(uint64_t key) {
  return (uint32_t)(key * UINT64_C(0x9e3779b97f4a7c15) >> 32);
}

/* The row of a key, or NULL. */
static inline const struct kith_grid_row *kith_grid_find_row(const struct kith_grid *grid, uint64_t key) {
  for (uint32_t k = kith_grid_hash(key);; ++k) {
    const kith_index r = grid->table[k & (grid->table_size - 1)];
    if (r < 0) return NULL;
    if (grid->row[r].key == key) return &grid->row[r];
  }
}

/* Coordinate of a row along axis a < NDIM - 1. */
static inline int32_t kith_grid_row_coordinate(const struct kith_grid_row *row, int a) {
  return (int32_t)(row->key >> (NDIM - 2 - a) * GRID_COORDINATE_BITS & GRID_TOP);
}

static inline struct kith_grid_layer *kith_grid_layer_of(struct kith_grid *grid, uint64_t key) {
  const uint64_t top = key >> (GRID_GHOST_BIT - GRID_LEVEL_BITS);
  return &grid->layer[(top >> GRID_LEVEL_BITS) * GRID_LEVELS + (top & ((1 << GRID_LEVEL_BITS) - 1))];
}

#endif
