/* selection.h - some nodes of a search: the targets of a neighbor list, or its sources.
 *
 * Points that are no nodes of the run are nodes of their own, with a search of their own. */
#ifndef KITH_NEIGHBOR_SELECTION_H
#define KITH_NEIGHBOR_SELECTION_H

#include "lib/neighbor/search.h"

struct kith_selection {
  const struct kith_nodes *nodes; /* borrowed, as all of it */
  struct kith_search *search;     /* of these nodes */
  uint64_t lists;                 /* bit l: nodes of list l; 0: of all lists */
  bool ghosts;                    /* of targets: ghosts too. Ghosts are sources in any case */
  bool (*chosen)(const void *context, const struct kith_nodes *nodes, kith_index i); /* NULL: all */
  const void *context;
};

/* Is node or ghost i one of them? `ghosts` is not looked at. */
static inline bool kith_selects(const struct kith_selection *s, kith_index i) {
  return (s->lists == 0 || (s->lists >> s->nodes->list->u8[i] & 1) != 0) &&
         (s->chosen == NULL || s->chosen(s->context, s->nodes, i));
}

#endif
