/* conformance_excluder.c - every excluder, alone and in chains. Oracle: tests/unit/oracle.h, which applies
 * the chain to all pairs of nodes; what it rejects must be in no row, pair, overlap row or intersection, and
 * must connect no overlap, with each search. Also the words that a scene may give, and those that are
 * refused. Excluders of lists whose targets are not their sources are tested by test_list.c. */
#include "tests/unit/oracle.h"

static struct kith_field *body, *chain_tag;

/* Two lists with ghosts; their tags are -1 .. 3 in `body` and 0 .. 3 in `chain`. */
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

/* Returns the number of pairs that a chain, given in words, leaves. */
static size_t pairs_left_by(const struct kith_nodes *nodes, const char *words) {
  struct kith_excluders chain;
  CHECK_OK(kith_excluders_create(&chain, words));
  const size_t pairs = oracle_conforms(nodes, chain.n > 0 ? chain.excluder : NULL);
  kith_excluders_clear(&chain);
  return pairs;
}

/* Each member rejects i, j and j, i alike, or one of both if it halves; what it rejects is in no list. */
static void check_members(void) {
  static const char *const settings[][2] = {{"connected", ":field=body"}, {"materials", ":of=gas and=dust"}};
  const struct kith_bonds bonds = {2, (const int64_t[][2]){{3, 4}, {7, 5}}};
  struct kith_nodes *nodes = tagged_nodes();
  const struct kith_selection set = {.nodes = nodes};
  for (const struct kith_excluder_ops *const *ops = kith_excluder_all(); *ops != NULL; ++ops) {
    struct kith_excluders chain;
    char words[100];
    snprintf(words, sizeof words, "%s", (*ops)->name);
    for (size_t k = 0; k < sizeof settings / sizeof *settings; ++k)
      if (strcmp(words, settings[k][0]) == 0) strcat(words, settings[k][1]);
    CHECK_OK(kith_excluders_create(&chain, words));
    chain.excluder[0].context = &bonds; /* others do not look at it */
    CHECK_OK(kith_excluder_setup(chain.excluder, &set, &set));
    for (kith_index i = 0; i < nodes->n_internal; ++i)
      for (kith_index j = 0; j < i; ++j) {
        const struct kith_candidate there = {&set, &set, i, j, 0}, back = {&set, &set, j, i, 0};
        const bool one = (*ops)->reject(chain.excluder, &there),
                   other = (*ops)->reject(chain.excluder, &back);
        CHECK((*ops)->halves ? one != other : one == other);
      }
    if (!(*ops)->self && !(*ops)->halves) oracle_conforms(nodes, chain.excluder);
    kith_excluders_clear(&chain);
  }
  kith_nodes_destroy(&nodes);
}

/* Excluders that a scene may name, on pairs whose tags are known. */
static void check_scene_words(void) {
  struct kith_nodes *nodes = tagged_nodes();
  const size_t all = pairs_left_by(nodes, ""), one = pairs_left_by(nodes, "connected:field=body"),
               both = pairs_left_by(nodes, "connected:field=chain | connected:field=body");
  CHECK(both < one && one < all);
  CHECK(pairs_left_by(nodes, "materials:of=gas and=dust | connected:field=body") < one);
  struct kith_excluders chain;
  const struct kith_selection set = {.nodes = nodes};
#define REJECTS(i, j) \
  kith_excluder_rejects(chain.excluder, KITH_NARROW, &(struct kith_candidate){&set, &set, i, j, 0})
  CHECK_OK(kith_excluders_create(&chain, "connected:field=chain"));
  CHECK_OK(kith_excluder_setup(chain.excluder, &set, &set));
  CHECK(REJECTS(1, 5) && !REJECTS(1, 6)); /* nodes 1, 5, ... have tag 1 */
  CHECK(!REJECTS(0, 4));                  /* tag 0 connects nothing */
  chain_tag->u8[6] = 1;                   /* the tag is read at each call */
  CHECK(REJECTS(1, 6));
  kith_excluders_clear(&chain);
  CHECK_OK(kith_excluders_create(&chain, "materials:of=dust"));
  CHECK_OK(kith_excluder_setup(chain.excluder, &set, &set));
#define BROAD(i, j) \
  kith_excluder_rejects(chain.excluder, KITH_BROAD, &(struct kith_candidate){&set, &set, i, j, 0})
  CHECK(BROAD(30, 31) && !BROAD(0, 1) && !BROAD(0, 31));
  kith_excluders_clear(&chain);
  kith_nodes_destroy(&nodes);
}

/* Targets and sources may be of nodes whose lists have other numbers, or that lack a material. */
static void check_materials_of_two(void) {
  static const char *const of_targets[] = {"gas", "dust"}, *const of_sources[] = {"dust", "ice", "gas"};
  struct kith_nodes *t, *s;
  struct kith_excluders chain;
  CHECK_OK(kith_nodes_create(&t, 2, of_targets));
  CHECK_OK(kith_nodes_create(&s, 3, of_sources));
  for (int l = 0; l < 2; ++l) CHECK_OK(kith_nodes_append(t, l, 1, NULL));
  for (int l = 0; l < 3; ++l) CHECK_OK(kith_nodes_append(s, l, 1, NULL));
  const struct kith_selection targets = {.nodes = t}, sources = {.nodes = s};
#define APART(i, j) \
  kith_excluder_rejects(chain.excluder, KITH_BROAD, &(struct kith_candidate){&targets, &sources, i, j, 0})
  CHECK_OK(kith_excluders_create(&chain, "materials:of=gas and=dust"));
  CHECK_OK(kith_excluder_setup(chain.excluder, &targets, &sources));
  CHECK(APART(0, 0) && APART(1, 2) && !APART(0, 2) && !APART(1, 0) && !APART(0, 1) && !APART(1, 1));
  kith_excluders_clear(&chain);
  CHECK_OK(kith_excluders_create(&chain, "materials:of=ice and=gas"));
  CHECK_OK(kith_excluder_setup(chain.excluder, &targets, &sources));
  CHECK(APART(0, 1) && !APART(1, 2) && !APART(0, 0) && !APART(0, 2));
  kith_excluders_clear(&chain);
  CHECK_OK(kith_excluders_create(&chain, "materials:of=iron"));
  CHECK_STATUS(KITH_BAD_INPUT, kith_excluder_setup(chain.excluder, &targets, &sources));
  kith_excluders_clear(&chain);
  kith_nodes_destroy(&t);
  kith_nodes_destroy(&s);
}

static void check_bonds(void) {
  struct kith_nodes *nodes = tagged_nodes();
  int64_t id[60][2];
  for (int k = 0; k < 60; ++k) id[k][0] = k * 7 % 30, id[k][1] = k * 11 % 29;
  const struct kith_bonds bonds = {60, (const int64_t(*)[2])id};
  struct kith_excluder excluder = {.ops = &kith_excluder_bonds, .context = &bonds};
  const size_t one = oracle_conforms(nodes, &excluder);
  CHECK(one < oracle_conforms(nodes, NULL));
  id[3][0] = 0, id[3][1] = 1; /* the next set-up reads the new bond */
  CHECK(oracle_conforms(nodes, &excluder) <= one + 2);
  const struct kith_selection set = {.nodes = nodes};
  CHECK(kith_excluder_rejects(&excluder, KITH_NARROW, &(struct kith_candidate){&set, &set, 1, 0, 0}));
  kith_excluder_bonds.clear(&excluder);
  kith_nodes_destroy(&nodes);
}

static bool far_apart(const struct kith_excluder *excluder, const struct kith_candidate *c) {
  const struct kith_nodes *nodes = c->sources->nodes;
  double x[NDIM];
  for (int a = 0; a < NDIM; ++a) {
    x[a] = nodes->position->f64[(size_t)c->j * NDIM + (size_t)a];
    if (nodes->shifts.n > 1) x[a] += nodes->shifts.by[c->shift][a];
  }
  return sqrt(kith_distance2(c->targets->nodes->position->f64 + (size_t)c->i * NDIM, x)) >
         *(const double *)excluder->context;
}

static bool odd_sum(const struct kith_excluder *excluder, const struct kith_candidate *c) {
  const int64_t *id = c->sources->nodes->id->i64;
  return (id[c->i] + id[c->j] + (excluder->self != NULL)) % 2 != 0;
}

static kith_status wrong_setup(struct kith_excluder *excluder, const struct kith_selection *targets,
                               const struct kith_selection *sources) {
  (void)excluder, (void)targets, (void)sources;
  KITH_FAIL(BAD_INPUT, "a set-up that fails");
}

/* A predicate leaves the same pairs in the broad and in the narrow phase, and chains may hold excluders of
 * both phases. */
static void check_custom(void) {
  static const struct kith_excluder_ops broad_ops = {.name = "odd", .phase = KITH_BROAD, .reject = odd_sum},
                                        narrow_ops = {.name = "odd", .phase = KITH_NARROW, .reject = odd_sum},
                                        far_ops = {.name = "far", .phase = KITH_NARROW, .reject = far_apart},
                                        wrong_ops = {.name = "wrong", .setup = wrong_setup};
  struct kith_nodes *nodes = tagged_nodes();
  const double width = 0.12;
  struct kith_excluder predicate = {.ops = &broad_ops};
  const size_t broad = oracle_conforms(nodes, &predicate);
  predicate.ops = &narrow_ops;
  CHECK(oracle_conforms(nodes, &predicate) == broad);
  struct kith_excluder far = {.ops = &far_ops, .context = &width};
  predicate.next = &far;
  CHECK(oracle_conforms(nodes, &predicate) < broad);
  struct kith_excluder wrong = {.ops = &wrong_ops};
  const struct kith_selection set = {.nodes = nodes};
  CHECK_STATUS(KITH_BAD_INPUT, kith_excluder_setup(&wrong, &set, &set));
  kith_nodes_destroy(&nodes);
}

/* Excluders that connectivity cannot have, and unknown words. */
static void check_refused(void) {
  static const struct {
    const char *words, *why;
  } wrong[] = {{"self", "excluder self is in the chain twice"},
               {"symmetric_duplicates", "packages need each interaction in both rows"},
               {"connected:field=body | connected:field=body", "excluder connected is in the chain twice"},
               {"connected:field=nothing", "nodes have no field 'nothing'"},
               {"connected:field=position", "tags are integers"},
               {"materials:of=iron", "there is no material 'iron'"},
               {"bonds", "a program gives them"}};
  struct kith_nodes *nodes = tagged_nodes();
  struct kith_search *search;
  struct kith_connectivity *c;
  struct kith_excluders chain;
  CHECK_OK(kith_search_create(&search, kith_search_find("tree"), nodes));
  CHECK_OK(kith_search_update(search));
  CHECK_OK(kith_connectivity_create(&c));
  for (size_t k = 0; k < sizeof wrong / sizeof *wrong; ++k) {
    CHECK_OK(kith_excluders_create(&chain, wrong[k].words));
    CHECK_STATUS(KITH_BAD_INPUT,
                 kith_connectivity_build(c, nodes, search, (struct kith_requirements){.rows = true},
                                         chain.excluder, NULL));
    CHECK(check_says(wrong[k].why));
    kith_excluders_clear(&chain);
  }
  CHECK_STATUS(KITH_BAD_INPUT, kith_excluders_create(&chain, "selves"));
  CHECK_STATUS(KITH_BAD_INPUT, kith_excluders_create(&chain, "connected:tag=body"));
  kith_connectivity_destroy(&c);
  kith_search_destroy(&search);
  kith_nodes_destroy(&nodes);
}

int main(void) {
  check_members();
  check_scene_words();
  check_materials_of_two();
  check_bonds();
  check_custom();
  check_refused();
  return check_failed();
}
