/* search.h - neighbor search: from nodes to candidates. One family: tree, grid, spacetree, brute.
 *
 * A search is made from all nodes (internal and ghosts) with a search radius each. It answers in three
 * stages:
 *   targets   groups of nodes that are close together; every node is in exactly one group, and a group holds
 *             internal nodes only, or ghosts only
 *   coarse    for the box of a group and its largest radius: runs of nodes that may interact with any of it
 *   refined   for one position: the candidates that pass the distance test of the mode (kith_search_at)
 * Which candidates are significant, |x_ij| <= R_i or <= R_j, is decided by the connectivity.
 *
 * Slot order: every search keeps its nodes in an order of its own, in which the nodes of a cell are
 * contiguous. A place in this order is a slot. Coordinates and squared radii are packed by slot, so that
 * candidates are streamed and not gathered. A run is a range of slots. After an update of all nodes the slots
 * of a cell ascend in node index. Candidates are a superset of the neighbors: none is ever missing, wherever
 * the nodes are (outside of the box, at equal positions) and however their radii differ.
 *
 * Where supports are ellipsoids (nodes.h) positions and distances are those in their metric.
 *
 *   gather          |x_j - x_i| <= R_i     scatter   |x_j - x_i| <= R_j     gather-scatter   either
 *
 * Sweeps: a member whose cells have levels can be walked over, cell by cell, with the events of
 * struct kith_sweep, instead of being asked. Positions are those that were packed: an event may move nodes,
 * which makes the search stale and changes nothing of this sweep. */
#ifndef KITH_NEIGHBOR_SEARCH_H
#define KITH_NEIGHBOR_SEARCH_H

#include "lib/core/param.h"
#include "lib/core/vec.h"
#include "lib/nodes/nodes.h"

enum kith_search_mode { KITH_GATHER, KITH_SCATTER, KITH_GATHER_SCATTER };

/* Relative slack of squared distances in box tests: the exact test may be compiled with or without fused
 * operations. */
#define KITH_SEARCH_SLACK 1e-14

/* Slots first .. first + count - 1. */
struct kith_run {
  kith_index first, count;
};

/* A growing list of runs, ascending and disjoint; adjacent ones are merged. Each thread uses its own. {0} is
 * an empty list; to set n = 0 empties it and keeps the memory. */
struct kith_runs {
  int n;
  size_t capacity;
  struct kith_run *run; /* owned */
};
static inline kith_status kith_runs_add(struct kith_runs *runs, kith_index first, kith_index count) {
  if (runs->n > 0) {
    struct kith_run *last = &runs->run[runs->n - 1];
    if (last->first + last->count == first) {
      last->count += count;
      return KITH_OK;
    }
  }
  const size_t n = (size_t)runs->n;
  if (n == runs->capacity) KITH_TRY(kith_grow(&runs->run, &runs->capacity, n, n + 1, sizeof *runs->run));
  runs->run[runs->n++] = (struct kith_run){first, count};
  return KITH_OK;
}
void kith_runs_clear(struct kith_runs *runs); /* frees */

/* The box around some nodes, and their largest search radius. */
struct kith_extent {
  struct kith_box box;
  double radius;
};
static inline void kith_extent_include(struct kith_extent *extent, const double *x, double radius) {
  kith_box_include(&extent->box, x);
  extent->radius = KITH_MAX(extent->radius, radius);
}
/* Joins b to a. False, and nothing is done, if the volume in which neighbors may lie would become more than
 * `most` times that of the larger one. */
bool kith_extent_join(struct kith_extent *a, const struct kith_extent *b, double most);

struct kith_search;

/* A cell of a sweep, and the nodes that may interact with those in it, as slots.
 *   targets  the nodes in the cell, which is half-open, that live on its level. Each node is a target once
 *   active   the nodes that may interact with them, ascending in level: the first n_coarser runs are of
 *            levels coarser than that of the cell; the others are its local set, nodes of its level, targets
 *            among them
 * To visit each interaction of two nodes once in each direction, evaluate f(target, other) for all nodes of
 * the active set, and at once f(other, target) for those of coarser levels, whose own cells do not know the
 * target. */
struct kith_cell {
  kith_index targets;
  const kith_index *target;
  int n_active, n_coarser;
  const struct kith_run *active;
};

/* The events of a sweep. touch_first and touch_last (NULL: nothing happens) are called once for the nodes of
 * each vertex, which are of one level: before any cell and after all cells that have them in their active
 * set. */
struct kith_sweep {
  kith_status (*touch_first)(void *context, const struct kith_run *run, int n);
  kith_status (*cell)(void *context, const struct kith_cell *cell);
  kith_status (*touch_last)(void *context, const struct kith_run *run, int n);
};

enum { KITH_SEARCH_COUNTERS = 5 };

struct kith_search_ops {
  const char *name, *doc;
  const struct kith_param *params; /* its own parameters, NULL: none */
  size_t settings_size;
  size_t state_size;                         /* bytes of private state at search->self, initially zero */
  void (*clear)(struct kith_search *search); /* frees what the private state owns; NULL: nothing */
  /* Builds from nodes 0 .. search->n - 1; fills slot arrays, which have room for them, and groups, of which
   * there are none yet. in_order is false. */
  kith_status (*update)(struct kith_search *search);
  /* Adds to `runs`, which is empty, the runs that may interact with a box of targets of largest radius
   * `radius`. Thread-safe. Box tests are loose by KITH_SEARCH_SLACK, so that rounding loses no candidate. */
  kith_status (*coarse)(const struct kith_search *search, const struct kith_box *box, double radius,
                        enum kith_search_mode mode, struct kith_runs *runs);
  /* Updates these nodes alone: no others moved or changed their radius. If search->n is n_internal now, the
   * ghosts are gone, and so are their groups already; the other groups are still those of the last update. */
  kith_status (*update_selected)(struct kith_search *search, const kith_index *nodes, kith_index count);
  /* Visits the interactions of its cells, each once (struct kith_sweep). NULL: it has no cells. */
  kith_status (*sweep)(const struct kith_search *search, const struct kith_sweep *sweep, void *context);
  size_t (*bytes)(const struct kith_search *search); /* memory that the private state owns; NULL: none */
  const char *const *counters; /* names of search->count, the last is NULL; NULL: none */
};

struct kith_search {
  const struct kith_search_ops *ops;
  const void *settings; /* borrowed; NULL: defaults. Set before the first update */
  /* Set by the caller: updates keep no cells, so that the number of candidates, by which block steps decide
   * when to search anew, is the same after a restart. */
  bool fresh_cells;
  void *self;
  /* What it was made from. */
  const struct kith_nodes *nodes;    /* borrowed */
  const struct kith_field *position; /* of each node, in the metric of the supports (nodes.h) */
  const struct kith_field *radius;   /* of each node: search_radius, unless the caller sets another */
  kith_index n, n_internal;          /* nodes seen: internal and ghosts; internal */
  uint64_t positions, order, ghosts; /* generations of the nodes at the last update */
  /* Slot order. */
  kith_index capacity;
  kith_index *node;         /* [n] node of a slot */
  double *coordinate[NDIM]; /* [n] by slot */
  double *radius2;          /* [n] squared search radius by slot */
  /* Groups of targets: runs of slots. */
  int n_groups;
  size_t groups_capacity;
  struct kith_run *group;
  /* true: the slot of an internal node is its index, and groups of internal nodes, and the runs that a query
   * finds, ascend. */
  bool in_order;
  uint8_t *near;                        /* [capacity] by slot, scratch of kith_search_near */
  uint64_t count[KITH_SEARCH_COUNTERS]; /* what the last update did */
};

#define KITH_SEARCH_LIST(X) X(tree) X(grid) X(spacetree) X(brute)
#define X(name) extern const struct kith_search_ops kith_search_##name;
KITH_SEARCH_LIST(X)
#undef X
KITH_FAMILY_FUNCTIONS(kith_search);

/* BAD_INPUT if ops is NULL, as kith_search_find gives for a name that it does not know. */
kith_status kith_search_create(struct kith_search **out, const struct kith_search_ops *ops,
                               const struct kith_nodes *nodes);
void kith_search_destroy(struct kith_search **search);

/* Updates the search with the present positions and search radii of all nodes. These and their squares must
 * be finite: that is not checked. */
kith_status kith_search_update(struct kith_search *search);
/* Updates the search where these nodes moved or changed their search radius, and no others. A node may be
 * named more than once. STALE if it was never updated, or nodes were reordered, or nodes or ghosts were added
 * or removed; but it is allowed to drop all ghosts. */
kith_status kith_search_update_selected(struct kith_search *search, const kith_index *nodes,
                                        kith_index count);
/* Finds the active nodes and all internal nodes that may interact with one: their indices, in the order of
 * their slots, go into *found, which kith_grow moves. Positions of active nodes are the present ones. What
 * another node has moved since the last update, plus what its search radius has grown, must be at most
 * `slack`. Nodes must have an activity. */
kith_status kith_search_near(struct kith_search *search, double slack, kith_index **found, size_t *capacity,
                             kith_index *count);
/* The first group from `group` on, before `end`, in which not all nodes may be idle: those in between are
 * skipped many at a time. Nodes must have an activity. */
int kith_search_next_awake(const struct kith_search *search, int group, int end);
/* STALE, by name, unless the search was made from the present positions and ghosts. A cull makes it stale,
 * too. */
kith_status kith_search_fresh(const struct kith_search *search);

/* Neighbors of any position (no node needed) with radius `radius`: coarse, then refined by the exact
 * distance test of the mode. Node indices, ascending, into *found, which kith_grow moves. BAD_INPUT for a
 * radius below 0. */
kith_status kith_search_at(const struct kith_search *search, const double *x, double radius,
                           enum kith_search_mode mode, kith_index **found, size_t *capacity,
                           kith_index *count);

/* Walks over all cells, parents first, on one thread. STALE if the search is; UNSUPPORTED, by name, if its
 * member has no sweep, or a search radius is too large for its cells. O(n levels log n), and the events. */
kith_status kith_search_sweep(const struct kith_search *search, const struct kith_sweep *sweep,
                              void *context);

size_t kith_search_bytes(const struct kith_search *search);

/* The cube whose Morton curve the tree follows: at least twice as wide as x[n][NDIM], cells at powers of two
 * counted from the origin of space, so that the order of nodes hardly depends on where the outermost ones
 * are. */
void kith_search_cube(const double *x, kith_index n, double *lower, double *upper);
/* Sorts the nodes of each list along this curve (kith_nodes_sort): then the tree need not sort, and
 * candidates ascend in node index. */
kith_status kith_search_sort_nodes(struct kith_nodes *nodes, bool *sorted);

/* The box around x[n][NDIM], and the largest search radius of all nodes. */
struct kith_box kith_box_around(const double *x, kith_index n);
double kith_search_largest_radius(const struct kith_search *search);

/* Some nodes of a search: the targets of a neighbor list, or its sources. Points that are no nodes of the run
 * are nodes of their own, with a search of their own. */
struct kith_selection {
  const struct kith_nodes *nodes; /* borrowed, as all of it */
  struct kith_search *search;     /* of these nodes */
  uint64_t lists;                 /* bit l: nodes of list l; 0: of all lists */
  bool ghosts;                    /* of targets: ghosts too. Ghosts are sources in any case */
  bool (*chosen)(const void *context, const struct kith_nodes *nodes, kith_index i); /* NULL: all */
  const void *context;
};

/* Is node or ghost i one of them? `ghosts` is not looked at. */
static inline bool kith_selects(const struct kith_selection *s, kith_index i) {
  return (s->lists == 0 || (s->lists >> s->nodes->list->u8[i] & 1) != 0) &&
         (s->chosen == NULL || s->chosen(s->context, s->nodes, i));
}

/* For members. */
static inline void kith_search_pack_slot(struct kith_search *search, kith_index slot) {
  const size_t i = (size_t)search->node[slot];
  const double radius = search->radius->f64[i];
  for (int a = 0; a < NDIM; ++a) search->coordinate[a][slot] = search->position->f64[i * NDIM + a];
  search->radius2[slot] = radius * radius;
}
/* Packs coordinates and squared radii of the nodes in slots first .. first + count - 1. */
void kith_search_pack(struct kith_search *search, kith_index first, kith_index count);
/* Adds a group of targets. */
kith_status kith_search_group(struct kith_search *search, kith_index first, kith_index count);

#endif
