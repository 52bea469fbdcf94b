/* test_patch.c - a patch after culling ghosts. Oracle: a build on the nodes that are left, which must be
 * bitwise identical; pairwise values must follow their pairs. */
#include "tests/unit/oracle.h"

enum { LIMIT = 4096 }; /* more nodes than any test here has */

/* A pairwise value that depends on the positions of both ends, so that it identifies its pair. */
static double factor(const struct kith_nodes *nodes, const kith_index *pair) {
  const double *x = nodes->position->f64;
  return x[pair[0] * NDIM] + 3 * x[pair[1] * NDIM] + 7 * x[pair[0] * NDIM + NDIM - 1] +
         11 * x[pair[1] * NDIM + NDIM - 1];
}

static void cull_patch_compare(struct kith_nodes *nodes, struct kith_connectivity *c, uint8_t *keep) {
  kith_index renumber[LIMIT];
  const kith_index old_count = kith_nodes_count(nodes);
  const struct kith_pairwise_spec two = {"two", 2, true, "lasts"},
                                  old = {"old", 3, true, "stale before the patch"};
  struct kith_pairwise *f_couple = NULL, *both = NULL, *stale = NULL;
  CHECK(old_count <= LIMIT);
  if (c->built.pairs) {
    CHECK_OK(kith_pairwise_prepare(&c->pairs, &old, &stale));
    --stale->generation;
    CHECK_OK(kith_pairwise_prepare(&c->pairs, &kith_f_couple, &f_couple));
    CHECK_OK(kith_pairwise_prepare(&c->pairs, &two, &both));
  }
  for (size_t p = 0; p < c->pairs.n; ++p) {
    f_couple->value[p] = factor(nodes, c->pairs.node[p]);
    both->value[2 * p] = 2 * f_couple->value[p], both->value[2 * p + 1] = -f_couple->value[p];
  }
  CHECK_OK(kith_nodes_cull_ghosts(nodes, keep, renumber));
  CHECK_OK(kith_connectivity_patch(c, nodes, renumber, old_count));
  CHECK_OK(kith_connectivity_fresh(c, nodes));
  CHECK_OK(kith_connectivity_valid(c, nodes));
  struct kith_connectivity *fresh = oracle_build(nodes, kith_search_find("brute"), c->built, NULL);
  CHECK(oracle_identical(c, fresh));
  for (size_t p = 0; p < c->pairs.n; ++p) {
    const double wanted = factor(nodes, c->pairs.node[p]);
    CHECK(f_couple->value[p] == wanted && both->value[2 * p] == 2 * wanted &&
          both->value[2 * p + 1] == -wanted);
  }
  if (c->built.pairs) {
    CHECK_OK(kith_pairwise_fresh(&c->pairs, f_couple));
    CHECK_OK(kith_pairwise_fresh(&c->pairs, both));
    CHECK_STATUS(KITH_STALE, kith_pairwise_fresh(&c->pairs, stale));
  }
  kith_connectivity_destroy(&fresh);
}

static struct kith_nodes *nodes_with_ghosts(int kinds, double depth, uint64_t seed) {
  const int count[3] = {16, 0, 9};
  struct kith_nodes *nodes = oracle_random(3, count, 0.1, 2.5, &seed);
  for (int a = 0; a < NDIM; ++a, kinds /= 3)
    if (kinds % 3 > 0) oracle_ghosts(nodes, a, kinds % 3 == 2, depth);
  return nodes;
}

/* Culls as the lifecycle does: ghosts that no row of an internal node holds. This is correct for all but
 * overlap with rows of ghosts. */
static void unneeded_ghosts(void) {
  int kinds = 1, culled = 0;
  for (int a = 0; a < NDIM; ++a) kinds *= 3;
  for (int k = 0; k < kinds; ++k)
    for (int variant = 0; variant < 6; ++variant) {
      struct kith_requirements need = {.rows = true, .pairs = variant > 0, .intersection = variant > 1};
      need.on_segment = variant == 3, need.ghost_rows = variant == 4, need.overlap_pairs = variant == 5;
      struct kith_nodes *nodes = nodes_with_ghosts(k, 0.5, (uint64_t)k);
      struct kith_connectivity *c = oracle_build(nodes, kith_search_find("tree"), need, NULL);
      uint8_t keep[LIMIT] = {0};
      kith_connectivity_mark_ghosts(c, nodes, keep);
      /* Marked ghosts are those that some internal node interacts with. */
      for (int g = nodes->n_internal; g < kith_nodes_count(nodes); ++g) {
        bool needed = false;
        for (int i = 0; i < nodes->n_internal; ++i) needed = needed || oracle_neighbors(nodes, NULL, i, g);
        CHECK(keep[g - nodes->n_internal] == needed);
        culled += !needed;
      }
      cull_patch_compare(nodes, c, keep);
      kith_connectivity_destroy(&c);
      kith_nodes_destroy(&nodes);
    }
  CHECK(culled > 0);
}

/* Where no overlap is stored, any ghosts may be culled, needed or not; twice in a row. */
static void any_ghosts(void) {
  uint64_t state = 21;
  for (int round = 0; round < 12; ++round) {
    struct kith_requirements need = {.rows = true, .pairs = round % 4 > 0, .intersection = round % 4 > 1};
    need.on_segment = round % 4 == 3, need.ghost_rows = round >= 6;
    struct kith_nodes *nodes = nodes_with_ghosts(1 + 3 * (round % 3), 0.4, state);
    struct kith_connectivity *c = oracle_build(nodes, kith_search_find("tree"), need, NULL);
    for (int again = 0; again < 2; ++again) {
      uint8_t keep[LIMIT];
      const double kept = round % 5 == 0 ? 0 : 0.6;
      for (int g = 0; g < nodes->n_ghost; ++g) keep[g] = check_random(&state) < kept;
      cull_patch_compare(nodes, c, keep);
    }
    kith_connectivity_destroy(&c);
    kith_nodes_destroy(&nodes);
  }
}

/* Overlap with rows of ghosts: two supports may share only the culled ghost, unless no kept node has it in
 * its row. Then only whole clusters may be culled; here the nodes near the box are kept, and a cluster far
 * away is culled. */
static void whole_clusters(void) {
  const struct kith_requirements need = {
      .pairs = true, .ghost_rows = true, .overlap_pairs = true, .intersection = true};
  for (int cut = 0; cut < 2; ++cut) {
    struct kith_nodes *nodes = nodes_with_ghosts(1, 0.4, 33);
    struct kith_ghost_block far = {.kind = KITH_GHOST_IMAGE, .count = nodes->lists[0].count};
    CHECK_OK(kith_resize(&far.control, 0, (size_t)far.count, sizeof *far.control));
    for (int a = 0; a < NDIM; ++a) far.image.sign[a] = 1, far.image.shift[a] = 100;
    for (kith_index k = 0; k < far.count; ++k) far.control[k] = k;
    const int near = nodes->n_ghost;
    CHECK_OK(kith_nodes_add_ghosts(nodes, &far));
    struct kith_connectivity *c = oracle_build(nodes, kith_search_find("tree"), need, NULL);
    uint8_t keep[LIMIT];
    for (int g = 0; g < nodes->n_ghost; ++g) keep[g] = cut ? g < near : 1;
    cull_patch_compare(nodes, c, keep);
    kith_connectivity_destroy(&c);
    kith_nodes_destroy(&nodes);
  }
}

static void refusals(void) {
  struct kith_nodes *nodes = nodes_with_ghosts(1, 0.4, 5);
  struct kith_connectivity *c =
      oracle_build(nodes, kith_search_find("tree"), (struct kith_requirements){.pairs = true}, NULL);
  kith_index renumber[LIMIT];
  const kith_index n = kith_nodes_count(nodes);
  for (kith_index i = 0; i < n; ++i) renumber[i] = i;
  CHECK_STATUS(KITH_STALE, kith_connectivity_patch(c, nodes, renumber, n - 1));
  renumber[0] = 1, renumber[1] = 0;
  CHECK_STATUS(KITH_INTERNAL, kith_connectivity_patch(c, nodes, renumber, n));
  renumber[0] = 0, renumber[1] = 1, renumber[n - 1] = -1;
  CHECK_STATUS(KITH_INTERNAL, kith_connectivity_patch(c, nodes, renumber, n));
  renumber[n - 1] = n - 1;
  CHECK_OK(kith_connectivity_patch(c, nodes, renumber, n));
  CHECK_OK(kith_connectivity_valid(c, nodes));
  kith_connectivity_destroy(&c);
  kith_nodes_destroy(&nodes);
}

int main(void) {
  unneeded_ghosts();
  any_ghosts();
  whole_clusters();
  refusals();
  return check_failed();
}
