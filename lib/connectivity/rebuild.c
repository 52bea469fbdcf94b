/* Rebuild policies.
 *
 * The bound of `displacement`. The lists hold every pair with |x0_ij| <= max(R_i, R_j), at the positions x0
 * of the snapshot, for all images of the nodes. Let now |x_ij| <= max(H_i, H_j), and say it is H_i. For any
 * common vector c, and with d = x - x0 - c up to whole periods (an image is as good as its node), |x0_ij| <=
 * |x_ij| + |d_i - d_j| <= H_i + |d_i| + max_k |d_k|, so the pair is listed if H_i + |d_i| + max_k |d_k| <=
 * R_i for all i. The maximum goes over all nodes of the process: a maximum over neighbors would miss a fast
 * node that comes from outside the rows.
 *
 * Ghosts move as their control nodes do. A mirror image moves by S d, as far as d itself, but a drift c
 * common to all nodes becomes S c: so c is 0 along axes that some image mirrors, and everywhere if there are
 * ghosts that do not follow a node.
 *
 * Rounding: positions, and the distance tests, are good to a few units in the last place of |x| and of H. A
 * node that has moved at all counts as moved by that much more; where nothing moved, the tests are repeated
 * on the same numbers. */
#include "lib/connectivity/rebuild.h"

#include "lib/core/family.h"

#include <ctype.h>
#include <float.h>
#include <string.h>

#include "lib/connectivity/internal.h"
#include "lib/core/sum.h"
#include "lib/core/vec.h"

/* --- always, never --- */

static kith_status nothing_create(struct kith_rebuild *policy) {
  policy->self = NULL;
  return KITH_OK;
}

static void nothing_destroy(struct kith_rebuild *policy) {
  (void)policy;
}

static kith_status nothing_snapshot(struct kith_rebuild *policy, const struct kith_nodes *nodes) {
  (void)policy, (void)nodes;
  return KITH_OK;
}

static kith_status always_due(const struct kith_rebuild *policy, const struct kith_nodes *nodes, bool *due) {
  (void)policy, (void)nodes;
  *due = true;
  return KITH_OK;
}

static kith_status never_due(const struct kith_rebuild *policy, const struct kith_nodes *nodes, bool *due) {
  (void)policy, (void)nodes;
  *due = false;
  return KITH_OK;
}

const struct kith_rebuild_ops kith_rebuild_always = {.name = "always",
                                                     .doc = "every step",
                                                     .create = nothing_create,
                                                     .destroy = nothing_destroy,
                                                     .due = always_due,
                                                     .snapshot = nothing_snapshot};

const struct kith_rebuild_ops kith_rebuild_never = {.name = "never",
                                                    .doc = "only when there is nothing yet",
                                                    .create = nothing_create,
                                                    .destroy = nothing_destroy,
                                                    .due = never_due,
                                                    .snapshot = nothing_snapshot};

/* --- entity-change --- */

struct entities {
  kith_index n, capacity;
  int n_lists;
  kith_index count[KITH_MAX_LISTS];
  int64_t *id; /* [n] */
};

static kith_status entity_create(struct kith_rebuild *policy) {
  return kith_resize(&policy->self, 0, 1, sizeof(struct entities));
}

static void entity_destroy(struct kith_rebuild *policy) {
  struct entities *seen = policy->self;
  if (seen != NULL) kith_free(&seen->id);
  kith_free(&policy->self);
}

static kith_status entity_due(const struct kith_rebuild *policy, const struct kith_nodes *nodes, bool *due) {
  const struct entities *seen = policy->self;
  *due = seen->n != nodes->n_internal || seen->n_lists != nodes->n_lists;
  for (int l = 0; l < nodes->n_lists && !*due; ++l) *due = seen->count[l] != nodes->lists[l].count;
  if (!*due && seen->n > 0) *due = memcmp(seen->id, nodes->id->i64, (size_t)seen->n * sizeof *seen->id) != 0;
  return KITH_OK;
}

static kith_status entity_snapshot(struct kith_rebuild *policy, const struct kith_nodes *nodes) {
  struct entities *seen = policy->self;
  const kith_index n = nodes->n_internal;
  if (n > seen->capacity) {
    KITH_TRY(kith_resize(&seen->id, 0, (size_t)n, sizeof *seen->id));
    seen->capacity = n;
  }
  seen->n = n;
  seen->n_lists = nodes->n_lists;
  for (int l = 0; l < nodes->n_lists; ++l) seen->count[l] = nodes->lists[l].count;
  if (n > 0) memcpy(seen->id, nodes->id->i64, (size_t)n * sizeof *seen->id);
  return KITH_OK;
}

const struct kith_rebuild_ops kith_rebuild_entity_change = {.name = "entity-change",
                                                            .doc = "nodes were added, deleted or reordered",
                                                            .create = entity_create,
                                                            .destroy = entity_destroy,
                                                            .due = entity_due,
                                                            .snapshot = entity_snapshot};

/* --- displacement --- */

struct displacement {
  kith_index n, capacity;
  bool drifts[NDIM]; /* a common drift along this axis is no displacement */
  double *position;  /* [n][NDIM] */
  double *reach;     /* [n] */
  double *moved;     /* [n] */
};

static kith_status displacement_create(struct kith_rebuild *policy) {
  return kith_resize(&policy->self, 0, 1, sizeof(struct displacement));
}

static void displacement_destroy(struct kith_rebuild *policy) {
  struct displacement *seen = policy->self;
  if (seen != NULL) {
    kith_free(&seen->position);
    kith_free(&seen->reach);
    kith_free(&seen->moved);
  }
  kith_free(&policy->self);
}

/* x - x0 - drift, up to whole periods. */
static void step_of(const struct kith_rebuild *policy, const double *x, const double *x0, const double *drift,
                    double *d) {
  for (int a = 0; a < NDIM; ++a) {
    d[a] = x[a] - x0[a] - drift[a];
    if (policy->period[a] > 0) d[a] -= policy->period[a] * nearbyint(d[a] / policy->period[a]);
  }
}

/* The displacement of the node with the lowest id. */
static void first_drift(const struct displacement *seen, const struct kith_nodes *nodes, double *first) {
  kith_index least = 0;
  for (kith_index i = 1; i < seen->n; ++i)
    if (nodes->id->i64[i] < nodes->id->i64[least]) least = i;
  const double *x = nodes->position->f64 + (size_t)least * NDIM, *x0 = seen->position + (size_t)least * NDIM;
  for (int a = 0; a < NDIM; ++a) first[a] = seen->n > 0 ? x[a] - x0[a] : 0;
  const int64_t id = seen->n > 0 ? nodes->id->i64[least] : INT64_MAX;
  kith_ranks_broadcast(nodes->ranks, kith_ranks_least(nodes->ranks, 0, id), first, sizeof(double) * NDIM);
}

/* The mean displacement, where it may be subtracted. The first node's comes first, so that the mean of a
 * drift beyond half a period is one drift and not two of opposite sign. */
static void common_drift(const struct kith_rebuild *policy, const struct kith_nodes *nodes, double *drift) {
  const struct displacement *seen = policy->self;
  struct kith_sum total[NDIM] = {0};
  double first[NDIM];
  uint64_t n = (uint64_t)seen->n;
  first_drift(seen, nodes, first);
  for (int a = 0; a < NDIM; ++a) first[a] = seen->drifts[a] ? first[a] : 0;
#pragma omp parallel if (seen->n > KITH_FEW)
  {
    struct kith_sum mine[NDIM] = {0};
    double d[NDIM];
#pragma omp for schedule(static) nowait
    for (kith_index i = 0; i < seen->n; ++i) {
      step_of(policy, nodes->position->f64 + (size_t)i * NDIM, seen->position + (size_t)i * NDIM, first, d);
      for (int a = 0; a < NDIM; ++a) kith_sum_add(&mine[a], d[a]);
    }
#pragma omp critical(kith_drift)
    for (int a = 0; a < NDIM; ++a) kith_sum_join(&total[a], &mine[a]);
  }
  kith_sum_ranks(nodes->ranks, total, NDIM);
  kith_ranks_sum_counts(nodes->ranks, &n, 1);
  for (int a = 0; a < NDIM; ++a)
    drift[a] = seen->drifts[a] ? first[a] + kith_sum_value(&total[a]) / (double)n : 0;
}

/* How far node i moved, rounding included; 0 only if it is where it was. */
static double moved(const struct kith_rebuild *policy, const double *x, const double *x0, const double *drift,
                    double support) {
  double d[NDIM], largest = support;
  bool same = true;
  step_of(policy, x, x0, drift, d);
  for (int a = 0; a < NDIM; ++a) {
    same = same && x[a] == x0[a] && drift[a] == 0;
    largest = KITH_MAX(largest, fabs(x[a]) + fabs(x0[a]) + fabs(drift[a]));
  }
  return same ? 0 : kith_norm(d) + 8 * DBL_EPSILON * largest;
}

static kith_status displacement_due(const struct kith_rebuild *policy, const struct kith_nodes *nodes,
                                    bool *due) {
  const struct displacement *seen = policy->self;
  const double *x = nodes->position->f64, *support = nodes->support->f64;
  *due = kith_ranks_any(nodes->ranks, seen->n != nodes->n_internal);
  if (*due || (seen->n == 0 && nodes->ranks == NULL)) return KITH_OK;
  double drift[NDIM], most = 0;
  common_drift(policy, nodes, drift);
#pragma omp parallel for schedule(static) reduction(max : most) if (seen->n > KITH_FEW)
  for (kith_index i = 0; i < seen->n; ++i) {
    seen->moved[i] =
        moved(policy, x + (size_t)i * NDIM, seen->position + (size_t)i * NDIM, drift, support[i]);
    most = KITH_MAX(most, seen->moved[i]);
  }
  kith_ranks_max(nodes->ranks, &most, 1);
  int late = 0;
#pragma omp parallel for schedule(static) reduction(| : late) if (seen->n > KITH_FEW)
  for (kith_index i = 0; i < seen->n; ++i) late |= !(support[i] + seen->moved[i] + most <= seen->reach[i]);
  *due = late != 0;
  return KITH_OK;
}

static kith_status displacement_room(struct displacement *seen, kith_index n) {
  if (n <= seen->capacity) return KITH_OK;
  seen->capacity = 0;
  KITH_TRY(kith_resize(&seen->position, 0, (size_t)n * NDIM, sizeof(double)));
  KITH_TRY(kith_resize(&seen->reach, 0, (size_t)n, sizeof(double)));
  KITH_TRY(kith_resize(&seen->moved, 0, (size_t)n, sizeof(double)));
  seen->capacity = n;
  return KITH_OK;
}

/* Remote ghosts are nodes of other ranks, or images that these know of. */
static void set_drifts(struct displacement *seen, const struct kith_nodes *nodes) {
  double still[NDIM];
  for (int a = 0; a < NDIM; ++a) {
    still[a] = 0;
    for (int b = 0; b < nodes->n_blocks; ++b) {
      const struct kith_ghost_block *block = &nodes->blocks[b];
      if (block->kind == KITH_GHOST_FROZEN || (block->kind == KITH_GHOST_IMAGE && block->image.sign[a] < 0))
        still[a] = 1;
    }
  }
  kith_ranks_max(nodes->ranks, still, NDIM);
  for (int a = 0; a < NDIM; ++a) seen->drifts[a] = still[a] == 0;
}

static kith_status displacement_snapshot(struct kith_rebuild *policy, const struct kith_nodes *nodes) {
  struct displacement *seen = policy->self;
  const size_t n = (size_t)nodes->n_internal;
  KITH_TRY(displacement_room(seen, nodes->n_internal));
  seen->n = nodes->n_internal;
  if (n > 0) memcpy(seen->position, nodes->position->f64, n * NDIM * sizeof(double));
  if (n > 0) memcpy(seen->reach, nodes->reach->f64, n * sizeof(double));
  set_drifts(seen, nodes);
  return KITH_OK;
}

const struct kith_rebuild_ops kith_rebuild_displacement = {
    .name = "displacement",
    .doc = "nodes moved, or supports grew, so far that the lists could miss a pair",
    .create = displacement_create,
    .destroy = displacement_destroy,
    .due = displacement_due,
    .snapshot = displacement_snapshot};

/* --- the family --- */

#define X(name) &kith_rebuild_##name,
KITH_FAMILY(kith_rebuild, KITH_REBUILD_LIST(X))
#undef X

static const struct kith_rebuild_ops *find(const char *word, size_t length) {
  for (const struct kith_rebuild_ops *const *ops = kith_rebuild_all(); *ops != NULL; ++ops)
    if (kith_name_is((*ops)->name, word, length)) return *ops;
  return NULL;
}

/* --- OR --- */

/* The next word of `text`, without blanks; *text moves behind its '|', or becomes NULL at the end. */
static const char *next_word(const char **text, size_t *length) {
  const char *word = *text, *bar = strchr(word, '|'), *stop = bar != NULL ? bar : word + strlen(word);
  *text = bar != NULL ? bar + 1 : NULL;
  while (word < stop && isspace((unsigned char)*word)) ++word;
  while (stop > word && isspace((unsigned char)stop[-1])) --stop;
  *length = (size_t)(stop - word);
  return word;
}

static kith_status add_policy(struct kith_rebuilds *out, const struct kith_rebuild_ops *ops,
                              const double *period) {
  for (int k = 0; k < out->n; ++k)
    if (out->policy[k].ops == ops) return KITH_OK; /* said twice */
  struct kith_rebuild *policy = &out->policy[out->n];
  policy->ops = ops;
  for (int a = 0; a < NDIM; ++a) policy->period[a] = period != NULL ? period[a] : 0;
  KITH_TRY(ops->create(policy));
  ++out->n;
  return KITH_OK;
}

kith_status kith_rebuilds_create(struct kith_rebuilds *out, const char *words, const double *period) {
  *out = (struct kith_rebuilds){0};
  while (words != NULL) {
    size_t length;
    const char *word = next_word(&words, &length);
    const struct kith_rebuild_ops *ops = find(word, length);
    const kith_status status =
        ops != NULL ? add_policy(out, ops, period)
                    : kith_fail(KITH_BAD_INPUT,
                                "'%.*s' is no rebuild policy: always, never, entity-change, displacement",
                                (int)length, word);
    if (status != KITH_OK) {
      kith_rebuilds_clear(out);
      return status;
    }
  }
  return KITH_OK;
}

void kith_rebuilds_clear(struct kith_rebuilds *rebuilds) {
  for (int k = 0; k < rebuilds->n; ++k) rebuilds->policy[k].ops->destroy(&rebuilds->policy[k]);
  *rebuilds = (struct kith_rebuilds){0};
}

kith_status kith_rebuilds_due(const struct kith_rebuilds *rebuilds, const struct kith_nodes *nodes,
                              const char **reason) {
  *reason = rebuilds->snapshot_taken ? NULL : "first build";
  for (int k = 0; k < rebuilds->n && *reason == NULL; ++k) {
    bool due;
    KITH_TRY(rebuilds->policy[k].ops->due(&rebuilds->policy[k], nodes, &due));
    if (kith_ranks_any(nodes->ranks, due)) *reason = rebuilds->policy[k].ops->name;
  }
  return KITH_OK;
}

kith_status kith_rebuilds_snapshot(struct kith_rebuilds *rebuilds, const struct kith_nodes *nodes) {
  rebuilds->snapshot_taken = false;
  for (int k = 0; k < rebuilds->n; ++k)
    KITH_TRY(rebuilds->policy[k].ops->snapshot(&rebuilds->policy[k], nodes));
  rebuilds->snapshot_taken = true;
  return KITH_OK;
}

void kith_rebuilds_invalidate(struct kith_rebuilds *rebuilds) {
  rebuilds->snapshot_taken = false;
}

bool kith_rebuilds_lasting(const struct kith_rebuilds *rebuilds) {
  for (int k = 0; k < rebuilds->n; ++k)
    if (rebuilds->policy[k].ops == &kith_rebuild_always) return false;
  return true;
}
