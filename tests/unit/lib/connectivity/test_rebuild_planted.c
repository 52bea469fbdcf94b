/* test_rebuild_planted.c - adds a fifth rebuild policy, `planted`, to the list: arrays that are sized by the
 * list must grow with it, and its settings and counter must work without other changes. The family and the
 * ledger are compiled here again, with the longer list. */
#define KITH_REBUILD_LIST(X) X(always) X(never) X(entity_change) X(displacement) X(planted)
#include "integrator/ledger.c"
#include "lib/connectivity/policies/rebuild.c"
#include "tests/check.h"

struct settings {
  double limit;
  int quiet;
};
static const struct kith_param params[] = {
    {"limit", KITH_PARAM_NUMBER, "2", "(0, 10]", "fires above", KITH_INTO(struct settings, limit)},
    {"quiet", KITH_PARAM_INTEGER, "0", "[0, 1]", "never fires", KITH_INTO(struct settings, quiet)},
    {0}};

/* Requires a rebuild when the first node has passed the limit, unless `quiet` is set. */
static bool needs_rebuild(const struct kith_rebuild *policy, const struct kith_nodes *nodes) {
  const struct settings *settings = policy->settings;
  return settings->quiet == 0 && nodes->position->f64[0] > settings->limit;
}

const struct kith_rebuild_ops kith_rebuild_planted = {.name = "planted",
                                                      .doc = "a test's",
                                                      KITH_SETTINGS(params, settings),
                                                      .covers = true,
                                                      .needs_rebuild = needs_rebuild};

/* Settings follow the name of a policy; errors in them are named. */
static void with_settings(const struct kith_nodes *nodes) {
  static const struct {
    const char *words;
    double limit;
    enum kith_rebuild_reason reason; /* where the node is at 3 */
  } good[] = {{"planted", 2, KITH_BECAUSE_planted},
              {"planted:", 2, KITH_BECAUSE_planted},
              {"never | planted: limit=2.5 | never", 2.5, KITH_BECAUSE_planted},
              {" planted : limit=4", 4, KITH_BECAUSE_none},
              {"planted:quiet=1 limit=1|displacement", 1, KITH_BECAUSE_none}};
  static const char *const bad[][2] = {{"planted:limit=11", "planted: limit: 11 is out of range (0, 10]"},
                                       {"never|planted:limit=x", "planted: limit: 'x' is"},
                                       {"planted:most=1", "planted has no parameter most"},
                                       {"planted:limit", "write it as key=value"},
                                       {"planted|planted:limit=1", "planted is there twice"},
                                       {"never:limit=1", "never has no parameter limit"}};
  for (size_t k = 0; k < sizeof good / sizeof good[0]; ++k) {
    struct kith_rebuilds r;
    enum kith_rebuild_reason reason;
    CHECK_OK(kith_rebuilds_create(&r, good[k].words, NULL));
    for (int p = 0; p < r.n; ++p)
      if (r.policy[p].ops == &kith_rebuild_planted)
        CHECK(((const struct settings *)r.policy[p].settings)->limit == good[k].limit);
      else
        CHECK(r.policy[p].settings == NULL);
    CHECK_OK(kith_rebuilds_snapshot(&r, nodes));
    CHECK_OK(kith_rebuilds_check(&r, nodes, KITH_OK, &reason));
    CHECK(reason == good[k].reason);
    kith_rebuilds_clear(&r);
  }
  for (size_t k = 0; k < sizeof bad / sizeof bad[0]; ++k) {
    struct kith_rebuilds r;
    CHECK_STATUS(KITH_BAD_INPUT, kith_rebuilds_create(&r, bad[k][0], NULL));
    CHECK(r.n == 0 && check_says(bad[k][1]));
  }
}

/* All five policies joined by OR, with guard words around the struct. */
static void all_policies(void) {
  struct {
    uint64_t before;
    struct kith_rebuilds rebuilds;
    uint64_t after;
  } r = {.before = 0x5a5a, .after = 0x5a5a};
  struct kith_nodes *nodes;
  const char *const names[] = {"gas"};
  enum kith_rebuild_reason reason;
  kith_index first;
  CHECK_OK(kith_nodes_create(&nodes, 1, names));
  CHECK_OK(kith_nodes_append(nodes, 0, 1, &first));
  nodes->position->f64[0] = 3;
  nodes->support->f64[0] = nodes->search_radius->f64[0] = 1;
  CHECK(KITH_REBUILD_POLICIES == 5 && sizeof r.rebuilds.policy / sizeof r.rebuilds.policy[0] == 5);
  CHECK_OK(kith_rebuilds_create(&r.rebuilds, "never|entity-change|planted: limit=1|displacement|always|never",
                                NULL));
  CHECK(r.rebuilds.n == 5 && r.before == 0x5a5a && r.after == 0x5a5a);
  CHECK_OK(kith_rebuilds_snapshot(&r.rebuilds, nodes));
  CHECK_OK(kith_rebuilds_check(&r.rebuilds, nodes, KITH_OK, &reason));
  CHECK(reason == KITH_BECAUSE_planted);
  kith_rebuilds_clear(&r.rebuilds);
  with_settings(nodes);
  kith_nodes_destroy(&nodes);
}

/* The last reason is counted in its own place, and the list from which the report is written has its name. */
static void reason_is_counted(void) {
  struct kith_ledger ledger = {.lifecycles = 1};
  ledger.because[KITH_BECAUSE_planted] += 1;
  CHECK(KITH_BECAUSE_planted == sizeof ledger.because / sizeof ledger.because[0] - 1);
  CHECK(kith_ledger_closes(&ledger) && ledger.boundary[0].created == 0);
#define X(name) reported += strcmp(#name, "planted") == 0 && ledger.because[KITH_BECAUSE_##name] == 1;
  int reported = 0;
  KITH_REBUILD_CAUSE_LIST(X)
  KITH_REBUILD_LIST(X)
#undef X
  CHECK(reported == 1);
  ledger.ghosts_created = 1; /* the ledger also reports that it does not balance */
  CHECK(!kith_ledger_closes(&ledger));
  ledger.ghosts_created = 0, ledger.boundary[KITH_MAX_BOUNDARIES - 1].culled = 1;
  CHECK(!kith_ledger_closes(&ledger));
}

int main(void) {
  all_policies();
  reason_is_counted();
  return check_failed();
}
