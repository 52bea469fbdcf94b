/* shell.h - what a map of cells means for each rank: its ghost cells, and the ranks to exchange them
 * with.
 *
 * The ghost cells of a rank are the cells of other ranks that share a face, an edge or a corner with its own
 * ones, periodic images included: one layer, each cell once however many of its images are adjacent
 * (kith_cells_neighbors tells which). Rank p sends to q those of its cells that are ghost cells of q. Both
 * lists are in ascending cell number, so that entry i of p's list to q is entry i of q's list from p without
 * any communication. */
#ifndef KITH_DOMAIN_PARTITION_SHELL_H
#define KITH_DOMAIN_PARTITION_SHELL_H

#include "lib/domain/partition/partition.h"

struct kith_shell {
  int rank, n_neighbors;
  int64_t n_cells, n_ghosts;
  int64_t *cell;     /* [n_cells] own cells, ascending */
  int32_t *neighbor; /* [n_neighbors] ranks, ascending; never the own one */
  /* Neighbor k: receive[receive_first[k] .. receive_first[k + 1]) and the like of send: cells, ascending. */
  int64_t *receive_first, *send_first; /* [n_neighbors + 1] */
  int64_t *receive;                    /* [n_ghosts] all ghost cells */
  int64_t *send;
};

/* `shell` is replaced: {0} or one that was built before. Cost: one pass over all cells, then the own ones. */
kith_status kith_shell_build(struct kith_shell *shell, const struct kith_partition *partition, int rank);
void kith_shell_clear(struct kith_shell *shell);

#endif
