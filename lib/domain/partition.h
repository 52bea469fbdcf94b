/* partition.h - which rank owns which cell. One family of partitioners: cart, kd, morton, hilbert, graph, p4est,
 * diffusion, gridbased, hybrid.
 *
 * Every rank holds the whole map, owner[cell], and computes it by itself: a partitioner is a deterministic
 * function of the cells, the number of ranks, the present map and the weights, which are replicated. Nothing here
 * communicates; no two ranks can disagree; the rank of any position is one lookup; and a map for 4096 ranks
 * can be looked at in one process. Memory: 4 bytes per cell on every rank, 8 for curves; more during an update.
 *
 * A partitioner is asked for by a text: its name, and words after a colon, separated by commas, that choose a
 * variant or give a command: `cart`, `diffusion:willebeek`, `diffusion:fixed,morton`. The same words can be said
 * later. What a member does not know is refused.
 *
 * Weights w_c >= 0 are the work of the cells. To every one is added KITH_EMPTY_CELL of their mean (of 1, if all are
 * zero): no region is so empty that dealing it out is arbitrary. A rank may be left without a cell. */
#ifndef KITH_DOMAIN_PARTITION_H
#define KITH_DOMAIN_PARTITION_H

#include "lib/domain/cells.h"

#define KITH_EMPTY_CELL 1e-3 /* work of a cell with nothing in it, in mean weights */

struct kith_partition;

struct kith_partitioner_ops {
  const char *name, *doc;
  const char *needs;        /* the library it was built without; NULL: available */
  const char *const *words; /* variants and commands, ended by NULL; NULL: none */
  size_t state_size;        /* bytes of private state at partition->self, zero at first */
  /* Takes words[word]; effective at the next map. NULL without words. */
  void (*command)(struct kith_partition *partition, int word);
  /* The first map, before anything is known of weights: writes owner[n]. After the words of the text. */
  kith_status (*first)(struct kith_partition *partition, int32_t *owner);
  /* The next map: `owner` holds the present one. Weights are positive; face_weight may be NULL. NULL: never changes. */
  kith_status (*update)(struct kith_partition *partition, const double *weight, const double *face_weight,
                        int32_t *owner);
  /* What the next map depends on besides the present one, the weights and the text: how many words that is; written unless `word` is NULL.
   * NULL: nothing. */
  size_t (*state)(const struct kith_partition *partition, int64_t *word);
  /* Takes back as many words as `state` has. BAD_FILE if they are none of its. NULL without `state`. */
  kith_status (*restore)(struct kith_partition *partition, const int64_t *word);
  void (*clear)(struct kith_partition *partition); /* frees what the private state owns; NULL: nothing */
};

struct kith_partition {
  const struct kith_partitioner_ops *ops;
  const struct kith_cells *cells; /* borrowed; lives and stays as long as the partition */
  int n_ranks;
  int32_t *owner;      /* [cells->n] 0 .. n_ranks - 1; owned; the pointer stays */
  uint64_t generation; /* counts the maps: 1, and one more with every change */
  void *self;
};

#define KITH_PARTITIONER_LIST(X) \
  X(cart) X(kd) X(morton) X(hilbert) X(graph) X(p4est) X(diffusion) X(gridbased) X(hybrid)
#define X(name) extern const struct kith_partitioner_ops kith_partitioner_##name;
KITH_PARTITIONER_LIST(X)
#undef X
const struct kith_partitioner_ops *kith_partitioner_find(const char *name); /* NULL if there is none */
const struct kith_partitioner_ops *const *kith_partitioner_all(void);       /* ended by NULL */

/* With its first map. BAD_INPUT: an unknown name or word (the valid ones are named), n_ranks < 1; UNSUPPORTED: built
 * without its library. */
kith_status kith_partition_create(struct kith_partition **out, const struct kith_cells *cells, int n_ranks,
                                  const char *text);
void kith_partition_destroy(struct kith_partition **partition);

/* Words as after the colon, separated by commas. BAD_INPUT at the first unknown one; those before it hold. */
kith_status kith_partition_command(struct kith_partition *partition, const char *words);

/* A new map from the present one. weight[cells->n]: the work of each cell, in any unit; NULL: equal.
 * face_weight[cells->n][NDIM]: what it costs to cut the face between a cell and its next one along the axis, in any
 * unit; NULL: equal; most members do not look. *changed = false: the map is as it was, to the last entry.
 * BAD_INPUT: a weight that is negative or not finite. After a failure the map is as it was. */
kith_status kith_partition_update(struct kith_partition *partition, const double *weight,
                                  const double *face_weight, bool *changed);
/* The same until a member that goes on from its last map has come to rest, 20 times at most. */
kith_status kith_partition_settle(struct kith_partition *partition, const double *weight);

/* For restarts: what a member remembers, as words (written unless NULL; their number is returned), and how it gets that back. The map, `owner`,
 * is restored by the caller. BAD_FILE: not the words of this member on these cells and ranks. */
size_t kith_partition_state(const struct kith_partition *partition, int64_t *word);
kith_status kith_partition_restore(struct kith_partition *partition, const int64_t *word, size_t n);

/* The rank that owns the cell of a position; -1 as kith_cells_of. */
static inline int kith_partition_rank_of(const struct kith_partition *partition, const double *x) {
  const int64_t c = kith_cells_of(partition->cells, x);
  return c < 0 ? -1 : partition->owner[c];
}

/* ---- for members ---- */

/* Ranks per axis, their product n_ranks: the fewest cut faces with a largest block within 10 % of the smallest possible. */
void kith_partition_mesh(const struct kith_cells *cells, int n_ranks, int *ranks);
/* Cuts a curve through all cells: the rank of a cell is where the middle of its weight lies among n_ranks equal shares of
 * the total, so that no rank has more than its share and one cell. weight NULL: equal. */
void kith_partition_cut(int64_t n, const kith_index *order, const double *weight, int n_ranks,
                        int32_t *owner);
/* Members that are an order of cells and cut it (state: struct kith_curve, filled by their `first`). */
struct kith_curve {
  kith_index *order; /* [cells->n] cells along the curve; owned */
};
kith_status kith_curve_first(struct kith_partition *partition, const uint64_t *key, int32_t *owner);
kith_status kith_curve_first_by_key(struct kith_partition *partition, uint64_t (*key_of)(const uint64_t *k),
                                    int32_t *owner); /* keys of the cells' coordinates */
kith_status kith_curve_update(struct kith_partition *partition, const double *weight,
                              const double *face_weight, int32_t *owner);
void kith_curve_clear(struct kith_partition *partition);

#endif
