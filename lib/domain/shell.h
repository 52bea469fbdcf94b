/* shell.h - what a map of cells means for a rank: its ghost cells, whom it exchanges them with, and how good the map is.
 *
 * The ghost cells of a rank are the foreign cells adjacent to its own ones by a face, an edge or a corner, periodic
 * images counted: one layer, each cell once, however many of its images are met (kith_cells_neighbors tells
 * which). What p sends to q are its cells that are ghosts of q. Both lists are in ascending cell number, so
 * that position i of p's list to q is position i of q's list from p, though neither asks the other. */
#ifndef KITH_DOMAIN_SHELL_H
#define KITH_DOMAIN_SHELL_H

#include "lib/domain/partition.h"

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

/* `shell` is replaced: {0} or one that was built before. Cost: one look at every cell, then the own ones. */
kith_status kith_shell_build(struct kith_shell *shell, const struct kith_partition *partition, int rank);
void kith_shell_clear(struct kith_shell *shell);

/* One rank in figures. */
struct kith_rank_figures {
  double weight;
  int64_t cells, ghosts; /* own; to be received */
  int64_t sends;         /* cells, one for each rank that they are sent to */
  int64_t cut_faces;     /* faces of own cells to foreign ones */
  int neighbors;         /* ranks to exchange with */
};

/* All ranks in figures. */
struct kith_partition_figures {
  double mean_weight, largest_weight;
  double imbalance; /* largest over mean; 1 if there is no weight */
  double cut;       /* weight of the cut faces, each counted once */
  int64_t cut_faces, largest_ghosts;
  int largest_neighbors, empty_ranks;
};

/* weight and face_weight as for kith_partition_update, without the work of empty cells; NULL: 1 each. rank[n_ranks] is
 * written. The same numbers as the shells of all ranks, in one sweep over the cells. */
kith_status kith_partition_figures(const struct kith_partition *partition, const double *weight,
                                   const double *face_weight, struct kith_rank_figures *rank,
                                   struct kith_partition_figures *all);

#endif
