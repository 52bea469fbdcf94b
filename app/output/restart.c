/* Checkpoints: the fields of the nodes, and beside them the arrays of numbers below. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "app/output/output.h"
#include "lib/io/checkpoint.h"
#include "lib/nodes/migrate.h"

enum { REALS = 7, COUNTS = 6, SUMS = 3 /* the last of the counts, which ranks add up */ };

/* Numbers that are stored of a run, for all ranks together. */
struct saved {
  double real[REALS];
  uint64_t count[COUNTS];
  struct kith_conservation_baseline baseline;
  struct kith_ledger ledger;
  struct kith_through through[2]; /* until now, and its rate */
  double drift[NDIM];             /* of a node since the lists were made (reference of cover.h) */
};

/* Its arrays of 8-byte numbers: member, name in the file, type. */
#define ARRAY_LIST(X)               \
  X(real, "clock", KITH_F64)        \
  X(count, "counts", KITH_I64)      \
  X(baseline, "baseline", KITH_F64) \
  X(through, "through", KITH_F64)   \
  X(drift, "drift", KITH_F64)       \
  X(ledger, "ledger", KITH_I64)

/* Where a simulation keeps `real` and `count`. */
struct places {
  double *real[REALS];
  uint64_t *count[COUNTS];
};

static struct places places_of(struct kith_simulation *m) {
  struct kith_integrator *it = &m->integrator;
  return (struct places){
      {&it->time, &it->dt, &it->kick.time, &it->timestep_limit.dt, &it->accurate_dt, &it->until, &it->every},
      {&it->step, (uint64_t *)&it->timestep_limit.node, &it->since_reorder, &m->package.pair_evaluations,
       &m->package.support_iterations, &m->package.fallbacks}};
}

static bool first_rank(const struct kith_simulation *m) {
  return kith_ranks_rank(m->nodes->ranks) == 0;
}

static struct saved collect(struct kith_simulation *m, const struct kith_conservation_baseline *baseline) {
  const struct places places = places_of(m);
  struct saved saved = {.baseline = *baseline,
                        .ledger = kith_ledger_of_all(&m->integrator.ledger, m->nodes->ranks),
                        .through = {m->hydro.through, m->integrator.flow.rate}};
  memcpy(saved.drift, m->rebuilds.cover.reference, sizeof saved.drift);
  for (int k = 0; k < REALS; ++k) saved.real[k] = *places.real[k];
  for (int k = 0; k < COUNTS; ++k) saved.count[k] = *places.count[k];
  kith_ranks_sum_counts(m->nodes->ranks, saved.count + COUNTS - SUMS, SUMS);
  return saved;
}

/* Writes the nodes of all ranks and all numbers. `c` is NULL except on rank 0. */
static kith_status put_all(struct kith_checkpoint *c, const struct kith_simulation *m,
                           const struct kith_output *output, const struct saved *saved) {
  const struct kith_decomposition *d = m->decomposition;
  const kith_status nodes = kith_checkpoint_put_nodes(c, m->nodes),
                    own = d != NULL ? kith_decomposition_save(d, m->nodes, c) : KITH_OK;
  KITH_TRY(nodes);
  if (own != KITH_OK || c == NULL) return own;
#define X(member, name, type) \
  KITH_TRY(kith_checkpoint_put(c, name, type, &saved->member, sizeof saved->member / 8));
  ARRAY_LIST(X)
#undef X
  return kith_checkpoint_put(c, "snapshot_times", KITH_F64, output->times, (size_t)output->n_snapshots);
}

kith_status kith_output_checkpoint(struct kith_output *output, struct kith_simulation *m,
                                   const struct kith_conservation_baseline *baseline) {
  struct kith_ranks *ranks = m->nodes->ranks;
  struct kith_checkpoint *c = NULL;
  struct saved saved = collect(m, baseline);
  char path[640];
  snprintf(path, sizeof path, "%s/checkpoint.kith", output->directory);
  /* Tables are flushed first: a restart keeps their rows up to the checkpoint. */
  kith_status status = kith_csv_log_sync(&output->history.steps);
  if (status == KITH_OK) status = kith_contacts_sync(output->contacts);
  if (status == KITH_OK) status = kith_csv_log_sync(&output->growth.log);
  if (status == KITH_OK) status = kith_probes_publish(output->probes);
  if (status == KITH_OK && first_rank(m)) status = kith_checkpoint_open_new(&c, path, m->scene->text);
  status = kith_ranks_allreduce_status(ranks, status);
  if (status == KITH_OK) {
    status = put_all(c, m, output, &saved);
    if (status == KITH_OK && c != NULL) status = kith_checkpoint_commit(&c);
    status = kith_ranks_allreduce_status(ranks, status);
  }
  kith_checkpoint_close(&c);
  return status;
}

static int compare_ids(const void *a, const void *b) {
  const int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
  return (x > y) - (x < y);
}

/* Checks that ids are not negative, and none is there twice. Each rank has the nodes of a range of ids. */
static kith_status check_ids(const struct kith_nodes *nodes, const char *path) {
  const size_t n = (size_t)nodes->n_internal;
  int64_t *id = NULL;
  KITH_TRY(kith_resize(&id, 0, n, sizeof *id));
  if (n > 0) memcpy(id, nodes->id->i64, n * sizeof *id);
  if (n > 0) qsort(id, n, sizeof *id, compare_ids);
  kith_status status = KITH_OK;
  if (n > 0 && id[0] < 0)
    status = kith_fail(KITH_BAD_FILE, "%s: damaged: a node has the id %lld", path, (long long)id[0]);
  for (size_t k = 1; k < n && status == KITH_OK; ++k)
    if (id[k] == id[k - 1])
      status = kith_fail(KITH_BAD_FILE, "%s: damaged: two nodes have the id %lld", path, (long long)id[k]);
  kith_free(&id);
  return status;
}

/* Checks values: a checksum can be right for a state that no run has. */
static kith_status check_state(const struct kith_simulation *m, const struct saved *saved, const char *path) {
  const struct kith_nodes *nodes = m->nodes;
  const struct kith_hydro *hydro = &m->hydro;
  for (int f = 0; f < nodes->n_fields; ++f) {
    const struct kith_field *field = nodes->fields[f];
    const bool positive = field == hydro->mass || field == hydro->density || field == nodes->support;
    if (!kith_field_lasts(nodes, field) || field->spec.type != KITH_F64) continue;
    for (size_t k = 0; k < (size_t)nodes->n_internal * (size_t)field->components; ++k)
      if (!isfinite(field->f64[k]) || (positive && !(field->f64[k] > 0)))
        KITH_FAIL(BAD_FILE, "%s: damaged: the %s of node %lld is %g", path, field->spec.name,
                  (long long)nodes->id->i64[k / (size_t)field->components], field->f64[k]);
  }
  const double time = saved->real[0], dt = saved->real[1];
  if (!(time >= 0) || !isfinite(time) || !(dt >= 0) || !isfinite(dt))
    KITH_FAIL(BAD_FILE, "%s: damaged: time %g, step of %g", path, time, dt);
  return KITH_OK;
}

/* Reads what this rank needs; the status is of this rank alone. */
static kith_status read_share(struct kith_checkpoint *c, struct kith_output *output,
                              struct kith_simulation *m, struct saved *saved, const char *path) {
  const size_t n_snapshots = kith_checkpoint_length(c, "snapshot_times");
  const kith_status same = kith_scene_check_same(m->scene, kith_checkpoint_scene(c));
  if (same != KITH_OK) return kith_fail(same, "%s: %s", path, kith_failure());
  if (n_snapshots > INT32_MAX / 2) KITH_FAIL(BAD_FILE, "%s: the list of snapshots is damaged", path);
#define X(member, name, type) \
  KITH_TRY(kith_checkpoint_get(c, name, type, &saved->member, sizeof saved->member / 8));
  ARRAY_LIST(X)
#undef X
  KITH_TRY(m->decomposition != NULL ? kith_decomposition_read(m->decomposition, m->nodes, c)
                                    : kith_checkpoint_nodes(c, m->nodes, NULL));
  KITH_TRY(check_state(m, saved, path));
  KITH_TRY(kith_reserve(&output->times, &output->capacity, n_snapshots, sizeof *output->times));
  output->n_snapshots = (int)n_snapshots;
  return kith_checkpoint_get(c, "snapshot_times", KITH_F64, output->times, n_snapshots);
}

static void take_back(struct kith_simulation *m, const struct saved *saved) {
  const struct places places = places_of(m);
  for (int k = 0; k < REALS; ++k) *places.real[k] = saved->real[k];
  for (int k = 0; k < COUNTS; ++k) /* sums over ranks go to rank 0 */
    if (k < COUNTS - SUMS || first_rank(m)) *places.count[k] = saved->count[k];
  m->hydro.through = saved->through[0], m->integrator.flow.rate = saved->through[1];
}

static kith_status read_all(struct kith_checkpoint *c, struct kith_output *output, struct kith_simulation *m,
                            struct saved *saved, const char *path) {
  struct kith_ranks *ranks = m->nodes->ranks;
  struct kith_nodes *by_id = NULL;
  KITH_TRY(kith_ranks_allreduce_status(ranks, read_share(c, output, m, saved, path)));
  KITH_TRY(kith_nodes_by_id(m->nodes, &by_id));
  const kith_status status = kith_ranks_allreduce_status(ranks, check_ids(by_id, path));
  kith_nodes_destroy(&by_id);
  KITH_TRY(status);
  if (m->decomposition != NULL) KITH_TRY(kith_decomposition_resume(m->decomposition, m->nodes));
  take_back(m, saved);
  return KITH_OK;
}

static kith_status restore_from(struct kith_output *output, const char *path, struct kith_simulation *m,
                                struct saved *saved) {
  struct kith_checkpoint *c;
  KITH_TRY(kith_checkpoint_open(&c, path, m->nodes->ranks));
  const kith_status status = read_all(c, output, m, saved, path);
  kith_checkpoint_close(&c);
  return status;
}

kith_status kith_output_restore(struct kith_output *output, const char *path, struct kith_simulation *m,
                                struct kith_conservation_baseline *baseline) {
  struct kith_integrator *it = &m->integrator;
  struct saved saved;
  char previous[1024], why[1024];
  snprintf(previous, sizeof previous, "%s.previous", path);
  const bool there = kith_ranks_any(m->nodes->ranks, access(previous, R_OK) == 0); /* all try it, or none */
  kith_status status = restore_from(output, path, m, &saved);
  if (status == KITH_BAD_FILE && there) {
    snprintf(why, sizeof why, "%.900s", kith_failure());
    status = restore_from(output, previous, m, &saved);
    output->from_previous = status == KITH_OK;
    if (status != KITH_OK)
      status = kith_ranks_allreduce_status(m->nodes->ranks, kith_fail(status, "%s", why));
    if (status == KITH_OK && first_rank(m))
      fprintf(stderr, "kith: warning: %s; going on from %s, of step %llu\n", why, previous,
              (unsigned long long)it->step);
  }
  KITH_TRY(status);
  *baseline = saved.baseline;
  KITH_TRY(kith_integrator_resume(it, &saved.baseline.totals)); /* makes the neighbor lists as they were */
  memcpy(m->rebuilds.cover.reference, saved.drift, sizeof saved.drift); /* the last step may have gone far */
  it->ledger = kith_ledger_of_rank(&saved.ledger, m->nodes->ranks);
  it->timestep_limit.reason = kith_package_timestep_limit(it->package, it->cfl).reason;
  return KITH_OK;
}
