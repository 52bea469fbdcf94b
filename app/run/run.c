/* run.c - a scene from start to end: steps, progress, snapshots, history, checkpoints, comparison, report,
 * picture. Of several ranks all run this; rank 0 prints and writes.
 *
 * Exit code: 0, 1 (the run failed, and a snapshot of where it failed is in the directory; or it was stopped
 * before its end) or 2 (scene, files). */
#include "app/cli/options.h"

#include <limits.h>
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>
#include "app/cli/process.h"
#include "app/cli/text.h"
#include "app/output/output.h"
#include "app/output/pictures/probe_plot.h"
#include "app/output/report.h"
#include "app/run/compared.h"
#include "app/run/signals.h"
#include "lib/io/atomic_file.h"

/* Progress that is shown: a row from time to time. */
struct progress {
  bool shown;
  double from, started, drawn; /* time and clock at the first step; clock when it was drawn */
};

struct run {
  const struct kith_options *options;
  const char *restart;      /* checkpoint file; NULL: none */
  struct kith_ranks *ranks; /* NULL: one process */
  struct kith_scene *scene;
  struct kith_profile *profile;
  struct kith_simulation *simulation;
  struct kith_compared compared;
  struct kith_output output;
  struct kith_conservation_baseline baseline;
  struct progress progress;
  struct kith_traffic traffic; /* during the steps */
  struct kith_provenance provenance;
  struct kith_report report;
  double entered, until, started, cpu_started; /* entered: clock when the program began */
  double saved, begun, slowest; /* clock at the last checkpoint and step; seconds of the slowest step */
  double next_snapshot;         /* its time */
  uint64_t first_step, first_updates, first_pairs;
  double updates; /* nodes of this rank, summed over the steps */
  bool stopped;   /* by a signal, or for want of time; the same on all ranks */
};

/* Joins the ranks. *ranks: NULL if this process is the only one. */
static kith_status join_ranks(struct kith_ranks **ranks, const struct kith_options *options) {
  KITH_TRY(kith_ranks_create(ranks));
  if (options->threads == 0) kith_share_cores(*ranks, INT_MAX);
  const int size = kith_ranks_size(*ranks);
  if (options->ranks > 0 && options->ranks != size)
    return kith_ranks_allreduce_status(
        *ranks, kith_fail(KITH_BAD_INPUT, "--ranks %d, but %d processes were started", options->ranks, size));
  return KITH_OK;
}

static double cpu_seconds(void) {
  return (double)clock() / CLOCKS_PER_SEC;
}

static bool first_rank(const struct run *run) {
  return kith_ranks_rank(run->ranks) == 0;
}

/* ---- start: all that can be found wrong before the first step ---- */

/* Refuses a trace that would replace a file which the run is made from. */
static kith_status check_read(const char *trace, const char *read) {
  if (!kith_is_same_file(trace, read)) return KITH_OK;
  KITH_FAIL(BAD_INPUT, "--trace: %s is the file %s, which this run reads", trace, read);
}

static const char *without_dot(const char *path) {
  while (strncmp(path, "./", 2) == 0) path += 2;
  return path;
}

/* Is the file in this directory, which need not be there yet? */
static bool is_in(const char *path, const char *directory) {
  const int length = kith_path_folder(path);
  char folder[KITH_PATH], wanted[KITH_PATH + 1];
  snprintf(folder, sizeof folder, "%.*s", length > 0 ? length : 2, length > 0 ? path : "./");
  snprintf(wanted, sizeof wanted, "%s%s", directory, directory[strlen(directory) - 1] == '/' ? "" : "/");
  return strcmp(without_dot(folder), without_dot(wanted)) == 0 || kith_is_same_file(folder, wanted);
}

/* Tests now whether the trace can be written, not at the end. The report is the only result whose name ends
 * with .json. */
static kith_status check_trace(const struct run *run, const char *directory) {
  const char *trace = run->options->trace, *name = trace + kith_path_folder(trace), *end = strrchr(name, '.');
  const bool inside = is_in(trace, directory);
  struct kith_atomic_file *file;
  for (const struct kith_config *c = run->scene->config; c != NULL; c = c->base)
    KITH_TRY(check_read(trace, c->file));
  if (run->restart != NULL) KITH_TRY(check_read(trace, run->restart));
  if (inside && (end == NULL || strcmp(end, ".json") != 0 || strcmp(name, "report.json") == 0))
    KITH_FAIL(BAD_INPUT,
              "--trace: %s may be the name of a result; in the directory of the results a trace is called "
              "NAME.json, and not report.json",
              trace);
  if (inside && access(directory, F_OK) != 0) return KITH_OK; /* it is made next */
  KITH_TRY(kith_atomic_file_open(&file, trace));
  kith_atomic_file_abandon(&file);
  return KITH_OK;
}

static kith_status open_output(struct run *run) {
  const struct kith_options *o = run->options;
  char own[KITH_PATH];
  snprintf(own, sizeof own, "out/%s", run->scene->name);
  const char *directory = o->directory != NULL ? o->directory : own;
  if (first_rank(run) && o->trace != NULL) KITH_TRY(check_trace(run, directory));
  return kith_output_open(&run->output, run->simulation, directory, run->restart, o->overwrite);
}

static kith_status read_scene(struct run *run) {
  const struct kith_options *o = run->options;
  KITH_TRY(kith_scene_read(&run->scene, o->subject, o->n_overrides, o->overrides));
  run->until = o->until >= 0 ? o->until : run->scene->until;
  return kith_scene_check_until(run->scene, run->until);
}

/* Checks that the end that a restart is asked for is not before its checkpoint. */
static kith_status check_future(const struct run *run) {
  const struct kith_integrator *it = &run->simulation->integrator;
  const struct kith_options *o = run->options;
  if (it->time > run->until)
    KITH_FAIL(BAD_INPUT, "%s: %g is in the past of the checkpoint, which is at time %g",
              o->until >= 0 ? "--until" : "until", run->until, it->time);
  if (o->steps >= 0 && it->step > (uint64_t)o->steps)
    KITH_FAIL(BAD_INPUT, "--steps: %d is in the past of the checkpoint, which is at step %llu", o->steps,
              (unsigned long long)it->step);
  return KITH_OK;
}

static kith_status prepare(struct run *run) {
  const struct kith_options *o = run->options;
  KITH_TRY(kith_ranks_allreduce_status(
      run->ranks, kith_profile_create(&run->profile, omp_get_max_threads(), o->trace != NULL)));
  KITH_TRY(kith_ranks_allreduce_status(run->ranks, kith_ranks_watch(run->ranks, o->watchdog, run->profile)));
  const double now = kith_seconds(); /* the same moment for all ranks: they leave a reduction together */
  double age = now - run->entered;
  kith_ranks_max(run->ranks, &age, 1);
  kith_profile_align(run->profile, now - age);
  kith_profile_begin_since(run->profile, "set-up", run->entered);
  KITH_TRY(kith_provenance_take(&run->provenance, o->arguments));
  KITH_TRY(kith_ranks_allreduce_status(run->ranks, read_scene(run)));
  KITH_TRY(kith_simulation_create(&run->simulation, run->scene, run->ranks, run->profile, o->check));
  run->compared.simulation = run->simulation;
  if (o->threads == 0) kith_share_cores(run->ranks, run->simulation->nodes->n_internal);
  if (run->restart != NULL) {
    KITH_TRY(kith_output_restore(&run->output, run->restart, run->simulation, &run->baseline));
    KITH_TRY(kith_ranks_allreduce_status(run->ranks, check_future(run)));
  }
  KITH_TRY(kith_ranks_allreduce_status(run->ranks, open_output(run)));
  kith_profile_end(run->profile);
  return KITH_OK;
}

/* ---- comparison: norms, measures and pictures, to which each rank adds its nodes ---- */

static bool measures(const struct kith_scene *scene) {
  bool wanted = false;
  for (int k = 0; k < KITH_N_MEASURES; ++k) wanted = wanted || scene->measure.wanted[k];
  return wanted;
}

/* Takes the measures that are wanted; start: as for kith_compared_measure. */
static void measure(const struct run *run, const double *start, double *value) {
  for (int k = 0; k < KITH_N_MEASURES; ++k)
    if (run->scene->measure.wanted[k])
      value[k] = kith_compared_measure(&run->compared, (enum kith_measure)k, start);
}

/* Beyond round-off, linear theory, and densities that are means over cells. */
static const double tolerated_mismatch = 0.01; /* 2 % of the mean of both */

/* Warns if the nodes do not start with the exact solution, whose parameters are then of another scene. */
static kith_status compare_start(struct run *run) {
  const struct kith_scene *scene = run->scene;
  const char *name = "";
  if (scene->exact.ops == NULL) return KITH_OK;
  KITH_TRY(kith_compared_take(&run->compared));
  const struct kith_profile_view view = kith_compared_view(&run->compared);
  const double part = kith_norms_mismatch(&name, scene->exact.ops, scene->exact.solution,
                                          scene->n_deposits > 0, &scene->exact.window, &view);
  kith_compared_clear(&run->compared);
  if (part > tolerated_mismatch && first_rank(run))
    fprintf(stderr, "kith: warning: exact: the scene does not start as %s does: the %s differs by %.3g %%\n",
            scene->exact.ops->name, name, 200 * part);
  return KITH_OK;
}

/* Measures what the measures at the end are compared with. */
static kith_status measure_start(struct run *run) {
  if (!measures(run->scene)) return KITH_OK;
  KITH_TRY(kith_compared_take(&run->compared));
  measure(run, NULL, run->baseline.measure);
  kith_compared_clear(&run->compared);
  return KITH_OK;
}

/* Appends the amplitude of the mode that grows, when it is wanted. */
static kith_status sample_growth(struct run *run) {
  const struct kith_integrator *it = &run->simulation->integrator;
  if (!kith_growth_due(&run->output.growth, it->time)) return KITH_OK;
  KITH_TRY(kith_compared_take(&run->compared));
  const double amplitude = kith_compared_measure(&run->compared, run->output.growth.measure, NULL);
  kith_compared_clear(&run->compared);
  return kith_ranks_allreduce_status(run->ranks,
                                     kith_growth_add(&run->output.growth, it->step, it->time, amplitude));
}

/* Draws pictures of what was sampled on the way. Called by one process. */
static kith_status draw_tables(struct run *run) {
  char path[640];
  if (run->output.growth.scene != NULL)
    KITH_TRY(kith_growth_draw(&run->output.growth, run->output.directory,
                              run->baseline.measure[run->output.growth.measure]));
  if (run->scene->n_probes == 0) return KITH_OK;
  KITH_TRY(kith_probes_publish(run->output.probes));
  snprintf(path, sizeof path, "%s/probes.h5", run->output.directory);
  if (access(path, F_OK) != 0) return KITH_OK; /* a restart from elsewhere that made no step has no samples */
  return kith_probes_draw(run->scene, run->scene->exact.solution, run->output.directory);
}

/* Writes a snapshot, and the picture of it, if every one is to have one. */
static kith_status write_snapshot(struct run *run) {
  char name[32];
  snprintf(name, sizeof name, "frame_%04d", run->output.n_snapshots);
  KITH_TRY(kith_output_snapshot(&run->output, run->simulation));
  if (!run->scene->output.plot || !run->scene->output.picture.frames) return KITH_OK;
  KITH_TRY(kith_compared_take(&run->compared));
  kith_compared_draw(&run->compared, run->output.directory, name, NULL);
  kith_compared_clear(&run->compared);
  return KITH_OK;
}

/* ---- steps ---- */

/* Prints a row after a step: every 2 seconds, and the last one. */
static void show_progress(struct run *run, bool last) {
  struct progress *p = &run->progress;
  const struct kith_integrator *it = &run->simulation->integrator;
  const double now = kith_seconds();
  if (!p->shown || (!last && now - p->drawn < 2)) return;
  p->drawn = now;
  const double done = run->until > p->from ? (it->time - p->from) / (run->until - p->from) : 1;
  char node[24] = "-", left[32];
  if (it->limiting_node >= 0) snprintf(node, sizeof node, "%lld", (long long)it->limiting_node);
  kith_text_seconds(left, done > 0 ? (now - p->started) * (1 - done) / done : 0);
  fprintf(stderr, "%8llu  %-12.6g %-11.4g %-14s %12s %10llu %5.1f%%  %s\n", (unsigned long long)it->step,
          it->time, it->dt, kith_limit_name(it->limiter), node, (unsigned long long)it->summary.ghosts,
          100 * done, left);
}

/* Warns if the ranks on this computer have more threads than cores that they may use. */
static void warn_of_cores(const struct kith_ranks *ranks) {
  const int here = kith_ranks_on_this_machine(ranks), threads = omp_get_max_threads(),
            online = (int)sysconf(_SC_NPROCESSORS_ONLN),
            cores = ranks != NULL ? kith_ranks_cores(ranks) : omp_get_num_procs();
  if (here * threads <= cores) return;
  fprintf(stderr, "kith: warning: %d rank%s of %d thread%s share %d core%s", here, here == 1 ? "" : "s",
          threads, threads == 1 ? "" : "s", cores, cores == 1 ? "" : "s");
  if (cores < online)
    fprintf(stderr, ", to which they are bound, of %d: mpirun --bind-to none, or taskset, binds otherwise",
            online);
  fputc('\n', stderr);
}

/* Writes the state of step 0. */
static kith_status write_start(struct run *run) {
  run->simulation->integrator.pending = kith_history_row(&run->output.history, run->simulation);
  KITH_TRY(sample_growth(run));
  KITH_TRY(write_snapshot(run));
  return kith_probes_sample(run->output.probes, false);
}

/* Evaluates the first rates of a new run, takes the totals that its drifts are measured against, and writes
 * its state as that of step 0. */
static kith_status begin(struct run *run) {
  struct kith_integrator *it = &run->simulation->integrator;
  run->first_step = it->step;
  it->summarizes = true;
  if (first_rank(run)) kith_simulation_warn(run->simulation);
  if (first_rank(run) && !run->options->quiet) warn_of_cores(run->ranks);
  kith_status status = KITH_OK;
  if (run->restart == NULL) KITH_STAGE(status, run->profile, "comparison", compare_start(run));
  KITH_TRY(status);
  run->started = run->saved = kith_seconds();
  run->cpu_started = cpu_seconds();
  if (run->restart == NULL) KITH_TRY(kith_simulation_start(run->simulation));
  run->first_updates = it->ledger.updates;
  run->first_pairs = run->simulation->package.pair_evaluations;
  if (run->restart != NULL) return KITH_OK;
  run->baseline = kith_conservation_baseline_of(&it->summary.totals);
  KITH_STAGE(status, run->profile, "comparison", measure_start(run));
  KITH_TRY(status);
  KITH_STAGE(status, run->profile, "output", write_start(run));
  return status;
}

/* Writes a checkpoint of now, before which all tables are on the disk. */
static kith_status save(struct run *run) {
  run->saved = kith_seconds();
  KITH_TRY(kith_ranks_allreduce_status(run->ranks, run->simulation->integrator.pending));
  return kith_output_checkpoint(&run->output, run->simulation, &run->baseline);
}

static bool finished(const struct run *run) {
  const struct kith_integrator *it = &run->simulation->integrator;
  return it->time >= run->until || (run->options->steps >= 0 && it->step >= (uint64_t)run->options->steps) ||
         run->stopped;
}

enum { STOP, SAVE };
_Static_assert((int)SAVE < (int)KITH_WISHES, "room for what a run asks");

static kith_status after_step(struct run *run) {
  struct kith_integrator *it = &run->simulation->integrator;
  kith_conservation_baseline_update(&run->baseline, run->simulation, &it->summary.totals);
  it->pending = kith_history_row(&run->output.history, run->simulation);
  KITH_TRY(sample_growth(run));
  KITH_TRY(kith_contacts_sample(run->output.contacts));
  KITH_TRY(kith_probes_sample(run->output.probes, finished(run)));
  if (it->time > run->next_snapshot - 1e-9 * run->scene->output.every) KITH_TRY(write_snapshot(run));
  const int steps_between = run->scene->output.checkpoint;
  if (it->wish[SAVE] > 0 || (steps_between > 0 && it->step % (uint64_t)steps_between == 0)) return save(run);
  return KITH_OK;
}

/* Asks for a stop or a checkpoint. A signal may have reached some ranks only, so each may ask; clocks differ,
 * so that of rank 0 counts. */
static void ask(void *context, double wish[KITH_WISHES]) {
  struct run *run = context;
  const struct kith_options *o = run->options;
  const double now = kith_seconds(), minutes = run->scene->output.checkpoint_minutes;
  run->slowest = KITH_MAX(run->slowest, now - run->begun);
  const bool late = o->walltime > 0 && now - run->entered + 2 * run->slowest > 60 * o->walltime;
  wish[STOP] = kith_signals_stop() || (first_rank(run) && late);
  wish[SAVE] = first_rank(run) && minutes > 0 && now - run->saved > 60 * minutes;
}

static kith_status steps(struct run *run) {
  struct kith_integrator *it = &run->simulation->integrator;
  run->progress = (struct progress){
      .shown = !run->options->quiet && first_rank(run), .from = it->time, .started = kith_seconds()};
  const struct kith_traffic before = kith_ranks_traffic(run->ranks);
  if (run->progress.shown)
    fprintf(stderr, "%8s  %-12s %-11s %-14s %12s %10s %6s  %s\n", "step", "time", "dt", "limited by", "node",
            "ghosts", "done", "ETA");
  it->ask = ask, it->asker = run;
  while (!finished(run)) {
    run->begun = kith_seconds();
    run->next_snapshot = kith_output_next(run->scene, it->time);
    KITH_TRY(kith_simulation_step(run->simulation,
                                  kith_output_step_end(run->scene, run->next_snapshot, run->until)));
    run->stopped = it->wish[STOP] > 0;
    kith_profile_begin(run->profile, "output");
    KITH_TRY(after_step(run));
    show_progress(run, finished(run));
    kith_profile_end(run->profile);
    run->updates += it->nodes->n_internal;
    run->slowest = KITH_MAX(run->slowest, kith_seconds() - run->begun);
  }
  const struct kith_traffic now = kith_ranks_traffic(run->ranks);
  run->traffic = (struct kith_traffic){now.messages - before.messages, now.bytes - before.bytes,
                                       now.collectives - before.collectives};
  return kith_ranks_allreduce_status(run->ranks, it->pending);
}

/* ---- end ---- */

/* Writes the last state: first the checkpoint, since the last snapshot is not one of a longer run. */
static kith_status write_state(struct run *run) {
  const double time = run->simulation->integrator.time;
  if (run->scene->output.checkpoint_at_end || run->stopped) KITH_TRY(save(run));
  if (run->output.n_snapshots == 0 || run->output.times[run->output.n_snapshots - 1] < time)
    KITH_TRY(write_snapshot(run));
  const bool compared = run->scene->exact.ops != NULL || run->scene->output.plot || measures(run->scene);
  return compared ? kith_compared_take(&run->compared) : KITH_OK;
}

static kith_status compare(const struct run *run, struct kith_report *report) {
  const struct kith_profile_view view = kith_compared_view(&run->compared);
  report->compared = run->scene->exact.ops != NULL;
  if (report->compared)
    KITH_TRY(kith_norms_measure(&report->norms, run->scene->exact.ops, run->scene->exact.solution,
                                report->time, &run->scene->exact.window, &view));
  measure(run, run->baseline.measure, report->measure);
  return KITH_OK;
}

static double updates(const struct run *run) {
  const struct kith_integrator *it = &run->simulation->integrator;
  return it->nodes->activity != NULL ? (double)(it->ledger.updates - run->first_updates) : run->updates;
}

/* Prints in one piece, since other ranks may print, too. */
static void print_restart_command(const struct run *run) {
  char path[640], word[4 * sizeof path];
  snprintf(path, sizeof path, "%s/checkpoint.kith", run->output.directory);
  FILE *text = fmemopen(word, sizeof word, "w");
  if (text != NULL) kith_text_word(text, path);
  if (text == NULL || fclose(text) != 0) snprintf(word, sizeof word, "%s", path);
  fprintf(stderr, "kith: stopped; go on with the same command and --restart %s\n", word);
}

static kith_status finish(struct run *run) {
  const struct kith_integrator *it = &run->simulation->integrator;
  struct kith_report *report = &run->report;
  const bool first = first_rank(run);
  kith_status status;
  char path[640];
  KITH_STAGE(status, run->profile, "output", write_state(run));
  KITH_TRY(status);
  kith_report_collect(report, run->simulation, &run->baseline, &run->provenance, updates(run),
                      (double)(run->simulation->package.pair_evaluations - run->first_pairs),
                      kith_seconds() - run->started, cpu_seconds() - run->cpu_started);
  KITH_STAGE(status, run->profile, "comparison", compare(run, report));
  KITH_TRY(status);
  kith_profile_begin(run->profile, "pictures");
  if (run->scene->output.plot)
    kith_compared_draw(&run->compared, run->output.directory, NULL, report->compared ? &report->norms : NULL);
  if (run->scene->output.plot && first && draw_tables(run) != KITH_OK)
    fprintf(stderr, "kith: warning: %s\n", kith_failure());
  kith_profile_end(run->profile);
  KITH_TRY(kith_report_detail_ranks(report, run->simulation, &run->traffic, it->step - run->first_step,
                                    run->output.history.largest_imbalance));
  if (first && !kith_profile_is_whole(run->profile))
    fputs("kith: warning: times of some stages are missing for want of memory\n", stderr);
  report->program_seconds = kith_seconds() - run->entered;
  snprintf(path, sizeof path, "%s/report.json", run->output.directory);
  KITH_TRY(kith_ranks_allreduce_status(run->ranks, first ? kith_report_write(report, path) : KITH_OK));
  if (run->options->trace != NULL) KITH_TRY(kith_trace_write(run->ranks, run->profile, run->options->trace));
  if (!first) return KITH_OK;
  kith_report_print(report, run->options->profile, stdout);
  printf("results in %s\n", run->output.directory);
  if (run->stopped)
    print_restart_command(run);
  else
    kith_fom_print(&report->fom);
  return KITH_OK;
}

/* Prints the last failure, once. Ranks that do not know of it would wait for this one: then all end here. */
static enum kith_exit print_failure(const struct run *run, enum kith_exit code) {
  const bool agreed = kith_ranks_status_is_shared(run->ranks);
  if (!agreed) fprintf(stderr, "kith: rank %d: %s\n", kith_ranks_rank(run->ranks), kith_failure());
  if (!agreed) kith_ranks_abort(run->ranks, code);
  if (first_rank(run)) fprintf(stderr, "kith: %s\n", kith_failure());
  return code;
}

/* Writes a snapshot of the node that failed, if it is known, with its neighbors. Collective. */
static void write_offenders(struct run *run, int64_t id, char *where, size_t size) {
  bool written = false;
  if (id < 0) return;
  if (kith_output_offenders(&run->output, run->simulation, id, &written) == KITH_OK && written)
    snprintf(where, size, ", that of node %lld and its neighbors in offenders.hdf", (long long)id);
}

/* Prints the reason, and writes a snapshot of where it happened, unless it is writing that failed. */
static enum kith_exit fail(struct run *run, kith_status status) {
  const struct kith_integrator *it = &run->simulation->integrator;
  const bool writing = status == KITH_BAD_FILE || status == KITH_NO_MEMORY;
  const int64_t failed = kith_failed_node();
  char reason[2048], where[640] = "", nearby[80] = "";
  snprintf(reason, sizeof reason, "%s", kith_failure());
  if (!writing && kith_ranks_status_is_shared(run->ranks) &&
      kith_output_snapshot(&run->output, run->simulation) == KITH_OK)
    snprintf(where, sizeof where, "; its state is in %.540s/snapshot_%04d.hdf", run->output.directory,
             run->output.n_snapshots - 1);
  if (where[0] != '\0') write_offenders(run, failed, nearby, sizeof nearby);
  if (!kith_ranks_status_is_shared(run->ranks)) return print_failure(run, KITH_EXIT_FAILED);
  if (run->options->trace != NULL &&
      kith_trace_write(run->ranks, run->profile, run->options->trace) != KITH_OK && first_rank(run))
    fprintf(stderr, "kith: warning: %s\n", kith_failure());
  if (first_rank(run))
    fprintf(stderr, "kith: %s %llu, time %.9g: %s%s%s\n", writing ? "after step" : "step",
            (unsigned long long)it->step + (writing ? 0 : 1), it->time, reason, where, nearby);
  return KITH_EXIT_FAILED;
}

static enum kith_exit carry_out(struct run *run) {
  kith_status status = begin(run);
  kith_signals_catch();
  if (status == KITH_OK) status = steps(run);
  if (status != KITH_OK) return fail(run, status);
  if (finish(run) != KITH_OK) return print_failure(run, KITH_EXIT_FAILED);
  return run->stopped ? KITH_EXIT_FAILED : KITH_EXIT_OK;
}

/* The checkpoint that --restart names; of a directory that in it. NULL: none. */
static const char *find_checkpoint(const char *named, char inside[1024]) {
  struct stat found;
  if (named == NULL || stat(named, &found) != 0 || !S_ISDIR(found.st_mode)) return named;
  snprintf(inside, 1024, "%s/checkpoint.kith", named);
  return inside;
}

/* Starts mpirun and waits: this process does no more than that. */
static enum kith_exit launch(const struct kith_options *options) {
  enum kith_exit code = KITH_EXIT_FAILED;
  if (options->ranks > kith_ranks_most()) {
    fprintf(stderr, "kith: --ranks %d: this program was built without MPI\n", options->ranks);
    return KITH_EXIT_USAGE;
  }
  const kith_status status = kith_signals_launch(options->ranks, options->arguments, &code);
  if (status != KITH_OK) fprintf(stderr, "kith: %s\n", kith_failure());
  return status == KITH_BAD_INPUT ? KITH_EXIT_USAGE : code;
}

enum kith_exit kith_run(const struct kith_options *options) {
  char inside[1024];
  struct run run = {.options = options,
                    .restart = find_checkpoint(options->restart, inside),
                    .entered = kith_seconds() - kith_process_age()};
  if (options->ranks > 1 && kith_launched() == 1) return launch(options);
  kith_signals_ignore();
  kith_json_watch();
  kith_status status = join_ranks(&run.ranks, options);
  if (status == KITH_OK) status = prepare(&run);
  const enum kith_exit refused = status == KITH_NO_MEMORY ? KITH_EXIT_FAILED : KITH_EXIT_USAGE;
  enum kith_exit code = status == KITH_OK ? carry_out(&run) : print_failure(&run, refused);
  if (kith_output_close(&run.output) != KITH_OK && code == KITH_EXIT_OK) {
    fprintf(stderr, "kith: %s\n", kith_failure());
    code = KITH_EXIT_FAILED;
  }
  kith_report_clear(&run.report);
  kith_free(&run.provenance.command);
  kith_compared_clear(&run.compared);
  kith_simulation_destroy(&run.simulation);
  kith_profile_destroy(&run.profile);
  kith_scene_destroy(&run.scene);
  kith_ranks_destroy(&run.ranks);
  return code;
}
