/* shell.h - what a map of cells means for each rank: its own cells, its ghost cells, and the ranks to
 * exchange them with.
 *
 * The ghost cells of a rank are the cells of other ranks within `reach` of its own ones, periodic images
 * included, and all that share a face, an edge or a corner with one of them (reach 0): each once, however
 * many of its images are near. Rank p sends to q those of its cells that are ghost cells of q: distances have
 * no direction. Both lists are in ascending cell number, so that entry i of p's list to q is entry i of q's
 * list from p without any communication. */
#ifndef KITH_DOMAIN_PARTITION_SHELL_H
#define KITH_DOMAIN_PARTITION_SHELL_H

#include "lib/domain/partition/partition.h"

struct kith_shell {
  int rank, n_neighbors;
  double reach;
  int64_t n_cells, n_ghosts;
  int64_t *cell;     /* [n_cells] own cells, ascending */
  int32_t *neighbor; /* [n_neighbors] ranks, ascending; never the own one */
  /* Neighbor k: receive[receive_first[k] .. receive_first[k + 1]) and the like of send: cells, ascending. */
  int64_t *receive_first, *send_first; /* [n_neighbors + 1] */
  int64_t *receive;                    /* [n_ghosts] all ghost cells */
  int64_t *send;
};

/* `shell` is replaced: {0} or one that was built before. Cost: one pass over all cells, and over the
 * surroundings of the own ones. No communication. */
kith_status kith_shell_build(struct kith_shell *shell, const struct kith_partition *partition, int rank,
                             double reach);
void kith_shell_clear(struct kith_shell *shell);

/* The number among the own cells of the one that holds a position, which is wrapped on periodic axes.
 * BAD_INPUT for a position that is not finite, is beyond an open side, or belongs to a cell of another rank:
 * the message says which. */
kith_status kith_shell_find(const struct kith_shell *shell, const struct kith_partition *partition,
                            const double *x, int64_t *own);

#endif
