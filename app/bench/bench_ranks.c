/* Strong and weak scaling: runs as child processes, beside what the scaling model predicts. */
#include "app/bench/bench_ranks.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "app/plan/calibration.h"
#include "app/plan/forecast.h"
#include "app/cli/process.h"
#include "app/cli/version.h"
#include "lib/io/atomic_file.h"

enum { REPEATS = 3, MOST_CASES = 48, STEPS = 10 };

/* Of a run: name, key of its report. */
#define MEASURED_LIST(X)                               \
  X(steps, "steps")                                    \
  X(nodes, "nodes")                                    \
  X(lifecycles, "ledger.lifecycles")                   \
  X(created, "ranks_detail.remote_ghosts_created")     \
  X(bytes, "ranks_detail.bytes_per_step.mean")         \
  X(messages, "ranks_detail.messages_per_step.mean")   \
  X(mean_nodes, "ranks_detail.nodes.mean")             \
  X(most_nodes, "ranks_detail.nodes.max")              \
  X(mean_entries, "ranks_detail.row_entries.mean")     \
  X(most_entries, "ranks_detail.row_entries.max")      \
  X(compute, "ranks_detail.compute_cpu_seconds.max")   \
  X(exchange, "ranks_detail.exchange_cpu_seconds.min") \
  X(wall, "stages.step.seconds")

struct measured {
#define X(name, key) double name;
  MEASURED_LIST(X)
#undef X
};

struct bench_case {
  bool weak;
  int ranks;
  double resolution;
  struct measured run; /* compute, exchange and wall: of a step, the least of the runs */
  struct kith_forecast plan;
};

/* Seconds. */
struct fitted {
  double work, ghost, local, byte;
};

struct bench {
  const struct kith_options *options;
  struct kith_programs programs;
  char scene[2 * KITH_PATH], directory[KITH_PATH];
  int n_cases, cores;
  struct bench_case cases[MOST_CASES];
  struct fitted costs;
};

/* ---- cases ---- */

/* 1, 2, 4 .. N; lattices and centers may need a resolution that is even. */
static void list_cases(struct bench *b, double resolution) {
  const int most = b->options->ranks;
  for (int weak = 0; weak < 2; ++weak)
    for (int r = 1; r <= most; r = r < most && 2 * r > most ? most : 2 * r) {
      const double part = pow((double)r / most, 1.0 / NDIM);
      b->cases[b->n_cases++] = (struct bench_case){
          .weak = weak, .ranks = r, .resolution = weak ? 2 * round(0.5 * part * resolution) : resolution};
    }
}

/* ---- runs ---- */

/* The words of a run are joined by newlines, which no word has, and cut again. */
static kith_status start_run(const struct bench *b, const struct bench_case *c, const char *directory) {
  const struct kith_options *o = b->options;
  char *text = NULL, log[2 * KITH_PATH + 16], *words[2 * KITH_MAX_OVERRIDES + 32];
  size_t size;
  int n = 0, code = 0;
  FILE *f = open_memstream(&text, &size);
  if (f == NULL) KITH_FAIL(NO_MEMORY, "no memory for the words of a run");
  fprintf(f, "%s%dd\nrun\n%s\n--set\ndimension=%d\n", b->programs.prefix, NDIM, b->scene, NDIM);
  for (int k = 0; k < o->n_overrides; ++k) fprintf(f, "--set\n%s\n", o->overrides[k]);
  fprintf(f, "--set\nresolution=%.10g\n--set\noutput.plot=false\n--ranks\n%d\n--steps\n%ld\n", c->resolution,
          c->ranks, o->steps > 0 ? o->steps : STEPS);
  fprintf(f, "--threads\n1\n--quiet\n--profile\n-o\n%s", directory);
  fclose(f);
  for (char *rest = text; rest != NULL;) words[n++] = strsep(&rest, "\n");
  words[n] = NULL;
  snprintf(log, sizeof log, "%s.log", directory);
  const kith_status status = kith_process_run(words, log, 0, &code);
  free(text);
  if (status == KITH_OK && code != 0)
    KITH_FAIL(DIVERGED, "%s on %d ranks ended with code %d: see %s", b->scene, c->ranks, code, log);
  return status;
}

static kith_status read_run(const char *directory, struct measured *out) {
  char path[2 * KITH_PATH + 16];
  snprintf(path, sizeof path, "%s/report.json", directory);
#define X(name, key) KITH_TRY(kith_report_number(path, key, &out->name));
  MEASURED_LIST(X)
#undef X
  out->compute /= out->steps, out->exchange /= out->steps, out->wall /= out->steps;
  return KITH_OK;
}

static kith_status run_case(const struct bench *b, struct bench_case *c) {
  char directory[2 * KITH_PATH];
  snprintf(directory, sizeof directory, "%s/%s-%d", b->directory, c->weak ? "weak" : "strong", c->ranks);
  for (int k = 0; k < REPEATS; ++k) {
    struct measured run;
    KITH_TRY(start_run(b, c, directory));
    KITH_TRY(read_run(directory, &run));
    if (k > 0) {
      run.compute = fmin(run.compute, c->run.compute);
      run.exchange = fmin(run.exchange, c->run.exchange);
      run.wall = fmin(run.wall, c->run.wall);
    }
    c->run = run;
  }
  return KITH_OK;
}

/* ---- predictions ---- */

/* Neighbor lists of a step; remote ghosts that a rank creates for one; busiest rank over the mean. */
static double lists_of(const struct measured *m) {
  return (m->lifecycles - 1) / m->steps;
}
static double created_of(const struct bench_case *c) {
  return c->run.created / c->run.lifecycles / c->ranks;
}
static double imbalance_of(const struct measured *m) {
  return (m->most_nodes + m->most_entries) / (m->mean_nodes + m->mean_entries);
}

static kith_status forecast(const struct bench *b, struct bench_case *c, struct kith_simulation *m) {
  const struct kith_costs none = {.network = b->options->network};
  struct kith_step_traffic traffic;
  struct kith_scaling_model *model = NULL;
  KITH_TRY(kith_simulation_start(m));
  KITH_TRY(kith_step_traffic(m, fmin(lists_of(&c->run), m->integrator.evaluations), &traffic));
  KITH_TRY(kith_scaling_model_create(&model, m, c->ranks));
  const kith_status status =
      kith_scaling_model_forecast(model, m->scene->partition.name, &traffic, &none, &c->plan);
  kith_scaling_model_destroy(&model);
  return status;
}

static kith_status plan_case(const struct bench *b, struct bench_case *c) {
  struct kith_scene *scene = NULL;
  struct kith_simulation *m = NULL;
  kith_status status = kith_scene_at_resolution(&scene, b->scene, b->options, c->resolution);
  if (status == KITH_OK) status = kith_simulation_create(&m, scene, NULL, false);
  if (status == KITH_OK) status = forecast(b, c, m);
  kith_simulation_destroy(&m);
  kith_scene_destroy(&scene);
  return status;
}

/* From the strong runs on 1 and 2 ranks, which come first. What comes out below zero is noise. */
static void fit(struct bench *b) {
  const struct bench_case *one = &b->cases[0], *two = &b->cases[1];
  struct fitted *f = &b->costs;
  f->work = one->run.compute / one->plan.work;
  f->local = one->run.exchange / one->run.nodes;
  f->ghost = fmax(0, (two->run.compute - f->work * two->plan.work) / two->plan.most_made);
  f->byte = fmax(0, (two->run.exchange - f->local * two->run.nodes / 2) / two->plan.most_bytes);
}

static double compute_of(const struct bench *b, const struct bench_case *c) {
  return b->costs.work * c->plan.work + b->costs.ghost * c->plan.most_made;
}

static double step_of(const struct bench *b, const struct bench_case *c) {
  return compute_of(b, c) + b->costs.local * c->run.nodes / c->ranks + b->costs.byte * c->plan.most_bytes;
}

/* ---- tables ---- */

/* "-" where there is nothing to compare. */
static const char *per_cent(char text[16], double predicted, double measured) {
  if (measured > 0)
    snprintf(text, 16, "%+.1f", 100 * (predicted / measured - 1));
  else
    snprintf(text, 16, "-");
  return text;
}

static const char *kind(const struct bench_case *c) {
  return c->weak ? "weak" : "strong";
}

static void print_counts(const struct bench *b, FILE *f) {
  char error[2][16];
  fprintf(f, "\n| %-6s | %5s | %8s | %8s | %8s | %5s | %9s | %9s | %5s | %6s | %6s | %6s | %6s |\n", "",
          "ranks", "nodes", "ghosts", "measured", "%", "KiB sent", "measured", "%", "mess.", "meas.",
          "imbal.", "meas.");
  fprintf(f, "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (int k = 0; k < b->n_cases; ++k) {
    const struct bench_case *c = &b->cases[k];
    fprintf(f, "| %-6s | %5d | %8.0f | %8.0f | %8.0f | %5s ", kind(c), c->ranks, c->run.nodes, c->plan.made,
            created_of(c), per_cent(error[0], c->plan.made, created_of(c)));
    fprintf(f, "| %9.1f | %9.1f | %5s | %6.1f | %6.1f | %6.3f | %6.3f |\n", c->plan.bytes / 1024,
            c->run.bytes / 1024, per_cent(error[1], c->plan.bytes, c->run.bytes), c->plan.messages,
            c->run.messages, c->plan.imbalance, imbalance_of(&c->run));
  }
}

static void print_seconds(const struct bench *b, FILE *f) {
  fprintf(f, "\n| %-6s | %5s | %10s | %10s | %5s | %10s | %10s | %5s | %10s |\n", "", "ranks", "compute ms",
          "measured", "%", "step ms", "measured", "%", "efficiency");
  fprintf(f, "|---|---|---|---|---|---|---|---|---|\n");
  for (int k = 0; k < b->n_cases; ++k) {
    const struct bench_case *c = &b->cases[k], *one = &b->cases[0];
    const bool fits = c->ranks <= b->cores, source = !c->weak && c->ranks <= 2;
    const double compute = compute_of(b, c), step = step_of(b, c), alone = step_of(b, one);
    char error[2][16], wall[16] = "-";
    if (fits) snprintf(wall, sizeof wall, "%.2f", 1e3 * c->run.wall);
    fprintf(f, "| %-6s | %5d | %10.2f | %10.2f | %5s | %10.2f | %10s | %5s | %10.3f |\n", kind(c), c->ranks,
            1e3 * compute, 1e3 * c->run.compute, source ? "fit" : per_cent(error[0], compute, c->run.compute),
            1e3 * step, wall, fits ? per_cent(error[1], step, c->run.wall) : "-",
            alone * c->run.nodes / one->run.nodes / c->ranks / step);
  }
}

static void print_costs(const struct bench *b, FILE *f) {
  const struct fitted *c = &b->costs;
  const struct bench_case *two = &b->cases[1];
  const double sent = two->plan.most_bytes / two->plan.most_made;
  fprintf(f,
          "\nCosts of this session: a node or row entry %.2f ns; own ghosts and lists, per node, %.0f ns;\n"
          "a remote ghost %.0f ns of computing; a byte sent for it (%.0f are) %.3f ns, from the\n"
          "search to the last copy. In all a remote ghost costs as much as %.1f row entries (plans: %.0f).\n",
          1e9 * c->work, 1e9 * c->local, 1e9 * c->ghost, sent, 1e9 * c->byte,
          (c->ghost + c->byte * sent) / c->work, KITH_GHOST_WORK);
}

static void print_all(const struct bench *b, FILE *f) {
  const char *slash = strrchr(b->scene, '/');
  fprintf(f, "kith %s, %s; %s, one thread a rank, %d cores\n", kith_version(), kith_build_text(),
          slash != NULL ? slash + 1 : b->scene, b->cores);
  fputs(
      "\nPredicted, then measured. Remote ghosts: created for neighbor lists, of the mean rank; KiB and\n"
      "messages: sent by the mean rank in a step; imbalance: nodes and row entries, busiest over mean.\n",
      f);
  print_counts(b, f);
  fputs(
      "\nCompute: processor time of the busiest rank in stages where none waits; step: wall time, measured\n"
      "only where every rank has a core; fit: what the costs were taken from. Efficiency: of the predicted\n"
      "step, nodes per second and rank over those of 1 rank.\n",
      f);
  print_seconds(b, f);
  print_costs(b, f);
}

/* ---- the bench ---- */

static kith_status prepare(struct bench *b) {
  const struct kith_options *o = b->options;
  struct kith_scene *scene = NULL;
  KITH_TRY(kith_programs_find(&b->programs));
  if (o->subject != NULL)
    snprintf(b->scene, sizeof b->scene, "%s", o->subject);
  else
    snprintf(b->scene, sizeof b->scene, "%s/sedov.yaml", b->programs.inputs);
  snprintf(b->directory, sizeof b->directory, "%s", o->directory != NULL ? o->directory : "out/bench-ranks");
  KITH_TRY(kith_scene_at_resolution(&scene, b->scene, o, 0));
  list_cases(b, scene->resolution);
  kith_scene_destroy(&scene);
  b->cores = omp_get_num_procs();
  setenv("OMP_NUM_THREADS", "1", 1);
  setenv("OMP_PROC_BIND", "false", 1); /* else all ranks sit on the first core */
  omp_set_num_threads(1);
  return kith_directory_make(b->directory);
}

/* Weak on N ranks is strong on N ranks. */
static bool known(const struct bench *b, struct bench_case *c) {
  for (const struct bench_case *d = b->cases; d < c; ++d)
    if (d->ranks == c->ranks && d->resolution == c->resolution) {
      c->run = d->run, c->plan = d->plan;
      return true;
    }
  return false;
}

static kith_status run_all(struct bench *b) {
  for (int k = 0; k < b->n_cases; ++k) {
    struct bench_case *c = &b->cases[k];
    if (known(b, c)) continue;
    if (!b->options->quiet)
      fprintf(stderr, "kith: %s, %d rank%s, resolution %.10g\n", kind(c), c->ranks, c->ranks > 1 ? "s" : "",
              c->resolution);
    KITH_TRY(run_case(b, c));
    KITH_TRY(plan_case(b, c));
  }
  return KITH_OK;
}

static kith_status write_tables(const struct bench *b) {
  char path[KITH_PATH + 16];
  struct kith_atomic_file *file;
  snprintf(path, sizeof path, "%s/scaling.md", b->directory);
  KITH_TRY(kith_atomic_file_open(&file, path));
  print_all(b, file->stream);
  return kith_atomic_file_commit(&file, false);
}

enum kith_exit kith_bench_ranks(const struct kith_options *options) {
  struct bench *b = NULL;
  enum kith_exit code = KITH_EXIT_USAGE;
  kith_status status = kith_resize(&b, 0, 1, sizeof *b);
  if (status == KITH_OK) b->options = options, status = prepare(b);
  if (status == KITH_OK) code = KITH_EXIT_FAILED, status = run_all(b);
  if (status == KITH_OK) {
    fit(b);
    print_all(b, stdout);
    status = write_tables(b);
  }
  if (status == KITH_OK)
    printf("\nresults in %s\n", b->directory), code = KITH_EXIT_OK;
  else
    fprintf(stderr, "kith: %s\n", kith_failure());
  kith_free(&b);
  return code;
}
