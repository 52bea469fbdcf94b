/* excluder.h - excluders reject candidates that a search found: they are no neighbors.
 *
 * A chain rejects what any of its excluders rejects: that is in no row, hence in no pair and no intersection;
 * it is in no overlap row, and no overlap is found through it. A broad excluder is asked about what lies
 * within reach of the box of a group, a narrow one about what the distance test leaves.
 *
 * Rows of hydro packages exclude the node itself (but not its images, which are other nodes), and their pair
 * list holds each pair once. */
#ifndef KITH_CONNECTIVITY_EXCLUDERS_EXCLUDER_H
#define KITH_CONNECTIVITY_EXCLUDERS_EXCLUDER_H

#include "lib/core/param.h"
#include "lib/neighbor/search.h"

enum kith_phase { KITH_BROAD, KITH_NARROW };

/* Source j as a neighbor of target i, which are nodes, or ghosts, of their selections. */
struct kith_candidate {
  const struct kith_selection *targets, *sources;
  kith_index i, j;
  int shift; /* j is this image of its node (lib/nodes/shifts.h) */
};

struct kith_excluder;

struct kith_excluder_ops {
  const char *name, *doc;
  const struct kith_param *params; /* its own parameters (excluder->settings), NULL: none */
  size_t settings_size;
  enum kith_phase phase;
  bool self;   /* it rejects the node itself and nothing else */
  bool halves; /* it rejects one of the two candidates of each pair: rows are not symmetric */
  /* Before each build: makes what `reject` needs from the present nodes, in excluder->self. NULL: nothing. */
  kith_status (*setup)(struct kith_excluder *excluder, const struct kith_selection *targets,
                       const struct kith_selection *sources);
  bool (*reject)(const struct kith_excluder *excluder, const struct kith_candidate *candidate);
  void (*clear)(struct kith_excluder *excluder); /* frees what self owns; NULL: nothing */
};

/* A program with a predicate of its own fills in ops and context. In the rows of packages `reject` must be
 * symmetric in i and j. It is called by several threads. */
struct kith_excluder {
  const struct kith_excluder_ops *ops;
  const void *context; /* of the caller, borrowed */
  void *settings;      /* what its params fill; NULL if it has none */
  void *self;
  struct kith_excluder *next; /* rest of the chain, borrowed, or NULL */
};

#define KITH_EXCLUDER_LIST(X) X(self) X(symmetric_duplicates) X(connected) X(materials) X(bonds)
#define X(name) extern const struct kith_excluder_ops kith_excluder_##name;
KITH_EXCLUDER_LIST(X)
#undef X
KITH_FAMILY_FUNCTIONS(kith_excluder);

/* The context of the excluder bonds: pairs of ids, in any order. */
struct kith_bonds {
  size_t n;
  const int64_t (*id)[2];
};

/* A chain from words joined by "|", with settings after a colon: "connected:field=barrier | materials:of=gas
 * and=dust". Empty words: an empty chain. */
struct kith_excluders {
  int n;
  struct kith_excluder excluder[8]; /* each borrows the next */
};
kith_status kith_excluders_create(struct kith_excluders *out, const char *words);
void kith_excluders_clear(struct kith_excluders *excluders);

/* For builders: sets up all of them. BAD_INPUT for what is in the chain twice, and for self and halves where
 * targets and sources are of different nodes. */
kith_status kith_excluder_setup(struct kith_excluder *chain, const struct kith_selection *targets,
                                const struct kith_selection *sources);

/* BAD_INPUT if one of them halves: rows of packages have each interaction at both ends. */
kith_status kith_excluder_keeps_pairs(const struct kith_excluder *chain);

/* Does any excluder of this phase reject it? */
static inline bool kith_excluder_rejects(const struct kith_excluder *chain, enum kith_phase phase,
                                         const struct kith_candidate *candidate) {
  for (; chain != NULL; chain = chain->next)
    if (chain->ops->phase == phase && chain->ops->reject(chain, candidate)) return true;
  return false;
}

#endif
