#include "app/output.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include "app/version.h"
#include "lib/domain/migrate.h"
#include "lib/io/checkpoint.h"
#include "lib/io/snapshot.h"

static kith_status make_directory(const char *path) {
  char part[512];
  if (path[0] == '\0') KITH_FAIL(BAD_INPUT, "-o: a directory without a name");
  if (snprintf(part, sizeof part, "%s", path) >= (int)sizeof part - 64)
    KITH_FAIL(BAD_FILE, "%s: the path is too long", path);
  for (char *slash = part + 1; (slash = strchr(slash, '/')) != NULL; ++slash) {
    *slash = '\0';
    mkdir(part, 0777);
    *slash = '/';
  }
  if (mkdir(part, 0777) != 0 && errno != EEXIST)
    KITH_FAIL(BAD_FILE, "%s: cannot create the directory: %s", path, strerror(errno));
  struct stat about;
  if (stat(path, &about) != 0 || !S_ISDIR(about.st_mode)) KITH_FAIL(BAD_FILE, "%s: not a directory", path);
  if (access(path, W_OK | X_OK) != 0)
    KITH_FAIL(BAD_FILE, "%s: cannot write there: %s", path, strerror(errno));
  return KITH_OK;
}

static void path_in(const struct kith_output *output, const char *name, char path[640]) {
  snprintf(path, 640, "%s/%s", output->directory, name);
}

/* Who writes. */
static bool writes(const struct kith_model *model) {
  return kith_ranks_rank(model->nodes->ranks) == 0;
}

kith_status kith_output_directory(struct kith_output *output, const char *directory) {
  snprintf(output->directory, sizeof output->directory, "%s", directory);
  return make_directory(directory);
}

kith_status kith_output_open(struct kith_output *output, const struct kith_model *model, bool restarted) {
  char path[640];
  output->started = kith_seconds();
  if (!writes(model)) return KITH_OK;
  path_in(output, "balance.csv", path);
  if (restarted)
    KITH_TRY(kith_history_cut(path, model->integrator.step));
  else
    remove(path);
  path_in(output, "history.csv", path);
  return restarted ? kith_history_continue(&output->history, path, model->integrator.step)
                   : kith_history_open(&output->history, path);
}

static void snapshot_name(int number, char name[32]) {
  snprintf(name, 32, "snapshot_%04d.hdf", number);
}

static kith_status write_series(const struct kith_output *output) {
  char(*names)[32] = NULL;
  const char **views = NULL;
  char path[640];
  double *times = NULL;
  const size_t n = (size_t)output->n_snapshots;
  int there = 0;
  kith_status status = kith_resize(&names, 0, n, sizeof *names);
  if (status == KITH_OK) status = kith_resize(&views, 0, n, sizeof *views);
  if (status == KITH_OK) status = kith_resize(&times, 0, n, sizeof *times);
  for (size_t k = 0; status == KITH_OK && k < n; ++k) {
    snapshot_name((int)k, names[k]);
    path_in(output, names[k], path);
    if (access(path, F_OK) != 0) continue;
    views[there] = names[k];
    times[there++] = output->times[k];
  }
  path_in(output, "snapshots.hdf.series", path);
  if (status == KITH_OK) status = kith_snapshot_series(path, there, views, times);
  kith_free(&names);
  kith_free(&views);
  kith_free(&times);
  return status;
}

kith_status kith_output_snapshot(struct kith_output *output, const struct kith_model *model) {
  const struct kith_integrator *it = &model->integrator;
  const struct kith_note notes[] = {{"Program", "kith"},           {"Version", kith_version()},
                                    {"Build", kith_build()},       {"SceneName", model->scene->name},
                                    {"Scene", model->scene->text}, {NULL, NULL}};
  const struct kith_snapshot_info info = {it->time, it->step, model->scene->domain, notes};
  char name[32], path[640];
  if (output->n_snapshots == output->capacity) {
    KITH_TRY(kith_resize(&output->times, (size_t)output->capacity, (size_t)output->capacity + 64,
                         sizeof *output->times));
    output->capacity += 64;
  }
  snapshot_name(output->n_snapshots, name);
  path_in(output, name, path);
  struct kith_nodes *dealt = NULL;
  if (model->scene->reproducible) KITH_TRY(kith_nodes_deal(model->nodes, &dealt));
  const kith_status status = kith_snapshot_write(path, dealt != NULL ? dealt : model->nodes, &info);
  kith_nodes_destroy(&dealt);
  KITH_TRY(status);
  output->times[output->n_snapshots++] = it->time;
  return kith_ranks_agree(model->nodes->ranks, writes(model) ? write_series(output) : KITH_OK);
}

kith_status kith_output_step(struct kith_output *output, const struct kith_model *model,
                             const struct kith_totals *totals) {
  const struct kith_integrator *it = &model->integrator;
  uint64_t count[] = {(uint64_t)model->nodes->n_internal, (uint64_t)model->nodes->n_ghost,
                      it->ledger.last_entries};
  kith_ranks_sum_counts(model->nodes->ranks, count, 3);
  struct kith_history_row row = {.step = it->step,
                                 .time = it->time,
                                 .dt = it->dt,
                                 .limiter = it->limiter,
                                 .kinetic = totals->kinetic,
                                 .internal = totals->internal,
                                 .potential = totals->potential,
                                 .work = totals->work,
                                 .velocity_over_sound = totals->velocity_over_sound,
                                 .nodes = (int64_t)count[0],
                                 .ghosts = (int64_t)count[1],
                                 .entries = (int64_t)count[2],
                                 .rebuilds = (int64_t)it->ledger.lifecycles,
                                 .seconds = kith_seconds() - output->started};
  memcpy(row.momentum, totals->momentum, sizeof row.momentum);
  memcpy(row.angular, totals->angular, sizeof row.angular);
  return kith_ranks_agree(model->nodes->ranks,
                          writes(model) ? kith_history_add(output->history, &row) : KITH_OK);
}

static kith_status write_balance(const struct kith_output *output, const struct kith_model *model,
                                 uint64_t migrated) {
  char path[640];
  const struct kith_share *share = model->share;
  path_in(output, "balance.csv", path);
  FILE *file = fopen(path, "a");
  if (file == NULL) KITH_FAIL(BAD_FILE, "%s: cannot write: %s", path, strerror(errno));
  if (ftell(file) == 0) fputs("step,time,imbalance,repartitions,migrated\n", file);
  fprintf(file, "%llu,%.17g,%.6g,%llu,%llu\n", (unsigned long long)model->integrator.step,
          model->integrator.time, share->seen, (unsigned long long)share->repartitions,
          (unsigned long long)migrated);
  if (fclose(file) != 0) KITH_FAIL(BAD_FILE, "%s: cannot write: %s", path, strerror(errno));
  return KITH_OK;
}

kith_status kith_output_balance(struct kith_output *output, const struct kith_model *model) {
  if (model->share == NULL || model->share->looks == output->looks) return KITH_OK;
  uint64_t migrated = model->share->migrated;
  kith_ranks_sum_counts(model->nodes->ranks, &migrated, 1);
  const kith_status status = writes(model) ? write_balance(output, model, migrated) : KITH_OK;
  output->looks = model->share->looks;
  return kith_ranks_agree(model->nodes->ranks, status);
}

kith_status kith_output_close(struct kith_output *output) {
  kith_free(&output->times);
  return kith_history_close(&output->history);
}

struct kith_origin kith_origin_of(const struct kith_totals *first) {
  return (struct kith_origin){
      .totals = *first, .kinetic_least = first->kinetic, .velocity_over_sound = first->velocity_over_sound};
}

static bool is_wall(const struct kith_model *model, int axis) {
  const struct kith_boundary_ops *lower = model->scene->boundary[axis].lower,
                                 *upper = model->scene->boundary[axis].upper;
  return (lower != NULL && lower != &kith_boundary_periodic) ||
         (upper != NULL && upper != &kith_boundary_periodic);
}

/* Nothing gives momentum along this axis. */
static bool keeps_momentum(const struct kith_model *model, int axis) {
  const struct kith_body *body = &model->hydro.body;
  return !is_wall(model, axis) && body->gravity[axis] == 0 && body->mass == 0;
}

static bool can_turn(const struct kith_model *model) {
  bool can = NDIM > 1;
  for (int a = 0; a < NDIM; ++a) can = can && !is_wall(model, a) && model->hydro.body.gravity[a] == 0;
  for (int k = 0; k < model->scene->n_regions; ++k) can = can && !model->scene->region[k].frozen;
  return can;
}

/* sum m |.| of now or then, whichever is larger. */
static double scale(double now, double then) {
  return fmax(fmax(now, then), 1e-300);
}

/* What is kept: see hydro.h. */
static double energy_of(const struct kith_totals *t) {
  return t->kinetic + t->internal + t->potential - t->work;
}

void kith_origin_follow(struct kith_origin *origin, const struct kith_model *model,
                        const struct kith_totals *now) {
  const struct kith_totals *then = &origin->totals;
  const double e0 = energy_of(then), e = fmax(fabs(e0), fabs(now->work - then->work));
  const double energy = fabs(energy_of(now) - e0) / (e > 0 ? e : 1);
  double momentum = 0, angular2 = 0;
  for (int a = 0; a < NDIM; ++a)
    if (keeps_momentum(model, a)) momentum = fmax(momentum, fabs(now->momentum[a] - then->momentum[a]));
  for (int a = 0; a < 3; ++a)
    angular2 += (now->angular[a] - then->angular[a]) * (now->angular[a] - then->angular[a]);
  momentum /= scale(now->momentum_scale, then->momentum_scale);
  const double angular =
      can_turn(model) ? sqrt(angular2) / scale(now->angular_scale, then->angular_scale) : NAN;
  origin->energy_drift = fmax(origin->energy_drift, energy);
  origin->momentum_drift = fmax(origin->momentum_drift, momentum);
  origin->angular_drift = isnan(angular) ? NAN : fmax(origin->angular_drift, angular);
  origin->kinetic_least = fmin(origin->kinetic_least, now->kinetic);
  origin->kinetic_rebound = fmax(origin->kinetic_rebound, now->kinetic - origin->kinetic_least);
  origin->velocity_over_sound = fmax(origin->velocity_over_sound, now->velocity_over_sound);
}

/* ---- checkpoint: everything that is not a field of the nodes, as arrays of numbers ---- */

enum {
  CLOCK_NUMBERS = 6,
  CLOCK_COUNTS = 12,
  ORIGIN_NUMBERS = sizeof(struct kith_origin) / sizeof(double),
  LEDGER_WORDS = sizeof(struct kith_ledger) / sizeof(int64_t)
};

static void pack(const struct kith_output *output, const struct kith_model *model,
                 double number[CLOCK_NUMBERS], int64_t count[CLOCK_COUNTS]) {
  const struct kith_integrator *it = &model->integrator;
  const double numbers[CLOCK_NUMBERS] = {it->time,    it->dt,       model->package.kicked,
                                         it->vote.dt, output->next, it->accurate_dt};
  memcpy(number, numbers, sizeof numbers);
  uint64_t done[] = {model->package.pair_evaluations, model->package.support_iterations,
                     model->package.fallbacks};
  kith_ranks_sum_counts(model->nodes->ranks, done, 3);
  const int64_t counts[CLOCK_COUNTS] = {(int64_t)it->step,   it->vote.node,    (int64_t)it->since_reorder,
                                        output->n_snapshots, (int64_t)done[0], (int64_t)done[1],
                                        (int64_t)done[2]};
  memcpy(count, counts, sizeof counts);
}

static void unpack(struct kith_output *output, struct kith_model *model, const double number[CLOCK_NUMBERS],
                   const int64_t count[CLOCK_COUNTS]) {
  struct kith_integrator *it = &model->integrator;
  it->time = number[0], it->dt = number[1], model->package.kicked = number[2], it->vote.dt = number[3],
  output->next = number[4];
  it->accurate_dt = number[5];
  it->step = (uint64_t)count[0], it->vote.node = count[1], it->since_reorder = (uint64_t)count[2];
  output->n_snapshots = (int)count[3];
  if (!writes(model)) return; /* what was done by all is counted by one */
  model->package.pair_evaluations = (uint64_t)count[4];
  model->package.support_iterations = (uint64_t)count[5];
  model->package.fallbacks = (uint64_t)count[6];
}

/* All that a checkpoint holds, of all ranks. */
struct saved {
  double number[CLOCK_NUMBERS], origins[ORIGIN_NUMBERS];
  int64_t count[CLOCK_COUNTS], ledger[LEDGER_WORDS];
  struct kith_shared shared;
};

static kith_status collect(struct saved *saved, const struct kith_output *output,
                           const struct kith_model *model, const struct kith_origin *origin) {
  pack(output, model, saved->number, saved->count);
  memcpy(saved->origins, origin, sizeof saved->origins);
  const struct kith_ledger all = kith_ledger_of_all(&model->integrator.ledger, model->nodes->ranks);
  memcpy(saved->ledger, &all, sizeof saved->ledger);
  return model->share != NULL ? kith_share_describe(model->share, model->nodes, &saved->shared) : KITH_OK;
}

static kith_status put_saved(struct kith_checkpoint *c, const struct kith_output *output,
                             const struct saved *saved) {
  KITH_TRY(kith_checkpoint_put_f64(c, "clock", saved->number, CLOCK_NUMBERS));
  KITH_TRY(kith_checkpoint_put_i64(c, "counts", saved->count, CLOCK_COUNTS));
  KITH_TRY(kith_checkpoint_put_f64(c, "origin", saved->origins, ORIGIN_NUMBERS));
  KITH_TRY(kith_checkpoint_put_i64(c, "ledger", saved->ledger, LEDGER_WORDS));
  if (saved->shared.n > 0) KITH_TRY(kith_checkpoint_put_i64(c, "share", saved->shared.word, saved->shared.n));
  return kith_checkpoint_put_f64(c, "snapshot_times", output->times, (size_t)output->n_snapshots);
}

/* The nodes of all; `c` is NULL but on rank 0. */
static kith_status put_nodes(struct kith_checkpoint *c, const struct kith_model *model) {
  const kith_status status = kith_checkpoint_put_nodes(c, model->nodes);
  if (model->share == NULL) return status;
  const kith_status work = kith_checkpoint_put_field(c, model->nodes, model->share->work);
  return status != KITH_OK ? status : work;
}

static kith_status write_checkpoint(const struct kith_output *output, const struct kith_model *model,
                                    const struct saved *saved) {
  struct kith_ranks *ranks = model->nodes->ranks;
  struct kith_checkpoint *c = NULL;
  char path[640];
  path_in(output, "checkpoint.kith", path);
  KITH_TRY(kith_ranks_agree(
      ranks, writes(model) ? kith_checkpoint_open_new(&c, path, model->scene->text) : KITH_OK));
  kith_status status = put_nodes(c, model);
  if (status == KITH_OK && c != NULL) status = put_saved(c, output, saved);
  if (status == KITH_OK && c != NULL) status = kith_checkpoint_commit(&c);
  kith_checkpoint_abandon(&c);
  return kith_ranks_agree(ranks, status);
}

kith_status kith_output_checkpoint(struct kith_output *output, const struct kith_model *model,
                                   const struct kith_origin *origin) {
  struct saved saved = {0};
  kith_status status = kith_ranks_agree(model->nodes->ranks, collect(&saved, output, model, origin));
  if (status == KITH_OK) status = write_checkpoint(output, model, &saved);
  kith_free(&saved.shared.word);
  return status;
}

/* Lists again as they were; the vote's reason and the ledger go on from where they stood. */
static kith_status resume(struct kith_checkpoint *c, struct kith_model *model) {
  struct kith_integrator *it = &model->integrator;
  int64_t ledger[LEDGER_WORDS];
  struct kith_ledger all;
  KITH_TRY(kith_ranks_agree(model->nodes->ranks, kith_checkpoint_i64(c, "ledger", ledger, LEDGER_WORDS)));
  KITH_TRY(kith_integrator_resume(it));
  memcpy(&all, ledger, sizeof all);
  it->ledger = kith_ledger_share(&all, model->nodes->ranks);
  it->vote.reason = kith_package_vote(it->package, it->cfl).reason;
  return KITH_OK;
}

/* This rank's part of the nodes that were read: what it had, or what lies in its cells if there were not as many ranks. */
static kith_status take_share(struct kith_checkpoint *c, struct kith_model *model) {
  struct kith_shared shared = {.n = kith_checkpoint_length(c, "share")};
  if (model->share == NULL) return KITH_OK;
  if (shared.n == SIZE_MAX) return kith_share_keep(model->share, model->nodes);
  kith_status status = kith_resize(&shared.word, 0, shared.n, sizeof *shared.word);
  if (status == KITH_OK) status = kith_checkpoint_i64(c, "share", shared.word, shared.n);
  if (status == KITH_OK) status = kith_share_restore(model->share, model->nodes, &shared);
  kith_free(&shared.word);
  return status;
}

static kith_status read_all(struct kith_checkpoint *c, struct kith_output *output, struct kith_model *model,
                            struct kith_origin *origin, const char *path) {
  double number[CLOCK_NUMBERS], origins[ORIGIN_NUMBERS];
  int64_t count[CLOCK_COUNTS];
  if (strcmp(kith_checkpoint_scene(c), model->scene->text) != 0)
    KITH_FAIL(BAD_INPUT, "%s: written by a run of another scene or with other settings", path);
  KITH_TRY(kith_checkpoint_f64(c, "clock", number, CLOCK_NUMBERS));
  KITH_TRY(kith_checkpoint_i64(c, "counts", count, CLOCK_COUNTS));
  if (count[3] < 0 || kith_checkpoint_length(c, "snapshot_times") != (size_t)count[3])
    KITH_FAIL(BAD_FILE, "%s: the list of snapshots is damaged", path);
  KITH_TRY(kith_checkpoint_f64(c, "origin", origins, ORIGIN_NUMBERS));
  KITH_TRY(kith_checkpoint_nodes(c, model->nodes));
  if (model->share != NULL && kith_checkpoint_length(c, "work") != SIZE_MAX)
    KITH_TRY(kith_checkpoint_i64(c, "work", model->share->work->i64, (size_t)model->nodes->n_internal));
  KITH_TRY(take_share(c, model));
  unpack(output, model, number, count);
  memcpy(origin, origins, sizeof origins);
  output->capacity = output->n_snapshots + 64;
  KITH_TRY(kith_resize(&output->times, 0, (size_t)output->capacity, sizeof *output->times));
  return kith_checkpoint_f64(c, "snapshot_times", output->times, (size_t)output->n_snapshots);
}

kith_status kith_output_restore(struct kith_output *output, const char *path, struct kith_model *model,
                                struct kith_origin *origin) {
  struct kith_checkpoint *c;
  KITH_TRY(kith_ranks_agree(model->nodes->ranks, kith_checkpoint_open(&c, path)));
  kith_status status = kith_ranks_agree(model->nodes->ranks, read_all(c, output, model, origin, path));
  if (status == KITH_OK) status = resume(c, model);
  if (status == KITH_OK && model->share != NULL) output->looks = model->share->looks;
  kith_checkpoint_close(&c);
  return status;
}
