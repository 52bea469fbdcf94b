/* decomposition.h - the domain decomposition: which rank owns which cell, which nodes must move to another
 * rank, and when the load is balanced again.
 *
 * Every rank comes with a share of the nodes, whichever, and sends them to the ranks that own their cells.
 * Later, nodes follow their cells when neighbor lists are rebuilt (kith_decomposition_assign and _move), and
 * only then. `home` of a node is the index, among the cells of this rank, of the cell that it was in then;
 * after a restart, when it may be in a cell of another rank already, of the nearest own one.
 *
 * Each rank has the whole map, 8 bytes a cell, and talks to the ranks of its shell: those whose cells are
 * within a reach that all ranks know.
 *
 * Load balance. The work of a node is the number of entries of its last row, plus 1. At every `every`-th
 * redistribution the work is summed by cells over all ranks; if the busiest rank has more than `imbalance`
 * times the mean, the partitioner is asked for a new map, which it may refuse.
 *
 * A restart on the same number of ranks, with the same partitioner and cells, is bitwise identical to an
 * uninterrupted run; on another number, or with others, the map is the first one of the scene. */
#ifndef KITH_DOMAIN_DECOMPOSITION_H
#define KITH_DOMAIN_DECOMPOSITION_H

#include "lib/domain/partition/shell.h"
#include "lib/io/checkpoint.h"
#include "lib/nodes/nodes.h"

struct kith_decomposition {
  struct kith_ranks *ranks; /* borrowed */
  struct kith_cells cells;
  struct kith_partition *partition; /* owned */
  struct kith_field *home;          /* I64: 0 .. n_own - 1 */
  struct kith_field *work;          /* I64: entries of the node's last row */
  int64_t n_own;                    /* cells of this rank */
  int32_t *place;          /* [cells.n] index among the own cells; n_own: a cell of another rank; owned */
  int32_t *own;            /* [n_own] ascending; owned */
  struct kith_shell shell; /* this rank's surroundings, once they were asked for */
  uint64_t map, shell_map; /* generations of the map that they belong to; 0: none */
  int32_t *to;             /* [nodes] the ranks they go to, by the last assignment; owned */
  size_t to_capacity;
  uint64_t leaving, far; /* nodes that leave this rank; of these, those that go to no neighbor */
  bool surrounded;       /* the shell was built anew since the last assignment */
  double outside;        /* how far a node is out of its cell at most */
  int every;             /* redistributions between balance checks; 0: never */
  double imbalance;      /* tolerated: largest work of a rank over the mean */
  uint64_t redistributions, balance_checks, repartitions; /* counted over the run */
  uint64_t migrated;                                      /* nodes that left this rank */
  double last_imbalance;                                  /* at the last check; 0: none yet */
  char partitioner[128];                                  /* as it was asked for */
  bool resumed;                                           /* map and nodes are those of a checkpoint */
};

/* The settings of a scene. */
struct kith_decomposition_options {
  const char *partitioner; /* name and options: partition.h */
  int every;
  double imbalance;
  int cells; /* per rank, about */
};

/* The cells to assign, at most `most`: none smaller than half the smallest support of all ranks, so that a
 * layer of cells is not thinner than a layer of nodes. Collective. */
kith_status kith_decomposition_cells(struct kith_cells *cells, const struct kith_nodes *nodes,
                                     const struct kith_box *box, const bool *periodic, int64_t most);
/* Cells over the box, and a first map that balances the number of nodes, which move to its ranks and then are
 * ordered by id. Collective; the status is agreed on. */
kith_status kith_decomposition_create(struct kith_decomposition **out, struct kith_nodes *nodes,
                                      const struct kith_box *box, const bool *periodic,
                                      const struct kith_decomposition_options *options);
void kith_decomposition_destroy(struct kith_decomposition **decomposition);

/* Finds the cells and ranks of nodes, after balancing the load if a check is due (only then collective).
 * `status`: of this rank so far, which is passed on; so is a failure, not agreed on. */
kith_status kith_decomposition_assign(struct kith_decomposition *decomposition, struct kith_nodes *nodes,
                                      kith_status status);
/* Then, `leaving` and `far` of all ranks being known: sends nodes to these ranks. The status of this rank.
 * Collective if some leave: among neighbors, or all if some are far or the shell is a new one. */
kith_status kith_decomposition_move(struct kith_decomposition *decomposition, struct kith_nodes *nodes,
                                    uint64_t leaving, uint64_t far);
/* `outside` at present, between assignments. */
double kith_decomposition_outside(const struct kith_decomposition *decomposition,
                                  const struct kith_nodes *nodes);
/* Builds the shell of this map, of a little more than this reach, unless there is one. *changed: there was
 * none. All ranks do the same; the status is that of this rank. No communication. */
kith_status kith_decomposition_surround(struct kith_decomposition *decomposition, double reach,
                                        bool *changed);
/* After lists were rebuilt: row_first[i + 1] - row_first[i] entries are the work of node i from now on. */
void kith_decomposition_measure(struct kith_decomposition *decomposition, const struct kith_nodes *nodes,
                                const size_t *row_first);

/* Adds the work of the nodes, their numbers by rank and list, the map, and the state of the partitioner.
 * Collective; `c` is NULL on all ranks but 0, which alone knows of a failure to write. */
kith_status kith_decomposition_save(const struct kith_decomposition *decomposition,
                                    const struct kith_nodes *nodes, struct kith_checkpoint *c);
/* The nodes of a checkpoint: with the same numbers of ranks and cells those that this rank had, and the map;
 * otherwise an equal part, and the map stays. BAD_FILE if the state does not belong to these nodes. Of this
 * rank alone. */
kith_status kith_decomposition_read(struct kith_decomposition *decomposition, struct kith_nodes *nodes,
                                    struct kith_checkpoint *c);
/* Then, by all ranks: nodes that are not where the map has them go there. The status is agreed on. */
kith_status kith_decomposition_resume(struct kith_decomposition *decomposition, struct kith_nodes *nodes);

#endif
