/* migrate.h - nodes move to other ranks, with all that they are: every registered field, whatever its role, since a scheme
 * may be in the middle of a step. Any distance. None is lost or doubled: the number of all nodes is checked, INTERNAL. */
#ifndef KITH_DOMAIN_MIGRATE_H
#define KITH_DOMAIN_MIGRATE_H

#include "lib/nodes/nodes.h"

/* Internal node i goes to rank to[i]. Ghosts are dropped. Those that stay keep their order; behind them, list by list, come
 * the others, rank by rank in the order they had there. *moved (may be NULL): how many left this rank. Collective. */
kith_status kith_nodes_migrate(struct kith_nodes *nodes, const int32_t *to, uint64_t *moved);

/* counts[rank][list] of the nodes of all ranks: kith_resize memory of the caller. Collective. */
kith_status kith_nodes_counts(const struct kith_nodes *nodes, int64_t **counts);

/* Copies with what snapshots have of a node (fields with an `output` name, and the standing ones), owned by the caller. Collective. */

/* In an order that all numbers of ranks share: list by list, rank by rank, ids ascend. Ranks get equal ranges of ids. */
kith_status kith_nodes_deal(const struct kith_nodes *nodes, struct kith_nodes **dealt);
/* All on rank 0 (it needs the memory), each list by id; NULL on the other ranks. */
kith_status kith_nodes_gather(const struct kith_nodes *nodes, struct kith_nodes **whole);

#endif
