/* list.h - a neighbor list: for each target the sources near it.
 *
 * Targets and sources are selections (search.h): the same nodes, some of each, or points that are no
 * nodes. A specification says all of it; what is missing or contradicts itself is refused by name. The rows
 * of hydro packages are built from one as well (connectivity.h).
 *
 * Ordinals. Target t = 0 .. n_targets - 1 is node target[t], and row[i] is t again, or -1; column[j] is the
 * ordinal of a source, or -1. Rows hold nodes, ascending unless `unsorted`.
 *
 * A list is made by kith_list_update, which asks its rebuild policies, and is then only read. It holds the
 * targets of this process, which are its nodes, and their sources, its nodes and ghosts. Whether it is
 * rebuilt is decided by all ranks together. */
#ifndef KITH_CONNECTIVITY_LIST_H
#define KITH_CONNECTIVITY_LIST_H

#include "lib/comm/sum.h"
#include "lib/connectivity/build/builder.h"
#include "lib/connectivity/policies/rebuild.h"
#include "lib/connectivity/storage/storage.h"

/* All borrowed. */
struct kith_list_spec {
  struct kith_selection targets, sources; /* of the same nodes: with the same search */
  enum kith_cutoff cutoff;
  double number;      /* of cutoff number, else 0 */
  const char *radius; /* the field of the other cutoffs, which the searches know too, else NULL */
  struct kith_excluder *excluders; /* chain; NULL: none, not even self */
  const char *storage;             /* "csr", "padded:width=64" */
  const char *rebuild;             /* policies (rebuild.h); between two sets of nodes: always */
  const double *period;            /* for the policies: lengths of periodic axes; NULL: none */
  bool unsorted;
  kith_index expected; /* entries of a row: memory that is reserved beforehand; 0: none */
};

/* Nodes among each other, within the search radius of either, in csr, always rebuilt. `self`, which leaves
 * out the node itself, becomes the head of the chain; `others`: the rest of it, or NULL. */
struct kith_list_spec kith_list_spec_among(const struct kith_nodes *nodes, struct kith_search *search,
                                           struct kith_excluder *self, struct kith_excluder *others);
/* What builders of rows need, from a specification; its excluders are set up. BAD_INPUT, by name, if
 * something of that is missing or contradictory. */
kith_status kith_list_spec_prepare(const struct kith_list_spec *spec, struct kith_builder *scratch,
                                   struct kith_build *build);

struct kith_list {
  struct kith_list_spec spec;
  kith_index n_targets, n_sources;
  kith_index *target, *row, *column; /* ordinals: see above */
  struct kith_stored stored;
  uint64_t builds; /* so far */
  bool built, invalidated;
  uint64_t ghosts[2]; /* generations, of the nodes of targets and sources */
  size_t targets_capacity, rows_capacity, columns_capacity;
  struct kith_rebuilds rebuilds;
  struct kith_builder scratch;
};

/* BAD_INPUT, by name, for what is missing or contradictory, and for wrong settings of storage and
 * policies. */
kith_status kith_list_create(struct kith_list **out, const struct kith_list_spec *spec);
void kith_list_destroy(struct kith_list **list);
/* Rebuilds it if that is due; *why: for which reason, none if it was kept. BAD_INPUT if the first
 * time there are targets and no sources, on all ranks together. Collective. */
kith_status kith_list_update(struct kith_list *list, enum kith_rebuild_reason *why);
/* The next update builds, whatever the policies say. All ranks call it. */
void kith_list_invalidate(struct kith_list *list);
/* STALE unless it was built, is not invalidated, and nodes and ghosts are those it was made from. */
kith_status kith_list_current(const struct kith_list *list);

/* --- iteration --- */

/* One target, whether it has neighbors or not. */
struct kith_neighbors {
  kith_index target, node; /* its ordinal; the node */
  const kith_index *source;
  const uint16_t *shift; /* which images the sources are (lib/nodes/shifts.h); NULL: none */
  size_t n;
};

/* What is found over all targets, or pairs, of all ranks: bitwise identical for any number of threads and
 * ranks and any storage, as sums are exact. If there is nothing: 0, 0, INFINITY, -INFINITY. */
enum kith_reduction { KITH_COUNT, KITH_SUM, KITH_LEAST, KITH_MOST };
struct kith_reducer {
  enum kith_reduction kind;
  double value; /* written */
};
enum { KITH_MAX_REDUCERS = 8 };
struct kith_tally {
  const struct kith_reducer *reducer;
  struct kith_sum sum[KITH_MAX_REDUCERS];
  double extreme[KITH_MAX_REDUCERS];
};
/* Adds a value to reducer k; a count adds 1, whatever the value. */
static inline void kith_tally_add(struct kith_tally *tally, int k, double value) {
  const enum kith_reduction kind = tally->reducer[k].kind;
  if (kind <= KITH_SUM) kith_sum_add(&tally->sum[k], kind == KITH_COUNT ? 1 : value);
  if (kind == KITH_LEAST) tally->extreme[k] = KITH_MIN(tally->extreme[k], value);
  if (kind == KITH_MOST) tally->extreme[k] = KITH_MAX(tally->extreme[k], value);
}

/* Is called for each target, by several threads. Pairs are its loop over the row: no function is called
 * through a pointer for each pair. */
typedef void (*kith_list_visit)(void *context, const struct kith_neighbors *neighbors,
                                struct kith_tally *tally);
/* n reducers, at most KITH_MAX_REDUCERS; 0: none, and reducer may be NULL. STALE as kith_list_current.
 * Collective if n > 0: the status is agreed on. */
kith_status kith_list_visit_all(const struct kith_list *list, kith_list_visit visit, void *context,
                                struct kith_reducer *reducer, int n);

#endif
