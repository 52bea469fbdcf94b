/* The family of excluders, and chains of them. */
#include "lib/connectivity/excluders/excluder.h"

#include <string.h>
#include "lib/core/choices.h"
#include "lib/core/family.h"

#define X(name) &kith_excluder_##name,
KITH_FAMILY(kith_excluder, KITH_EXCLUDER_LIST(X))
#undef X

/* --- chains --- */

kith_status kith_excluder_setup(struct kith_excluder *chain, const struct kith_selection *targets,
                                const struct kith_selection *sources) {
  for (struct kith_excluder *e = chain; e != NULL; e = e->next) {
    for (const struct kith_excluder *k = chain; k != e; k = k->next)
      if (k->ops == e->ops && k->context == e->context &&
          (e->settings == NULL || memcmp(k->settings, e->settings, e->ops->settings_size) == 0))
        KITH_FAIL(BAD_INPUT, "excluder %s is in the chain twice", e->ops->name);
    if ((e->ops->self || e->ops->halves) && targets->nodes != sources->nodes)
      KITH_FAIL(BAD_INPUT, "excluder %s: no target is a source, they are of different nodes", e->ops->name);
    if (e->ops->setup != NULL) KITH_TRY(e->ops->setup(e, targets, sources));
  }
  return KITH_OK;
}

kith_status kith_excluder_keeps_pairs(const struct kith_excluder *chain) {
  char name[64];
  for (; chain != NULL; chain = chain->next) {
    if (!chain->ops->halves) continue;
    kith_choices_format(chain->ops->name, name, sizeof name);
    KITH_FAIL(BAD_INPUT,
              "excluder %s: packages need each interaction in both rows; it is for lists of the library",
              name);
  }
  return KITH_OK;
}

static kith_status add(struct kith_excluders *out, const char *text, size_t length) {
  const int most = (int)(sizeof out->excluder / sizeof out->excluder[0]);
  struct kith_excluder *e = &out->excluder[out->n];
  int member;
  if (out->n == most) KITH_FAIL(BAD_INPUT, "more than %d excluders", most);
  KITH_TRY(kith_family_choose(kith_excluder_member, "excluder", text, length, &member, &e->settings));
  e->ops = kith_excluder_all()[member];
  if (out->n++ > 0) e[-1].next = e;
  return KITH_OK;
}

kith_status kith_excluders_create(struct kith_excluders *out, const char *words) {
  kith_status status = KITH_OK;
  const char *word;
  size_t length;
  *out = (struct kith_excluders){0};
  if (words[0] == '\0') return KITH_OK;
  while (status == KITH_OK && kith_next_word(&words, &word, &length)) status = add(out, word, length);
  if (status != KITH_OK) kith_excluders_clear(out);
  return status;
}

void kith_excluders_clear(struct kith_excluders *excluders) {
  for (struct kith_excluder *e = excluders->excluder; e < excluders->excluder + excluders->n; ++e) {
    if (e->self != NULL && e->ops->clear != NULL) e->ops->clear(e);
    kith_free(&e->settings);
  }
  *excluders = (struct kith_excluders){0};
}

/* --- members without settings --- */

static bool same_node(const struct kith_excluder *excluder, const struct kith_candidate *c) {
  (void)excluder;
  return c->i == c->j && c->shift == c->sources->nodes->shifts.zero;
}

const struct kith_excluder_ops kith_excluder_self = {
    .name = "self",
    .doc = "the node itself, but not its images; always active in the rows of packages",
    .phase = KITH_BROAD,
    .self = true,
    .reject = same_node};

/* Sets the displacement of j from the node that it is a periodic image of; 0 if it is no image. False if it
 * is a mirror image, or a ghost of another rank. */
static bool displacement_of(const struct kith_candidate *candidate, double shift[NDIM]) {
  const struct kith_nodes *nodes = candidate->sources->nodes;
  kith_index j = candidate->j;
  for (int a = 0; a < NDIM; ++a) shift[a] = nodes->shifts.n > 1 ? nodes->shifts.by[candidate->shift][a] : 0;
  while (j >= nodes->n_internal) { /* an image may be one of an image */
    const struct kith_ghost_block *block = kith_nodes_ghost_block(nodes, j);
    if (block->kind != KITH_GHOST_IMAGE) return block->kind == KITH_GHOST_FROZEN;
    for (int a = 0; a < NDIM; ++a) {
      if (block->image.sign[a] < 0) return false;
      shift[a] += block->image.shift[a];
    }
    j = block->control[j - block->first];
  }
  return true;
}

/* Images of j at opposite shifts make one interaction where j is an image of i itself: the one whose first
 * shift that is not 0 is negative goes. */
static bool second_of_two(const struct kith_excluder *excluder, const struct kith_candidate *c) {
  const int64_t *id = c->targets->nodes->id->i64;
  double shift[NDIM];
  (void)excluder;
  if (!kith_selects(c->targets, c->j) || !kith_selects(c->sources, c->i)) return false;
  if (id[c->i] != id[c->j] || !displacement_of(c, shift)) return id[c->j] < id[c->i];
  int a = 0;
  while (a < NDIM - 1 && shift[a] == 0) ++a;
  return shift[a] < 0;
}

const struct kith_excluder_ops kith_excluder_symmetric_duplicates = {
    .name = "symmetric_duplicates",
    .doc =
        "where two nodes are in each other's list, the entry whose source has the lower id; for lists of "
        "programs",
    .phase = KITH_BROAD,
    .halves = true,
    .reject = second_of_two};
