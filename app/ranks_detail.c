#include "app/ranks_detail.h"

#include <math.h>
#include <string.h>

enum { SPREADS = offsetof(struct kith_ranks_detail, collectives_per_step) / sizeof(struct kith_spread) };

/* Stages whose own time has messages or agreements in it, and so waiting. */
static bool talks(const char *name) {
  static const char *const talking[] = {"due",     "lifecycle", "migrate", "ghosts",     "cull",
                                        "refresh", "control",   "closure", "equilibrium"};
  for (size_t k = 0; k < sizeof talking / sizeof *talking; ++k)
    if (strcmp(name, talking[k]) == 0) return true;
  return kith_boundary_find(name) != NULL || kith_package_find(name) != NULL;
}

/* Of the steps: what a rank does alone, and the rest. */
static void clock_cpu(const struct kith_profile *profile, double *compute, double *exchange) {
  const struct kith_stage *stage;
  const int n = kith_profile_stages(profile, &stage);
  *compute = *exchange = 0;
  for (int s = 0; s < n; ++s)
    if (strncmp(stage[s].path, "step", 4) == 0)
      *(talks(stage[s].name) ? exchange : compute) += stage[s].self_cpu;
}

/* Remote ghosts of the last lists, and those in the row of an internal node. */
static kith_status count_needed(const struct kith_model *m, double *kept, double *needed) {
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

static void spread(struct kith_ranks *ranks, const double *mine, struct kith_spread *out) {
  double least[SPREADS], sum[SPREADS], most[SPREADS];
  memcpy(least, mine, sizeof least), memcpy(sum, mine, sizeof sum), memcpy(most, mine, sizeof most);
  kith_ranks_min(ranks, least, SPREADS);
  kith_ranks_sum(ranks, sum, SPREADS);
  kith_ranks_max(ranks, most, SPREADS);
  for (int k = 0; k < SPREADS; ++k)
    out[k] = (struct kith_spread){least[k], sum[k] / kith_ranks_size(ranks), most[k]};
}

/* Over the run, of this rank: ghosts of others that were made, culled, kept; nodes that left. */
enum { MADE, CULLED, KEPT, LAST_KEPT, LAST_NEEDED, MIGRATED, COUNTS };
static void count_all(const struct kith_model *m, double count[COUNTS]) {
  if (m->share == NULL) return;
  const struct kith_ledger *ledger = &m->integrator.ledger;
  const int distributed = m->boundaries.n - 1; /* it comes last */
  count[MADE] = (double)ledger->boundary[distributed].created;
  count[CULLED] = (double)ledger->boundary[distributed].culled;
  count[KEPT] = (double)ledger->boundary[distributed].kept;
  count[MIGRATED] = (double)m->share->migrated;
}

kith_status kith_ranks_detail(const struct kith_model *m, const struct kith_traffic *before,
                              const struct kith_traffic *after, uint64_t steps,
                              struct kith_ranks_detail *out) {
  struct kith_ranks *ranks = m->nodes->ranks;
  const double n = fmax((double)steps, 1);
  double count[COUNTS] = {0}, compute, exchange;
  struct kith_spread all[SPREADS];
  count_all(m, count);
  clock_cpu(m->profile, &compute, &exchange);
  KITH_TRY(kith_ranks_agree(ranks, count_needed(m, &count[LAST_KEPT], &count[LAST_NEEDED])));
  const double mine[SPREADS] = {m->nodes->n_internal,
                                (double)m->integrator.ledger.last_entries,
                                count[LAST_KEPT],
                                (double)(after->messages - before->messages) / n,
                                (double)(after->bytes - before->bytes) / n,
                                compute,
                                exchange};
  spread(ranks, mine, all);
  kith_ranks_sum(ranks, count, COUNTS);
  *out = (struct kith_ranks_detail){
      .collectives_per_step = (double)(after->collectives - before->collectives) / n,
      .created = count[MADE],
      .culled = count[CULLED],
      .kept = count[KEPT],
      .last_kept = count[LAST_KEPT],
      .last_needed = count[LAST_NEEDED],
      .migrated = count[MIGRATED],
      .repartitions = m->share != NULL ? (double)m->share->repartitions : 0};
  memcpy(out, all, sizeof all);
  return KITH_OK;
}

void kith_ranks_detail_print(const struct kith_ranks_detail *d, FILE *out) {
  static const char *const name[] = {
#define X(name, doc) doc,
      KITH_RANKS_SPREAD_LIST(X)
#undef X
  };
  struct kith_spread all[SPREADS];
  memcpy(all, d, sizeof all);
  fprintf(out, "\n%-60s %12s %12s %12s %9s\n", "a rank", "least", "mean", "most", "most/mean");
  for (int k = 0; k < SPREADS; ++k)
    if (all[k].most > 0)
      fprintf(out, "%-60s %12.6g %12.6g %12.6g %9.3f\n", name[k], all[k].least, all[k].mean, all[k].most,
              all[k].most / all[k].mean);
  fprintf(out,
          "ghosts of other ranks: %.10g made, %.10g culled, %.10g kept; at the end %.10g, of them strictly "
          "needed %.10g\n",
          d->created, d->culled, d->kept, d->last_kept, d->last_needed);
  fprintf(out, "%.4g collective calls a step; %.10g nodes migrated, %.4g new maps\n", d->collectives_per_step,
          d->migrated, d->repartitions);
}
