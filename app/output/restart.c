/* Checkpoints: the fields of the nodes, and beside them the arrays of numbers below. */
#include <string.h>
#include "app/output/output.h"
#include "lib/io/checkpoint.h"

enum { REALS = 6, COUNTS = 6, SUMS = 3 /* the last of the counts, which ranks add up */ };

/* What is stored of a run, of all ranks: written from here, and read to here. */
struct saved {
  double real[REALS];
  uint64_t count[COUNTS];
  struct kith_conservation_baseline baseline;
  struct kith_ledger ledger;
};

struct array {
  const char *name;
  enum kith_type type;
  void *values;
  size_t n;
};
enum { ARRAYS = 4 };
#define ARRAYS_OF(saved)                                                                     \
  {                                                                                          \
    {"clock", KITH_F64, (saved)->real, REALS}, {"counts", KITH_I64, (saved)->count, COUNTS}, \
        {"baseline", KITH_F64, &(saved)->baseline, sizeof(saved)->baseline / 8},             \
        {"ledger", KITH_I64, &(saved)->ledger, sizeof(saved)->ledger / 8},                   \
  }

/* Where the numbers belong. */
struct places {
  double *real[REALS]; /* NULL: 0 is stored */
  uint64_t *count[COUNTS];
};

static struct places places_of(struct kith_output *output, struct kith_simulation *m) {
  struct kith_integrator *it = &m->integrator;
  double *const accurate_dt = it->scheme->accurate_dt != NULL ? it->scheme->accurate_dt(it) : NULL;
  return (struct places){
      {&it->time, &it->dt, &it->kick.time, &it->timestep_limit.dt, accurate_dt, &output->next},
      {&it->step, (uint64_t *)&it->timestep_limit.node, &it->since_reorder, &m->package.pair_evaluations,
       &m->package.support_iterations, &m->package.fallbacks}};
}

static bool first_rank(const struct kith_simulation *m) {
  return kith_ranks_rank(m->nodes->ranks) == 0;
}

/* ---- writing ---- */

static struct saved collect(struct kith_output *output, struct kith_simulation *m,
                            const struct kith_conservation_baseline *baseline) {
  const struct places places = places_of(output, m);
  struct saved saved = {.baseline = *baseline,
                        .ledger = kith_ledger_of_all(&m->integrator.ledger, m->nodes->ranks)};
  for (int k = 0; k < REALS; ++k) saved.real[k] = places.real[k] != NULL ? *places.real[k] : 0;
  for (int k = 0; k < COUNTS; ++k) saved.count[k] = *places.count[k];
  kith_ranks_sum_counts(m->nodes->ranks, saved.count + COUNTS - SUMS, SUMS);
  return saved;
}

static kith_status put_saved(struct kith_checkpoint *c, const struct kith_output *output, struct saved *saved,
                             const struct kith_decomposition_state *d) {
  const struct array all[ARRAYS] = ARRAYS_OF(saved);
  for (int k = 0; k < ARRAYS; ++k)
    KITH_TRY(kith_checkpoint_put(c, all[k].name, all[k].type, all[k].values, all[k].n));
  if (d->n > 0) KITH_TRY(kith_checkpoint_put(c, "decomposition", KITH_I64, d->word, d->n));
  return kith_checkpoint_put(c, "snapshot_times", KITH_F64, output->times, (size_t)output->n_snapshots);
}

/* The nodes of all; `c` is NULL but on rank 0. */
static kith_status put_nodes(struct kith_checkpoint *c, const struct kith_simulation *m) {
  const kith_status status = kith_checkpoint_put_nodes(c, m->nodes);
  if (m->decomposition == NULL) return status;
  const kith_status work = kith_checkpoint_put_field(c, m->nodes, m->decomposition->work);
  return status != KITH_OK ? status : work;
}

static kith_status write_checkpoint(const struct kith_output *output, const struct kith_simulation *m,
                                    struct saved *saved, const struct kith_decomposition_state *d) {
  struct kith_ranks *ranks = m->nodes->ranks;
  struct kith_checkpoint *c = NULL;
  char path[640];
  snprintf(path, sizeof path, "%s/checkpoint.kith", output->directory);
  KITH_TRY(kith_ranks_allreduce_status(
      ranks, first_rank(m) ? kith_checkpoint_open_new(&c, path, m->scene->text) : KITH_OK));
  kith_status status = put_nodes(c, m);
  if (status == KITH_OK && c != NULL) status = put_saved(c, output, saved, d);
  if (status == KITH_OK && c != NULL) status = kith_checkpoint_commit(&c);
  kith_checkpoint_close(&c);
  return kith_ranks_allreduce_status(ranks, status);
}

kith_status kith_output_checkpoint(struct kith_output *output, struct kith_simulation *m,
                                   const struct kith_conservation_baseline *baseline) {
  struct saved saved = collect(output, m, baseline);
  struct kith_decomposition_state d = {0};
  kith_status status =
      m->decomposition != NULL ? kith_decomposition_describe(m->decomposition, m->nodes, &d) : KITH_OK;
  status = kith_ranks_allreduce_status(m->nodes->ranks, status);
  if (status == KITH_OK) status = write_checkpoint(output, m, &saved, &d);
  kith_free(&d.word);
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
  if (status == KITH_OK) status = kith_checkpoint_get(c, "decomposition", KITH_I64, state.word, state.n);
  if (status == KITH_OK) status = kith_decomposition_restore(m->decomposition, m->nodes, &state);
  kith_free(&state.word);
  return status;
}

static kith_status read_nodes(struct kith_checkpoint *c, struct kith_simulation *m) {
  KITH_TRY(kith_checkpoint_nodes(c, m->nodes));
  if (m->decomposition != NULL && kith_checkpoint_length(c, "work") != SIZE_MAX)
    KITH_TRY(
        kith_checkpoint_get(c, "work", KITH_I64, m->decomposition->work->i64, (size_t)m->nodes->n_internal));
  return take_own(c, m);
}

static kith_status read_all(struct kith_checkpoint *c, struct kith_output *output, struct kith_simulation *m,
                            struct saved *saved, const char *path) {
  const struct places places = places_of(output, m);
  const struct array all[ARRAYS] = ARRAYS_OF(saved);
  const size_t n_snapshots = kith_checkpoint_length(c, "snapshot_times");
  const kith_status same = kith_scene_check_same(m->scene, kith_checkpoint_scene(c));
  if (same != KITH_OK) return kith_fail(same, "%s: %s", path, kith_failure());
  if (n_snapshots > INT32_MAX / 2) KITH_FAIL(BAD_FILE, "%s: the list of snapshots is damaged", path);
  for (int k = 0; k < ARRAYS; ++k)
    KITH_TRY(kith_checkpoint_get(c, all[k].name, all[k].type, all[k].values, all[k].n));
  KITH_TRY(read_nodes(c, m));
  for (int k = 0; k < REALS; ++k)
    if (places.real[k] != NULL) *places.real[k] = saved->real[k];
  for (int k = 0; k < COUNTS; ++k) /* sums are kept by rank 0 */
    if (k < COUNTS - SUMS || first_rank(m)) *places.count[k] = saved->count[k];
  KITH_TRY(kith_reserve(&output->times, &output->capacity, n_snapshots, sizeof *output->times));
  output->n_snapshots = (int)n_snapshots;
  return kith_checkpoint_get(c, "snapshot_times", KITH_F64, output->times, n_snapshots);
}

/* Neighbor lists as they were; the ledger and the reason of the time step limit continue. */
static kith_status resume(struct kith_simulation *m, const struct kith_ledger *ledger) {
  struct kith_integrator *it = &m->integrator;
  KITH_TRY(kith_integrator_resume(it));
  it->ledger = kith_ledger_of_rank(ledger, m->nodes->ranks);
  it->timestep_limit.reason = kith_package_timestep_limit(it->package, &it->kick, it->cfl).reason;
  return KITH_OK;
}

kith_status kith_output_restore(struct kith_output *output, const char *path, struct kith_simulation *m,
                                struct kith_conservation_baseline *baseline) {
  struct kith_ranks *ranks = m->nodes->ranks;
  struct kith_checkpoint *c;
  struct saved saved;
  KITH_TRY(kith_ranks_allreduce_status(ranks, kith_checkpoint_open(&c, path)));
  kith_status status = kith_ranks_allreduce_status(ranks, read_all(c, output, m, &saved, path));
  kith_checkpoint_close(&c);
  if (status != KITH_OK) return status;
  *baseline = saved.baseline;
  return resume(m, &saved.ledger);
}
