/* excluder.h - excluders reject pairs of nodes that a search found: they do not interact.
 *
 * A pair is significant only if no excluder of the chain rejects it. What a chain rejects is in no row, hence
 * in no pair and no intersection; it is in no overlap row, and no overlap is found through it. A broad
 * excluder is asked before the distance test, a narrow one after it.
 *
 * Always active without an excluder: no row holds its own node (but its images, which are other nodes), and
 * the pair list holds each pair once. */
#ifndef KITH_CONNECTIVITY_EXCLUDER_H
#define KITH_CONNECTIVITY_EXCLUDER_H

#include "lib/nodes/nodes.h"

/* name, doc */
#define KITH_EXCLUDER_LIST(X)                                                                    \
  X(none, "an empty chain; costs nothing")                                                       \
  X(self, "always active: no row holds its own node, but its images, which are other nodes")     \
  X(symmetric_duplicates, "always active: the pair list holds each pair once")                   \
  X(connected, "nodes with equal tags do not interact: nodes of one rigid body or of one chain") \
  X(custom, "a predicate of the caller, before the distance test (broad) or after it (narrow)")

enum kith_phase { KITH_BROAD, KITH_NARROW };

/* Fill it in for a predicate of your own. `reject` is symmetric in i and j, and thread-safe. */
struct kith_excluder {
  enum kith_phase phase;
  bool (*reject)(const void *context, const struct kith_nodes *nodes, kith_index i, kith_index j);
  const void *context;              /* borrowed */
  const struct kith_excluder *next; /* rest of the chain, borrowed, or NULL */
};

/* Does any excluder of this phase reject (i, j)? */
static inline bool kith_excluder_rejects(const struct kith_excluder *chain, enum kith_phase phase,
                                         const struct kith_nodes *nodes, kith_index i, kith_index j) {
  for (; chain != NULL; chain = chain->next)
    if (chain->phase == phase && chain->reject(chain->context, nodes, i, j)) return true;
  return false;
}

static inline bool kith_excluder_same_tag(const void *context, const struct kith_nodes *nodes, kith_index i,
                                          kith_index j) {
  const struct kith_field *tag = context;
  (void)nodes;
  if (tag->spec.type == KITH_I64) return tag->i64[i] > 0 && tag->i64[i] == tag->i64[j];
  return tag->u8[i] > 0 && tag->u8[i] == tag->u8[j];
}

/* Rejects pairs with equal tags above 0 in an I64 or U8 field (borrowed; 0 and below: no tag). BAD_INPUT for
 * an F64 field. Ghosts carry the tag of their control node. Narrow, as a distance costs less than a call. */
static inline kith_status kith_excluder_connected(struct kith_excluder *out, const struct kith_field *tag,
                                                  const struct kith_excluder *next) {
  if (tag->spec.type == KITH_F64)
    KITH_FAIL(BAD_INPUT, "field '%s' cannot be a tag: tags are integers", tag->spec.name);
  *out = (struct kith_excluder){KITH_NARROW, kith_excluder_same_tag, tag, next};
  return KITH_OK;
}

#endif
