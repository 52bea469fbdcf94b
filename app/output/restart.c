/* Checkpoints: the fields of the nodes, and beside them the arrays of numbers below. */
#include <string.h>
#include "app/output/output.h"
#include "lib/io/checkpoint.h"

enum {
  REALS = 6,
  COUNTS = 6,
  SUMS = 3, /* the last of the counts, which ranks add up */
  BASELINE = sizeof(struct kith_conservation_baseline) / sizeof(double),
  LEDGER = sizeof(struct kith_ledger) / sizeof(int64_t)
};

/* What is stored of a run: written from here, and read to here. */
struct stored {
  double *real[REALS];
  uint64_t *count[COUNTS];
};

static struct stored stored_of(struct kith_output *output, struct kith_simulation *m) {
  struct kith_integrator *it = &m->integrator;
  return (struct stored){
      {&it->time, &it->dt, &it->kick.time, &it->timestep_limit.dt, &it->accurate_dt, &output->next},
      {&it->step, (uint64_t *)&it->timestep_limit.node, &it->since_reorder, &m->package.pair_evaluations,
       &m->package.support_iterations, &m->package.fallbacks}};
}

static bool first_rank(const struct kith_simulation *m) {
  return kith_ranks_rank(m->nodes->ranks) == 0;
}

/* ---- writing ---- */

/* The arrays of all ranks. */
struct saved {
  double real[REALS], baseline[BASELINE];
  int64_t count[COUNTS], ledger[LEDGER];
  struct kith_decomposition_state decomposition;
};

static kith_status collect(struct saved *saved, struct kith_output *output, struct kith_simulation *m,
                           const struct kith_conservation_baseline *baseline) {
  const struct stored stored = stored_of(output, m);
  const struct kith_ledger all = kith_ledger_of_all(&m->integrator.ledger, m->nodes->ranks);
  uint64_t count[COUNTS];
  for (int k = 0; k < REALS; ++k) saved->real[k] = *stored.real[k];
  for (int k = 0; k < COUNTS; ++k) count[k] = *stored.count[k];
  kith_ranks_sum_counts(m->nodes->ranks, count + COUNTS - SUMS, SUMS);
  memcpy(saved->count, count, sizeof count);
  memcpy(saved->baseline, baseline, sizeof saved->baseline);
  memcpy(saved->ledger, &all, sizeof saved->ledger);
  return m->decomposition != NULL
             ? kith_decomposition_describe(m->decomposition, m->nodes, &saved->decomposition)
             : KITH_OK;
}

static kith_status put_saved(struct kith_checkpoint *c, const struct kith_output *output,
                             const struct saved *saved) {
  const struct kith_decomposition_state *d = &saved->decomposition;
  KITH_TRY(kith_checkpoint_put_f64(c, "clock", saved->real, REALS));
  KITH_TRY(kith_checkpoint_put_i64(c, "counts", saved->count, COUNTS));
  KITH_TRY(kith_checkpoint_put_f64(c, "baseline", saved->baseline, BASELINE));
  KITH_TRY(kith_checkpoint_put_i64(c, "ledger", saved->ledger, LEDGER));
  if (d->n > 0) KITH_TRY(kith_checkpoint_put_i64(c, "decomposition", d->word, d->n));
  return kith_checkpoint_put_f64(c, "snapshot_times", output->times, (size_t)output->n_snapshots);
}

/* The nodes of all; `c` is NULL but on rank 0. */
static kith_status put_nodes(struct kith_checkpoint *c, const struct kith_simulation *m) {
  const kith_status status = kith_checkpoint_put_nodes(c, m->nodes);
  if (m->decomposition == NULL) return status;
  const kith_status work = kith_checkpoint_put_field(c, m->nodes, m->decomposition->work);
  return status != KITH_OK ? status : work;
}

static kith_status write_checkpoint(const struct kith_output *output, const struct kith_simulation *m,
                                    const struct saved *saved) {
  struct kith_ranks *ranks = m->nodes->ranks;
  struct kith_checkpoint *c = NULL;
  char path[640];
  snprintf(path, sizeof path, "%s/checkpoint.kith", output->directory);
  KITH_TRY(kith_ranks_allreduce_status(
      ranks, first_rank(m) ? kith_checkpoint_open_new(&c, path, m->scene->text) : KITH_OK));
  kith_status status = put_nodes(c, m);
  if (status == KITH_OK && c != NULL) status = put_saved(c, output, saved);
  if (status == KITH_OK && c != NULL) status = kith_checkpoint_commit(&c);
  kith_checkpoint_abandon(&c);
  return kith_ranks_allreduce_status(ranks, status);
}

kith_status kith_output_checkpoint(struct kith_output *output, struct kith_simulation *m,
                                   const struct kith_conservation_baseline *baseline) {
  struct saved saved = {0};
  kith_status status = kith_ranks_allreduce_status(m->nodes->ranks, collect(&saved, output, m, baseline));
  if (status == KITH_OK) status = write_checkpoint(output, m, &saved);
  kith_free(&saved.decomposition.word);
  return status;
}

/* ---- reading ---- */

/* This rank's part of the nodes that were read: what it had, or what lies in its cells if there were not as
 * many ranks. */
static kith_status take_own(struct kith_checkpoint *c, struct kith_simulation *m) {
  struct kith_decomposition_state state = {.n = kith_checkpoint_length(c, "decomposition")};
  if (m->decomposition == NULL) return KITH_OK;
  if (state.n == SIZE_MAX) return kith_decomposition_keep_own(m->decomposition, m->nodes);
  kith_status status = kith_resize(&state.word, 0, state.n, sizeof *state.word);
  if (status == KITH_OK) status = kith_checkpoint_i64(c, "decomposition", state.word, state.n);
  if (status == KITH_OK) status = kith_decomposition_restore(m->decomposition, m->nodes, &state);
  kith_free(&state.word);
  return status;
}

static kith_status read_nodes(struct kith_checkpoint *c, struct kith_simulation *m) {
  KITH_TRY(kith_checkpoint_nodes(c, m->nodes));
  if (m->decomposition != NULL && kith_checkpoint_length(c, "work") != SIZE_MAX)
    KITH_TRY(kith_checkpoint_i64(c, "work", m->decomposition->work->i64, (size_t)m->nodes->n_internal));
  return take_own(c, m);
}

static kith_status read_all(struct kith_checkpoint *c, struct kith_output *output, struct kith_simulation *m,
                            struct kith_conservation_baseline *baseline, const char *path) {
  const struct stored stored = stored_of(output, m);
  const size_t n_snapshots = kith_checkpoint_length(c, "snapshot_times");
  double real[REALS], numbers[BASELINE];
  int64_t count[COUNTS];
  const kith_status same = kith_scene_check_same(m->scene, kith_checkpoint_scene(c));
  if (same != KITH_OK) return kith_fail(same, "%s: %s", path, kith_failure());
  if (n_snapshots > INT32_MAX / 2) KITH_FAIL(BAD_FILE, "%s: the list of snapshots is damaged", path);
  KITH_TRY(kith_checkpoint_f64(c, "clock", real, REALS));
  KITH_TRY(kith_checkpoint_i64(c, "counts", count, COUNTS));
  KITH_TRY(kith_checkpoint_f64(c, "baseline", numbers, BASELINE));
  KITH_TRY(read_nodes(c, m));
  for (int k = 0; k < REALS; ++k) *stored.real[k] = real[k];
  for (int k = 0; k < COUNTS; ++k) /* sums are kept by rank 0 */
    if (k < COUNTS - SUMS || first_rank(m)) *stored.count[k] = (uint64_t)count[k];
  memcpy(baseline, numbers, sizeof numbers);
  output->n_snapshots = (int)n_snapshots;
  output->capacity = output->n_snapshots + 64;
  KITH_TRY(kith_resize(&output->times, 0, (size_t)output->capacity, sizeof *output->times));
  return kith_checkpoint_f64(c, "snapshot_times", output->times, n_snapshots);
}

/* Neighbor lists as they were; the ledger and the reason of the time step limit continue. */
static kith_status resume(struct kith_checkpoint *c, struct kith_simulation *m) {
  struct kith_integrator *it = &m->integrator;
  struct kith_ranks *ranks = m->nodes->ranks;
  int64_t words[LEDGER];
  struct kith_ledger all;
  KITH_TRY(kith_ranks_allreduce_status(ranks, kith_checkpoint_i64(c, "ledger", words, LEDGER)));
  KITH_TRY(kith_integrator_resume(it));
  memcpy(&all, words, sizeof all);
  it->ledger = kith_ledger_of_rank(&all, ranks);
  it->timestep_limit.reason = kith_package_timestep_limit(it->package, &it->kick, it->cfl).reason;
  return KITH_OK;
}

kith_status kith_output_restore(struct kith_output *output, const char *path, struct kith_simulation *m,
                                struct kith_conservation_baseline *baseline) {
  struct kith_ranks *ranks = m->nodes->ranks;
  struct kith_checkpoint *c;
  KITH_TRY(kith_ranks_allreduce_status(ranks, kith_checkpoint_open(&c, path)));
  kith_status status = kith_ranks_allreduce_status(ranks, read_all(c, output, m, baseline, path));
  if (status == KITH_OK) status = resume(c, m);
  kith_checkpoint_close(&c);
  return status;
}
