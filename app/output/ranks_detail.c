/* What ranks did: values of each rank are reduced to their minimum, mean and maximum. */
#include "app/output/report.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static double sum(struct kith_ranks *ranks, double mine) {
  kith_ranks_sum(ranks, &mine, 1);
  return mine;
}

static struct kith_spread spread(struct kith_ranks *ranks, double mine) {
  struct kith_spread all = {mine, sum(ranks, mine) / kith_ranks_size(ranks), mine};
  kith_ranks_min(ranks, &all.min, 1);
  kith_ranks_max(ranks, &all.max, 1);
  return all;
}

/* The stages of rank 0, one after the other: other ranks may lack some, or have met them in another order. */
static kith_status detail_stages(struct kith_ranks *ranks, const struct kith_profile *profile,
                                 struct kith_ranks_detail *out) {
  const struct kith_stage *stage;
  const int n_own = kith_profile_stages(profile, &stage);
  if (ranks == NULL) return KITH_OK;
  out->n_stages = n_own;
  kith_ranks_broadcast(ranks, 0, &out->n_stages, sizeof out->n_stages);
  KITH_TRY(kith_ranks_allreduce_status(
      ranks, kith_resize(&out->stage, 0, (size_t)out->n_stages, sizeof *out->stage)));
  for (int s = 0; s < out->n_stages; ++s) {
    char path[256] = "";
    if (kith_ranks_rank(ranks) == 0) snprintf(path, sizeof path, "%s", stage[s].path);
    kith_ranks_broadcast(ranks, 0, path, sizeof path);
    double seconds = 0;
    for (int k = 0; k < n_own; ++k)
      if (strncmp(stage[k].path, path, sizeof path - 1) == 0) seconds = stage[k].seconds;
    out->stage[s] = spread(ranks, seconds);
  }
  return KITH_OK;
}

/* ---- counts ---- */

/* Stages whose own time has messages or reductions in it, and so waiting. */
static bool communicates(const char *name) {
  static const char *const stages[] = {"due",  "lifecycle", "migrate", "ghosts",
                                       "cull", "refresh",   "control", "closure"};
  for (size_t k = 0; k < sizeof stages / sizeof *stages; ++k)
    if (strcmp(name, stages[k]) == 0) return true;
  return kith_boundary_find(name) != NULL || kith_package_find(name) != NULL;
}

/* Of the steps: without communication, and the rest. */
static void cpu_seconds(const struct kith_profile *profile, double *compute, double *exchange) {
  const struct kith_stage *stage;
  const int n = kith_profile_stages(profile, &stage);
  *compute = *exchange = 0;
  for (int s = 0; s < n; ++s)
    if (strncmp(stage[s].path, "step", 4) == 0)
      *(communicates(stage[s].name) ? exchange : compute) += stage[s].self_cpu;
}

/* Remote ghosts of the last neighbor lists, and those in the row of an internal node. */
static kith_status count_needed(const struct kith_simulation *m, double *kept, double *needed) {
  const struct kith_nodes *nodes = m->nodes;
  uint8_t *used = NULL;
  KITH_TRY(kith_resize(&used, 0, (size_t)nodes->n_ghost + 1, 1));
  *kept = *needed = 0;
  kith_connectivity_mark_ghosts(m->connectivity, nodes, used);
  for (int b = 0; b < nodes->n_blocks; ++b) {
    const struct kith_ghost_block *block = &nodes->blocks[b];
    for (kith_index k = 0; block->kind == KITH_GHOST_REMOTE && k < block->count; ++k)
      *kept += 1, *needed += used[block->first - nodes->n_internal + k] != 0;
  }
  kith_free(&used);
  return KITH_OK;
}

kith_status kith_ranks_detail(struct kith_ranks_detail *out, const struct kith_simulation *m,
                              const struct kith_traffic *before, const struct kith_traffic *after,
                              uint64_t n_steps) {
  struct kith_ranks *ranks = m->nodes->ranks;
  const struct kith_ledger *l = &m->integrator.ledger;
  const struct kith_decomposition *d = m->decomposition;
  struct kith_ledger_boundary remote = {0};
  const double steps = fmax((double)n_steps, 1);
  double compute, exchange, kept = 0, needed = 0;
  if (d != NULL) remote = l->boundary[m->boundaries.n - 1]; /* it comes last */
  *out = (struct kith_ranks_detail){0};
  KITH_TRY(kith_ranks_allreduce_status(ranks, count_needed(m, &kept, &needed)));
  cpu_seconds(m->profile, &compute, &exchange);
#define X(name, value, doc) out->name = spread(ranks, value);
  KITH_RANKS_SPREAD_LIST(X)
#undef X
#define SAME(value) (value)
#define SUM(value) sum(ranks, value)
#define X(name, kind, value, doc) out->name = kind(value);
  KITH_RANKS_TOTAL_LIST(X)
#undef X
  return detail_stages(ranks, m->profile, out);
}
