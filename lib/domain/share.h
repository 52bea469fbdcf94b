/* share.h - this rank's share of the nodes: the map cell -> rank, who must move, and when the map is made anew.
 *
 * Every rank lays out the whole scene and keeps what lies in its cells (kith_share_keep); later nodes follow their cells
 * when lists are rebuilt (kith_share_settle), and only then. `home` is the cell in which a node was last settled, as its place among the
 * cells of this rank; n_own stands for all others, where a node may be after a restart, until it is settled.
 *
 * Balance: every `every` settlements the work, of a node the entries of its last row (and 1 for the node itself), is summed by cells over
 * all ranks; if the busiest rank has more than `imbalance` times the mean, the partitioner is asked for a new map. It may refuse: then
 * nothing changed. All ranks compute the same map from the same weights.
 *
 * A restart on as many ranks goes on to the last bit, whenever the next look comes: work is a field of the nodes, the map and what the
 * partitioner remembers are stored. On another number of ranks the map is that of the start of the scene. */
#ifndef KITH_DOMAIN_SHARE_H
#define KITH_DOMAIN_SHARE_H

#include "lib/domain/partition.h"
#include "lib/nodes/nodes.h"

struct kith_share {
  struct kith_ranks *ranks; /* borrowed */
  struct kith_cells cells;
  struct kith_partition *partition; /* owned */
  struct kith_field *home;          /* I64, work: 0 .. n_own */
  struct kith_field *work;          /* I64, work: entries of the node's last row */
  int64_t n_own;
  int64_t *own;     /* [n_own] cells of this rank, ascending; owned */
  int32_t *place;   /* [cells.n] place of a cell among the own ones, n_own if it is none; owned */
  uint64_t map;     /* generation of the map that these are of */
  int every;        /* settlements between looks at the balance; 0: never */
  double imbalance; /* what is borne */
  uint64_t settled, looks, repartitions,
      migrated; /* counted over the run; migrated: nodes that left this rank */
  double seen;  /* last imbalance, 0: not looked yet */
};

/* What a scene says of it. */
struct kith_sharing {
  const char *partitioner; /* name and words: partition.h */
  int every;
  double imbalance;
  int cells; /* wanted per rank */
};

/* The cells that are dealt out, `most` of them or fewer: none smaller than half the smallest support, so that a layer of them is no
 * thinner than a layer of nodes. */
kith_status kith_share_cells(struct kith_cells *cells, const struct kith_nodes *nodes,
                             const struct kith_box *box, const bool *periodic, int64_t most);
/* Cells over the box, and the first map by the number of nodes in them. `nodes` are those of the whole scene, with their ranks. */
kith_status kith_share_create(struct kith_share **out, struct kith_nodes *nodes, const struct kith_box *box,
                              const bool *periodic, const struct kith_sharing *sharing);
void kith_share_destroy(struct kith_share **share);

/* Drops the nodes of other ranks' cells. All nodes are here. No communication. */
kith_status kith_share_keep(struct kith_share *share, struct kith_nodes *nodes);
/* Balances if that is due, then sends nodes where their cells are. Collective. */
kith_status kith_share_settle(struct kith_share *share, struct kith_nodes *nodes);
/* Lists were made: rows row_first[i] .. row_first[i + 1] - 1 are the work of the nodes from now on. */
void kith_share_measure(struct kith_share *share, const struct kith_nodes *nodes, const size_t *row_first);

/* Who has how many nodes of each list, the map, and the memory of the partitioner: for checkpoints, which store nodes list by list, rank by
 * rank. `work` is stored beside it. Collective; owned by the caller. */
struct kith_shared {
  size_t n;
  int64_t *word; /* kith_resize memory */
};
kith_status kith_share_describe(const struct kith_share *share, const struct kith_nodes *nodes,
                                struct kith_shared *out);
/* All nodes are here as they were stored, with their work: keeps what this rank had and the map, if there were as many ranks and cells; else
 * those of its cells. BAD_FILE if the description is not of these nodes. */
kith_status kith_share_restore(struct kith_share *share, struct kith_nodes *nodes,
                               const struct kith_shared *shared);

#endif
