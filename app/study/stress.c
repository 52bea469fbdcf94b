/* stress.c - where a method stops working: `kith stress [SWEEP|FILE]`, all sweeps of
 * inputs/stress/sweeps.yaml by default; `kith stress list`.
 *
 * A sweep varies one parameter of one scene, from mild to hard, for every method; a bound on a measure says
 * what still counts as working. A run that fails, or takes more than two minutes of processor time, does not
 * pass. On stdout, and in DIR/stress.md (-o, out/stress by default): which values pass, sweep by method; the
 * file has also the bounds, and why runs did not pass. DIR/points.csv has all runs.
 *
 * Exit code: 0; 3 if a method does not even pass the first value of a sweep; 1 if the results cannot be
 * written; 2 for an unknown sweep, settings that no run takes, or a directory that cannot be written to. */
#include <math.h>
#include "app/study/study.h"

/* The measure of job k, divided by that at the first value if the sweep says so; NaN if the run failed. */
static double judged_value(const struct kith_suite *s, int k) {
  const double value = s->point[k].value[KITH_MEASURES],
               first = s->point[k - k % s->n_values].value[KITH_MEASURES];
  return s->point[k].failed ? NAN : !s->of_first ? value : value == first ? 1 : value / first;
}

static bool passes(const struct kith_suite *s, int k) {
  return isnan(s->at_most) ? judged_value(s, k) >= s->at_least : judged_value(s, k) <= s->at_most;
}

void kith_sweep_answer(const struct kith_suite *s, int m, char text[128]) {
  const int n = s->n_values, start = m * n;
  int good = 0, first = 0; /* all that pass, and those before the first that does not */
  for (int k = 0; k < n; ++k) {
    first += first == k && passes(s, start + k);
    good += passes(s, start + k);
  }
  const char *last = s->job[start + KITH_MAX(first - 1, 0)].value;
  if (good == 0)
    snprintf(text, 128, "none");
  else if (s->named_values || good > first)
    snprintf(text, 128, good == n ? "all %d" : "%d of %d", good, n);
  else
    snprintf(text, 128, good == n ? "all (%s)" : "to %s", last);
}

static void put_bound(FILE *f, const struct kith_suite *s) {
  const bool most = isnan(s->at_least);
  fprintf(f, "%s %s %.6g%s", s->measure[0], most ? "at most" : "at least", most ? s->at_most : s->at_least,
          s->of_first ? " times that of the first value" : "");
}

static void put_table(FILE *f, const struct kith_study *w) {
  char text[128];
  fprintf(f, "| %-22s |", "passes");
  for (int m = 0; m < w->suite->n_methods; ++m)
    fprintf(f, " %-14s |", w->suite->job[m * w->suite->n_values].label);
  fputs("\n|---|", f);
  for (int m = 0; m < w->suite->n_methods; ++m) fputs("---|", f);
  for (const struct kith_suite *s = w->suite; s < w->suite + w->n; ++s) {
    fprintf(f, "\n| %-22s |", s->name);
    for (int m = 0; m < s->n_methods; ++m) {
      kith_sweep_answer(s, m, text);
      fprintf(f, " %-14s |", text);
    }
  }
  fputc('\n', f);
}

/* Writes the bound of a sweep, and what did not pass. */
static void put_sweep(FILE *f, const struct kith_suite *s) {
  fprintf(f, "\n## %s\n\n%s, scene %s in %d-D; passes: ", s->name, s->parameter, s->scene, s->dimension);
  put_bound(f, s);
  fprintf(f, " (%s).\n\n", s->reason);
  for (int k = 0; k < s->n_methods * s->n_values; ++k) {
    if (passes(s, k)) continue;
    fprintf(f, "- %s at %s: ", s->job[k].label, s->job[k].value);
    if (s->point[k].failed)
      fprintf(f, "failed, %s\n", s->point[k].why);
    else
      fprintf(f, "%.4g\n", judged_value(s, k));
  }
}

static void put_text(FILE *f, const struct kith_study *w, bool to_file) {
  if (to_file)
    fputs("# Where methods stop working\n\nOne parameter at a time, from mild to hard: values that pass.\n\n",
          f);
  put_table(f, w);
  for (int k = 0; k < w->n && to_file; ++k) put_sweep(f, &w->suite[k]);
}

/* Has `kith plan` check one's own sweeps before any run is started: each method at the first value, and each
 * value with the first method. Beyond these a method may refuse a value, which then does not pass. */
static kith_status check_own(const struct kith_study *w, const char *path) {
  char what[256];
  for (const struct kith_suite *s = w->suite; s < w->suite + w->n; ++s)
    for (int k = 0; k < s->n_methods * s->n_values; ++k) {
      if (k >= s->n_values && k % s->n_values > 0) continue;
      snprintf(what, sizeof what, "sweep %s at %s, method", s->name, s->job[k].value);
      KITH_TRY(kith_job_check(&w->programs, &s->job[k], path, what));
    }
  return KITH_OK;
}

/* Reads the sweeps. Those of inputs are right, also where a method refuses a whole sweep: the first run alone
 * is checked, if the command line sets something. */
static kith_status read_sweeps(struct kith_study *w) {
  const struct kith_options *o = w->options;
  const bool own = o->subject != NULL && kith_suite_is_path(o->subject);
  char path[2 * KITH_PATH];
  snprintf(path, sizeof path, "%s%.700s", own ? "" : w->programs.inputs,
           own ? o->subject : "/stress/sweeps.yaml");
  KITH_TRY(kith_sweeps_read(w, path, own ? NULL : o->subject));
  snprintf(w->directory, sizeof w->directory, "%.700s", o->directory != NULL ? o->directory : "out/stress");
  if (own) return check_own(w, path);
  return o->n_overrides > 0 ? kith_job_check(&w->programs, w->suite->job, NULL, NULL) : KITH_OK;
}

static kith_status list(struct kith_study *w) {
  static const struct kith_options all; /* without what the command line says */
  w->options = &all;
  KITH_TRY(read_sweeps(w));
  for (const struct kith_suite *s = w->suite; s < w->suite + w->n; ++s) {
    printf("%-22s %s, %s in %d-D\n%22s ", s->name, s->parameter, s->scene, s->dimension, "");
    put_bound(stdout, s);
    printf(": %s\n", s->reason);
  }
  putchar('\n');
  kith_sweeps_reference();
  return KITH_OK;
}

/* 3 if a method does not even pass the mildest value. */
static enum kith_exit verdict(const struct kith_study *w) {
  for (const struct kith_suite *s = w->suite; s < w->suite + w->n; ++s)
    for (int m = 0; m < s->n_methods; ++m)
      if (!passes(s, m * s->n_values)) return KITH_EXIT_TOLERANCE;
  return KITH_EXIT_OK;
}

enum kith_exit kith_stress(const struct kith_options *options) {
  static const struct kith_study_verb verb = {.name = "stress",
                                              .cpu_limit = 120,
                                              .list = list,
                                              .read = read_sweeps,
                                              .put = put_text,
                                              .verdict = verdict};
  return kith_study_run(&verb, options);
}
