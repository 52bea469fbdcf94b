/* The directory of a run: snapshots and their series, the trace. */
#define _GNU_SOURCE /* FNM_EXTMATCH */
#include "app/output/output.h"

#include <dirent.h>
#include <errno.h>
#include <float.h>
#include <fnmatch.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "app/cli/process.h"
#include "lib/core/version.h"
#include "lib/io/atomic_file.h"
#include "lib/io/checkpoint.h"
#include "lib/io/snapshot.h"
#include "lib/nodes/migrate.h"

static void path_in(const struct kith_output *output, const char *name, char path[640]) {
  snprintf(path, 640, "%s/%s", output->directory, name);
}

static kith_status make_directory(struct kith_output *output, const char *directory, bool create) {
  if (snprintf(output->directory, sizeof output->directory, "%s", directory) >=
      (int)sizeof output->directory - 64)
    KITH_FAIL(BAD_FILE, "%s: the path is too long", directory);
  if (!create) return KITH_OK;
  KITH_TRY(kith_directory_make(directory));
  if (access(directory, W_OK | X_OK) != 0)
    KITH_FAIL(BAD_FILE, "%s: cannot write there: %s", directory, strerror(errno));
  return KITH_OK;
}

static void snapshot_name(int number, char name[32]) {
  snprintf(name, 32, "snapshot_%04d.hdf", number);
}

/* Renames a damaged checkpoint, so that the next one does not put it in the place of the good one. */
static kith_status set_damaged_aside(const struct kith_output *output) {
  char path[640], aside[660];
  struct kith_checkpoint *c;
  path_in(output, "checkpoint.kith", path);
  snprintf(aside, sizeof aside, "%s.damaged", path);
  if (kith_checkpoint_open(&c, path, NULL) == KITH_OK)
    kith_checkpoint_close(&c);
  else if (rename(path, aside) != 0 && errno != ENOENT)
    KITH_FAIL(BAD_FILE, "%s: cannot rename it: %s", path, strerror(errno));
  return KITH_OK;
}

/* Writes the list of the snapshots that are there; a restart may have begun in another directory. */
static kith_status write_series(const struct kith_output *output) {
  char path[640], name[32];
  json_t *files = json_array();
  for (int k = 0; k < output->n_snapshots; ++k) {
    snapshot_name(k, name);
    path_in(output, name, path);
    if (access(path, F_OK) == 0)
      json_array_append_new(files, json_pack("{s:s, s:f}", "name", name, "time", output->times[k]));
  }
  path_in(output, "snapshots.hdf.series", path);
  return kith_json_write(path, json_pack("{s:s, s:o}", "file-series-version", "1.0", "files", files));
}

/* Did an earlier run leave this picture or snapshot? Of a restart: is it one that is yet to be written? */
static bool is_of_earlier_run(const struct kith_output *output, bool restarted, const char *name) {
#define DATA "@(profile|exact|mean).dat|map_+([0-9]).bin"
  static const char pictures[] = "@(@(plot|growth).@(gp|png|pdf)|probe_*.@(gp|png|pdf|dat|bin)|" DATA ")",
                    of_frame[] = "@(.@(gp|png)|_@(" DATA "))"; /* after the number */
#undef DATA
  char own[32];
  int number = -1;
  if (sscanf(name, "snapshot_%d", &number) == 1 || sscanf(name, "frame_%d", &number) == 1) {
    const bool later = number >= (restarted ? output->n_snapshots : 0);
    snapshot_name(number, own);
    if (strcmp(name, own) == 0) return later;
    const int length = snprintf(own, sizeof own, "frame_%04d", number);
    return later && strncmp(name, own, (size_t)length) == 0 &&
           fnmatch(of_frame, name + length, FNM_EXTMATCH) == 0;
  }
  return !restarted && fnmatch(pictures, name, FNM_EXTMATCH) == 0;
}

/* Removes what an earlier run left: a run that fails must not stand beside another one's report. Tables that
 * this run writes are empty by now. */
static kith_status clear(const struct kith_output *output, bool restarted) {
  const char *const old[] = {"checkpoint.kith",
                             "checkpoint.kith.previous",
                             "probes.h5",
                             "report.json",
                             "snapshots.hdf.series",
                             output->contacts == NULL ? "contacts.csv" : NULL,
                             output->growth.scene == NULL ? "growth.csv" : NULL};
  char path[640];
  if (restarted && output->from_previous) KITH_TRY(set_damaged_aside(output));
  if (restarted) KITH_TRY(write_series(output)); /* without those that are removed below */
  for (size_t k = 0; k < sizeof old / sizeof *old && !restarted; ++k) {
    if (old[k] == NULL) continue;
    path_in(output, old[k], path);
    if (unlink(path) != 0 && errno != ENOENT)
      KITH_FAIL(BAD_FILE, "%s: cannot remove it: %s", path, strerror(errno));
  }
  path_in(output, "offenders.hdf", path);
  unlink(path);
  DIR *directory = opendir(output->directory);
  if (directory == NULL) KITH_FAIL(BAD_FILE, "%s: %s", output->directory, strerror(errno));
  for (const struct dirent *entry; (entry = readdir(directory)) != NULL;)
    if (is_of_earlier_run(output, restarted, entry->d_name)) unlinkat(dirfd(directory), entry->d_name, 0);
  closedir(directory);
  return KITH_OK;
}

static kith_status claim(struct kith_output *output, bool restarted, bool overwrite) {
  char path[640];
  KITH_TRY(kith_directory_claim(output->directory, &output->lock));
  path_in(output, "checkpoint.kith", path);
  if (!restarted && !overwrite && access(path, F_OK) == 0)
    KITH_FAIL(BAD_FILE,
              "%s: there is the checkpoint of an earlier run; go on with --restart %s, add --overwrite, or "
              "give -o DIR",
              output->directory, path);
  return KITH_OK;
}

/* Is the checkpoint in this directory? Then what else is there is of the same run. */
static bool goes_on_here(const char *directory, const char *checkpoint) {
  char folder[1024] = ".";
  if (checkpoint == NULL) return false;
  const int length = kith_path_folder(checkpoint);
  if (length > 0) snprintf(folder, sizeof folder, "%.*s", length, checkpoint);
  return kith_is_same_file(directory, folder);
}

kith_status kith_output_open(struct kith_output *output, struct kith_simulation *m, const char *directory,
                             const char *checkpoint, bool overwrite) {
  const bool first = kith_ranks_rank(m->nodes->ranks) == 0;
  KITH_TRY(make_directory(output, directory, first));
  const bool restarted = goes_on_here(output->directory, checkpoint);
  if (first) KITH_TRY(claim(output, restarted, overwrite));
  KITH_TRY(kith_history_open(&output->history, output->directory, m, restarted));
  KITH_TRY(kith_probes_create(&output->probes, m, output->directory, restarted));
  KITH_TRY(kith_contacts_create(&output->contacts, m, output->directory, restarted));
  KITH_TRY(kith_growth_open(&output->growth, output->directory, m, restarted));
  return first ? clear(output, restarted) : KITH_OK;
}

/* Set when jansson gets no memory for something: it goes on without that. */
static _Thread_local bool json_incomplete;

static void *json_allocate(size_t bytes) {
  void *p = malloc(bytes);
  json_incomplete |= p == NULL;
  return p;
}

void kith_json_watch(void) {
  json_set_alloc_funcs(json_allocate, free);
}

kith_status kith_json_write(const char *path, json_t *json) {
  struct kith_atomic_file *file = NULL;
  kith_status status = kith_atomic_file_open(&file, path);
  if (status == KITH_OK) json_dumpf(json, file->stream, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
  json_decref(json);
  if (status == KITH_OK && json_incomplete) status = kith_fail(KITH_NO_MEMORY, "no memory for %s", path);
  if (status == KITH_OK) fputc('\n', file->stream); /* what could not be written shows at the commit */
  if (status == KITH_OK) return kith_atomic_file_commit(&file, false);
  kith_atomic_file_abandon(&file);
  return status;
}

static kith_status write_snapshot(const char *path, const struct kith_simulation *simulation,
                                  bool with_frozen) {
  const struct kith_integrator *it = &simulation->integrator;
  char build[256];
  snprintf(build, sizeof build, "%d-D, %s, %s", NDIM, kith_compiler(), kith_flags());
  const struct kith_note notes[] = {{"Program", "kith"},
                                    {"Version", kith_version()},
                                    {"Build", build},
                                    {"SceneName", simulation->scene->name},
                                    {"Scene", simulation->scene->text},
                                    {NULL, NULL}};
  struct kith_snapshot_info info = {
      .time = it->time,
      .step = it->step,
      .box = simulation->scene->domain,
      .frozen = with_frozen ? kith_boundaries_held(&simulation->boundaries) : NULL,
      .notes = notes};
  for (int a = 0; a < NDIM; ++a) info.periodic[a] = simulation->scene->period[a] > 0;
  struct kith_nodes *dealt = NULL;
  if (simulation->scene->reproducible) KITH_TRY(kith_nodes_by_id(simulation->nodes, &dealt));
  const kith_status status = kith_snapshot_write(path, dealt != NULL ? dealt : simulation->nodes, &info);
  kith_nodes_destroy(&dealt);
  return status;
}

double kith_output_next(const struct kith_scene *scene, double time) {
  const double every = scene->output.every;
  if (every <= 0) return INFINITY;
  return every * (floor(time / every * (1 + 2 * DBL_EPSILON) + 1e-9) + 1);
}

double kith_output_step_end(const struct kith_scene *scene, double next, double until) {
  return next > until - 1e-9 * scene->output.every ? until : next;
}

kith_status kith_output_snapshot(struct kith_output *output, const struct kith_simulation *simulation) {
  char name[32], path[640];
  const size_t n = (size_t)output->n_snapshots;
  struct kith_ranks *ranks = simulation->nodes->ranks;
  KITH_TRY(kith_ranks_allreduce_status(
      ranks, kith_grow(&output->times, &output->capacity, n, n + 1, sizeof *output->times)));
  snapshot_name(output->n_snapshots, name);
  path_in(output, name, path);
  KITH_TRY(write_snapshot(path, simulation, true));
  output->times[output->n_snapshots++] = simulation->integrator.time;
  return kith_ranks_allreduce_status(ranks, kith_ranks_rank(ranks) == 0 ? write_series(output) : KITH_OK);
}

/* How far a node reaches: its support, or its search radius if the support is not finite. */
static double reach_of(const struct kith_nodes *nodes, kith_index i) {
  return isfinite(nodes->support->f64[i]) ? nodes->support->f64[i] : nodes->search_radius->f64[i];
}

kith_status kith_output_offenders(const struct kith_output *output, struct kith_simulation *m, int64_t id,
                                  bool *written) {
  struct kith_nodes *nodes = m->nodes;
  double center[NDIM + 1]; /* position and reach, from the rank that has the node */
  uint8_t *others = NULL;
  char path[640];
  for (int a = 0; a <= NDIM; ++a) center[a] = -INFINITY;
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    if (nodes->id->i64[i] != id) continue;
    memcpy(center, nodes->position->f64 + (size_t)i * NDIM, NDIM * sizeof *center);
    center[NDIM] = reach_of(nodes, i);
  }
  kith_ranks_max(nodes->ranks, center, NDIM + 1);
  *written = isfinite(center[NDIM]);
  if (!*written) return KITH_OK;
  KITH_TRY(kith_ranks_allreduce_status(nodes->ranks, kith_resize(&others, 0, (size_t)nodes->n_internal, 1)));
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    const double *x = nodes->position->f64 + (size_t)i * NDIM,
                 r = kith_scene_distance(m->scene, x, center, nodes->stretch);
    others[i] = nodes->id->i64[i] != id && !(r <= fmax(center[NDIM], reach_of(nodes, i)));
  }
  kith_status status = kith_ranks_allreduce_status(nodes->ranks, kith_nodes_delete(nodes, others));
  kith_free(&others);
  path_in(output, "offenders.hdf", path);
  if (status == KITH_OK) status = write_snapshot(path, m, false);
  return status;
}

static kith_status append(const struct kith_atomic_file *file, const struct kith_profile *profile, int rank,
                          bool last) {
  FILE *f = fopen(file->temporary, "a");
  if (f == NULL) KITH_FAIL(BAD_FILE, "%s: cannot write: %s", file->path, strerror(errno));
  fputs(rank == 0 ? "[\n" : ",\n", f);
  kith_profile_write_events(profile, rank, f);
  if (last) fputs("\n]\n", f);
  const bool whole = !ferror(f);
  if (fclose(f) != 0 || !whole) KITH_FAIL(BAD_FILE, "%s: cannot write: %s", file->path, strerror(errno));
  return KITH_OK;
}

kith_status kith_trace_write(struct kith_ranks *ranks, const struct kith_profile *profile, const char *path) {
  const int me = kith_ranks_rank(ranks), size = kith_ranks_size(ranks);
  struct kith_atomic_file *file = NULL;
  kith_status status = me == 0 ? kith_atomic_file_open(&file, path) : kith_atomic_file_join(&file, path);
  status = kith_ranks_allreduce_status(ranks, status);
  for (int r = 0; r < size && status == KITH_OK; ++r)
    status = kith_ranks_allreduce_status(ranks, r == me ? append(file, profile, me, r == size - 1) : KITH_OK);
  if (status == KITH_OK)
    status = kith_ranks_allreduce_status(ranks, me == 0 ? kith_atomic_file_commit(&file, false) : KITH_OK);
  kith_atomic_file_abandon(&file);
  return status;
}

kith_status kith_output_close(struct kith_output *output) {
  kith_free(&output->times);
  if (output->lock > 0) close(output->lock);
  const kith_status probes = kith_probes_destroy(&output->probes),
                    contacts = kith_contacts_destroy(&output->contacts),
                    growth = kith_csv_log_close(&output->growth.log),
                    history = kith_csv_log_close(&output->history.steps);
  return history != KITH_OK ? history : contacts != KITH_OK ? contacts : growth != KITH_OK ? growth : probes;
}
