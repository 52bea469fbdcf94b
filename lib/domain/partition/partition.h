/* partition.h - the map of cells to ranks. One family of partitioners: cart, kd, morton, hilbert, graph,
 * p4est, diffusion, gridbased, hybrid.
 *
 * Every rank holds the whole map, owner[cell], and computes it by itself: a partitioner is a deterministic
 * function of the cells, the number of ranks, the present map and the weights, which are replicated. Nothing
 * here communicates, and a map for 4096 ranks can be inspected in one process. Memory: 4 bytes per cell on
 * every rank, 8 for curves; more during an update.
 *
 * A partitioner is selected by a text: its name, and after a colon parameters of its own, parted by blanks:
 * `cart`, `diffusion:flow=willebeek iterations=5`. Others are refused.
 *
 * Weights w_c >= 0 are the work of the cells. KITH_EMPTY_CELL times their mean (1 if all are zero) is added
 * to each, so that empty regions are divided evenly too. A rank may be left without a cell. */
#ifndef KITH_DOMAIN_PARTITION_PARTITION_H
#define KITH_DOMAIN_PARTITION_PARTITION_H

#include "lib/core/param.h"
#include "lib/domain/cells.h"

#define KITH_EMPTY_CELL 1e-3 /* work of an empty cell, in mean weights */

struct kith_partition;

struct kith_partitioner_ops {
  const char *name, *doc;
  const struct kith_param *params; /* its own parameters, NULL: none */
  size_t settings_size;
  const char *needs;       /* the library that is missing in this build; NULL: available */
  double seconds_per_cell; /* of a map, about, for each halving of the ranks; 0: a microsecond or less */
  size_t state_size;       /* bytes of private state at partition->self, initially zero */
  /* The first map, without weights: writes owner[n]. NULL: `update` without weights makes it, where
   * `owner` is that of the partition. */
  kith_status (*first)(struct kith_partition *partition, int32_t *owner);
  uint64_t (*key_of)(const uint64_t *k); /* for kith_curve_first_by_key: key of a cell, by its coordinates */
  /* The next map: `owner` holds the present one. Weights are positive, of mean 1. NULL: the map never
   * changes. */
  kith_status (*update)(struct kith_partition *partition, const double *weight, int32_t *owner);
  /* For restarts: what the next map depends on besides the present one, the weights and the text. Returns the
   * number of words, and writes them unless `word` is NULL. NULL: nothing. */
  size_t (*state)(const struct kith_partition *partition, int64_t *word);
  /* Restores as many words as `state` returns. BAD_FILE if they are not valid. NULL without `state`. */
  kith_status (*restore)(struct kith_partition *partition, const int64_t *word);
  void (*clear)(struct kith_partition *partition); /* frees what the private state owns; NULL: nothing */
};

struct kith_partition {
  const struct kith_partitioner_ops *ops;
  const struct kith_cells *cells; /* borrowed; must not change */
  int n_ranks;
  int32_t *owner;      /* [cells->n] 0 .. n_ranks - 1; owned; never moves */
  uint64_t generation; /* of the map: 1, incremented by every change */
  void *settings;      /* of the member: as its params say; owned */
  void *self;
};

#define KITH_PARTITIONER_LIST(X) \
  X(cart) X(kd) X(morton) X(hilbert) X(graph) X(p4est) X(diffusion) X(gridbased) X(hybrid)
#define X(name) extern const struct kith_partitioner_ops kith_partitioner_##name;
KITH_PARTITIONER_LIST(X)
#undef X
KITH_FAMILY_FUNCTIONS(kith_partitioner);

/* A partition with its first map. BAD_INPUT: an unknown name or parameter, a value that is not allowed,
 * n_ranks < 1; UNSUPPORTED: built without the library that it needs. */
kith_status kith_partition_create(struct kith_partition **out, const struct kith_cells *cells, int n_ranks,
                                  const char *text);
void kith_partition_destroy(struct kith_partition **partition);

/* A new map from the present one. weight[cells->n]: the work of each cell, in any unit; NULL: equal.
 * *changed = false: no entry of the map changed. BAD_INPUT: a weight that is negative or not finite. After a
 * failure the map is unchanged. */
kith_status kith_partition_update(struct kith_partition *partition, const double *weight, bool *changed);
/* Updates until the map does not change any more, at most 20 times. */
kith_status kith_partition_converge(struct kith_partition *partition, const double *weight);

/* load[n_ranks], written: the work of each rank by the map owner[cells->n], in these weights of cells; NULL:
 * 1 each. Returns the largest over the mean; 1 if there is no work. */
double kith_partition_loads(const struct kith_partition *partition, const int32_t *owner,
                            const double *weight, double *load);

/* For restarts: the private state of the member as words (written unless NULL; their number is returned), and
 * how it is restored. The map, `owner`, is restored by the caller. BAD_FILE: the words do not belong to this
 * member, these cells and this number of ranks. */
size_t kith_partition_state(const struct kith_partition *partition, int64_t *word);
kith_status kith_partition_restore(struct kith_partition *partition, const int64_t *word, size_t n);

/* ---- for members ---- */

/* Ranks per axis, whose product is n_ranks, one beyond the first `axes`: the fewest cut faces among those
 * whose largest block is within 10 % of the smallest possible. */
void kith_partition_mesh(const struct kith_cells *cells, int n_ranks, int axes, int *ranks);
/* For members that cut an order of the cells (private state: struct kith_curve, filled by their `first`). */
struct kith_curve {
  kith_index *order; /* [cells->n] cells along the curve; owned */
};
kith_status kith_curve_first(struct kith_partition *partition, const uint64_t *key, int32_t *owner);
kith_status kith_curve_first_by_key(struct kith_partition *partition, int32_t *owner);
kith_status kith_curve_update(struct kith_partition *partition, const double *weight, int32_t *owner);
void kith_curve_clear(struct kith_partition *partition);
#define KITH_CURVE \
  .state_size = sizeof(struct kith_curve), .update = kith_curve_update, .clear = kith_curve_clear

#endif
