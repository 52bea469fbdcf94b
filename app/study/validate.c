/* validate.c - runs with their tolerances: `kith validate [SUITE|FILE]`; list() says which suites there are,
 * rows of one's own are as in validate_rows.h.
 *
 * One line per row on stdout, and, with norms and where the bound comes from, in DIR/validation.csv (-o,
 * out/validate by default); what the runs print is in DIR/ROW.log.
 *
 * Exit code: 0; 3 if a row is out of tolerance; 1 if a run failed or the results cannot be written; 2 for an
 * unknown suite, a wrong file or a directory that cannot be written to. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "app/scene/config.h"
#include "app/study/validate_rows.h"
#include "lib/core/profile.h"

enum { PATH = KITH_JOB_PATH };

/* One pass through a suite. */
struct validation {
  const char *directory;
  struct kith_programs programs;
  int n;
  struct kith_row *rows;     /* owned */
  bool quick;                /* only rows that are quick, of SUITE-quick */
  const char *last, *before; /* the last two that ran, by name; NULL: none */
  int n_compared, n_same;    /* rows compared with another one; of these, those that are the same */
  int n_done, n_wrong, n_failed;
  int width;                  /* of the column of names */
  int n_errors;               /* rows so far that have a resolution; from their values orders are computed */
  double *error, *resolution; /* [n_errors], with room for all rows; owned, one behind the other */
  int lock;                   /* of the directory; 0: none */
  struct kith_csv_log table;
};

/* Writes DIR/RUN/FILE and returns it. */
static const char *in_run(const struct validation *v, const char *run, const char *file, char path[PATH]) {
  snprintf(path, PATH, "%.700s/%s/%s", v->directory, run, file);
  return path;
}

/* Fails if a run has no results which a row needs: a report is the last that a run writes. */
static kith_status need(const struct validation *v, const char *run) {
  char path[PATH];
  if (access(in_run(v, run, "report.json", path), R_OK) == 0) return KITH_OK;
  KITH_FAIL(BAD_FILE, "no results of row %s: its run failed, or was not wanted", run);
}

/* Runs a row. What an earlier validation left of it is deleted: it must not pass for its results if it
 * fails. */
static kith_status run(const struct validation *v, const struct kith_row *row) {
  static const char *const left[] = {"report.json", "snapshots.hdf.series", "checkpoint.kith",
                                     "checkpoint.kith.previous"};
  char out[PATH], log[PATH + 8];
  struct kith_job job = row->job;
  struct kith_job_end end = {0};
  if (job.threads == 0 && row->quick) job.threads = 1;
  for (size_t k = 0; k < sizeof left / sizeof *left; ++k) unlink(in_run(v, row->job.label, left[k], out));
  if (row->restart[0] != '\0') {
    KITH_TRY(need(v, row->restart));
    in_run(v, row->restart, "checkpoint.kith", job.restart);
  }
  snprintf(out, sizeof out, "%.700s/%s", v->directory, row->job.label);
  snprintf(log, sizeof log, "%s.log", out);
  KITH_TRY(kith_job_run(&v->programs, &job, "run", out, log, 0, &end));
  if (end.code == 0) return KITH_OK;
  unlink(in_run(v, row->job.label, "report.json", out));
  KITH_FAIL(DIVERGED, "the run failed: %s; see %s", end.why, log);
}

static kith_status report_value(const struct validation *v, const char *run, const char *measure,
                                double *value) {
  char path[PATH];
  KITH_TRY(need(v, run));
  return kith_report_measure(in_run(v, run, "report.json", path), measure, value);
}

static kith_status same_norms(const struct validation *v, double *value) {
  static const char *const keys[] = {"norms.density.l1", "norms.velocity.l1", "norms.pressure.l1",
                                     "norms.density_peak"};
  *value = 0;
  if (v->before == NULL) KITH_FAIL(BAD_INPUT, "same norms as what: there is no run before");
  for (size_t k = 0; k < sizeof keys / sizeof *keys; ++k) {
    double a, b;
    KITH_TRY(report_value(v, v->before, keys[k], &a));
    KITH_TRY(report_value(v, v->last, keys[k], &b));
    *value = fmax(*value, fabs(a / b - 1));
  }
  return KITH_OK;
}

/* Finds the last snapshot in the list that a run has written. Older runs may have left more files. */
static kith_status last_snapshot(const struct validation *v, const char *label, char path[PATH]) {
  struct kith_config *series = NULL;
  KITH_TRY(need(v, label));
  KITH_TRY(kith_config_read(&series, in_run(v, label, "snapshots.hdf.series", path)));
  const struct kith_config_node *files = kith_config_at(series, "files");
  const struct kith_config_node *name = files == NULL ? NULL : kith_config_child(files->last, "name");
  const kith_status status = name != NULL ? KITH_OK : kith_fail(KITH_BAD_FILE, "%s: no snapshot", path);
  if (name != NULL) in_run(v, label, name->text, path);
  kith_config_destroy(&series);
  return status;
}

static kith_status compare(const struct validation *v, const struct kith_row *row,
                           struct kith_snapshot_diff *same) {
  char path[2][PATH];
  double entries[2];
  *same = (struct kith_snapshot_diff){.difference = NAN};
  if (row->like[0] == '\0') return KITH_OK;
  KITH_TRY(last_snapshot(v, row->like, path[0]));
  KITH_TRY(last_snapshot(v, v->last, path[1]));
  KITH_TRY(kith_snapshot_diff_files(path[0], path[1], row->tolerance > 0, same));
  if (row->tolerance > 0) return KITH_OK;
  /* Bitwise also in connectivity, as one number: entries of all rows of all ranks, over the whole run. */
  KITH_TRY(report_value(v, row->like, "ledger.row_entries", &entries[0]));
  KITH_TRY(report_value(v, v->last, "ledger.row_entries", &entries[1]));
  if (entries[0] != entries[1]) *same = (struct kith_snapshot_diff){INFINITY, "rows", same->reordered};
  return KITH_OK;
}

static kith_status order(const struct validation *v, int number, double *value) {
  const int first = v->n_errors - number;
  for (int k = first; k < v->n_errors; ++k)
    if (k < 0 || isnan(v->error[k])) KITH_FAIL(BAD_FILE, "one of the last %d values is missing", number);
  *value = kith_order(number, v->resolution + first, v->error + first);
  return KITH_OK;
}

static kith_status measure(struct validation *v, const struct kith_row *row, double *value) {
  kith_status status = KITH_OK;
  if (row->job.dimension > 0) {
    v->before = v->last, v->last = row->job.label; /* even if it fails: rows after it need this run, too */
    status = run(v, row);
  }
  if (status == KITH_OK && row->kind == KITH_ROW_SAME_NORMS) status = same_norms(v, value);
  if (status == KITH_OK && row->kind == KITH_ROW_ORDER) status = order(v, row->number, value);
  if (row->kind != KITH_ROW_VALUE) return status;
  if (status == KITH_OK) status = report_value(v, v->last, row->measure, value);
  const char *resolution = strstr(row->job.settings, "resolution=");
  if (resolution == NULL) return status;
  v->error[v->n_errors] = status == KITH_OK ? *value : NAN;
  v->resolution[v->n_errors++] = strtod(resolution + strlen("resolution="), NULL);
  return status;
}

/* A number of the last run's report, for the table; NaN if there is none. */
static double last_value(const struct validation *v, const char *key) {
  double value;
  return v->last != NULL && report_value(v, v->last, key, &value) == KITH_OK ? value : NAN;
}

struct outcome {
  double value, seconds;
  struct kith_snapshot_diff same; /* NaN: not required */
  bool failed, good;
};

/* What is required of a row: a bound, or a figure, from which the value may differ by `within`. */
struct limit {
  const char *relation;
  double value, within;
};

static struct limit limit_of(const struct kith_row *row) {
  const double figure = strtod(row->prints, NULL);
  const char *point = strchr(row->prints, '.'), *power = strpbrk(row->prints, "eE");
  if (row->prints[0] == '\0')
    return isnan(row->at_least) ? (struct limit){"<=", row->at_most, 0}
                                : (struct limit){">=", row->at_least, 0};
  if (row->within > 0) return (struct limit){"=", figure, row->within * fabs(figure)};
  const double digits = point == NULL ? 0 : (double)strspn(point + 1, "0123456789");
  /* Rounding takes half of one in the last digit; other compilers may differ a little. */
  return (struct limit){"=", figure, 0.51 * pow(10, (power != NULL ? strtod(power + 1, NULL) : 0) - digits)};
}

static bool holds(const struct limit *limit, double value) {
  return limit->relation[0] == '<'   ? value <= limit->value
         : limit->relation[0] == '>' ? value >= limit->value
                                     : fabs(value - limit->value) <= 1.000001 * limit->within;
}

static void print_row(const struct validation *v, const struct kith_row *row, const struct outcome *o) {
  char limit[32] = "", value[32] = "-";
  const bool same = o->same.difference <= row->tolerance;
  const struct limit required = limit_of(row);
  if (row->kind != KITH_ROW_NOTHING)
    snprintf(limit, sizeof limit, "%-2s %-10.4g", required.relation, required.value);
  if (row->kind != KITH_ROW_NOTHING) snprintf(value, sizeof value, "%.5g", o->value);
  printf("%-*s %12s  %-13s %-6s %9.1e %7.0f %7.1f s", v->width, row->job.label, value, limit,
         o->good ? "ok" : "FAILED", last_value(v, "energy_drift"), last_value(v, "floors"), o->seconds);
  if (o->same.difference == 0) printf("  same as %s", row->like);
  if (o->same.difference > 0)
    printf("  %s %s %s%.2g in %s%s", same ? "same as" : "DIFFERS FROM", row->like, same ? "to " : "by ",
           o->same.difference > DBL_MIN ? o->same.difference : 0, o->same.field,
           !same && o->same.reordered ? "; nodes are stored in another order" : "");
  putchar('\n');
}

static kith_status put_row(struct validation *v, const struct kith_row *row, const struct outcome *o) {
  static const char *const also[] = {"norms.density.l1", "norms.velocity.l1", "norms.pressure.l1",
                                     "energy_drift",     "momentum_drift",    "floors"};
  FILE *f = v->table.file;
  const struct limit required = limit_of(row);
  kith_study_put_quoted(f, row->job.label);
  fprintf(f, ",%.17g,%s,%.17g,%s,%.3f,", o->value, required.relation, required.value,
          o->good ? "ok" : "FAILED", o->seconds);
  kith_study_put_quoted(f, row->source);
  for (size_t k = 0; k < sizeof also / sizeof *also; ++k) fprintf(f, ",%.17g", last_value(v, also[k]));
  fprintf(f, ",%d,%d,", KITH_MAX(row->job.ranks, 1), row->job.threads);
  kith_study_put_quoted(f, row->varied);
  fputc(',', f);
  kith_study_put_quoted(f, row->like);
  fprintf(f, ",%.17g", o->same.difference);
  return kith_csv_log_row(&v->table);
}

static kith_status do_row(struct validation *v, const struct kith_row *row) {
  struct outcome o = {.value = NAN, .same.difference = NAN};
  const double begun = kith_seconds();
  char why[2048];
  o.failed = measure(v, row, &o.value) != KITH_OK || compare(v, row, &o.same) != KITH_OK;
  const struct limit required = limit_of(row);
  o.good = !o.failed && !(o.same.difference > row->tolerance) &&
           (row->kind == KITH_ROW_NOTHING || holds(&required, o.value));
  o.seconds = kith_seconds() - begun;
  snprintf(why, sizeof why, "%s", kith_failure());
  print_row(v, row, &o);
  if (o.failed) printf("    %s\n", why);
  fflush(stdout);
  ++v->n_done, v->n_wrong += !o.good, v->n_failed += o.failed;
  v->n_compared += row->like[0] != '\0', v->n_same += o.same.difference <= row->tolerance;
  return put_row(v, row, &o);
}

static kith_status do_rows(struct validation *v) {
  const double begun = kith_seconds();
  v->width = 28;
  for (int k = 0; k < v->n; ++k) v->width = KITH_MAX(v->width, (int)strlen(v->rows[k].job.label));
  printf("%-*s %12s  %-13s %-6s %9s %7s\n", v->width, "row", "measured", "bound", "", "energy", "floors");
  for (int k = 0; k < v->n; ++k)
    if (!v->quick || v->rows[k].quick) KITH_TRY(do_row(v, &v->rows[k]));
  printf("%d rows, %d out of tolerance%s; %.0f s; %s/validation.csv\n", v->n_done, v->n_wrong,
         v->n_failed > 0 ? ", and some runs failed" : "", kith_seconds() - begun, v->directory);
  if (v->n_compared > 0)
    printf("%d of %d runs end in the same state as the row they are compared with\n", v->n_same,
           v->n_compared);
  return kith_csv_log_close(&v->table);
}

static void list(void) {
  puts(
      "quick   1-D and small 2-D runs, minutes; the default\n"
      "full    all rows of quick, and larger ones\n"
      "gates   what must hold for each package, with the known exemptions\n"
      "ranks   runs of 1 to 8 processes against one: bitwise identical, balance, ghosts; minutes\n"
      "readme  the figures of README and manual: do their commands print them? readme-quick: in seconds\n"
      "decks   small, medium and large runs of a proxy application, with their stored results\n"
      "The rows are in inputs/validation; a file of one's own may have others.\n");
  kith_rows_reference();
}

/* Reads the rows of a suite: quick and full are of targets.yaml; other names are files beside it, paths too.
 * Has `kith plan` check all rows of one's own file before any is run; those of inputs are right. */
static kith_status read_rows(struct validation *v, const char *suite) {
  char path[PATH];
  const bool is_path = kith_suite_is_path(suite);
  const char *name = strcmp(suite, "full") == 0    ? "targets"
                     : strcmp(suite, "quick") == 0 ? "targets-quick"
                                                   : suite;
  const char *quick = strstr(name, "-quick");
  v->quick = !is_path && quick != NULL;
  snprintf(path, sizeof path, "%s", suite);
  if (!is_path)
    snprintf(path, sizeof path, "%s/validation/%.*s.yaml", v->programs.inputs,
             quick != NULL ? (int)KITH_MIN(quick - name, 100) : 100, name);
  static const char what[] = "validate: no file of rows and no suite";
  if (!is_path) KITH_TRY(kith_study_inputs(&v->programs, "/validation", what, suite));
  if (!is_path && access(path, R_OK) != 0)
    return kith_study_unknown(what, suite, "quick|full|gates|ranks|readme|readme-quick|decks");
  KITH_TRY(kith_rows_read_file(&v->rows, &v->n, path, &v->programs));
  bool any = !v->quick;
  for (int k = 0; k < v->n; ++k) any = any || v->rows[k].quick;
  if (!any) KITH_FAIL(BAD_INPUT, "validate: no row of %s is quick: leave out -quick", path);
  KITH_TRY(kith_resize(&v->error, 0, 2 * (size_t)v->n, sizeof *v->error));
  v->resolution = v->error + v->n;
  for (const struct kith_row *row = v->rows; row < v->rows + v->n; ++row)
    if (is_path && row->job.dimension > 0) KITH_TRY(kith_job_check(&v->programs, &row->job, path, "row"));
  return KITH_OK;
}

static kith_status validate(struct validation *v, const char *suite, enum kith_exit *code) {
  static const char names[] =
      "row,measured,relation,bound,verdict,seconds,source,density.l1,velocity.l1,pressure.l1,energy_drift,"
      "momentum_drift,floors,ranks,threads,varied,like,difference";
  KITH_TRY(kith_programs_find(&v->programs));
  KITH_TRY(read_rows(v, suite));
  KITH_TRY(kith_directory_make(v->directory));
  KITH_TRY(kith_directory_claim(v->directory, &v->lock));
  KITH_TRY(kith_csv_log_open(&v->table, v->directory, "validation.csv", names, NULL));
  *code = KITH_EXIT_FAILED;
  KITH_TRY(do_rows(v));
  if (v->n_failed == 0) *code = v->n_wrong > 0 ? KITH_EXIT_TOLERANCE : KITH_EXIT_OK;
  return KITH_OK;
}

enum kith_exit kith_validate(const struct kith_options *options) {
  const char *suite = options->subject != NULL ? options->subject : "quick";
  struct validation v = {.directory = options->directory != NULL ? options->directory : "out/validate"};
  enum kith_exit code = KITH_EXIT_USAGE;
  if (strcmp(suite, "list") == 0) {
    list();
    return KITH_EXIT_OK;
  }
  const kith_status status = validate(&v, suite, &code);
  if (status == KITH_NO_MEMORY) code = KITH_EXIT_FAILED;
  if (status != KITH_OK) fprintf(stderr, "kith: %s\n", kith_failure());
  kith_csv_log_close(&v.table);
  if (v.lock > 0) close(v.lock);
  KITH_FREE(&v.rows, &v.error);
  return code;
}
