#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* strtok_r */
#endif
#include "app/stress.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "app/progress.h"
#include "app/text.h"
#include "app/words.h"
#include "lib/core/profile.h"
#include "physics/package.h"

#include "app/stress_rows.h"

static const double CPU_LIMIT = 120;

/* --- verdicts --- */

/* The metric as it is judged; for OF_FIRST over the first rung, where 0 over 0 is 1. */
static double judged(const struct kith_ladder *l, int method, int rung) {
  const int metric = kith_metric_find(l->sweep->metric);
  const double value = l->point[method][rung].value[metric], first = l->point[method][0].value[metric];
  if (l->sweep->gate != KITH_OF_FIRST) return value;
  return value == first ? 1 : value / first;
}

void kith_ladder_judge(struct kith_ladder *l) {
  const struct kith_sweep *s = l->sweep;
  for (int m = 0; m < kith_n_stress_methods; ++m)
    for (int k = 0; k < l->n; ++k) {
      const double value = l->point[m][k].failed ? NAN : judged(l, m, k);
      l->shown[m][k] = value;
      l->pass[m][k] = s->gate == KITH_AT_LEAST ? value >= s->bound : value <= s->bound;
    }
}

static void rung_text(const struct kith_rung *rung, char text[64]) {
  if (rung->name != NULL)
    snprintf(text, 64, "%s", rung->name);
  else
    snprintf(text, 64, "%.6g", rung->x);
}

/* "to 0.6", "12, 20 - 40": the stretches of rungs that pass. */
static void answer_values(const struct kith_ladder *l, int method, char text[128]) {
  char from[64], to[64];
  int n = 0;
  text[0] = '\0';
  for (int k = 0, next; k < l->n && n < 100; k = next) {
    next = k + 1;
    if (!l->pass[method][k]) continue;
    while (next < l->n && l->pass[method][next]) ++next;
    rung_text(&l->sweep->rung[k], from);
    rung_text(&l->sweep->rung[next - 1], to);
    const char *comma = n > 0 ? ", " : "";
    n += next == k + 1 ? snprintf(text + n, (size_t)(128 - n), "%s%s", comma, from)
         : k == 0      ? snprintf(text + n, (size_t)(128 - n), "to %s", to)
                       : snprintf(text + n, (size_t)(128 - n), "%s%s - %s", comma, from, to);
  }
}

void kith_ladder_answer(const struct kith_ladder *l, int method, char text[128]) {
  char last[64];
  int good = 0;
  for (int k = 0; k < l->n; ++k) good += l->pass[method][k];
  rung_text(&l->sweep->rung[l->n - 1], last);
  if (good == 0)
    snprintf(text, 128, "none");
  else if (l->sweep->rung[0].name != NULL)
    snprintf(text, 128, good == l->n ? "all %d" : "%d of %d", good, l->n);
  else if (good == l->n)
    snprintf(text, 128, "all (%s)", last);
  else
    answer_values(l, method, text);
}

void kith_sweep_gate_text(const struct kith_sweep *s, char text[160]) {
  static const char *const relations[] = {"at most", "at least", "at most"};
  snprintf(text, 160, "%s %s %.6g%s", s->metric, relations[s->gate], s->bound,
           s->gate == KITH_OF_FIRST ? " times that of the first" : "");
}

/* --- runs --- */

static kith_status set_words(struct kith_job *job, const char *settings) {
  char text[1024], *rest;
  snprintf(text, sizeof text, "%s", settings);
  for (char *word = strtok_r(text, " ", &rest); word != NULL; word = strtok_r(NULL, " ", &rest)) {
    char *equals = strchr(word, '=');
    if (equals == NULL) KITH_FAIL(INTERNAL, "'%s' is not key=value", word);
    *equals = '\0';
    KITH_TRY(kith_job_set(job, word, equals + 1));
  }
  return KITH_OK;
}

struct stress {
  const struct kith_options *options;
  struct kith_programs programs;
  struct kith_matrix *matrix;
  struct kith_ladder *ladder;
  int n, done, all; /* ladders; runs */
  double started;
  int fresh; /* runs that were not there */
};

static kith_status make_job(const struct stress *w, const struct kith_sweep *s, int method,
                            const struct kith_rung *rung, char scene[KITH_PATH + 64], struct kith_job *job) {
  snprintf(scene, KITH_PATH + 64, "%s/%s.yaml", w->programs.inputs, s->scene);
  *job = (struct kith_job){.scene = scene, .dimension = s->dimension, .x = rung->x};
  snprintf(job->method, sizeof job->method, "%s %s", s->name, kith_stress_methods[method].name);
  KITH_TRY(set_words(job, kith_stress_methods[method].settings));
  KITH_TRY(set_words(job, s->settings));
  KITH_TRY(set_words(job, rung->settings));
  for (int k = 0; k < w->options->n_overrides; ++k) KITH_TRY(set_words(job, w->options->overrides[k]));
  return KITH_OK;
}

static kith_status run_rung(struct stress *w, struct kith_ladder *l, int method, int k) {
  struct kith_job job;
  char scene[KITH_PATH + 64];
  struct kith_point *p = &l->point[method][k];
  KITH_TRY(make_job(w, l->sweep, method, &l->sweep->rung[k], scene, &job));
  const struct kith_point *found = kith_matrix_find(w->matrix, kith_matrix_key(w->matrix, &job));
  ++w->done;
  if (found != NULL) {
    *p = *found;
    return KITH_OK;
  }
  kith_progress_start(w->done - 1, w->all, &job, w->options->quiet);
  KITH_TRY(kith_matrix_run(w->matrix, &job, p));
  const double left = (kith_seconds() - w->started) / ++w->fresh * (w->all - w->done);
  kith_progress_point(w->done, w->all, p, kith_metric_find(l->sweep->metric), left, w->options->quiet);
  return KITH_OK;
}

static kith_status run_ladder(struct stress *w, struct kith_ladder *l) {
  for (int m = 0; m < kith_n_stress_methods; ++m)
    for (int k = 0; k < l->n; ++k) KITH_TRY(run_rung(w, l, m, k));
  kith_ladder_judge(l);
  return KITH_OK;
}

/* What the command line sets must make sense to one run at least, before any is started. */
static kith_status check_overrides(struct stress *w) {
  struct kith_job job;
  char scene[KITH_PATH + 64], why[256];
  double seconds;
  int code;
  if (w->options->n_overrides == 0) return KITH_OK;
  KITH_TRY(make_job(w, w->ladder[0].sweep, 0, &w->ladder[0].sweep->rung[0], scene, &job));
  KITH_TRY(kith_job_plan(&w->programs, 1, &job, &code, &seconds, why));
  if (code == 2) KITH_FAIL(BAD_INPUT, "stress: %s", why);
  return KITH_OK;
}

/* --- what is told --- */

static void print_table(int n, const struct kith_ladder *ladders) {
  char text[128];
  printf("%-22s", "passes");
  for (int m = 0; m < kith_n_stress_methods; ++m) printf(" %16s", kith_stress_methods[m].name);
  putchar('\n');
  for (int k = 0; k < n; ++k) {
    printf("%-22s", ladders[k].sweep->name);
    for (int m = 0; m < kith_n_stress_methods; ++m) {
      kith_ladder_answer(&ladders[k], m, text);
      printf(" %16s", text);
    }
    putchar('\n');
  }
}

static enum kith_exit list(void) {
  char gate[160];
  for (int k = 0; k < kith_n_sweeps; ++k) {
    const struct kith_sweep *s = &kith_sweeps[k];
    kith_sweep_gate_text(s, gate);
    printf("%-22s %s, %s in %d-D\n%22s %s: %s\n", s->name, s->knob, s->scene, s->dimension, "", gate,
           s->reason);
  }
  return KITH_EXIT_OK;
}

static int rungs_of(const struct kith_sweep *s) {
  int n = 0;
  while (n < KITH_RUNGS && s->rung[n].settings != NULL) ++n;
  return n;
}

static kith_status choose(struct stress *w) {
  char words[2048] = "", told[2048], near[64];
  const char *subject = w->options->subject;
  KITH_TRY(kith_resize(&w->ladder, 0, (size_t)kith_n_sweeps, sizeof *w->ladder));
  for (int k = 0; k < kith_n_sweeps; ++k) {
    const struct kith_sweep *s = &kith_sweeps[k];
    const size_t used = strlen(words);
    snprintf(words + used, sizeof words - used, "|%s", s->name);
    if (subject != NULL && strcmp(subject, s->name) != 0) continue;
    w->ladder[w->n].n = rungs_of(s);
    w->ladder[w->n].sweep = s;
    w->all += w->ladder[w->n++].n * kith_n_stress_methods;
  }
  if (w->n > 0) return KITH_OK;
  if (kith_words_nearest(words, subject, near, sizeof near))
    KITH_FAIL(BAD_INPUT, "stress: no sweep '%.60s'; did you mean '%s'?", subject, near);
  kith_words_tell(words, told, sizeof told);
  KITH_FAIL(BAD_INPUT, "stress: no sweep '%.60s'; there are %s", subject, told);
}

/* 3: a method that does not even pass the mildest rung. */
static enum kith_exit verdict(const struct stress *w) {
  for (int k = 0; k < w->n; ++k)
    for (int m = 0; m < kith_n_stress_methods; ++m)
      if (!w->ladder[k].pass[m][0]) return KITH_EXIT_TOLERANCE;
  return KITH_EXIT_OK;
}

static kith_status run_all(struct stress *w) {
  w->started = kith_seconds();
  for (int k = 0; k < w->n; ++k) KITH_TRY(run_ladder(w, &w->ladder[k]));
  return kith_stress_write(w->n, w->ladder, w->matrix->directory);
}

enum kith_exit kith_stress(const struct kith_options *options) {
  struct stress w = {.options = options};
  enum kith_exit code = KITH_EXIT_USAGE;
  if (options->subject != NULL && strcmp(options->subject, "list") == 0) return list();
  setenv("OMP_WAIT_POLICY", "passive", 0); /* small runs on few cores: who waits, sleeps */
  kith_status status = choose(&w);
  if (status == KITH_OK) status = kith_programs_find(&w.programs);
  if (status == KITH_OK) status = check_overrides(&w);
  if (status == KITH_OK)
    status = kith_matrix_open(&w.matrix, options->directory != NULL ? options->directory : "out/stress",
                              options->threads, CPU_LIMIT);
  if (status == KITH_OK) {
    code = KITH_EXIT_FAILED;
    status = run_all(&w);
  }
  if (status == KITH_OK) {
    print_table(w.n, w.ladder);
    printf("%d runs; %s/stress.html\n", w.all, w.matrix->directory);
    code = verdict(&w);
  } else {
    fprintf(stderr, "kith: %s\n", kith_failure());
  }
  kith_matrix_close(&w.matrix);
  kith_free(&w.ladder);
  return code;
}
