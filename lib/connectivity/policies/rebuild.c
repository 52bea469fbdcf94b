/* The family of rebuild policies, and the OR of several. */
#include "lib/connectivity/policies/rebuild.h"

#include <stdlib.h>
#include <string.h>
#include "lib/core/family.h"

#define X(name) &kith_rebuild_##name,
KITH_FAMILY(kith_rebuild, KITH_REBUILD_LIST(X))
#undef X

const char *kith_rebuild_reason_name(enum kith_rebuild_reason reason) {
#define X(name) #name,
  static const char *const names[] = {"none", KITH_REBUILD_CAUSE_LIST(X) KITH_REBUILD_LIST(X)};
#undef X
  return names[reason];
}

static kith_status add_policy(struct kith_rebuilds *out, char *word) {
  char *options = word, *name = kith_trimmed(strsep(&options, ":")); /* NULL without a colon */
  int k = 0;
  while (kith_rebuild_all()[k] != NULL && kith_rebuild_all()[k] != kith_rebuild_find(name)) ++k;
  const struct kith_rebuild_ops *ops = kith_rebuild_all()[k];
#define X(name) " " #name
  if (ops == NULL) KITH_FAIL(BAD_INPUT, "'%s' is no rebuild policy; there are:" KITH_REBUILD_LIST(X), name);
#undef X
  if (options != NULL && ops->params == NULL)
    KITH_FAIL(BAD_INPUT, "%s has no parameter %s", ops->name, kith_trimmed(options));
  for (int p = 0; p < out->n; ++p)
    if (out->policy[p].ops == ops && options != NULL)
      KITH_FAIL(BAD_INPUT, "rebuild policy %s is there twice", ops->name);
    else if (out->policy[p].ops == ops)
      return KITH_OK;
  struct kith_rebuild *policy = &out->policy[out->n++];
  *policy = (struct kith_rebuild){.ops = ops, .reason = KITH_REBUILD_REASONS - KITH_REBUILD_POLICIES + k};
  KITH_TRY(kith_settings_create(&policy->settings, kith_rebuild_member(k), options));
  return kith_params_check(ops->params, ops->name, policy->settings);
}

kith_status kith_rebuilds_create(struct kith_rebuilds *out, const char *words, const double *period) {
  char *copy = strdup(words), *rest = copy;
  *out = (struct kith_rebuilds){0};
  for (int a = 0; a < NDIM; ++a) out->cover.period[a] = period != NULL ? period[a] : 0;
  kith_status status =
      copy != NULL ? KITH_OK : kith_fail(KITH_NO_MEMORY, "no memory for the names of rebuild policies");
  while (rest != NULL && status == KITH_OK) status = add_policy(out, strsep(&rest, "|"));
  free(copy);
  if (status != KITH_OK)
    kith_rebuilds_clear(out);
  else
    out->keeps_cover = kith_rebuilds_lasting(out);
  return status;
}

void kith_rebuilds_clear(struct kith_rebuilds *rebuilds) {
  for (struct kith_rebuild *policy = rebuilds->policy; policy < rebuilds->policy + rebuilds->n; ++policy) {
    if (policy->self != NULL) policy->ops->destroy(policy);
    if (policy->settings != NULL) kith_params_clear(policy->ops->params, policy->settings);
    kith_free(&policy->settings);
  }
  kith_cover_clear(&rebuilds->cover);
  *rebuilds = (struct kith_rebuilds){0};
}

/* Does some policy fire before the lists could miss a pair? */
static bool covers(const struct kith_rebuilds *rebuilds) {
  for (int k = 0; k < rebuilds->n; ++k)
    if (rebuilds->policy[k].ops->covers) return true;
  return false;
}

kith_status kith_rebuilds_allow(const struct kith_rebuilds *rebuilds, const char *why) {
  if (covers(rebuilds)) return KITH_OK;
  KITH_FAIL(STALE,
            "%s, and policy %s does not rebuild the lists: choose displacement or always, or a larger skin",
            why, rebuilds->policy[0].ops->name);
}

kith_status kith_rebuilds_check(const struct kith_rebuilds *rebuilds, const struct kith_nodes *nodes,
                                enum kith_rebuild_reason *reason) {
  *reason = rebuilds->snapshot_taken ? KITH_BECAUSE_none : KITH_BECAUSE_first_build;
  for (int k = 0; k < rebuilds->n && *reason == KITH_BECAUSE_none; ++k) {
    const struct kith_rebuild *policy = &rebuilds->policy[k];
    const bool due =
        policy->ops->needs_rebuild != NULL && policy->ops->needs_rebuild(policy, &rebuilds->cover, nodes);
    if (kith_ranks_any(nodes->ranks, policy->ops->every_step || due)) *reason = policy->reason;
  }
  if (*reason != KITH_BECAUSE_none || covers(rebuilds) || kith_rebuilds_covered(rebuilds, nodes))
    return KITH_OK;
  return kith_rebuilds_allow(rebuilds, "nodes moved, or supports grew, so far that the lists may miss pairs");
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

bool kith_rebuilds_lasting(const struct kith_rebuilds *rebuilds) {
  for (int k = 0; k < rebuilds->n; ++k)
    if (rebuilds->policy[k].ops->every_step) return false;
  return true;
}
