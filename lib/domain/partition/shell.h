/* shell.h - what a map of cells means for each rank: its ghost cells, the ranks to exchange them with, and
 * the quality of the map.
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

/* Figures of one rank. */
struct kith_rank_figures {
  double weight;
  int64_t cells, ghosts; /* own; received */
  int64_t sends;         /* cells, each as often as it is sent */
  int64_t cut_faces;     /* between own cells and those of other ranks */
  int neighbors;         /* ranks to exchange with */
};

/* Figures of all ranks. */
struct kith_partition_figures {
  double mean_weight, largest_weight;
  double imbalance; /* largest over mean; 1 if there is no weight */
  double cut;       /* weight of the cut faces, each counted once */
  int64_t cut_faces, largest_ghosts;
  int largest_neighbors, empty_ranks;
};

/* weight and face_weight as for kith_partition_update, without the work of empty cells; NULL: 1 each.
 * rank[n_ranks] is written. The figures agree with the shells of all ranks; one pass over the cells. */
kith_status kith_partition_figures(const struct kith_partition *partition, const double *weight,
                                   const double *face_weight, struct kith_rank_figures *rank,
                                   struct kith_partition_figures *all);

#endif
