/* The ledger: sums over ranks, whether it closes. */
#include "integrator/ledger.h"

#include <string.h>

/* Copies the counters that are the same on all ranks. */
static void copy_common(struct kith_ledger *to, const struct kith_ledger *from) {
#define COPY_EACH(name)
#define COPY_TOGETHER(name) to->name = from->name;
#define X(name, how, doc) COPY_##how(name)
  KITH_LEDGER_LIST(X)
#undef X
  memcpy(to->because, from->because, sizeof to->because);
}

struct kith_ledger kith_ledger_of_all(const struct kith_ledger *ledger, struct kith_ranks *ranks) {
  struct kith_ledger all = *ledger;
  kith_ranks_sum_counts(ranks, (uint64_t *)&all, sizeof all / sizeof(uint64_t));
  copy_common(&all, ledger);
  return all;
}

struct kith_ledger kith_ledger_of_rank(const struct kith_ledger *all, const struct kith_ranks *ranks) {
  struct kith_ledger mine = {0};
  if (kith_ranks_rank(ranks) == 0) return *all;
  copy_common(&mine, all);
  return mine;
}

bool kith_ledger_closes(const struct kith_ledger *ledger) {
  struct kith_ledger_boundary sum = {0};
  uint64_t lifecycles = 0;
  bool closes = true;
  for (int b = 0; b < KITH_MAX_BOUNDARIES; ++b) {
    const struct kith_ledger_boundary *own = &ledger->boundary[b];
    closes = closes && own->created == own->culled + own->kept;
    sum.created += own->created, sum.culled += own->culled, sum.kept += own->kept;
  }
  for (int r = 0; r < KITH_REBUILD_REASONS; ++r) lifecycles += ledger->because[r];
  return closes && sum.created == ledger->ghosts_created && sum.culled == ledger->ghosts_culled &&
         sum.kept == ledger->ghosts_kept && lifecycles == ledger->lifecycles;
}
