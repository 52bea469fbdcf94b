/* A fifth rebuild policy: what is sized by the list of policies grows with it, and nothing is overrun. The
 * family and the ledger are compiled here once more, with the longer list. */
#define KITH_REBUILD_LIST(X) X(always) X(never) X(entity_change) X(displacement) X(planted)
#include "integrator/ledger.c"
#include "lib/connectivity/policies/rebuild.c"
#include "tests/check.h"

static bool needs_rebuild(const struct kith_rebuild *policy, const struct kith_cover *cover,
                          const struct kith_nodes *nodes) {
  (void)policy, (void)cover, (void)nodes;
  return true;
}

const struct kith_rebuild_ops kith_rebuild_planted = {
    .name = "planted", .doc = "a test's", .covers = true, .needs_rebuild = needs_rebuild};

/* An OR of all five, with guards around it. */
static void all_policies(void) {
  struct {
    uint64_t before;
    struct kith_rebuilds rebuilds;
    uint64_t after;
  } r = {.before = 0x5a5a, .after = 0x5a5a};
  struct kith_nodes *nodes;
  const char *const names[] = {"gas"};
  enum kith_rebuild_reason reason;
  CHECK_OK(kith_nodes_create(&nodes, 1, names));
  CHECK(KITH_REBUILD_POLICIES == 5 && sizeof r.rebuilds.policy / sizeof r.rebuilds.policy[0] == 5);
  CHECK_OK(kith_rebuilds_create(&r.rebuilds, "never|entity-change|displacement|planted|always|never", NULL));
  CHECK(r.rebuilds.n == 5 && r.before == 0x5a5a && r.after == 0x5a5a);
  CHECK_OK(kith_rebuilds_snapshot(&r.rebuilds, nodes));
  CHECK_OK(kith_rebuilds_check(&r.rebuilds, nodes, &reason));
  CHECK(reason == KITH_BECAUSE_planted && strcmp(kith_rebuild_reason_name(reason), "planted") == 0);
  kith_rebuilds_clear(&r.rebuilds);
  kith_nodes_destroy(&nodes);
}

/* The last reason is counted where it belongs, and reported by name. */
static void counted(void) {
  struct kith_ledger ledger = {.lifecycles = 1};
  struct kith_ledger_entry entry;
  bool reported = false;
  ledger.because[KITH_BECAUSE_planted] += 1;
  CHECK(KITH_BECAUSE_planted == sizeof ledger.because / sizeof ledger.because[0] - 1);
  CHECK(kith_ledger_closes(&ledger) && ledger.boundary[0].created == 0);
  for (int k = 0; kith_ledger_entry(&ledger, k, &entry); ++k)
    reported = reported || (strcmp(entry.name, "rebuilds_because_planted") == 0 && entry.value == 1);
  CHECK(reported);
  ledger.ghosts_created = 1; /* and it tells when it does not close */
  CHECK(!kith_ledger_closes(&ledger));
  ledger.ghosts_created = 0, ledger.boundary[KITH_MAX_BOUNDARIES - 1].culled = 1;
  CHECK(!kith_ledger_closes(&ledger));
}

int main(void) {
  all_policies();
  counted();
  return check_failed();
}
