/* The family of rebuild policies, and the OR of several. */
#include "lib/connectivity/policies/rebuild.h"

#include <ctype.h>
#include <string.h>
#include "lib/core/family.h"

#define X(name) &kith_rebuild_##name,
KITH_FAMILY(kith_rebuild, KITH_REBUILD_LIST(X))
#undef X

const char *kith_rebuild_reason_name(enum kith_rebuild_reason reason) {
  static const char *const names[KITH_REBUILD_REASONS] = {"none",
#define X(name, ...) #name,
                                                          KITH_REBUILD_CAUSE_LIST(X) KITH_REBUILD_LIST(X)
#undef X
  };
  return names[reason];
}

/* The place of a policy in the list, -1 if there is none of this name. */
static int find(const char *word, size_t length) {
  for (int k = 0; k < KITH_REBUILD_POLICIES; ++k)
    if (kith_name_is(kith_rebuild_all()[k]->name, word, length)) return k;
  return -1;
}

/* The next word of `text`, without blanks; *text moves behind its '|', or becomes NULL at the end. */
static const char *next_word(const char **text, size_t *length) {
  const char *word = *text, *bar = strchr(word, '|'), *stop = bar != NULL ? bar : word + strlen(word);
  *text = bar != NULL ? bar + 1 : NULL;
  while (word < stop && isspace((unsigned char)*word)) ++word;
  while (stop > word && isspace((unsigned char)stop[-1])) --stop;
  *length = (size_t)(stop - word);
  return word;
}

static kith_status add_policy(struct kith_rebuilds *out, int which) {
  const struct kith_rebuild_ops *ops = kith_rebuild_all()[which];
  for (int k = 0; k < out->n; ++k)
    if (out->policy[k].ops == ops) return KITH_OK; /* named twice */
  struct kith_rebuild *policy = &out->policy[out->n];
  *policy = (struct kith_rebuild){ops, KITH_REBUILD_REASONS - KITH_REBUILD_POLICIES + which, NULL};
  if (ops->create != NULL) KITH_TRY(ops->create(policy));
  ++out->n;
  return KITH_OK;
}

kith_status kith_rebuilds_create(struct kith_rebuilds *out, const char *words, const double *period) {
  *out = (struct kith_rebuilds){0};
  for (int a = 0; a < NDIM; ++a) out->cover.period[a] = period != NULL ? period[a] : 0;
  while (words != NULL) {
    size_t length;
    const char *word = next_word(&words, &length);
    const int which = find(word, length);
#define X(name) " " #name
    const kith_status status =
        which >= 0 ? add_policy(out, which)
                   : kith_fail(KITH_BAD_INPUT, "'%.*s' is no rebuild policy; there are:" KITH_REBUILD_LIST(X),
                               (int)length, word);
#undef X
    if (status != KITH_OK) {
      kith_rebuilds_clear(out);
      return status;
    }
  }
  out->keeps_cover = kith_rebuilds_lasting(out);
  return KITH_OK;
}

void kith_rebuilds_clear(struct kith_rebuilds *rebuilds) {
  for (int k = 0; k < rebuilds->n; ++k)
    if (rebuilds->policy[k].ops->destroy != NULL) rebuilds->policy[k].ops->destroy(&rebuilds->policy[k]);
  kith_cover_clear(&rebuilds->cover);
  *rebuilds = (struct kith_rebuilds){0};
}

kith_status kith_rebuilds_check(const struct kith_rebuilds *rebuilds, const struct kith_nodes *nodes,
                                enum kith_rebuild_reason *reason) {
  *reason = rebuilds->snapshot_taken ? KITH_BECAUSE_none : KITH_BECAUSE_first_build;
  for (int k = 0; k < rebuilds->n && *reason == KITH_BECAUSE_none; ++k) {
    const struct kith_rebuild *policy = &rebuilds->policy[k];
    if (kith_ranks_any(nodes->ranks, policy->ops->needs_rebuild(policy, &rebuilds->cover, nodes)))
      *reason = policy->reason;
  }
  if (*reason != KITH_BECAUSE_none || kith_rebuilds_cover(rebuilds)) return KITH_OK;
  if (!kith_rebuilds_covered(rebuilds, nodes))
    KITH_FAIL(STALE,
              "nodes moved, or supports grew, so far that the neighbor lists may miss pairs, and policy "
              "%s does not rebuild them: choose displacement or always, or a larger skin",
              rebuilds->policy[0].ops->name);
  return KITH_OK;
}

bool kith_rebuilds_covered(const struct kith_rebuilds *rebuilds, const struct kith_nodes *nodes) {
  return !kith_ranks_any(nodes->ranks, !kith_cover_holds(&rebuilds->cover, nodes));
}

kith_status kith_rebuilds_snapshot(struct kith_rebuilds *rebuilds, const struct kith_nodes *nodes) {
  rebuilds->snapshot_taken = false;
  if (rebuilds->keeps_cover) KITH_TRY(kith_cover_snapshot(&rebuilds->cover, nodes));
  for (int k = 0; k < rebuilds->n; ++k)
    if (rebuilds->policy[k].ops->snapshot != NULL)
      KITH_TRY(rebuilds->policy[k].ops->snapshot(&rebuilds->policy[k], nodes));
  rebuilds->snapshot_taken = true;
  return KITH_OK;
}

void kith_rebuilds_invalidate(struct kith_rebuilds *rebuilds) {
  rebuilds->snapshot_taken = false;
}

bool kith_rebuilds_lasting(const struct kith_rebuilds *rebuilds) {
  for (int k = 0; k < rebuilds->n; ++k)
    if (rebuilds->policy[k].ops->every_step) return false;
  return true;
}

bool kith_rebuilds_cover(const struct kith_rebuilds *rebuilds) {
  for (int k = 0; k < rebuilds->n; ++k)
    if (rebuilds->policy[k].ops->covers) return true;
  return false;
}
