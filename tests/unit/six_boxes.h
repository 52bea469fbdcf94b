/* six_boxes.h - six cubes on the diagonal, for tests of lists on one and on several ranks, and the number of
 * overlapping pairs that each of four selections and four chains of excluders must leave. */
#ifndef KITH_TEST_SIX_BOXES_H
#define KITH_TEST_SIX_BOXES_H

#include "lib/connectivity/list.h"
#include "tests/unit/oracle.h"

/* Cubes are given by center (x = y = z) and half edge. They are dealt out to the ranks in turn: those of this
 * rank are nodes, all others frozen ghosts. */
static inline struct kith_nodes *six_boxes(int rank, int ranks) {
  static const char *const names[] = {"boxes"};
  static const double center[6] = {0, 100, 2.5, 200, 1, 2}, half_edge[6] = {2, 0.5, 1, 0.5, 1.5, 1.5};
  struct kith_nodes *nodes;
  kith_index first, k = 0;
  int mine = 0;
  for (int id = 0; id < 6; ++id) mine += id % ranks == rank;
  CHECK_OK(kith_nodes_create(&nodes, 1, names));
  CHECK_OK(kith_nodes_append(nodes, 0, mine, &first));
  const struct kith_ghost_block block = {.kind = KITH_GHOST_FROZEN, .count = 6 - mine};
  CHECK_OK(kith_nodes_add_ghosts(nodes, &block));
  for (int ghosts = 0; ghosts < 2; ++ghosts)
    for (int id = 0; id < 6; ++id) {
      if ((id % ranks != rank) != ghosts) continue;
      for (int a = 0; a < NDIM; ++a) nodes->position->f64[k * NDIM + a] = center[id];
      nodes->search_radius->f64[k] = half_edge[id];
      nodes->list->u8[k] = 0;
      nodes->id->i64[k++] = id;
    }
  ++nodes->positions;
  return nodes;
}

static inline bool six_boxes_chosen(const void *context, const struct kith_nodes *nodes, kith_index i) {
  return *(const int *)context >> nodes->id->i64[i] & 1;
}

/* Rows: targets and sources are all; disjoint; overlapping; the same two cubes. Columns, the chains: none;
 * self; symmetric_duplicates; both. */
static const size_t six_boxes_pairs[4][4] = {{18, 12, 12, 6}, {1, 1, 1, 1}, {9, 7, 8, 6}, {4, 2, 3, 1}};

static inline struct kith_list_spec six_boxes_spec(const struct kith_nodes *nodes, struct kith_search *search,
                                                   int relation, int chain,
                                                   struct kith_excluder excluder[2]) {
  static const int targets[4] = {0x3f, 0x03, 0x33, 0x30}, sources[4] = {0x3f, 0x0c, 0x3c, 0x30};
  excluder[0] = (struct kith_excluder){.ops = &kith_excluder_self};
  excluder[1] = (struct kith_excluder){.ops = &kith_excluder_symmetric_duplicates};
  if (chain == 3) excluder[0].next = &excluder[1];
  return (struct kith_list_spec){
      .targets = {nodes, search, .chosen = six_boxes_chosen, .context = &targets[relation]},
      .sources = {nodes, search, .chosen = six_boxes_chosen, .context = &sources[relation]},
      .cutoff = KITH_CUTOFF_boxes,
      .radius = "search_radius",
      .excluders = chain == 0   ? NULL
                   : chain == 2 ? &excluder[1]
                                : &excluder[0],
      .storage = "csr",
      .rebuild = "always"};
}

#endif
