/* ledger.h - counters of a run: one table for the counters, the report and the sums over ranks.
 *
 * Ghosts are counted independently when boundaries create them, when they are culled, and in the blocks that
 * are left (kept). So created = culled + kept is a check, for each boundary and in total
 * (kith_ledger_closes). */
#ifndef KITH_INTEGRATOR_LEDGER_H
#define KITH_INTEGRATOR_LEDGER_H

#include "boundaries/boundary.h"
#include "lib/connectivity/policies/rebuild.h"

/* Counter (its name in report.json, after "ledger."), how ranks combine, what it counts. EACH: ranks are
 * summed (a pair between ranks counts twice); TOGETHER: it is the same on all ranks. */
#define KITH_LEDGER_LIST(X)                                                                     \
  X(lifecycles, TOGETHER, "rebuilds of ghosts, searches and connectivity")                      \
  X(reorders, EACH, "reorderings of the nodes along the curve")                                 \
  X(evaluations, TOGETHER, "evaluations of the rates")                                          \
  X(updates, EACH, "evaluations of single nodes: with block steps of the active ones")          \
  X(rejected_steps, TOGETHER, "attempts that were repeated with a shorter step")                \
  X(refreshes, TOGETHER, "evaluations that only refreshed the ghosts' values")                  \
  X(ghosts_created, EACH, "ghosts made by the boundaries")                                      \
  X(ghosts_culled, EACH, "ghosts removed because no internal node needs them")                  \
  X(ghosts_kept, EACH, "ghosts left after the cull")                                            \
  X(row_entries, EACH, "neighbors in the rows of internal nodes")                               \
  X(pairs, EACH, "flattened pairs")                                                             \
  X(overlap_pairs, EACH, "flattened pairs of nodes whose supports overlap")                     \
  X(pairs_cut, EACH, "pairs that barriers cut")                                                 \
  X(last_ghosts, EACH, "ghosts after the last lifecycle")                                       \
  X(last_row_entries, EACH, "neighbors in the rows of internal nodes after the last lifecycle") \
  X(last_pairs, EACH, "pairs after the last lifecycle")

/* Only uint64_t members: checkpoints store it as words. */
struct kith_ledger {
#define X(name, ...) uint64_t name;
  KITH_LEDGER_LIST(X)
#undef X
  uint64_t because[KITH_REBUILD_REASONS]; /* lifecycles by reason */
  struct kith_ledger_boundary {
    uint64_t created, culled, kept;
  } boundary[KITH_MAX_BOUNDARIES];
};

/* Returns the sums over all ranks. Collective. */
struct kith_ledger kith_ledger_of_all(const struct kith_ledger *ledger, struct kith_ranks *ranks);
/* Splits the ledger of all ranks so that kith_ledger_of_all gives it back: rank 0 keeps the sums. */
struct kith_ledger kith_ledger_of_rank(const struct kith_ledger *all, const struct kith_ranks *ranks);
/* Do counters agree? created = culled + kept for each boundary and in total, and lifecycles = sum over their
 * reasons. */
bool kith_ledger_closes(const struct kith_ledger *ledger);

#endif
