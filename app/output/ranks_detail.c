/* What ranks did: values of each rank are reduced to their minimum, mean and maximum. */
#include "app/output/ranks_detail.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SPREADS = offsetof(struct kith_ranks_detail, collectives_per_step) / sizeof(struct kith_spread) };

static kith_status spread(struct kith_ranks *ranks, int n, const double *mine, struct kith_spread *out) {
  double *value = NULL; /* min, mean, max of all */
  const size_t bytes = (size_t)n * sizeof *value;
  KITH_TRY(kith_ranks_allreduce_status(ranks, kith_resize(&value, 0, 3 * (size_t)n, sizeof *value)));
  for (int k = 0; k < 3; ++k) memcpy(value + k * n, mine, bytes);
  kith_ranks_min(ranks, value, n);
  kith_ranks_sum(ranks, value + n, n);
  kith_ranks_max(ranks, value + 2 * n, n);
  for (int k = 0; k < n; ++k)
    out[k] = (struct kith_spread){value[k], value[n + k] / kith_ranks_size(ranks), value[2 * n + k]};
  kith_free(&value);
  return KITH_OK;
}

/* ---- stages ---- */

/* The paths of this rank's stages, each ended by 0; free them. */
static kith_status join_paths(const struct kith_profile *profile, char **text, uint64_t *bytes, uint64_t *n) {
  const struct kith_stage *stage;
  size_t size = 0;
  FILE *file = open_memstream(text, &size);
  if (file == NULL) KITH_FAIL(NO_MEMORY, "no memory for the stages");
  *n = (uint64_t)kith_profile_stages(profile, &stage);
  for (uint64_t s = 0; s < *n; ++s) fprintf(file, "%s%c", stage[s].path, '\0');
  if (fclose(file) != 0) KITH_FAIL(NO_MEMORY, "no memory for the stages");
  *bytes = size;
  return KITH_OK;
}

static double seconds_of(const struct kith_profile *profile, const char *path) {
  const struct kith_stage *stage;
  const int n = kith_profile_stages(profile, &stage);
  for (int s = 0; s < n; ++s)
    if (strcmp(stage[s].path, path) == 0) return stage[s].seconds;
  return 0;
}

/* With the paths of rank 0. */
static kith_status spread_stages(struct kith_ranks *ranks, const struct kith_profile *profile,
                                 const char *path, struct kith_ranks_detail *out) {
  const size_t n = (size_t)out->n_stages;
  double *mine = NULL;
  kith_status status = kith_resize(&mine, 0, n, sizeof *mine);
  if (status == KITH_OK) status = kith_resize(&out->stage, 0, n, sizeof *out->stage);
  status = kith_ranks_allreduce_status(ranks, status);
  for (size_t s = 0; status == KITH_OK && s < n; ++s, path += strlen(path) + 1)
    mine[s] = seconds_of(profile, path);
  if (status == KITH_OK) status = spread(ranks, (int)n, mine, out->stage);
  kith_free(&mine);
  return status;
}

static kith_status detail_stages(struct kith_ranks *ranks, const struct kith_profile *profile,
                                 struct kith_ranks_detail *out) {
  char *own = NULL, *text = NULL;
  uint64_t size[2]; /* bytes, stages */
  if (ranks == NULL) return KITH_OK;
  kith_status status = kith_ranks_allreduce_status(ranks, join_paths(profile, &own, &size[0], &size[1]));
  if (status == KITH_OK) {
    kith_ranks_broadcast(ranks, 0, size, sizeof size);
    status = kith_ranks_allreduce_status(ranks, kith_resize(&text, 0, size[0], 1));
  }
  if (status == KITH_OK) {
    if (kith_ranks_rank(ranks) == 0) memcpy(text, own, size[0]);
    kith_ranks_broadcast(ranks, 0, text, size[0]);
    out->n_stages = (int)size[1];
    status = spread_stages(ranks, profile, text, out);
  }
  free(own);
  kith_free(&text);
  return status;
}

/* ---- counts ---- */

/* Stages whose own time has messages or reductions in it, and so waiting. */
static bool communicates(const char *name) {
  static const char *const stages[] = {"due",     "lifecycle", "migrate", "ghosts",     "cull",
                                       "refresh", "control",   "closure", "equilibrium"};
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
                              uint64_t steps) {
  struct kith_ranks *ranks = m->nodes->ranks;
  const struct kith_ledger *ledger = &m->integrator.ledger;
  const double n = fmax((double)steps, 1);
  double compute, exchange, last = 0, needed = 0, sum[6] = {0};
  struct kith_spread all[SPREADS];
  *out = (struct kith_ranks_detail){0};
  KITH_TRY(kith_ranks_allreduce_status(ranks, count_needed(m, &last, &needed)));
  cpu_seconds(m->profile, &compute, &exchange);
  const double mine[SPREADS] = {m->nodes->n_internal,
                                (double)ledger->last_row_entries,
                                last,
                                (double)(after->messages - before->messages) / n,
                                (double)(after->bytes - before->bytes) / n,
                                compute,
                                exchange};
  KITH_TRY(spread(ranks, SPREADS, mine, all));
  memcpy(out, all, sizeof all);
  if (m->decomposition != NULL) {
    const int distributed = m->boundaries.n - 1; /* it comes last */
    const double counts[] = {(double)ledger->boundary[distributed].created,
                             (double)ledger->boundary[distributed].culled,
                             (double)ledger->boundary[distributed].kept,
                             last,
                             needed,
                             (double)m->decomposition->migrated};
    memcpy(sum, counts, sizeof sum);
    kith_ranks_sum(ranks, sum, 6);
    out->repartitions = (double)m->decomposition->repartitions;
  }
  out->collectives_per_step = (double)(after->collectives - before->collectives) / n;
  out->remote_ghosts_created = sum[0], out->remote_ghosts_culled = sum[1], out->remote_ghosts_kept = sum[2];
  out->remote_ghosts_last = sum[3], out->remote_ghosts_last_needed = sum[4], out->nodes_migrated = sum[5];
  return detail_stages(ranks, m->profile, out);
}

void kith_ranks_detail_clear(struct kith_ranks_detail *detail) {
  kith_free(&detail->stage);
  detail->n_stages = 0;
}

/* ---- the tables ---- */

static void print_stages(const struct kith_ranks_detail *d, const struct kith_profile *profile, FILE *out) {
  enum { WIDTH = 36 };
  const struct kith_stage *stage;
  const int n = KITH_MIN(kith_profile_stages(profile, &stage), d->n_stages);
  double root = 0;
  fprintf(out, "\n%-*s %9s %11s %11s %11s %9s %7s\n", WIDTH, "stage, seconds of all ranks", "calls", "min",
          "mean", "max", "max/mean", "share");
  for (int s = 0; s < n; ++s) {
    const struct kith_spread *t = &d->stage[s];
    const int indent = KITH_MIN(2 * stage[s].depth, WIDTH - 8), room = WIDTH - indent;
    if (stage[s].depth == 0) root = t->mean;
    fprintf(out, "%*s%-*.*s %9llu %11.6f %11.6f %11.6f %9.2f %6.1f%%\n", indent, "", room, room,
            stage[s].name, (unsigned long long)stage[s].calls, t->min, t->mean, t->max,
            t->mean > 0 ? t->max / t->mean : 1, root > 0 ? 100 * t->mean / root : 0);
  }
}

static void print_spread(const char *doc, const struct kith_spread *s, FILE *out) {
  if (s->max > 0)
    fprintf(out, "%-64s %10.5g %10.5g %10.5g %9.3f\n", doc, s->min, s->mean, s->max, s->max / s->mean);
}

void kith_ranks_detail_print(const struct kith_ranks_detail *d, const struct kith_profile *profile,
                             FILE *out) {
  print_stages(d, profile, out);
  fprintf(out, "\n%-64s %10s %10s %10s %9s\n", "of a rank", "min", "mean", "max", "max/mean");
#define X(name, doc) print_spread(doc, &d->name, out);
  KITH_RANKS_SPREAD_LIST(X)
#undef X
  fprintf(out, "\n%-64s %10s\n", "of all ranks", "total");
#define X(name, doc) fprintf(out, "%-64s %10.10g\n", doc, d->name);
  KITH_RANKS_TOTAL_LIST(X)
#undef X
}
