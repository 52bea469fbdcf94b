/* excluder.h - stock excluders, and how a chain is asked.
 *
 * `custom`: fill in a struct kith_excluder yourself; it is called for candidates (broad) or hits (narrow).
 *
 * What a chain rejects is in no row, hence in no pair and no intersection; it is in no overlap row, and no
 * overlap goes through it. */
#ifndef KITH_CONNECTIVITY_EXCLUDER_H
#define KITH_CONNECTIVITY_EXCLUDER_H

#include "lib/connectivity/connectivity.h"

/* name, doc */
#define KITH_EXCLUDER_LIST(X)                                                                      \
  X(none, "an empty chain; costs nothing")                                                         \
  X(self, "always: no row holds its own node, but its images, which are other nodes")              \
  X(symmetric_duplicates, "always: the pair list holds each pair once")                            \
  X(connected, "nodes with the same tag do not interact: members of one body, links of one chain") \
  X(custom, "a predicate of your own, before the distance test (broad) or after it (narrow)")

/* Rejects pairs with equal tags above 0 in an I64 or U8 field (borrowed; 0 and below: no tag). BAD_INPUT for
 * an F64 field. Ghosts carry the tag of their control node. `next`: the rest of the chain or NULL. */
kith_status kith_excluder_connected(struct kith_excluder *out, const struct kith_field *tag,
                                    const struct kith_excluder *next);

/* Does any member of this phase reject (i, j)? */
static inline bool kith_excluder_rejects(const struct kith_excluder *chain, enum kith_phase phase,
                                         const struct kith_nodes *nodes, kith_index i, kith_index j) {
  for (; chain != NULL; chain = chain->next)
    if (chain->phase == phase && chain->reject(chain->context, nodes, i, j)) return true;
  return false;
}

#endif
