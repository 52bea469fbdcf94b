/* migrate.h - nodes move to other ranks, with all registered fields, whatever their role, since a scheme may
 * be in the middle of a step. */
#ifndef KITH_NODES_MIGRATE_H
#define KITH_NODES_MIGRATE_H

#include "lib/nodes/nodes.h"

/* Internal node i goes to rank to[i], which is this rank or one of the n_neighbors ranks in `neighbor`; two
 * ranks must name each other. If neighbor is NULL, to[i] may be any rank. Ghosts are dropped. In each list
 * nodes that stay keep their order, and the arriving ones follow, rank by rank, in the order that they had
 * there. *moved (may be NULL): how many left this rank. Collective; the status is that of this rank. A rank
 * without memory for the messages ends all ranks, because they wait for it. */
kith_status kith_nodes_migrate(struct kith_nodes *nodes, const int32_t *to, int n_neighbors,
                               const int32_t *neighbor, uint64_t *moved);

/* INTERNAL, in one message of all ranks, unless there are as many nodes after a migration as before, both
 * counted over all ranks. Collective. */
kith_status kith_nodes_all_left(struct kith_ranks *ranks, uint64_t before, uint64_t after);

/* Sorts each list of this rank by id. */
kith_status kith_nodes_sort_by_id(struct kith_nodes *nodes);

/* counts[rank][list] of the nodes of all ranks: kith_resize memory owned by the caller. Collective. */
kith_status kith_nodes_counts(const struct kith_nodes *nodes, int64_t **counts);

/* A copy with the fields of snapshots (those with an `output` name, and the fields that all nodes have), in
 * an order that does not depend on the number of ranks: list by list, rank by rank, ids ascend. Each rank
 * gets an equal range of ids. Owned by the caller. Collective. */
kith_status kith_nodes_by_id(const struct kith_nodes *nodes, struct kith_nodes **out);

#endif
