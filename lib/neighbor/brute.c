/* brute.c - every node is a candidate, always: the reference that the other searches are tested against. */
#include "lib/neighbor/search.h"

enum { GROUP = 32 };

/* Slots are nodes; groups are blocks of nodes, internal ones first. */
static kith_status brute_update(struct kith_search *search) {
  for (kith_index i = 0; i < search->n; ++i) search->node[i] = i;
  kith_search_pack(search, 0, search->n);
  for (kith_index i = 0; i < search->n;) {
    const kith_index end = i < search->n_internal ? search->n_internal : search->n;
    const kith_index count = KITH_MIN(GROUP, end - i);
    KITH_TRY(kith_search_group(search, i, count));
    i += count;
  }
  return KITH_OK;
}

static kith_status brute_update_selected(struct kith_search *search, const kith_index *nodes,
                                         kith_index count) {
  for (kith_index k = 0; k < count; ++k) kith_search_pack_slot(search, nodes[k]);
  return KITH_OK;
}

static kith_status brute_coarse(const struct kith_search *search, const struct kith_box *box, double radius,
                                enum kith_search_mode mode, struct kith_runs *runs) {
  (void)box, (void)radius, (void)mode;
  return search->n > 0 ? kith_runs_add(runs, 0, search->n) : KITH_OK;
}

const struct kith_search_ops kith_search_brute = {
    .name = "brute",
    .doc = "every node is a candidate: O(n^2), the reference of the others",
    .update = brute_update,
    .update_selected = brute_update_selected,
    .coarse = brute_coarse,
};
