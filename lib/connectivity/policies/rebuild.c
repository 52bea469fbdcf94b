/* The family of rebuild policies, those that are all said by their constant, and the OR of several. */
#include "lib/connectivity/policies/rebuild.h"

#include <string.h>
#include "lib/core/family.h"

#define X(name) &kith_rebuild_##name,
KITH_FAMILY(kith_rebuild, KITH_REBUILD_LIST(X))
#undef X

const struct kith_rebuild_ops kith_rebuild_always = {
    .name = "always", .doc = "every step", .covers = true, .every_step = true};
const struct kith_rebuild_ops kith_rebuild_never = {
    .name = "never", .doc = "only when there is nothing yet; the run stops when the lists could miss a pair"};
const struct kith_rebuild_ops kith_rebuild_displacement = {
    .name = "displacement",
    .doc = "nodes moved, or supports grew, so far that the lists could miss a pair",
    .covers = true};

const char *kith_rebuild_reason_name(enum kith_rebuild_reason reason) {
#define X(name) #name,
  static const char *const names[] = {"none", KITH_REBUILD_CAUSE_LIST(X) KITH_REBUILD_LIST(X)};
#undef X
  return names[reason];
}

static kith_status add_policy(struct kith_rebuilds *out, const char *text, size_t length) {
  void *settings;
  int k;
  KITH_TRY(kith_family_choose(kith_rebuild_member, "rebuild policy", text, length, &k, &settings));
  const struct kith_rebuild_ops *ops = kith_rebuild_all()[k];
  for (const struct kith_rebuild *p = out->policy; p < out->policy + out->n; ++p) {
    if (p->ops != ops) continue;
    const bool same = settings == NULL || memcmp(p->settings, settings, ops->settings_size) == 0;
    kith_free(&settings);
    if (same) return KITH_OK;
    KITH_FAIL(BAD_INPUT, "rebuild policy %s is there twice, with different settings", ops->name);
  }
  out->policy[out->n++] = (struct kith_rebuild){
      .ops = ops, .settings = settings, .reason = KITH_REBUILD_REASONS - KITH_REBUILD_POLICIES + k};
  return KITH_OK;
}

kith_status kith_rebuilds_create(struct kith_rebuilds *out, const char *words, const double *period) {
  kith_status status = KITH_OK;
  const char *word;
  size_t length;
  *out = (struct kith_rebuilds){0};
  for (int a = 0; a < NDIM; ++a) out->cover.period[a] = period != NULL ? period[a] : 0;
  while (status == KITH_OK && kith_next_word(&words, &word, &length)) status = add_policy(out, word, length);
  if (status != KITH_OK)
    kith_rebuilds_clear(out);
  else
    out->keeps_cover = kith_rebuilds_lasting(out);
  return status;
}

void kith_rebuilds_clear(struct kith_rebuilds *rebuilds) {
  for (struct kith_rebuild *policy = rebuilds->policy; policy < rebuilds->policy + rebuilds->n; ++policy) {
    if (policy->self != NULL) policy->ops->destroy(policy);
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

kith_status kith_rebuilds_allow(const struct kith_rebuilds *rebuilds, const struct kith_nodes *nodes,
                                int64_t id, const char *why) {
  if (covers(rebuilds)) return KITH_OK;
  return kith_ranks_allreduce_status(
      nodes->ranks,
      kith_fail_node(
          KITH_STALE, id,
          "%s, and no policy rebuilds the lists in time: choose displacement or always, or a larger skin",
          why));
}

enum kith_rebuild_reason kith_rebuilds_certain(const struct kith_rebuilds *rebuilds) {
  if (!rebuilds->snapshot_taken) return KITH_BECAUSE_first_build;
  return rebuilds->policy[0].ops->every_step ? rebuilds->policy[0].reason : KITH_BECAUSE_none;
}

/* Measures the cover, and combines what the policies of all ranks want. */
static kith_status measure(struct kith_rebuilds *rebuilds, const struct kith_nodes *nodes, kith_status status,
                           double due[KITH_REBUILD_POLICIES]) {
  for (int k = 0; k < rebuilds->n; ++k) {
    const struct kith_rebuild *policy = &rebuilds->policy[k];
    due[k] = policy->ops->every_step ||
             (policy->ops->needs_rebuild != NULL && policy->ops->needs_rebuild(policy, nodes));
  }
  if (rebuilds->keeps_cover) kith_cover_measure(&rebuilds->cover, nodes);
  const struct kith_shared parts[] = {{KITH_SHARE_MAX, rebuilds->n, due},
                                      kith_cover_shared(&rebuilds->cover)};
  return kith_ranks_agree(nodes->ranks, status, rebuilds->keeps_cover ? 2 : 1, parts);
}

kith_status kith_rebuilds_check(struct kith_rebuilds *rebuilds, const struct kith_nodes *nodes,
                                kith_status status, enum kith_rebuild_reason *reason) {
  double due[KITH_REBUILD_POLICIES] = {0};
  *reason = kith_rebuilds_certain(rebuilds);
  if (*reason != KITH_BECAUSE_none) return kith_ranks_allreduce_status(nodes->ranks, status);
  KITH_TRY(measure(rebuilds, nodes, status, due));
  const bool holds = kith_cover_holds(&rebuilds->cover), lasts = holds && !kith_cover_far(&rebuilds->cover);
  for (int k = 0; k < rebuilds->n && *reason == KITH_BECAUSE_none; ++k) {
    const struct kith_rebuild *policy = &rebuilds->policy[k];
    if (due[k] > 0 || (policy->ops->covers && !lasts)) *reason = policy->reason;
  }
  if (*reason != KITH_BECAUSE_none || covers(rebuilds) || holds) return KITH_OK;
  return kith_rebuilds_allow(rebuilds, nodes, -1,
                             "nodes moved, or supports grew, so far that the lists may miss pairs");
}

kith_status kith_rebuilds_covered(struct kith_rebuilds *rebuilds, const struct kith_nodes *nodes,
                                  kith_status status, bool *covered) {
  kith_cover_measure(&rebuilds->cover, nodes);
  const struct kith_shared part = kith_cover_shared(&rebuilds->cover);
  KITH_TRY(kith_ranks_agree(nodes->ranks, status, 1, &part));
  *covered = kith_cover_holds(&rebuilds->cover);
  return KITH_OK;
}

kith_status kith_rebuilds_take(struct kith_rebuilds *rebuilds, const struct kith_nodes *nodes) {
  rebuilds->snapshot_taken = false;
  if (rebuilds->keeps_cover) KITH_TRY(kith_cover_snapshot(&rebuilds->cover, nodes));
  for (int k = 0; k < rebuilds->n; ++k)
    if (rebuilds->policy[k].ops->snapshot != NULL)
      KITH_TRY(rebuilds->policy[k].ops->snapshot(&rebuilds->policy[k], nodes));
  rebuilds->snapshot_taken = true;
  return KITH_OK;
}

struct kith_shared kith_rebuilds_shared(struct kith_rebuilds *rebuilds) {
  return (struct kith_shared){KITH_SHARE_MAX, NDIM, rebuilds->cover.still};
}

kith_status kith_rebuilds_snapshot(struct kith_rebuilds *rebuilds, const struct kith_nodes *nodes) {
  const struct kith_shared part = kith_rebuilds_shared(rebuilds);
  return kith_ranks_agree(nodes->ranks, kith_rebuilds_take(rebuilds, nodes), 1, &part);
}

bool kith_rebuilds_lasting(const struct kith_rebuilds *rebuilds) {
  for (int k = 0; k < rebuilds->n; ++k)
    if (rebuilds->policy[k].ops->every_step) return false;
  return true;
}
