#include "app/run.h"

#include <math.h>
#include <omp.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include "app/launch.h"
#include "app/output.h"
#include "app/plot.h"
#include "app/report.h"
#include "app/screen.h"
#include "app/stage_times.h"
#include "app/trace.h"
#include "app/version.h"
#include "lib/domain/migrate.h"
#include "lib/io/atomic_file.h"

struct run {
  const struct kith_options *options;
  struct kith_ranks *ranks; /* NULL: one process */
  struct kith_scene *scene;
  struct kith_profile *profile;
  struct kith_model *model;
  struct kith_output output;
  struct kith_origin origin;
  struct kith_screen screen;
  struct kith_nodes *whole; /* at the end, on rank 0: all nodes; NULL: they are the model's */
  void *exact;              /* solution, NULL without one */
  struct kith_stage_times stage_times;
  struct kith_ranks_detail ranks_detail;
  struct kith_traffic before_steps, after_steps;
  double until, started, cpu_started;
  uint64_t first_step;
  bool stopped; /* by a signal */
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

/* Of all nodes, which are on rank 0: the fields have their names from kith_hydro_init. */
static struct kith_profile_view view_of(const struct run *run) {
  const struct kith_nodes *nodes = run->whole != NULL ? run->whole : run->model->nodes;
#define VALUES(name) kith_nodes_field_named(nodes, name)->f64
  return (struct kith_profile_view){nodes->n_internal, VALUES("position"), VALUES("velocity"), VALUES("mass"),
                                    VALUES("density"), VALUES("pressure"), VALUES("energy")};
#undef VALUES
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
  const struct kith_profile_view view = view_of(run);
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

static bool speaks(const struct run *run) {
  return kith_ranks_rank(run->ranks) == 0;
}

/* Rank 0 writes; all know where. */
static kith_status open_output(struct run *run) {
  const struct kith_options *o = run->options;
  char directory[256];
  snprintf(directory, sizeof directory, "out/%s", run->scene->name);
  const char *where = o->directory != NULL ? o->directory : directory;
  snprintf(run->output.directory, sizeof run->output.directory, "%s", where);
  if (!speaks(run)) return KITH_OK;
  KITH_TRY(kith_output_directory(&run->output, where));
  if (o->trace != NULL) KITH_TRY(try_file(o->trace));
  return kith_output_open(&run->output, run->model, o->restart != NULL);
}

/* The scene and its nodes: the same on every rank, which then keeps its own. */
static kith_status lay_out(struct run *run) {
  const struct kith_options *o = run->options;
  if (o->subject == NULL) KITH_FAIL(BAD_INPUT, "run: no scene; for example: kith run inputs/sod.yaml");
  KITH_TRY(kith_scene_read(&run->scene, o->subject, o->n_overrides, o->overrides));
  run->until = o->until >= 0 ? o->until : run->scene->until;
  KITH_TRY(kith_scene_lasts(run->scene, run->until));
  KITH_TRY(kith_profile_create(&run->profile, omp_get_max_threads(), o->trace != NULL));
  if (o->profile) kith_profile_clock_cpu(run->profile);
  if (run->scene->exact.ops != NULL)
    KITH_TRY(run->scene->exact.ops->create(&run->exact, &run->scene->exact.parameters));
  KITH_TRY(kith_model_create(&run->model, run->scene, run->profile, o->check));
  return kith_model_share(run->model, run->ranks);
}

/* Everything that can be found wrong before the first step. */
static kith_status prepare(struct run *run) {
  const char *restart = run->options->restart;
  KITH_TRY(kith_ranks_agree(run->ranks, lay_out(run)));
  kith_profile_align(run->profile); /* all leave the agreement together */
  if (restart != NULL) KITH_TRY(kith_output_restore(&run->output, restart, run->model, &run->origin));
  return kith_ranks_agree(run->ranks, open_output(run));
}

static bool measures(const struct run *run) {
  bool wanted = false;
  for (int k = 0; k < KITH_N_MEASURES; ++k) wanted = wanted || run->scene->measure.wanted[k];
  return wanted;
}

/* Of the start, by rank 0. */
static kith_status measure_start(struct run *run) {
  if (!measures(run)) return KITH_OK;
  if (run->ranks != NULL) KITH_TRY(kith_nodes_gather(run->model->nodes, &run->whole));
  const kith_status status = speaks(run) ? measure(run, NULL, run->origin.measure) : KITH_OK;
  kith_nodes_destroy(&run->whole);
  return kith_ranks_agree(run->ranks, status);
}

/* First rates of a new run, and what its drifts are measured by. */
static kith_status begin(struct run *run) {
  struct kith_integrator *it = &run->model->integrator;
  run->started = kith_seconds();
  run->cpu_started = cpu_seconds();
  run->first_step = it->step;
  if (speaks(run)) kith_model_warn(run->model);
  if (run->options->restart != NULL) return KITH_OK;
  KITH_TRY(kith_model_start(run->model));
  const struct kith_totals first = kith_hydro_totals(&run->model->hydro);
  run->origin = kith_origin_of(&first);
  KITH_TRY(measure_start(run));
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
  KITH_TRY(kith_output_balance(&run->output, run->model));
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

/* A signal may have reached some ranks only. */
static bool finished(struct run *run) {
  const struct kith_integrator *it = &run->model->integrator;
  run->stopped = kith_ranks_any(run->ranks, stop_signal != 0);
  return it->time >= run->until || (run->options->steps >= 0 && it->step >= (uint64_t)run->options->steps) ||
         run->stopped;
}

static kith_status steps(struct run *run) {
  struct kith_integrator *it = &run->model->integrator;
  kith_screen_init(&run->screen, stderr, run->options->quiet || !speaks(run), it->time, run->until);
  run->before_steps = kith_ranks_traffic(run->ranks);
  for (bool end = finished(run); !end;) {
    KITH_TRY(kith_integrator_step(it, landing(run)));
    KITH_TRY(after_step(run));
    end = finished(run);
    kith_screen_step(&run->screen, it, end);
  }
  run->after_steps = kith_ranks_traffic(run->ranks);
  return KITH_OK;
}

/* ---- end ---- */

enum { LEDGER_ENTRIES = 48 };

/* What only a run of several ranks has to tell: sums over them, but for what they do together. */
static int rank_entries(const struct run *run, struct kith_report_entry *entry) {
  const struct kith_share *share = run->model->share;
  const struct kith_traffic traffic = kith_ranks_traffic(run->ranks);
  if (share == NULL) return 0;
  const int distributed = run->model->boundaries.n - 1; /* it comes last */
  const struct kith_ledger *ledger = &run->model->integrator.ledger;
  uint64_t sum[] = {share->migrated, traffic.messages, traffic.bytes, ledger->boundary[distributed].created,
                    ledger->boundary[distributed].kept};
  kith_ranks_sum_counts(run->ranks, sum, 5);
  const struct kith_report_entry entries[] = {
      {"nodes_migrated", (double)sum[0]},      {"messages", (double)sum[1]},
      {"message_bytes", (double)sum[2]},       {"remote_ghosts_created", (double)sum[3]},
      {"remote_ghosts_kept", (double)sum[4]},  {"collective_calls", (double)traffic.collectives},
      {"balance_looks", (double)share->looks}, {"repartitions", (double)share->repartitions},
      {"work_imbalance", share->seen},         {"cells", (double)share->cells.n}};
  memcpy(entry, entries, sizeof entries);
  return (int)(sizeof entries / sizeof entries[0]);
}

static int ledger_entries(const struct run *run, struct kith_report_entry entry[LEDGER_ENTRIES]) {
  const struct kith_ledger all = kith_ledger_of_all(&run->model->integrator.ledger, run->ranks), *l = &all;
  uint64_t done[] = {run->model->package.support_iterations, run->model->package.fallbacks};
  struct kith_bytes bytes[KITH_MODEL_STRUCTURES];
  kith_model_bytes(run->model, bytes);
  kith_ranks_sum_counts(run->ranks, done, 2);
  const struct kith_report_entry counts[] = {
      {"lifecycles", (double)l->lifecycles},   {"rebuilds_for_support", (double)l->support_rebuilds},
      {"reorders", (double)l->reorders},       {"evaluations", (double)l->evaluations},
      {"rejected_steps", (double)l->rejected}, {"refreshes", (double)l->refreshes},
      {"ghosts_created", (double)l->created},  {"ghosts_culled", (double)l->culled},
      {"ghosts_kept", (double)l->kept},        {"candidates", (double)l->candidates},
      {"row_entries", (double)l->row_entries}, {"pairs", (double)l->pairs},
      {"support_iterations", (double)done[0]}, {"gradient_fallbacks", (double)done[1]}};
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
  for (int k = 0; k < KITH_MODEL_STRUCTURES; ++k) {
    double sum = (double)bytes[k].bytes;
    kith_ranks_sum(run->ranks, &sum, 1);
    entry[n++] = (struct kith_report_entry){names[k], sum};
  }
  return n + rank_entries(run, entry + n);
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
  const double n_steps = (double)(it->step - run->first_step);
  double sum[] = {(double)m->nodes->n_internal, (double)it->ledger.last_entries,
                  (double)m->package.pair_evaluations, cpu_seconds() - run->cpu_started};
  kith_ranks_sum(run->ranks, sum, 4);
  const double n = sum[0];
  *r = (struct kith_report){.scene = run->scene->name,
                            .package = m->package.ops->name,
                            .kernel = kith_kernel_facts[m->package.kernel].name,
                            .scheme = it->scheme->name,
                            .dimension = NDIM,
                            .ranks = kith_ranks_size(run->ranks),
                            .threads = omp_get_max_threads(),
                            .nodes = (uint64_t)n,
                            .steps = it->step,
                            .time = it->time,
                            .wall_seconds = kith_seconds() - run->started,
                            .cpu_seconds = sum[3],
                            .pairs_per_node = 0.5 * sum[1] / fmax(n, 1),
                            .pair_evaluations = sum[2],
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

/* Collective. The checkpoint comes first: the last snapshot is not one that a longer run would write. */
static kith_status write_state(struct run *run) {
  const double time = run->model->integrator.time;
  if (run->scene->output.checkpoint_at_end || run->stopped)
    KITH_TRY(kith_output_checkpoint(&run->output, run->model, &run->origin));
  if (run->output.n_snapshots == 0 || run->output.times[run->output.n_snapshots - 1] < time)
    KITH_TRY(kith_output_snapshot(&run->output, run->model));
  const bool looked_at = run->exact != NULL || run->scene->output.plot || measures(run);
  return run->ranks != NULL && looked_at ? kith_nodes_gather(run->model->nodes, &run->whole) : KITH_OK;
}

/* By rank 0. */
static kith_status write_results(struct run *run, struct kith_report *report) {
  char path[640];
  const struct kith_profile_view view = view_of(run);
  const double time = run->model->integrator.time;
  if (run->exact != NULL) {
    KITH_TRY(kith_norms_measure(&report->norms, run->scene->exact.ops, run->exact, time,
                                &run->scene->exact.window, &view));
    report->compared = true;
  }
  report->measured = run->scene->measure.wanted;
  KITH_TRY(measure(run, run->origin.measure, report->measure));
  snprintf(path, sizeof path, "%s/report.json", run->output.directory);
  KITH_TRY(kith_report_write(report, path));
  return KITH_OK;
}

/* How the ranks shared the work. */
static kith_status look_at_ranks(struct run *run, struct kith_report *report) {
  KITH_TRY(kith_stage_times(run->ranks, run->profile, &run->stage_times));
  KITH_TRY(kith_ranks_detail(run->model, &run->before_steps, &run->after_steps,
                             run->model->integrator.step - run->first_step, &run->ranks_detail));
  if (run->ranks != NULL) report->stage_times = &run->stage_times;
  report->ranks_detail = &run->ranks_detail;
  return KITH_OK;
}

static void print_profile(const struct run *run, const struct kith_report *report) {
  if (!run->options->profile) return;
  if (run->ranks == NULL) {
    kith_profile_print(run->profile, stdout,
                       (double)report->nodes * (double)(report->steps - run->first_step));
    return;
  }
  kith_stage_times_print(&run->stage_times, run->profile, stdout);
  kith_ranks_detail_print(&run->ranks_detail, stdout);
}

/* A picture is no reason to lose a run. */
static void picture(const struct run *run, const struct kith_report *report) {
  if (!run->scene->output.plot) return;
  const struct kith_plot plot = {.scene = run->scene->name,
                                 .time = report->time,
                                 .resolution = run->scene->resolution,
                                 .nodes = view_of(run),
                                 .exact = run->exact != NULL ? run->scene->exact.ops : NULL,
                                 .solution = run->exact,
                                 .norms = report->compared ? &report->norms : NULL};
  if (kith_plot_write(&plot, run->output.directory) != KITH_OK ||
      kith_plot_draw(run->output.directory) != KITH_OK)
    fprintf(stderr, "kith: warning: no picture: %s\n", kith_failure());
}

/* The last failure, said once. If the other ranks do not know of it they wait for this one: then all end here. */
static enum kith_exit complain(const struct run *run, enum kith_exit code) {
  const bool agreed = kith_ranks_agreed(run->ranks);
  if (!agreed) fprintf(stderr, "kith: rank %d: %s\n", kith_ranks_rank(run->ranks), kith_failure());
  if (!agreed) kith_ranks_abort(run->ranks, code);
  if (speaks(run)) fprintf(stderr, "kith: %s\n", kith_failure());
  return code;
}

static enum kith_exit end(struct run *run) {
  struct kith_report report;
  struct kith_report_entry ledger[LEDGER_ENTRIES];
  kith_screen_end(&run->screen);
  fill_report(run, &report, ledger);
  kith_status status = look_at_ranks(run, &report);
  if (status == KITH_OK) status = write_state(run);
  if (status != KITH_OK) return complain(run, KITH_EXIT_FAILED);
  if (speaks(run)) status = write_results(run, &report);
  status = kith_ranks_agree(run->ranks, status);
  if (status == KITH_OK && run->options->trace != NULL)
    status = kith_trace_write(run->ranks, run->profile, run->options->trace);
  if (status != KITH_OK) return complain(run, KITH_EXIT_FAILED);
  if (!speaks(run)) return run->stopped ? KITH_EXIT_FAILED : KITH_EXIT_OK;
  picture(run, &report);
  kith_report_print(&report, stdout);
  print_profile(run, &report);
  printf("results in %s\n", run->output.directory);
  if (run->stopped)
    fprintf(stderr, "kith: stopped by signal %d; go on with --restart %s/checkpoint.kith\n", (int)stop_signal,
            run->output.directory);
  return run->stopped ? KITH_EXIT_FAILED : KITH_EXIT_OK;
}

/* The reason, and a snapshot of where it happened, unless it is writing that failed. */
static enum kith_exit fail(struct run *run, kith_status status) {
  char reason[1024], where[640] = "";
  snprintf(reason, sizeof reason, "%s", kith_failure());
  kith_screen_end(&run->screen);
  if (!kith_ranks_agreed(run->ranks)) return complain(run, KITH_EXIT_FAILED);
  const struct kith_integrator *it = &run->model->integrator;
  const bool writing = status == KITH_BAD_FILE || status == KITH_NO_MEMORY;
  const kith_status kept = writing ? KITH_OK : kith_output_snapshot(&run->output, run->model);
  if (kept != KITH_OK && !kith_ranks_agreed(run->ranks)) return complain(run, KITH_EXIT_FAILED);
  if (!writing && kept == KITH_OK)
    snprintf(where, sizeof where, "; its state is in %.540s/snapshot_%04d.hdf", run->output.directory,
             run->output.n_snapshots - 1);
  if (!speaks(run)) return KITH_EXIT_FAILED;
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
  kith_status status = kith_launch(&run.ranks, options);
  if (status == KITH_OK) status = prepare(&run);
  if (status == KITH_OK)
    code = go(&run);
  else
    complain(&run, code);
  if (kith_output_close(&run.output) != KITH_OK && code == KITH_EXIT_OK) {
    fprintf(stderr, "kith: %s\n", kith_failure());
    code = KITH_EXIT_FAILED;
  }
  if (run.exact != NULL) run.scene->exact.ops->destroy(&run.exact);
  kith_nodes_destroy(&run.whole);
  kith_stage_times_clear(&run.stage_times);
  kith_model_destroy(&run.model);
  kith_profile_destroy(&run.profile);
  kith_scene_destroy(&run.scene);
  kith_ranks_destroy(&run.ranks);
  return code;
}
