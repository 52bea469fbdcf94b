#include "app/run.h"

#include <math.h>
#include <omp.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include "app/output.h"
#include "app/plot.h"
#include "app/report.h"
#include "app/screen.h"
#include "app/version.h"
#include "lib/io/atomic_file.h"

struct run {
  const struct kith_options *options;
  struct kith_scene *scene;
  struct kith_profile *profile;
  struct kith_model *model;
  struct kith_output output;
  struct kith_origin origin;
  struct kith_screen screen;
  void *exact; /* solution, NULL without one */
  double until, started, cpu_started;
  uint64_t first_step;
};

/* The one thing a signal can reach: checked between steps. */
static volatile sig_atomic_t stop_signal;

static void on_signal(int number) {
  stop_signal = number;
}

static void catch_signals(void) {
  struct sigaction action = {.sa_handler = on_signal, .sa_flags = SA_RESTART};
  sigaction(SIGINT, &action, NULL);
  sigaction(SIGTERM, &action, NULL);
  sigaction(SIGUSR1, &action, NULL);
  /* A file that may not grow further is an error of its write. */
  action.sa_handler = SIG_IGN;
  sigaction(SIGXFSZ, &action, NULL);
}

static double cpu_seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- what is looked at ---- */

static struct kith_profile_view view_of(const struct kith_model *m) {
  const struct kith_hydro *h = &m->hydro;
  return (struct kith_profile_view){m->nodes->n_internal, m->nodes->position->f64, h->velocity->f64,
                                    h->mass->f64,         h->density->f64,         h->pressure->f64,
                                    h->energy->f64};
}

static struct kith_measured measured_of(const struct run *run, const struct kith_profile_view *view) {
  struct kith_measured m = {.nodes = view,
                            .domain = run->scene->domain,
                            .time = run->model->integrator.time,
                            .kinetic_start = run->origin.totals.kinetic};
  memcpy(m.center, run->model->hydro.center, sizeof m.center);
  return m;
}

static kith_status measure(const struct run *run, const double *start, double *value) {
  const struct kith_profile_view view = view_of(run->model);
  struct kith_measured m = measured_of(run, &view);
  m.start = start;
  for (int k = 0; k < KITH_N_MEASURES; ++k)
    if (run->scene->measure.wanted[k]) KITH_TRY(kith_measure_take((enum kith_measure)k, &m, &value[k]));
  return KITH_OK;
}

/* ---- start ---- */

/* Can it be written? Better to know now than at the end. */
static kith_status try_file(const char *path) {
  struct kith_atomic_file *file;
  KITH_TRY(kith_atomic_file_open(&file, path));
  kith_atomic_file_abandon(&file);
  return KITH_OK;
}

static kith_status open_output(struct run *run) {
  const struct kith_options *o = run->options;
  char directory[256];
  snprintf(directory, sizeof directory, "out/%s", run->scene->name);
  KITH_TRY(kith_output_directory(&run->output, o->directory != NULL ? o->directory : directory));
  if (o->trace != NULL) KITH_TRY(try_file(o->trace));
  return kith_output_open(&run->output, run->model, o->restart != NULL);
}

/* Everything that can be found wrong before the first step. */
static kith_status prepare(struct run *run) {
  const struct kith_options *o = run->options;
  if (o->subject == NULL) KITH_FAIL(BAD_INPUT, "run: no scene; for example: kith run inputs/sod.yaml");
  KITH_TRY(kith_scene_read(&run->scene, o->subject, o->n_overrides, o->overrides));
  run->until = o->until >= 0 ? o->until : run->scene->until;
  KITH_TRY(kith_profile_create(&run->profile, omp_get_max_threads(), o->trace != NULL));
  if (run->scene->exact.ops != NULL)
    KITH_TRY(run->scene->exact.ops->create(&run->exact, &run->scene->exact.parameters));
  KITH_TRY(kith_model_create(&run->model, run->scene, run->profile, o->check));
  if (o->restart != NULL) KITH_TRY(kith_output_restore(&run->output, o->restart, run->model, &run->origin));
  return open_output(run);
}

/* First rates of a new run, and what its drifts are measured by. */
static kith_status begin(struct run *run) {
  struct kith_integrator *it = &run->model->integrator;
  run->started = kith_seconds();
  run->cpu_started = cpu_seconds();
  run->first_step = it->step;
  kith_model_warn(run->model);
  if (run->options->restart != NULL) return KITH_OK;
  KITH_TRY(kith_model_start(run->model));
  const struct kith_totals first = kith_hydro_totals(&run->model->hydro);
  run->origin = kith_origin_of(&first);
  KITH_TRY(measure(run, NULL, run->origin.measure));
  KITH_TRY(kith_output_snapshot(&run->output, run->model));
  run->output.next = run->scene->output.every;
  return KITH_OK;
}

/* ---- steps ---- */

/* The next moment that a step must land on. */
static double landing(const struct run *run) {
  const double every = run->scene->output.every;
  if (every <= 0 || run->output.next > run->until - 1e-9 * every)
    return run->until; /* no crumb between the two */
  return run->output.next;
}

static kith_status after_step(struct run *run) {
  const struct kith_integrator *it = &run->model->integrator;
  const struct kith_totals totals = kith_hydro_totals(&run->model->hydro);
  kith_origin_follow(&run->origin, run->model, &totals);
  KITH_TRY(kith_output_step(&run->output, run->model, &totals));
  const double every = run->scene->output.every;
  if (every > 0 && it->time > run->output.next - 1e-9 * every) {
    KITH_TRY(kith_output_snapshot(&run->output, run->model));
    run->output.next += every;
  }
  const int steps_between = run->scene->output.checkpoint;
  if (steps_between > 0 && it->step % (uint64_t)steps_between == 0)
    KITH_TRY(kith_output_checkpoint(&run->output, run->model, &run->origin));
  return KITH_OK;
}

static bool finished(const struct run *run) {
  const struct kith_integrator *it = &run->model->integrator;
  return it->time >= run->until || (run->options->steps >= 0 && it->step >= (uint64_t)run->options->steps) ||
         stop_signal != 0;
}

static kith_status steps(struct run *run) {
  struct kith_integrator *it = &run->model->integrator;
  kith_screen_init(&run->screen, stderr, run->options->quiet, it->time, run->until);
  while (!finished(run)) {
    KITH_TRY(kith_integrator_step(it, landing(run)));
    KITH_TRY(after_step(run));
    kith_screen_step(&run->screen, it, finished(run));
  }
  return KITH_OK;
}

/* ---- end ---- */

enum { LEDGER_ENTRIES = 32 };

static int ledger_entries(const struct run *run, struct kith_report_entry entry[LEDGER_ENTRIES]) {
  const struct kith_ledger *l = &run->model->integrator.ledger;
  const struct kith_package *p = &run->model->package;
  struct kith_bytes bytes[KITH_MODEL_STRUCTURES];
  kith_model_bytes(run->model, bytes);
  const struct kith_report_entry counts[] = {{"lifecycles", (double)l->lifecycles},
                                             {"rebuilds_for_support", (double)l->support_rebuilds},
                                             {"reorders", (double)l->reorders},
                                             {"evaluations", (double)l->evaluations},
                                             {"rejected_steps", (double)l->rejected},
                                             {"refreshes", (double)l->refreshes},
                                             {"ghosts_created", (double)l->created},
                                             {"ghosts_culled", (double)l->culled},
                                             {"ghosts_kept", (double)l->kept},
                                             {"candidates", (double)l->candidates},
                                             {"row_entries", (double)l->row_entries},
                                             {"pairs", (double)l->pairs},
                                             {"support_iterations", (double)p->support_iterations},
                                             {"gradient_fallbacks", (double)p->fallbacks}};
  int n = (int)(sizeof counts / sizeof counts[0]);
  memcpy(entry, counts, sizeof counts);
#define X(name) "rebuilds_because_" #name,
  static const char *const because[] = {"rebuilds_because_first_build", KITH_REBUILD_LIST(X)};
#undef X
  for (size_t k = 0; k < sizeof because / sizeof because[0]; ++k)
    entry[n++] = (struct kith_report_entry){because[k], (double)l->because[k]};
  static const char *const names[KITH_MODEL_STRUCTURES] = {"bytes_nodes",        "bytes_search",
                                                           "bytes_connectivity", "bytes_package",
                                                           "bytes_pairwise",     "bytes_integrator"};
  for (int k = 0; k < KITH_MODEL_STRUCTURES; ++k)
    entry[n++] = (struct kith_report_entry){names[k], (double)bytes[k].bytes};
  return n;
}

/* What the flow did, from the start of the run to now. */
static void fill_flow(const struct run *run, struct kith_report *r) {
  const struct kith_origin *origin = &run->origin;
  const struct kith_totals now = kith_hydro_totals(&run->model->hydro);
  r->energy_drift = origin->energy_drift;
  r->momentum_drift = origin->momentum_drift;
  r->angular_momentum_drift = origin->angular_drift;
  r->kinetic.start = origin->totals.kinetic;
  r->kinetic.end = now.kinetic;
  r->kinetic.rebound = origin->totals.kinetic > 0 ? origin->kinetic_rebound / origin->totals.kinetic : NAN;
  r->velocity_over_sound.largest = origin->velocity_over_sound;
  r->velocity_over_sound.end = now.velocity_over_sound;
}

static void fill_report(struct run *run, struct kith_report *r, struct kith_report_entry *ledger) {
  const struct kith_model *m = run->model;
  const struct kith_integrator *it = &m->integrator;
  const double n = (double)m->nodes->n_internal, n_steps = (double)(it->step - run->first_step);
  *r = (struct kith_report){.scene = run->scene->name,
                            .package = m->package.ops->name,
                            .kernel = kith_kernel_facts[m->package.kernel].name,
                            .scheme = it->scheme->name,
                            .dimension = NDIM,
                            .ranks = 1,
                            .threads = omp_get_max_threads(),
                            .nodes = (uint64_t)m->nodes->n_internal,
                            .steps = it->step,
                            .time = it->time,
                            .wall_seconds = kith_seconds() - run->started,
                            .cpu_seconds = cpu_seconds() - run->cpu_started,
                            .pairs_per_node = 0.5 * (double)it->ledger.last_entries / fmax(n, 1),
                            .pair_evaluations = (double)m->package.pair_evaluations,
                            .rejected = it->ledger.rejected,
                            .version = kith_version(),
                            .compiler = kith_compiler(),
                            .flags = kith_flags()};
  fill_flow(run, r);
  r->node_updates_per_second = n * n_steps / fmax(r->wall_seconds, 1e-9);
  r->n_stages = kith_profile_stages(run->profile, &r->stages);
  r->n_ledger = ledger_entries(run, ledger);
  r->ledger = ledger;
}

static kith_status write_results(struct run *run, struct kith_report *report) {
  char path[640];
  const struct kith_profile_view view = view_of(run->model);
  const double time = run->model->integrator.time;
  /* The checkpoint comes first: the last snapshot is not one that a longer run would write. */
  if (run->scene->output.checkpoint_at_end || stop_signal != 0)
    KITH_TRY(kith_output_checkpoint(&run->output, run->model, &run->origin));
  if (run->output.n_snapshots == 0 || run->output.times[run->output.n_snapshots - 1] < time)
    KITH_TRY(kith_output_snapshot(&run->output, run->model));
  if (run->exact != NULL) {
    KITH_TRY(kith_norms_measure(&report->norms, run->scene->exact.ops, run->exact, time,
                                &run->scene->exact.window, &view));
    report->compared = true;
  }
  report->measured = run->scene->measure.wanted;
  KITH_TRY(measure(run, run->origin.measure, report->measure));
  snprintf(path, sizeof path, "%s/report.json", run->output.directory);
  KITH_TRY(kith_report_write(report, path));
  if (run->options->trace != NULL) KITH_TRY(kith_profile_write_trace(run->profile, run->options->trace));
  return KITH_OK;
}

/* A picture is no reason to lose a run. */
static void picture(const struct run *run, const struct kith_report *report) {
  if (!run->scene->output.plot) return;
  const struct kith_plot plot = {.scene = run->scene->name,
                                 .time = report->time,
                                 .resolution = run->scene->resolution,
                                 .nodes = view_of(run->model),
                                 .exact = run->exact != NULL ? run->scene->exact.ops : NULL,
                                 .solution = run->exact,
                                 .norms = report->compared ? &report->norms : NULL};
  if (kith_plot_write(&plot, run->output.directory) != KITH_OK ||
      kith_plot_draw(run->output.directory) != KITH_OK)
    fprintf(stderr, "kith: warning: no picture: %s\n", kith_failure());
}

static enum kith_exit end(struct run *run) {
  struct kith_report report;
  struct kith_report_entry ledger[LEDGER_ENTRIES];
  kith_screen_end(&run->screen);
  fill_report(run, &report, ledger);
  if (write_results(run, &report) != KITH_OK) {
    fprintf(stderr, "kith: %s\n", kith_failure());
    return KITH_EXIT_FAILED;
  }
  picture(run, &report);
  kith_report_print(&report, stdout);
  if (run->options->profile)
    kith_profile_print(run->profile, stdout, (double)report.nodes * (double)(report.steps - run->first_step));
  printf("results in %s\n", run->output.directory);
  if (stop_signal != 0)
    fprintf(stderr, "kith: stopped by signal %d; go on with --restart %s/checkpoint.kith\n", (int)stop_signal,
            run->output.directory);
  return stop_signal != 0 ? KITH_EXIT_FAILED : KITH_EXIT_OK;
}

/* The reason, and a snapshot of where it happened, unless it is writing that failed. */
static enum kith_exit fail(struct run *run, kith_status status) {
  char reason[1024], where[640] = "";
  snprintf(reason, sizeof reason, "%s", kith_failure());
  kith_screen_end(&run->screen);
  const struct kith_integrator *it = &run->model->integrator;
  const bool writing = status == KITH_BAD_FILE || status == KITH_NO_MEMORY;
  if (!writing && kith_output_snapshot(&run->output, run->model) == KITH_OK)
    snprintf(where, sizeof where, "; its state is in %.540s/snapshot_%04d.hdf", run->output.directory,
             run->output.n_snapshots - 1);
  fprintf(stderr, "kith: %s %llu, time %.9g: %s%s\n", writing ? "after step" : "step",
          (unsigned long long)it->step + (writing ? 0 : 1), it->time, reason, where);
  return KITH_EXIT_FAILED;
}

static enum kith_exit go(struct run *run) {
  kith_status status = begin(run);
  if (status == KITH_OK) status = steps(run);
  return status == KITH_OK ? end(run) : fail(run, status);
}

enum kith_exit kith_run(const struct kith_options *options) {
  struct run run = {.options = options};
  enum kith_exit code = KITH_EXIT_USAGE;
  catch_signals();
  if (prepare(&run) == KITH_OK)
    code = go(&run);
  else
    fprintf(stderr, "kith: %s\n", kith_failure());
  if (kith_output_close(&run.output) != KITH_OK && code == KITH_EXIT_OK) {
    fprintf(stderr, "kith: %s\n", kith_failure());
    code = KITH_EXIT_FAILED;
  }
  if (run.exact != NULL) run.scene->exact.ops->destroy(&run.exact);
  kith_model_destroy(&run.model);
  kith_profile_destroy(&run.profile);
  kith_scene_destroy(&run.scene);
  return code;
}
