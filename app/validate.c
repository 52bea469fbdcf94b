#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* setenv, strtok_r */
#endif
#include "app/validate.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "app/config.h"
#include "app/front.h"
#include "app/process.h"
#include "app/validate_rows.h"
#include "app/validate_same.h"
#include "lib/core/profile.h"
#include "lib/io/atomic_file.h"

enum { MOST_WORDS = 300, PATH = KITH_PATH };

/* One pass through a suite. */
struct validation {
  const char *directory;
  struct kith_programs programs;
  int n;
  struct kith_row *rows;     /* owned */
  bool quick;                /* only those rows */
  char last[96], before[96]; /* the last two runs: their directories below `directory` */
  int n_compared, n_same;    /* with another row */
  int width;                 /* of a name */
  int n_errors;              /* of the rows so far that have a resolution, for orders */
  double *error, *resolution;
  int dimension;     /* of the last run */
  double seconds[4]; /* by dimension */
  FILE *table;
};

/* --- one run --- */

/* Runs the scene of a row into DIR/`name`. `more`: options parted by blanks. */
static kith_status run(const struct validation *v, const struct kith_row *row, const char *name,
                       const char *more) {
  char program[PATH + 8], scene[PATH + 80], out[PATH], log[PATH + 8], settings[600], options[PATH + 64];
  char *words[MOST_WORDS], *rest;
  int n = 0, code;
  snprintf(program, sizeof program, "%s%dd", v->programs.prefix, row->dimension);
  snprintf(scene, sizeof scene, "%s/%s.yaml", v->programs.inputs, row->scene);
  snprintf(out, sizeof out, "%s/%s", v->directory, name);
  snprintf(log, sizeof log, "%s.log", out);
  snprintf(settings, sizeof settings, "dimension=%d output.plot=false %s", row->dimension, row->settings);
  snprintf(options, sizeof options, "%s", more);
  words[n++] = program, words[n++] = "run", words[n++] = scene, words[n++] = "--quiet", words[n++] = "-o",
  words[n++] = out;
  for (char *word = strtok_r(settings, " ", &rest); word != NULL && n < MOST_WORDS - 8;
       word = strtok_r(NULL, " ", &rest))
    words[n++] = "--set", words[n++] = word;
  for (char *word = strtok_r(options, " ", &rest); word != NULL && n < MOST_WORDS - 1;
       word = strtok_r(NULL, " ", &rest))
    words[n++] = word;
  words[n] = NULL;
  KITH_TRY(kith_process_run(words, log, 0, &code));
  if (code != 0) KITH_FAIL(DIVERGED, "the run failed with code %d, see %s", code, log);
  return KITH_OK;
}

/* --- what is measured --- */

static kith_status report_value(const struct validation *v, const char *run_name, const char *key,
                                double *value) {
  char path[PATH + 80];
  snprintf(path, sizeof path, "%s/%s/report.json", v->directory, run_name);
  return kith_report_number(path, key, value);
}

static kith_status shock(const struct validation *v, double *value) {
  double radius, exact;
  KITH_TRY(report_value(v, v->last, "norms.shock_radius", &radius));
  KITH_TRY(report_value(v, v->last, "norms.shock_exact", &exact));
  *value = fabs(radius / exact - 1);
  return KITH_OK;
}

/* `A / B`, or one key. */
static kith_status of_report(const struct validation *v, const char *measure, double *value) {
  char key[96];
  double by;
  const char *slash = strstr(measure, " / ");
  if (slash == NULL) return report_value(v, v->last, measure, value);
  snprintf(key, sizeof key, "%.*s", (int)(slash - measure), measure);
  KITH_TRY(report_value(v, v->last, key, value));
  KITH_TRY(report_value(v, v->last, slash + strlen(" / "), &by));
  *value /= by;
  return KITH_OK;
}

/* Column 3 of balance.csv; the first look is at a map that was made before anything was measured. */
static kith_status balance(const struct validation *v, double *value) {
  char path[PATH + 160], line[256];
  double seen;
  int looks = 0;
  snprintf(path, sizeof path, "%s/%s/balance.csv", v->directory, v->last);
  FILE *file = fopen(path, "r");
  if (file == NULL) KITH_FAIL(BAD_FILE, "%s: cannot read: nobody looked at the balance", path);
  *value = 0;
  while (fgets(line, sizeof line, file) != NULL)
    if (sscanf(line, "%*[^,],%*[^,],%lf", &seen) == 1 && ++looks > 1) *value = fmax(*value, seen);
  fclose(file);
  if (looks < 2) KITH_FAIL(BAD_FILE, "%s: %d looks at the balance, wanted two", path, looks);
  return KITH_OK;
}

static kith_status same_norms(const struct validation *v, double *value) {
  static const char *const keys[] = {"norms.density.l1", "norms.velocity.l1", "norms.pressure.l1",
                                     "norms.density_peak"};
  *value = 0;
  for (size_t k = 0; k < sizeof keys / sizeof *keys; ++k) {
    double a, b;
    KITH_TRY(report_value(v, v->before, keys[k], &a));
    KITH_TRY(report_value(v, v->last, keys[k], &b));
    *value = fmax(*value, fabs(a / b - 1));
  }
  return KITH_OK;
}

static kith_status open_both(const char *a, const char *b, FILE *file[2]) {
  file[0] = fopen(a, "r"), file[1] = fopen(b, "r");
  if (file[0] != NULL && file[1] != NULL) return KITH_OK;
  for (int k = 0; k < 2; ++k)
    if (file[k] != NULL) fclose(file[k]);
  KITH_FAIL(BAD_FILE, "%s or %s: cannot read", a, b);
}

static kith_status different_bytes(const char *a, const char *b, double *value) {
  FILE *file[2];
  KITH_TRY(open_both(a, b, file));
  *value = 0;
  for (int x = 0, y = 0; x != EOF || y != EOF; *value += x != y) x = getc(file[0]), y = getc(file[1]);
  fclose(file[0]);
  fclose(file[1]);
  return KITH_OK;
}

/* Cuts a line of history after the momentum (what follows is counted by process), and takes out what limited
 * the step (after a restart it says so). */
static void keep_physics(char *line) {
  char *comma[32] = {NULL};
  int n = 0;
  for (char *c = line; (c = strchr(c, ',')) != NULL && n < 32; ++c) comma[n++] = c;
  if (n < 12) return;
  *comma[n - 5] = '\0';
  memmove(comma[2], comma[3], strlen(comma[3]) + 1);
}

static kith_status different_lines(const char *a, const char *b, double *value) {
  FILE *file[2];
  char line[2][1024];
  KITH_TRY(open_both(a, b, file));
  *value = 0;
  for (bool more = true; more;) {
    const bool x = fgets(line[0], sizeof line[0], file[0]) != NULL,
               y = fgets(line[1], sizeof line[1], file[1]) != NULL;
    if (x && y) {
      keep_physics(line[0]);
      keep_physics(line[1]);
    }
    *value += x != y || (x && strcmp(line[0], line[1]) != 0);
    more = x || y;
  }
  fclose(file[0]);
  fclose(file[1]);
  return KITH_OK;
}

static kith_status threads(const struct validation *v, const struct kith_row *row, double *value) {
  char name[2][112], path[2][PATH + 160];
  for (int k = 0; k < 2; ++k) {
    snprintf(name[k], sizeof name[k], "%s-%d", row->name, k + 1);
    snprintf(path[k], sizeof path[k], "%s/%s/checkpoint.kith", v->directory, name[k]);
    KITH_TRY(run(v, row, name[k],
                 k == 0 ? "--set output.checkpoint_at_end=true --threads 1"
                        : "--set output.checkpoint_at_end=true --threads 2"));
  }
  return different_bytes(path[0], path[1], value);
}

static kith_status restart(const struct validation *v, const struct kith_row *row, double *value) {
  char whole[112], parts[112], more[PATH + 240], path[2][PATH + 160];
  snprintf(whole, sizeof whole, "%s-whole", row->name);
  snprintf(parts, sizeof parts, "%s-parts", row->name);
  snprintf(more, sizeof more, "--set output.checkpoint_at_end=true --steps %d", row->number);
  KITH_TRY(run(v, row, whole, "--set output.checkpoint_at_end=true"));
  KITH_TRY(run(v, row, parts, more));
  snprintf(more, sizeof more, "--set output.checkpoint_at_end=true --restart %s/%s/checkpoint.kith",
           v->directory, parts);
  KITH_TRY(run(v, row, parts, more));
  snprintf(path[0], sizeof path[0], "%s/%s/history.csv", v->directory, whole);
  snprintf(path[1], sizeof path[1], "%s/%s/history.csv", v->directory, parts);
  return different_lines(path[0], path[1], value);
}

/* --- the same as another row --- */

/* The last file that a run's list of snapshots names: older runs may have left more. */
static kith_status last_snapshot(const struct validation *v, const char *run_name, char path[PATH + 400]) {
  struct kith_config *series = NULL;
  snprintf(path, PATH + 400, "%s/%s/snapshots.hdf.series", v->directory, run_name);
  KITH_TRY(kith_config_read(&series, path));
  const struct kith_config_node *files = kith_config_at(series, "files");
  const struct kith_config_node *name = files == NULL ? NULL : kith_config_child(files->last, "name");
  if (name != NULL)
    snprintf(path, PATH + 400, "%s/%s/%.250s", v->directory, run_name, name->text);
  else
    kith_fail(KITH_BAD_FILE, "%s: no snapshot", path);
  kith_config_destroy(&series);
  return name != NULL ? KITH_OK : KITH_BAD_FILE;
}

/* Connectivity in one number: entries of all rows of all ranks, over the whole run. */
static kith_status compare_rows(const struct validation *v, const struct kith_row *row,
                                struct kith_same *same) {
  double entries[2];
  KITH_TRY(report_value(v, row->like, "ledger.row_entries", &entries[0]));
  KITH_TRY(report_value(v, v->last, "ledger.row_entries", &entries[1]));
  if (entries[0] != entries[1]) *same = (struct kith_same){INFINITY, "rows"};
  return KITH_OK;
}

static kith_status compare(const struct validation *v, const struct kith_row *row, struct kith_same *same) {
  char path[2][PATH + 400];
  *same = (struct kith_same){.difference = NAN};
  if (row->like[0] == '\0') return KITH_OK;
  KITH_TRY(last_snapshot(v, row->like, path[0]));
  KITH_TRY(last_snapshot(v, v->last, path[1]));
  KITH_TRY(kith_same_snapshots(path[0], path[1], row->tolerance > 0, same));
  return row->tolerance > 0 ? KITH_OK : compare_rows(v, row, same);
}

/* --- rows --- */

/* Runs the scene of the row, if it has one, and keeps what orders need. */
static kith_status run_row(struct validation *v, const struct kith_row *row) {
  char more[64] = "";
  const int threads = row->threads > 0 ? row->threads : row->quick ? 1 : 0;
  if (row->dimension == 0) return KITH_OK;
  if (threads > 0) snprintf(more, sizeof more, "--threads %d", threads);
  if (row->ranks > 1) snprintf(more + strlen(more), sizeof more - strlen(more), " --ranks %d", row->ranks);
  KITH_TRY(run(v, row, row->name, more));
  snprintf(v->before, sizeof v->before, "%s", v->last);
  snprintf(v->last, sizeof v->last, "%s", row->name);
  v->dimension = row->dimension;
  return KITH_OK;
}

static kith_status measure_value(struct validation *v, const struct kith_row *row, double *value) {
  KITH_TRY(of_report(v, row->measure, value));
  const char *resolution = strstr(row->settings, "resolution=");
  if (resolution == NULL) return KITH_OK;
  v->error[v->n_errors] = *value;
  v->resolution[v->n_errors++] = strtod(resolution + strlen("resolution="), NULL);
  return KITH_OK;
}

static kith_status measure(struct validation *v, const struct kith_row *row, double *value) {
  if (row->kind == KITH_ROW_THREADS) return threads(v, row, value);
  if (row->kind == KITH_ROW_RESTART) return restart(v, row, value);
  KITH_TRY(run_row(v, row));
  if (row->kind == KITH_ROW_SHOCK) return shock(v, value);
  if (row->kind == KITH_ROW_SAME_NORMS) return same_norms(v, value);
  if (row->kind == KITH_ROW_BALANCE) return balance(v, value);
  if (row->kind == KITH_ROW_NOTHING) return KITH_OK;
  if (row->kind == KITH_ROW_VALUE) return measure_value(v, row, value);
  const int first = KITH_MAX(v->n_errors - row->number, 0);
  *value = kith_order(v->n_errors - first, v->resolution + first, v->error + first);
  return KITH_OK;
}

/* What the report says of the last run, NaN if there is none: for the table. */
static double said(const struct validation *v, const struct kith_row *row, const char *key) {
  double value;
  const bool ran = row->kind != KITH_ROW_THREADS && row->kind != KITH_ROW_RESTART && v->last[0] != '\0';
  return ran && report_value(v, v->last, key, &value) == KITH_OK ? value : NAN;
}

/* What a row has come to. */
struct outcome {
  double value, seconds;
  struct kith_same same; /* NaN: not asked */
  bool failed, good;
};

static void print_row(const struct validation *v, const struct kith_row *row, const struct outcome *o) {
  char gate[32] = "";
  const bool least = !isnan(row->at_least);
  if (row->kind != KITH_ROW_NOTHING)
    snprintf(gate, sizeof gate, "%s %-10.4g", least ? ">=" : "<=", least ? row->at_least : row->at_most);
  printf("%-*s %12.5g  %-13s %-6s %9.1e %7.0f %7.1f s", v->width, row->name, o->value, gate,
         o->good ? "ok" : "FAILED", said(v, row, "energy_drift"), said(v, row, "floors"), o->seconds);
  if (o->same.difference == 0) printf("  same as %s", row->like);
  if (o->same.difference > 0)
    printf("  %s %s %s%.2g in %s", o->same.difference <= row->tolerance ? "same as" : "DIFFERS FROM",
           row->like, o->same.difference <= row->tolerance ? "to " : "by ", o->same.difference,
           o->same.field);
  putchar('\n');
}

static void put_row(const struct validation *v, const struct kith_row *row, const struct outcome *o) {
  static const char *const also[] = {"norms.density.l1", "norms.velocity.l1", "norms.pressure.l1",
                                     "energy_drift",     "momentum_drift",    "floors"};
  const bool least = !isnan(row->at_least);
  fprintf(v->table, "%s,%.17g,%s,%.17g,%s,%.3f,\"%s\"", row->name, o->value,
          least ? ">=" : "<=", least ? row->at_least : row->at_most, o->good ? "ok" : "FAILED", o->seconds,
          row->source);
  for (size_t k = 0; k < sizeof also / sizeof *also; ++k) fprintf(v->table, ",%.17g", said(v, row, also[k]));
  fprintf(v->table, ",%d,%d,%s,%s,%.17g\n", KITH_MAX(row->ranks, 1), row->threads, row->varied, row->like,
          o->same.difference);
}

static bool is_good(const struct kith_row *row, const struct outcome *o) {
  const bool measured = row->kind == KITH_ROW_NOTHING ||
                        (isnan(row->at_most) ? o->value >= row->at_least : o->value <= row->at_most);
  return !o->failed && measured && !(o->same.difference > row->tolerance);
}

/* false: out of tolerance, or it failed (*failed). */
static bool do_row(struct validation *v, const struct kith_row *row, bool *failed) {
  struct outcome o = {.value = NAN, .same.difference = NAN};
  const double begun = kith_seconds();
  o.failed = measure(v, row, &o.value) != KITH_OK || compare(v, row, &o.same) != KITH_OK;
  o.good = is_good(row, &o);
  o.seconds = kith_seconds() - begun;
  char why[256];
  snprintf(why, sizeof why, "%s", kith_failure());
  print_row(v, row, &o);
  put_row(v, row, &o);
  if (o.failed) printf("    %s\n", why);
  fflush(stdout);
  v->seconds[row->dimension > 0 ? row->dimension : v->dimension] += o.seconds;
  v->n_compared += row->like[0] != '\0';
  v->n_same += o.same.difference <= row->tolerance;
  *failed = o.failed;
  return o.good;
}

static enum kith_exit do_rows(struct validation *v) {
  int wrong = 0, failures = 0, n = 0;
  v->width = 28;
  for (int k = 0; k < v->n; ++k) v->width = KITH_MAX(v->width, (int)strlen(v->rows[k].name));
  printf("%-*s %12s  %-13s %-6s %9s %7s\n", v->width, "row", "measured", "gate", "", "drift", "floors");
  for (int k = 0; k < v->n; ++k) {
    bool failed;
    if (v->quick && !v->rows[k].quick) continue;
    ++n;
    if (!do_row(v, &v->rows[k], &failed)) ++wrong;
    failures += failed;
  }
  printf("%d rows, %d out of tolerance%s; 1-D %.0f s, 2-D %.0f s, 3-D %.0f s\n", n, wrong,
         failures > 0 ? ", and some runs failed" : "", v->seconds[1], v->seconds[2], v->seconds[3]);
  if (v->n_compared > 0)
    printf("%d of %d runs end in the same state as the row they are compared with\n", v->n_same,
           v->n_compared);
  return failures > 0 ? KITH_EXIT_FAILED : wrong > 0 ? KITH_EXIT_TOLERANCE : KITH_EXIT_OK;
}

/* --- suites --- */

/* quick and full are of targets.yaml; other names are files beside it, or paths. */
static kith_status find(struct validation *v, const char *suite, char path[PATH + 160]) {
  v->quick = strcmp(suite, "quick") == 0;
  const bool path_given = strchr(suite, '/') != NULL || strchr(suite, '.') != NULL;
  const char *name = v->quick || strcmp(suite, "full") == 0 ? "targets" : suite;
  if (path_given)
    snprintf(path, PATH + 160, "%s", suite);
  else
    snprintf(path, PATH + 160, "%s/validation/%.100s.yaml", v->programs.inputs, name);
  if (!path_given && access(path, R_OK) != 0)
    KITH_FAIL(BAD_INPUT, "validate: no suite '%.60s'; quick, full, gates, ranks, list, or a file of rows",
              suite);
  return kith_rows_read_file(&v->rows, &v->n, path);
}

static enum kith_exit list(const struct validation *v) {
  puts(
      "quick  1-D and small 2-D runs, minutes\nfull   every line of the table of targets\n"
      "gates  what must hold for each package, with the exemptions that are known\n"
      "ranks  runs of 1 to 8 processes against one: the same bits, balance, ghosts; minutes\n");
  for (int k = 0; k < v->n; ++k) {
    const struct kith_row *row = &v->rows[k];
    const bool least = !isnan(row->at_least);
    printf("%-5s  %-28s %s %-8.4g %s\n", row->quick ? "quick" : "full", row->name,
           least ? ">=" : "<=", least ? row->at_least : row->at_most, row->source);
  }
  return KITH_EXIT_OK;
}

static kith_status validate(struct validation *v, enum kith_exit *code) {
  char path[PATH];
  struct kith_atomic_file *file;
  KITH_TRY(kith_resize(&v->error, 0, (size_t)v->n, sizeof *v->error));
  KITH_TRY(kith_resize(&v->resolution, 0, (size_t)v->n, sizeof *v->resolution));
  KITH_TRY(kith_directory_make(v->directory));
  snprintf(path, sizeof path, "%s/validation.csv", v->directory);
  KITH_TRY(kith_atomic_file_open(&file, path));
  v->table = file->stream;
  fputs(
      "row,measured,relation,bound,verdict,seconds,source,density.l1,velocity.l1,pressure.l1,energy_drift,"
      "momentum_drift,floors,ranks,threads,varied,like,difference\n",
      v->table);
  *code = do_rows(v);
  return kith_atomic_file_commit(&file, false);
}

enum kith_exit kith_validate(const struct kith_options *options) {
  const char *suite = options->subject != NULL ? options->subject : "quick";
  const bool only_list = strcmp(suite, "list") == 0;
  struct validation v = {.directory = options->directory != NULL ? options->directory : "out/validate"};
  enum kith_exit code = KITH_EXIT_USAGE;
  char path[PATH + 160];
  kith_status status = kith_programs_find(&v.programs);
  if (status == KITH_OK) status = find(&v, only_list ? "full" : suite, path);
  if (status == KITH_OK && only_list) code = list(&v);
  if (status == KITH_OK && !only_list) {
    setenv("OMP_WAIT_POLICY", "passive", 0); /* small runs on few cores: who waits, sleeps */
    code = KITH_EXIT_FAILED;
    status = validate(&v, &code);
  }
  if (status != KITH_OK) fprintf(stderr, "kith: %s\n", kith_failure());
  kith_free(&v.rows);
  kith_free(&v.error);
  kith_free(&v.resolution);
  return code;
}
