/* conformance_rebuild.c - rebuild policies just below and above their thresholds, which follow by hand from
 * H, the search radius and the motion of nodes. By brute force: as long as the displacement policy requires
 * no rebuild, no pair is missing from the lists. */
#include "lib/connectivity/policies/rebuild.h"

#include <omp.h>
#include <string.h>

#include "tests/unit/oracle.h"

static const double unit[3] = {1, 1, 1};

static bool reason_is(struct kith_rebuilds *rebuilds, const struct kith_nodes *nodes,
                      enum kith_rebuild_reason wanted) {
  enum kith_rebuild_reason reason = KITH_REBUILD_REASONS;
  CHECK_OK(kith_rebuilds_check(rebuilds, nodes, KITH_OK, &reason));
  return reason == wanted;
}

/* 40 nodes in two lists with support H = 0.1 and search radius R = 0.15, so the skin is 0.05. */
static struct kith_nodes *two_lists(void) {
  uint64_t state = 2;
  const int count[3] = {30, 10, 0};
  struct kith_nodes *nodes = oracle_random(2, count, 0, 1, &state);
  for (int i = 0; i < 40; ++i) nodes->support->f64[i] = 0.1, nodes->search_radius->f64[i] = 0.15;
  return nodes;
}

/* Policies with a snapshot of two_lists, which it returns. */
static struct kith_nodes *begin(struct kith_rebuilds *r, const char *words) {
  struct kith_nodes *nodes = two_lists();
  CHECK_OK(kith_rebuilds_create(r, words, unit));
  CHECK_OK(kith_rebuilds_snapshot(r, nodes));
  return nodes;
}

static void end(struct kith_rebuilds *r, struct kith_nodes **nodes) {
  kith_rebuilds_clear(r);
  kith_nodes_destroy(nodes);
}

static void parsing(void) {
  struct kith_rebuilds r;
  CHECK_OK(kith_rebuilds_create(&r, "displacement | entity_change|  never ", unit));
  CHECK(r.n == 3 && r.policy[0].ops == &kith_rebuild_displacement &&
        r.policy[1].ops == &kith_rebuild_entity_change);
  CHECK(r.policy[2].ops == &kith_rebuild_never && kith_rebuilds_lasting(&r) && !r.snapshot_taken);
  kith_rebuilds_clear(&r);
  CHECK_OK(kith_rebuilds_create(&r, "never|always|never|always|never|always", NULL));
  CHECK(r.n == 2 && !kith_rebuilds_lasting(&r) && r.cover.period[0] == 0);
  kith_rebuilds_clear(&r);
  const char *const bad[] = {"",
                             "sometimes",
                             "never|",
                             "|never",
                             "never||always",
                             "never always",
                             "displacement|always-",
                             "entity change",
                             "never:skin=1",
                             "always|displacement: skin=1"};
  for (int k = 0; k < (int)(sizeof bad / sizeof *bad); ++k) {
    CHECK_STATUS(KITH_BAD_INPUT, kith_rebuilds_create(&r, bad[k], unit));
    CHECK(r.n == 0);
  }
  CHECK(kith_rebuild_find("entity_change") == &kith_rebuild_entity_change &&
        kith_rebuild_find("entity-change") == &kith_rebuild_entity_change);
  CHECK(kith_rebuild_find("entity") == NULL && kith_rebuild_find("entity-changes") == NULL);
  for (const struct kith_rebuild_ops *const *ops = kith_rebuild_all(); *ops; ++ops)
    CHECK(kith_rebuild_find((*ops)->name) == *ops && (*ops)->doc != NULL);
}

static void always_and_never(void) {
  struct kith_nodes *nodes = two_lists();
  struct kith_rebuilds r;
  static const char *const words[] = {"never", "always", "displacement|always"};
  for (int always = 0; always < 3; ++always) {
    CHECK_OK(kith_rebuilds_create(&r, words[always], unit));
    CHECK(reason_is(&r, nodes, KITH_BECAUSE_first_build));
    CHECK_OK(kith_rebuilds_snapshot(&r, nodes));
    CHECK(reason_is(&r, nodes, always ? KITH_BECAUSE_always : KITH_BECAUSE_none));
    r.snapshot_taken = false;
    CHECK(reason_is(&r, nodes, KITH_BECAUSE_first_build));
    kith_rebuilds_clear(&r);
  }
  kith_nodes_destroy(&nodes);
}

/* Does a policy fire that can, with its own reason? If none covers the check may stop the run instead, and
 * must if none can fire. */
static bool fires_or_stops(struct kith_rebuilds *r, const struct kith_nodes *nodes) {
  enum kith_rebuild_reason reason;
  const kith_status status = kith_rebuilds_check(r, nodes, KITH_OK, &reason);
  bool covers = false, fired = false;
  for (int k = 0; k < r->n; ++k) {
    const struct kith_rebuild_ops *ops = r->policy[k].ops;
    covers = covers || ops->covers;
    fired = fired ||
            (reason == r->policy[k].reason && (ops->covers || ops->every_step || ops->needs_rebuild != NULL));
  }
  return status == KITH_OK ? fired : status == KITH_STALE && !covers;
}

/* When the lists may miss a pair a policy rebuilds them, or the check stops the run; policies that let lists
 * last do neither earlier. */
static void check_stale(const char *words) {
  struct kith_rebuilds r;
  struct kith_nodes *nodes = begin(&r, words);
  nodes->position->f64[0] += 0.024, nodes->position->f64[NDIM] -= 0.024;
  if (kith_rebuilds_lasting(&r)) CHECK(reason_is(&r, nodes, KITH_BECAUSE_none));
  nodes->position->f64[0] += 0.002, nodes->position->f64[NDIM] -= 0.002;
  CHECK(fires_or_stops(&r, nodes));
  nodes->position->f64[0] -= 0.026, nodes->position->f64[NDIM] += 0.026;
  nodes->support->f64[3] = 0.151; /* growth of a support, without motion */
  CHECK(fires_or_stops(&r, nodes));
  end(&r, &nodes);
}

static void entity_change(void) {
  struct kith_rebuilds r;
  struct kith_nodes *nodes = begin(&r, "entity-change");
  nodes->position->f64[0] += 10; /* motion does not matter to this policy */
  oracle_ghosts(nodes, 0, false, 0.2);
  CHECK(reason_is(&r, nodes, KITH_BECAUSE_none));
  kith_index order[40], first;
  for (int i = 0; i < 40; ++i) order[i] = i;
  CHECK_OK(kith_nodes_reorder(nodes, order));
  CHECK(reason_is(&r, nodes, KITH_BECAUSE_none));
  order[3] = 4, order[4] = 3; /* a swap, at constant number of nodes */
  CHECK_OK(kith_nodes_reorder(nodes, order));
  CHECK(reason_is(&r, nodes, KITH_BECAUSE_entity_change));
  CHECK_OK(kith_nodes_reorder(nodes, order));
  CHECK(reason_is(&r, nodes, KITH_BECAUSE_none));
  CHECK_OK(kith_nodes_append(nodes, 1, 1, &first));
  CHECK(reason_is(&r, nodes, KITH_BECAUSE_entity_change));
  CHECK_OK(kith_rebuilds_snapshot(&r, nodes));
  CHECK(reason_is(&r, nodes, KITH_BECAUSE_none));
  uint8_t dead[41] = {0};
  dead[7] = 1;
  CHECK_OK(kith_nodes_delete(nodes, dead));
  CHECK(reason_is(&r, nodes, KITH_BECAUSE_entity_change));
  CHECK_OK(kith_rebuilds_snapshot(&r, nodes));
  /* The ids stay the same, but one node moves to the other list. */
  --nodes->lists[0].count, --nodes->lists[1].first, ++nodes->lists[1].count;
  CHECK(reason_is(&r, nodes, KITH_BECAUSE_entity_change));
  ++nodes->lists[0].count, ++nodes->lists[1].first, --nodes->lists[1].count;
  CHECK(reason_is(&r, nodes, KITH_BECAUSE_none));
  memset(dead, 1, sizeof dead); /* deletes all nodes */
  CHECK_OK(kith_nodes_delete(nodes, dead));
  CHECK(reason_is(&r, nodes, KITH_BECAUSE_entity_change));
  CHECK_OK(kith_rebuilds_snapshot(&r, nodes));
  CHECK(reason_is(&r, nodes, KITH_BECAUSE_none));
  end(&r, &nodes);
}

/* Two nodes move in opposite directions, so that there is no common motion to subtract: each may go half the
 * skin, 0.025. The offset 1e-9 is far above the rounding of positions of order 1, and far below the skin. */
static void threshold(void) {
  struct kith_rebuilds r;
  struct kith_nodes *nodes = begin(&r, "displacement");
  CHECK(reason_is(&r, nodes, KITH_BECAUSE_none));
  double *x = nodes->position->f64, *support = nodes->support->f64;
  for (int a = 0; a < NDIM; ++a)
    for (int k = 0; k < 3; ++k) {
      const double d = 0.025 + (k == 0   ? -0.001
                                : k == 1 ? -1e-9
                                         : 1e-9),
                   before[2] = {x[5 * NDIM + a], x[9 * NDIM + a]};
      x[5 * NDIM + a] += d, x[9 * NDIM + a] -= d;
      CHECK(reason_is(&r, nodes, k < 2 ? KITH_BECAUSE_none : KITH_BECAUSE_displacement));
      x[5 * NDIM + a] += 1, x[9 * NDIM + a] -= 3; /* wrapped across faces, by up to three periods */
      CHECK(reason_is(&r, nodes, k < 2 ? KITH_BECAUSE_none : KITH_BECAUSE_displacement));
      x[5 * NDIM + a] = before[0], x[9 * NDIM + a] = before[1];
    }
  /* If nothing moves, a support may grow by the whole skin. */
  support[3] = nextafter(0.15, 0);
  CHECK(reason_is(&r, nodes, KITH_BECAUSE_none));
  support[3] = 0.15;
  CHECK(reason_is(&r, nodes, KITH_BECAUSE_none));
  support[3] = nextafter(0.15, 1);
  CHECK(reason_is(&r, nodes, KITH_BECAUSE_displacement));
  /* Growth and motion share the skin: H_i + |d_i| + max |d_j| <= R, whichever node moves. */
  support[3] = 0.13;
  const double grown[] = {0.01, 0.02};
  for (int k = 0; k < 4; ++k) {
    const int mover = k < 2 ? 3 : 5, other = 9;
    const double d = grown[k / 2] + (k % 2 ? 1e-9 : -1e-9), before[2] = {x[mover * NDIM], x[other * NDIM]};
    x[mover * NDIM] += d, x[other * NDIM] -= d;
    CHECK(reason_is(&r, nodes, k % 2 ? KITH_BECAUSE_displacement : KITH_BECAUSE_none));
    x[mover * NDIM] = before[0], x[other * NDIM] = before[1];
  }
  support[3] = NAN; /* NaN must cause a rebuild */
  CHECK(reason_is(&r, nodes, KITH_BECAUSE_displacement));
  end(&r, &nodes);
}

static void boost_all(const struct kith_nodes *nodes, double by) {
  for (int i = 0; i < nodes->n_internal; ++i)
    for (int a = 0; a < NDIM; ++a) {
      double *x = &nodes->position->f64[i * NDIM + a];
      *x += (a + 1) * by;
      *x -= floor(*x); /* wraps */
    }
}

/* In a periodic or open box a uniform motion of less than half a period is subtracted; it is not between
 * mirrors, nor beside ghosts that stay where they are. With `never`, lists stay valid under any of it. */
static void boost(void) {
  struct kith_rebuilds r;
  for (int ghosts = 0; ghosts < 4; ++ghosts) { /* periodic, mirrored, none, frozen */
    struct kith_nodes *nodes = begin(&r, "displacement");
    const struct kith_ghost_block frozen = {.kind = KITH_GHOST_FROZEN, .count = 1};
    if (ghosts < 2) oracle_ghosts(nodes, NDIM - 1, ghosts == 1, 0.2);
    if (ghosts == 3) CHECK_OK(kith_nodes_add_ghosts(nodes, &frozen));
    CHECK_OK(kith_rebuilds_snapshot(&r, nodes));
    boost_all(nodes, 0.3);
    CHECK(reason_is(&r, nodes, ghosts % 2 ? KITH_BECAUSE_displacement : KITH_BECAUSE_none));
    boost_all(nodes, 0.3); /* above half a period: nodes must be wrapped again */
    CHECK(reason_is(&r, nodes, KITH_BECAUSE_displacement));
    end(&r, &nodes);
  }
  struct kith_nodes *nodes = begin(&r, "never");
  for (int round = 0; round < 2; ++round) {
    boost_all(nodes, 0.3);
    CHECK(reason_is(&r, nodes, KITH_BECAUSE_none));
  }
  end(&r, &nodes);
}

/* Random walks with growing supports in a periodic box: as long as the policy requires no rebuild, every pair
 * within a support now was within R at the snapshot (brute force over nearest images). The policy must not
 * ask at each step either. */
static void never_misses(const char *words) {
  uint64_t state = 77;
  struct kith_rebuilds r;
  struct kith_nodes *nodes = begin(&r, words);
  int quiet = 0, rebuilt = 0;
  double old[40 * NDIM];
  for (int round = 0; round < 60; ++round) {
    CHECK_OK(kith_rebuilds_snapshot(&r, nodes));
    memcpy(old, nodes->position->f64, sizeof old);
    for (int step = 0; step < 20; ++step) {
      boost_all(nodes, 0.07);
      for (int i = 0; i < 40 * NDIM; ++i) nodes->position->f64[i] += 0.008 * (check_random(&state) - 0.5);
      for (int i = 0; i < 40; ++i) nodes->support->f64[i] = 0.1 + 0.02 * check_random(&state);
      if (!reason_is(&r, nodes, KITH_BECAUSE_none)) {
        ++rebuilt;
        break;
      }
      ++quiet;
      for (int i = 0; i < 40; ++i)
        for (int j = 0; j < i; ++j) {
          double now = 0, then = 0; /* nearest images suffice: R is below half a period */
          for (int a = 0; a < NDIM; ++a) {
            const double d = nodes->position->f64[i * NDIM + a] - nodes->position->f64[j * NDIM + a],
                         e = old[i * NDIM + a] - old[j * NDIM + a];
            now += pow(d - nearbyint(d), 2), then += pow(e - nearbyint(e), 2);
          }
          CHECK(!(sqrt(now) <= KITH_MAX(nodes->support->f64[i], nodes->support->f64[j])) ||
                sqrt(then) <= 0.15);
        }
    }
  }
  CHECK(quiet > 100 && rebuilt > 10);
  end(&r, &nodes);
}

/* Every member under its own name. */
static void members(void) {
  for (const struct kith_rebuild_ops *const *ops = kith_rebuild_all(); *ops != NULL; ++ops) {
    check_stale((*ops)->name);
    if ((*ops)->covers && !(*ops)->every_step) never_misses((*ops)->name);
  }
  check_stale("never|entity-change");
  check_stale("never|displacement");
}

/* After a rebuild all policies have a new snapshot, also those that were not evaluated. */
static void all_take_snapshots(void) {
  struct kith_nodes *nodes = two_lists();
  struct kith_rebuilds r;
  CHECK_OK(kith_rebuilds_create(&r, "entity-change|displacement", unit));
  CHECK(reason_is(&r, nodes, KITH_BECAUSE_first_build));
  CHECK_OK(kith_rebuilds_snapshot(&r, nodes));
  CHECK(reason_is(&r, nodes, KITH_BECAUSE_none));
  nodes->id->i64[0] = 12345;
  nodes->position->f64[0] += 0.2;
  CHECK(reason_is(&r, nodes, KITH_BECAUSE_entity_change));
  CHECK_OK(kith_rebuilds_snapshot(&r, nodes));
  CHECK(reason_is(&r, nodes, KITH_BECAUSE_none));
  nodes->position->f64[0] += 0.2;
  CHECK(reason_is(&r, nodes, KITH_BECAUSE_displacement));
  end(&r, &nodes);
}

/* The decision does not depend on the number of threads: 10000 nodes are three blocks of the sum, and the
 * support is within one rounding of the threshold. */
static void threads(void) {
  uint64_t state = 4;
  const int count[3] = {10000, 0, 0};
  struct kith_nodes *nodes = oracle_random(1, count, 0, 1, &state);
  struct kith_rebuilds r;
  CHECK_OK(kith_rebuilds_create(&r, "displacement", unit));
  for (int i = 0; i < 10000; ++i) nodes->support->f64[i] = 0.1, nodes->search_radius->f64[i] = 0.15;
  CHECK_OK(kith_rebuilds_snapshot(&r, nodes));
  for (int i = 0; i < 10000 * NDIM; ++i) nodes->position->f64[i] += 0.02 * check_random(&state);
  double low = 0.1, high = 0.15; /* bisection to the last bit, on one number of threads */
  while (nextafter(low, 1) < high) {
    const double middle = 0.5 * (low + high);
    nodes->support->f64[0] = middle;
    if (reason_is(&r, nodes, KITH_BECAUSE_none))
      low = middle;
    else
      high = middle;
  }
  for (int t = 1; t <= 3; ++t) {
    omp_set_num_threads(t);
    nodes->support->f64[0] = low;
    CHECK(reason_is(&r, nodes, KITH_BECAUSE_none));
    nodes->support->f64[0] = high;
    CHECK(reason_is(&r, nodes, KITH_BECAUSE_displacement));
  }
  end(&r, &nodes);
}

int main(void) {
  parsing();
  always_and_never();
  members();
  entity_change();
  threshold();
  boost();
  all_take_snapshots();
  threads();
  return check_failed();
}
