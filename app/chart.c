#include "app/chart.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "app/plot.h"
#include "app/progress.h"
#include "app/text.h"
#include "lib/core/profile.h"

enum { MANY = 1000, LONG = 3600 }; /* runs, and seconds, that are only started after a yes */
static const double START = 0.05;  /* seconds to start a process, and to end it */

/* All that a chart needs while it is made. */
struct work {
  const struct kith_options *options;
  struct kith_programs programs;
  struct kith_suite *suite;
  struct kith_matrix *matrix; /* NULL until there is a directory */
  struct kith_chart chart;
  char directory[KITH_PATH];
  double *estimate;       /* of each method, seconds at the coarsest resolution; NaN: not known */
  double *wall, *wall_at; /* of each method's last run, and its resolution */
};

static struct kith_job *job_of(const struct work *w, int m, int r, struct kith_job *job,
                               kith_status *status) {
  *status = kith_suite_job(w->suite, m, w->suite->resolution[r], job);
  return job;
}

/* --- before anything runs --- */

/* Which values of which axis worked at least once, and why they did not. */
struct verdicts {
  int n;
  struct verdict {
    const struct kith_config_node *value;
    const char *key;
    bool good;
    char why[256];
  } * verdict;
};

static kith_status judge(struct verdicts *all, const struct kith_suite *s, int m, bool good,
                         const char *why) {
  for (int a = 0; a < s->n_axes; ++a) {
    const struct kith_config_node *value = s->axis[a].list->first;
    for (int k = kith_suite_position(s, m, a); k > 0; --k) value = value->next;
    struct verdict *v = NULL;
    for (int k = 0; k < all->n && v == NULL; ++k)
      if (all->verdict[k].value == value) v = &all->verdict[k];
    if (v == NULL) {
      KITH_TRY(kith_resize(&all->verdict, (size_t)all->n, (size_t)all->n + 1, sizeof *v));
      v = &all->verdict[all->n++];
      v->value = value, v->key = s->axis[a].key;
    }
    v->good |= good;
    if (!good && v->why[0] == '\0') snprintf(v->why, sizeof v->why, "%s", why);
  }
  return KITH_OK;
}

/* The settings of all runs are wrong, or the first value that never worked. */
static kith_status refuse_bad(const struct verdicts *all, const struct kith_suite *s, int n_good,
                              const char *why) {
  int bad = 0;
  for (int k = 0; k < all->n; ++k) bad += !all->verdict[k].good;
  if (n_good == 0 && (all->n == 0 || bad > 1)) { /* is one of them to blame? */
    for (int k = 0; k < all->n; ++k) {
      const char *key = all->verdict[k].key;
      if (key != NULL && strstr(all->verdict[k].why, key) != NULL)
        return kith_config_fail(all->verdict[k].value, NULL, "%s", all->verdict[k].why);
    }
    KITH_FAIL(BAD_INPUT, "%s: no method can run: %s", s->config->file, why);
  }
  for (int k = 0; k < all->n; ++k)
    if (!all->verdict[k].good)
      return kith_config_fail(all->verdict[k].value, NULL, "%s", all->verdict[k].why);
  return KITH_OK;
}

static bool all_there(const struct work *w, int m) {
  struct kith_job job;
  kith_status status = KITH_OK;
  for (int r = 0; w->matrix != NULL && r < w->suite->n_resolutions && status == KITH_OK; ++r)
    if (kith_matrix_find(w->matrix, kith_matrix_key(w->matrix, job_of(w, m, r, &job, &status))) == NULL)
      return false;
  return w->matrix != NULL;
}

/* Many combinations: those in which at most one axis is not at its first value, or, before anybody said yes, the first. */
static bool is_checked(const struct kith_suite *s, int m, bool first_only) {
  enum { ALL = 64 };
  int moved = 0;
  for (int a = 0; a < s->n_axes; ++a) moved += kith_suite_position(s, m, a) > 0;
  return s->n_methods <= ALL || moved == 0 || (moved == 1 && !first_only);
}

static kith_status check_method(struct work *w, int m, struct verdicts *all, int *n_good, char why[256]) {
  struct kith_job job;
  int code;
  KITH_TRY(kith_suite_job(w->suite, m, w->suite->resolution[0], &job));
  KITH_TRY(kith_job_plan(&w->programs, w->chart.threads, &job, &code, &w->estimate[m], why));
  *n_good += code != 2;
  return judge(all, w->suite, m, code != 2, why);
}

static kith_status check(struct work *w) {
  struct verdicts all = {0};
  const bool unasked = w->suite->n_methods * w->suite->n_resolutions > MANY && !w->options->yes;
  int n_good = 0, n = 0;
  char why[256] = "";
  kith_status status = KITH_OK;
  for (int m = 0; m < w->chart.n_methods && status == KITH_OK; ++m) {
    if (!is_checked(w->suite, m, unasked)) continue;
    if (all_there(w, m)) {
      ++n_good;
      status = judge(&all, w->suite, m, true, "");
    } else {
      status = check_method(w, m, &all, &n_good, why);
    }
    ++n;
  }
  if (status == KITH_OK && n_good < n) status = refuse_bad(&all, w->suite, n_good, why);
  kith_free(&all.verdict);
  return status;
}

/* --- time --- */

/* Nodes and steps: the cost of a run goes with the resolution to the power of the dimension plus one. */
static double scaled(const struct work *w, double seconds, double from, double to) {
  return seconds * pow(to / from, w->suite->dimension + 1);
}

/* What the plan of a method said of the coarsest resolution, or the mean of those that said something. NaN: none did. */
static double planned(const struct work *w, int m) {
  double sum = 0;
  int n = 0;
  if (isfinite(w->estimate[m])) return w->estimate[m];
  for (int k = 0; k < w->chart.n_methods; ++k)
    if (isfinite(w->estimate[k])) sum += w->estimate[k], ++n;
  return n > 0 ? sum / n : NAN;
}

/* From the method's last run, else from those of the others, else from the plans. NaN: nothing is known yet. */
static double expected(const struct work *w, int m, double resolution) {
  if (w->wall[m] > 0) return scaled(w, w->wall[m], w->wall_at[m], resolution);
  double sum = 0;
  int n = 0;
  for (int k = 0; k < w->chart.n_methods; ++k)
    if (w->wall[k] > 0) sum += scaled(w, w->wall[k], w->wall_at[k], resolution), ++n;
  if (n > 0) return sum / n;
  return scaled(w, planned(w, m), w->suite->resolution[0], resolution);
}

static kith_status ask(const struct work *w) {
  char text[32];
  double seconds = 0;
  int64_t runs = 0;
  for (int m = 0; m < w->chart.n_methods; ++m) {
    if (all_there(w, m)) continue;
    const double first = planned(w, m);
    for (int r = 0; r < w->suite->n_resolutions; ++r, ++runs)
      seconds +=
          START + (isfinite(first) ? scaled(w, first, w->suite->resolution[0], w->suite->resolution[r]) : 0);
  }
  if ((runs <= MANY && seconds <= LONG) || w->options->yes) return KITH_OK;
  KITH_FAIL(BAD_INPUT, "%s: %lld runs, about %s in all as their plans have it; --yes starts them",
            w->suite->name, (long long)runs, kith_text_seconds(text, seconds));
}

/* --- the runs --- */

static kith_status run_point(struct work *w, int m, int r, int *done) {
  struct kith_job job;
  const struct kith_suite *s = w->suite;
  struct kith_point *p = &w->chart.point[(size_t)m * s->n_resolutions + r];
  const int all = w->chart.n_methods * s->n_resolutions;
  KITH_TRY(kith_suite_job(s, m, s->resolution[r], &job));
  const struct kith_point *found = kith_matrix_find(w->matrix, kith_matrix_key(w->matrix, &job));
  if (found != NULL) {
    *p = *found;
  } else {
    kith_progress_start(*done, all, &job, w->options->quiet);
    KITH_TRY(kith_matrix_run(w->matrix, &job, p));
  }
  ++*done;
  w->chart.n_failed += p->failed;
  if (!p->failed) w->wall[m] = p->value[1], w->wall_at[m] = s->resolution[r];
  if (found != NULL) return KITH_OK;
  double left = 0;
  for (int k = r; k < s->n_resolutions; ++k)
    for (int b = k == r ? m + 1 : 0; b < w->chart.n_methods; ++b) left += expected(w, b, s->resolution[k]);
  kith_progress_point(*done, all, p, s->norm[0], left, w->options->quiet);
  return KITH_OK;
}

/* The coarse ones of all methods first: a chart that is interrupted has something of each. */
static kith_status run_all(struct work *w) {
  int done = 0;
  for (int r = 0; r < w->suite->n_resolutions; ++r)
    for (int m = 0; m < w->chart.n_methods; ++m) KITH_TRY(run_point(w, m, r, &done));
  return KITH_OK;
}

/* --- all of it --- */

static void find_machine(char machine[100]) {
  char line[256];
  snprintf(machine, 100, "an unknown processor");
  FILE *file = fopen("/proc/cpuinfo", "r");
  while (file != NULL && fgets(line, sizeof line, file) != NULL) {
    char *colon = strchr(line, ':');
    if (strncmp(line, "model name", strlen("model name")) != 0 || colon == NULL) continue;
    colon[strcspn(colon, "\n")] = '\0';
    snprintf(machine, 100, "%.99s", colon + 1 + strspn(colon + 1, " "));
    break;
  }
  if (file != NULL) fclose(file);
}

static kith_status make_arrays(struct work *w) {
  struct kith_chart *c = &w->chart;
  const size_t n = (size_t)c->n_methods;
  struct kith_job job;
  KITH_TRY(kith_resize(&c->label, 0, n, sizeof *c->label));
  KITH_TRY(kith_resize(&c->point, 0, n * w->suite->n_resolutions, sizeof *c->point));
  KITH_TRY(kith_resize(&w->estimate, 0, n, sizeof *w->estimate));
  KITH_TRY(kith_resize(&w->wall, 0, n, sizeof *w->wall));
  KITH_TRY(kith_resize(&w->wall_at, 0, n, sizeof *w->wall_at));
  for (size_t m = 0; m < n; ++m) {
    KITH_TRY(kith_suite_job(w->suite, (int64_t)m, w->suite->resolution[0], &job));
    memcpy(c->label[m], job.method, sizeof job.method);
    w->estimate[m] = NAN;
  }
  return KITH_OK;
}

/* Nothing is made before all is known to be right; an earlier chart is looked at first. */
static kith_status prepare(struct work *w) {
  const struct kith_options *o = w->options;
  char path[KITH_PATH + 16];
  if (o->subject == NULL) KITH_FAIL(BAD_INPUT, "chart: no scene or suite; 'kith chart list' has them");
  KITH_TRY(kith_suite_read(&w->suite, &w->programs, o->subject, o->n_overrides, o->overrides));
  w->chart.suite = w->suite;
  w->chart.threads = KITH_MAX(o->threads, 1);
  w->chart.n_methods = (int)w->suite->n_methods;
  if (w->suite->others[0] != '\0')
    KITH_TRY(kith_others_read(&w->chart.others, w->suite->others, w->suite->scene_name, w->suite->dimension));
  KITH_TRY(make_arrays(w));
  find_machine(w->chart.machine);
  snprintf(w->directory, sizeof w->directory, "%s%.300s", o->directory != NULL ? "" : "out/chart/",
           o->directory != NULL ? o->directory : w->suite->name);
  snprintf(path, sizeof path, "%s/points.csv", w->directory);
  if (access(path, F_OK) == 0) KITH_TRY(kith_matrix_open(&w->matrix, w->directory, w->chart.threads, 0));
  KITH_TRY(check(w));
  KITH_TRY(ask(w));
  return w->matrix != NULL ? KITH_OK : kith_matrix_open(&w->matrix, w->directory, w->chart.threads, 0);
}

static kith_status tell(const struct work *w) {
  char text[KITH_CHART_TEXT];
  for (int k = 0; k < w->suite->n_norms; ++k) {
    KITH_TRY(kith_chart_sentence(&w->chart, k, text));
    kith_text_wrapped(stdout, 2, "", text);
    KITH_TRY(kith_chart_front_names(&w->chart, k, 0, text));
    kith_text_wrapped(stdout, 4, "    ", "on the front:");
    kith_text_wrapped(stdout, 4, "    ", text[0] != '\0' ? text : "nobody");
    kith_chart_others_sentence(&w->chart, k, text);
    if (text[0] != '\0') kith_text_wrapped(stdout, 4, "    ", text);
  }
  printf("%d runs, %d failed; %s/chart.html\n", w->chart.n_methods * w->suite->n_resolutions,
         w->chart.n_failed, w->directory);
  return KITH_OK;
}

static kith_status finish(struct work *w) {
  KITH_TRY(kith_chart_write(&w->chart, w->directory));
  if (kith_plot_draw(w->directory) != KITH_OK)
    fprintf(stderr, "kith: warning: no chart.png: %s\n", kith_failure());
  return tell(w);
}

static void clear(struct work *w) {
  kith_matrix_close(&w->matrix);
  kith_suite_destroy(&w->suite);
  kith_others_clear(&w->chart.others);
  kith_free(&w->chart.label);
  kith_free(&w->chart.point);
  kith_free(&w->estimate);
  kith_free(&w->wall);
  kith_free(&w->wall_at);
}

enum kith_exit kith_chart(const struct kith_options *options) {
  struct work w = {.options = options};
  enum kith_exit code = KITH_EXIT_USAGE;
  setenv("OMP_WAIT_POLICY", "passive", 0); /* small runs on few cores: who waits, sleeps */
  kith_status status = kith_programs_find(&w.programs);
  if (status == KITH_OK && options->subject != NULL && strcmp(options->subject, "list") == 0)
    return kith_suite_list(&w.programs) == KITH_OK ? KITH_EXIT_OK : KITH_EXIT_FAILED;
  if (status == KITH_OK) status = prepare(&w);
  if (status == KITH_OK) {
    status = run_all(&w);
    if (status == KITH_OK) status = finish(&w);
    code = status == KITH_OK && w.chart.n_failed == 0 ? KITH_EXIT_OK : KITH_EXIT_FAILED;
  }
  if (status != KITH_OK) fprintf(stderr, "kith: %s\n", kith_failure());
  clear(&w);
  return code;
}
