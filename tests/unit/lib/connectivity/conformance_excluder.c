/* conformance_excluder.c - every excluder of the list, alone and in chains: what it rejects is in no row,
 * pair, overlap row or intersection, and no overlap goes through it; all searches agree. */
#include "tests/unit/oracle.h"

#include "lib/connectivity/excluder.h"

static struct kith_field *body, *chain_tag;

/* Two lists with ghosts; tags -1 .. 3 in `body`, 0 .. 3 in `chain`. */
static struct kith_nodes *tagged_nodes(void) {
  const struct kith_field_spec of_body = {"body", KITH_SCALAR, KITH_I64, KITH_STATE, NULL, "tag of a body"};
  const struct kith_field_spec of_chain = {"chain", KITH_SCALAR, KITH_U8, KITH_STATE, NULL, "tag of a chain"};
  const int count[2] = {30, 10};
  uint64_t state = 5;
  struct kith_nodes *nodes = oracle_random(2, count, 0.15, 2, &state);
  CHECK_OK(kith_nodes_field(nodes, &of_body, &body));
  CHECK_OK(kith_nodes_field(nodes, &of_chain, &chain_tag));
  for (int i = 0; i < 40; ++i) body->i64[i] = i % 5 - 1, chain_tag->u8[i] = (uint8_t)(i % 4);
  oracle_ghosts(nodes, 0, false, 0.3);
  return nodes;
}

static struct kith_connectivity *build(const struct kith_nodes *nodes, const struct kith_search_ops *ops,
                                       const struct kith_excluder *chain, int variant) {
  const struct kith_requirements need = {
      .overlap_pairs = true, .intersection = true, .ghost_rows = variant & 1, .on_segment = variant & 2};
  struct kith_search *search;
  struct kith_connectivity *c;
  CHECK_OK(kith_search_create(&search, ops, nodes));
  CHECK_OK(kith_search_update(search));
  CHECK_OK(kith_connectivity_create(&c));
  CHECK_OK(kith_connectivity_build(c, nodes, search, need, chain, NULL));
  CHECK_OK(kith_connectivity_valid(c, nodes));
  kith_search_destroy(&search);
  return c;
}

/* All that is built against the definitions, which ask the chain. Returns the number of pairs. */
static size_t conforms(const struct kith_nodes *nodes, const struct kith_excluder *chain) {
  size_t pairs = 0;
  for (int variant = 0; variant < 4; ++variant) {
    struct kith_connectivity *first = build(nodes, kith_search_find("brute"), chain, variant);
    oracle_check(first, nodes, chain);
    for (const struct kith_search_ops *const *ops = kith_search_all(); *ops != NULL; ++ops) {
      struct kith_connectivity *other = build(nodes, *ops, chain, variant);
      CHECK(oracle_same(first, other));
      kith_connectivity_destroy(&other);
    }
    if (variant == 0) pairs = first->pairs.n;
    kith_connectivity_destroy(&first);
  }
  return pairs;
}

static void check_none(void) {
  struct kith_nodes *nodes = tagged_nodes();
  CHECK(conforms(nodes, NULL) > 0);
  kith_nodes_destroy(&nodes);
}

/* A row holds images of its own node, but never the node, though its distance is 0. */
static void check_self(void) {
  struct kith_nodes *nodes = oracle_lattice(1, 1, 1);
  oracle_ghosts(nodes, 0, false, 1);
  struct kith_connectivity *c = build(nodes, kith_search_find("tree"), NULL, 1);
  for (kith_index i = 0; i < c->rows.n; ++i) CHECK(!kith_rows_hold(&c->rows, i, i));
  CHECK(c->rows.first[1] == 2);
  kith_connectivity_destroy(&c);
  kith_nodes_destroy(&nodes);
}

static void check_symmetric_duplicates(void) {
  struct kith_nodes *nodes = tagged_nodes();
  struct kith_connectivity *c = build(nodes, kith_search_find("grid"), NULL, 1);
  CHECK(2 * c->pairs.n == c->rows.first[c->rows.n]);
  for (size_t p = 1; p < c->pairs.n; ++p)
    CHECK(c->pairs.node[p][0] > c->pairs.node[p - 1][0] ||
          (c->pairs.node[p][0] == c->pairs.node[p - 1][0] && c->pairs.node[p][1] > c->pairs.node[p - 1][1]));
  kith_connectivity_destroy(&c);
  kith_nodes_destroy(&nodes);
}

static void check_connected(void) {
  struct kith_nodes *nodes = tagged_nodes();
  struct kith_excluder by_body, by_chain;
  CHECK_OK(kith_excluder_connected(&by_body, body, NULL));
  CHECK_OK(kith_excluder_connected(&by_chain, chain_tag, &by_body));
  const size_t all = conforms(nodes, NULL), one = conforms(nodes, &by_body),
               both = conforms(nodes, &by_chain);
  CHECK(both < one && one < all);
  /* By hand: chain 1 is nodes 1, 5, ...; tag 0 connects nothing. */
  CHECK(kith_excluder_rejects(&by_chain, KITH_NARROW, nodes, 1, 5));
  CHECK(!kith_excluder_rejects(&by_chain, KITH_NARROW, nodes, 0, 4));
  CHECK_STATUS(KITH_BAD_INPUT, kith_excluder_connected(&by_body, nodes->support, NULL));
  kith_nodes_destroy(&nodes);
}

static bool far_apart(const void *context, const struct kith_nodes *nodes, kith_index i, kith_index j) {
  return fabs(nodes->position->f64[i * NDIM] - nodes->position->f64[j * NDIM]) > *(const double *)context;
}

static bool odd_sum(const void *context, const struct kith_nodes *nodes, kith_index i, kith_index j) {
  (void)context;
  return (nodes->id->i64[i] + nodes->id->i64[j]) % 2 != 0;
}

/* The same predicate gives the same result in both phases; chains of both phases. */
static void check_custom(void) {
  struct kith_nodes *nodes = tagged_nodes();
  const double width = 0.12;
  struct kith_excluder same_body, predicate = {KITH_BROAD, odd_sum, NULL, NULL};
  const size_t broad = conforms(nodes, &predicate);
  predicate.phase = KITH_NARROW;
  CHECK(conforms(nodes, &predicate) == broad);
  CHECK_OK(kith_excluder_connected(&same_body, body, NULL));
  const struct kith_excluder narrow = {KITH_NARROW, far_apart, &width, &same_body};
  const struct kith_excluder first = {KITH_BROAD, odd_sum, NULL, &narrow};
  CHECK(conforms(nodes, &first) < broad);
  kith_nodes_destroy(&nodes);
}

int main(void) {
#define X(name, doc) check_##name();
  KITH_EXCLUDER_LIST(X)
#undef X
  return check_failed();
}
