/* migrate.h - nodes move to other ranks, with all that they are: every registered field, whatever its role, since a scheme
 * may be in the middle of a step. Any distance. None is lost or doubled: the number of all nodes is checked, INTERNAL. */
#ifndef KITH_DOMAIN_MIGRATE_H
#define KITH_DOMAIN_MIGRATE_H

#include "lib/nodes/nodes.h"

/* Internal node i goes to rank to[i]. Ghosts are dropped. Those that stay keep their order; behind them, list by list, come
 * the others, rank by rank in the order they had there. *moved (may be NULL): how many left this rank. Collective. */
kith_status kith_nodes_migrate(struct kith_nodes *nodes, const int32_t *to, uint64_t *moved);

/* All internal nodes of all ranks on rank 0, list by list, by id or rank by rank; `fields` tells which come along: those of role STATE (restarts),
 * or those in snapshots. *whole is owned by the caller; NULL on the other ranks. Collective; NULL ranks: a copy by id. */
enum kith_gathered { KITH_GATHER_STATE, KITH_GATHER_OUTPUT };
kith_status kith_nodes_gather(const struct kith_nodes *nodes, enum kith_gathered fields, bool by_id,
                              struct kith_nodes **whole);

#endif
