/* campaign.c - jobs as child processes, their numbers, and what is kept of them. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* memfd_create, strtok_r */
#endif
#include "app/study/campaign.h"

#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include "app/cli/text.h"
#include "app/cli/version.h"
#include "lib/core/profile.h"

/* ---- jobs ---- */

kith_status kith_job_set(struct kith_job *job, const char *assignment) {
  enum { MOST_RANKS = 4096 };
  const size_t used = strlen(job->settings), length = strlen(assignment);
  if (strncmp(assignment, "ranks=", strlen("ranks=")) == 0) {
    char *end;
    const long ranks = strtol(assignment + strlen("ranks="), &end, 10);
    if (*end != '\0' || ranks < 1 || ranks > MOST_RANKS)
      KITH_FAIL(BAD_INPUT, "%.80s: not one of 1 to %d processes", assignment, MOST_RANKS);
    job->ranks = (int)ranks;
    return KITH_OK;
  }
  if (strchr(assignment, '=') == NULL || strchr(assignment, '\n') != NULL)
    KITH_FAIL(BAD_INPUT, "'%.80s' is not key=value on one line", assignment);
  if (used + length + 2 > sizeof job->settings)
    KITH_FAIL(BAD_INPUT, "%.80s: the settings of a run are too long", assignment);
  snprintf(job->settings + used, sizeof job->settings - used, "%s\n", assignment);
  return KITH_OK;
}

kith_status kith_job_set_words(struct kith_job *job, const char *settings) {
  char text[KITH_JOB_SETTINGS], *rest;
  snprintf(text, sizeof text, "%s", settings);
  for (char *word = strtok_r(text, " ", &rest); word != NULL; word = strtok_r(NULL, " ", &rest))
    KITH_TRY(kith_job_set(job, word));
  return KITH_OK;
}

/* The last line of a log that starts with "kith: " and is no warning. */
static void find_reason(const char *log, int code, char why[256]) {
  char line[1024];
  FILE *file = fopen(log, "r");
  snprintf(why, 256, code < 0 ? "ended by signal %d" : "exit code %d", abs(code));
  if (code == -SIGXCPU || code == -SIGKILL)
    snprintf(why, 256, "took more processor time than a run may have");
  while (file != NULL && code > 0 && fgets(line, sizeof line, file) != NULL) {
    if (strncmp(line, "kith: ", 6) != 0 || strncmp(line, "kith: warning: ", 15) == 0) continue;
    line[strcspn(line, "\n")] = '\0';
    char *state = strstr(line, "; its state is in "); /* a snapshot, which goes */
    if (state != NULL) *state = '\0';
    snprintf(why, 256, "%.255s", line + 6);
  }
  if (file != NULL) fclose(file);
}

kith_status kith_job_run(const struct kith_programs *programs, const struct kith_job *job, const char *verb,
                         const char *directory, const char *log, double cpu_limit, int *code, char why[256]) {
  enum { WORDS = 2 * 128 };
  char program[KITH_PATH + 8], dimension[16], threads[16], ranks[16], steps[16], settings[KITH_JOB_SETTINGS];
  const char *words[WORDS];
  char *rest;
  int n = 0;
  snprintf(program, sizeof program, "%s%dd", programs->prefix, job->dimension);
  snprintf(dimension, sizeof dimension, "dimension=%d", job->dimension);
  snprintf(threads, sizeof threads, "%d", job->threads);
  snprintf(ranks, sizeof ranks, "%d", job->ranks);
  snprintf(steps, sizeof steps, "%d", job->steps);
  memcpy(settings, job->settings, sizeof settings);
  words[n++] = program, words[n++] = verb, words[n++] = job->scene, words[n++] = "--quiet";
  words[n++] = "--set", words[n++] = dimension, words[n++] = "--set", words[n++] = "output.plot=false";
  if (job->threads > 0) words[n++] = "--threads", words[n++] = threads;
  if (job->ranks > 1 && directory != NULL) words[n++] = "--ranks", words[n++] = ranks;
  if (job->steps > 0) words[n++] = "--steps", words[n++] = steps;
  if (job->restart[0] != '\0') words[n++] = "--restart", words[n++] = job->restart;
  if (directory != NULL) words[n++] = "-o", words[n++] = directory;
  for (char *word = strtok_r(settings, "\n", &rest); word != NULL; word = strtok_r(NULL, "\n", &rest)) {
    if (n + 3 > WORDS) KITH_FAIL(BAD_INPUT, "%.80s: too many settings for a run", word);
    words[n++] = "--set", words[n++] = word;
  }
  words[n] = NULL;
  unlink(log);
  KITH_TRY(kith_process_run((char *const *)words, log, cpu_limit, code));
  if (*code == 0) return KITH_OK;
  find_reason(log, *code, why);
  if (*code == 127) KITH_FAIL(BAD_FILE, "cannot start %s", program);
  if (*code == -SIGINT || *code == -SIGTERM || *code == -SIGHUP || strncmp(why, "stopped by signal", 17) == 0)
    KITH_FAIL(BAD_FILE, "a run was stopped from outside, see %s", log);
  return KITH_OK;
}

kith_status kith_job_check(const struct kith_programs *programs, const struct kith_job *job) {
  char log[64], why[256];
  int code = 0;
  const int file = memfd_create("plan", 0);
  if (file < 0) KITH_FAIL(INTERNAL, "no file in memory: %s", strerror(errno));
  snprintf(log, sizeof log, "/proc/self/fd/%d", file);
  const kith_status status = kith_job_run(programs, job, "plan", NULL, log, 0, &code, why);
  close(file);
  return status == KITH_OK && code == 2 ? kith_fail(KITH_BAD_INPUT, "%s", why) : status;
}

/* ---- numbers ---- */

const char kith_norm_choices[] =
    "density.l1|density.l2|density.linf|velocity.l1|velocity.l2|velocity.linf|pressure.l1|pressure.l2|"
    "pressure.linf|energy.l1|energy.l2|energy.linf|speed.l1|speed.l2|speed.linf|"
    "contact_pressure_error|density_peak";

kith_status kith_report_measure(const char *report, const char *measure, double *value) {
  char key[128];
  double divisor;
  if (strcmp(measure, "shock") == 0) measure = "norms.shock_radius / norms.shock_exact - 1";
  const char *slash = strstr(measure, " / "), *minus = strstr(measure, " - 1");
  if (slash == NULL) return kith_report_number(report, measure, value);
  snprintf(key, sizeof key, "%.*s", (int)(slash - measure), measure);
  KITH_TRY(kith_report_number(report, key, value));
  slash += strlen(" / ");
  snprintf(key, sizeof key, "%.*s", minus != NULL ? (int)(minus - slash) : (int)strlen(slash), slash);
  KITH_TRY(kith_report_number(report, key, &divisor));
  *value = minus != NULL ? fabs(*value / divisor - 1) : *value / divisor;
  return KITH_OK;
}

/* ---- what is kept ---- */

/* FNV-1a, 64 bits. */
static uint64_t hash(uint64_t h, const char *text) {
  for (; *text != '\0'; ++text) h = (h ^ (unsigned char)*text) * UINT64_C(0x100000001b3);
  return h;
}

/* DIR/runs/sph-limited-100-0123456789abcdef */
static void run_directory(const struct kith_campaign *c, const struct kith_job *job,
                          char path[KITH_JOB_PATH]) {
  char text[4096], *name = path + snprintf(path, KITH_JOB_PATH, "%s/runs/", c->directory);
  uint64_t key = UINT64_C(0xcbf29ce484222325);
  FILE *scene = fopen(job->scene, "r");
  while (scene != NULL && fgets(text, sizeof text, scene) != NULL) key = hash(key, text);
  if (scene != NULL) fclose(scene);
  snprintf(text, sizeof text, "%s %d %d %d\n", kith_version(), job->dimension, job->threads,
           KITH_MAX(job->ranks, 1));
  key = hash(hash(key, text), job->settings);
  snprintf(name, KITH_JOB_PATH - (size_t)(name - path), "%s-%s-%016" PRIx64, job->label, job->value, key);
  for (char *c0 = name; *c0 != '\0'; ++c0)
    if (strchr("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.-+", *c0) == NULL) *c0 = '-';
  if (name[0] == '.') name[0] = '-';
}

/* Snapshots of a hundred runs fill a disk. */
static void remove_snapshots(const char *directory) {
  DIR *entries = opendir(directory);
  if (entries == NULL) return;
  for (struct dirent *e; (e = readdir(entries)) != NULL;)
    if (strncmp(e->d_name, "snapshot", strlen("snapshot")) == 0) unlinkat(dirfd(entries), e->d_name, 0);
  closedir(entries);
}

static kith_status keep_failure(const char *path, const char *why) {
  FILE *file = fopen(path, "w");
  if (file == NULL || fputs(why, file) == EOF || fclose(file) != 0)
    KITH_FAIL(BAD_FILE, "%s: %s", path, strerror(errno));
  return KITH_OK;
}

static bool earlier_failure(const char *path, char why[256]) {
  FILE *file = fopen(path, "r");
  if (file == NULL) return false;
  why[fread(why, 1, 255, file)] = '\0';
  fclose(file);
  return true;
}

/* Runs the job into PATH.part, and names it PATH. */
static kith_status run_new(const struct kith_campaign *c, const struct kith_job *job, const char *path,
                           const char *failure, struct kith_point *p) {
  char part[KITH_JOB_PATH + 8], log[KITH_JOB_PATH + 8];
  int code;
  snprintf(part, sizeof part, "%s.part", path);
  snprintf(log, sizeof log, "%s.log", path);
  KITH_TRY(kith_job_run(&c->programs, job, "run", part, log, c->cpu_limit, &code, p->why));
  remove_snapshots(part);
  p->failed = code != 0;
  if (p->failed) return keep_failure(failure, p->why);
  if (rename(part, path) != 0) KITH_FAIL(BAD_FILE, "%s: %s", path, strerror(errno));
  return KITH_OK;
}

/* ---- the table and the progress ---- */

void kith_csv_quoted(FILE *out, const char *text) {
  fputc('"', out);
  for (const char *s = text; *s != '\0'; ++s) {
    if (*s == '"') fputc('"', out);
    fputc((unsigned char)*s < ' ' ? ' ' : *s, out);
  }
  fputc('"', out);
}

static void put_point(const struct kith_campaign *c, const struct kith_job *job, const struct kith_point *p) {
  const char *const texts[] = {job->label, job->value, p->failed ? "failed" : "ok", p->why, job->settings};
  for (size_t k = 0; k < sizeof texts / sizeof *texts; ++k) {
    if (k > 0) fputc(',', c->table);
    kith_csv_quoted(c->table, texts[k]);
  }
  for (int k = 0; k < c->n_columns; ++k) fprintf(c->table, ",%.9g", p->value[k]);
  fputc('\n', c->table);
  fflush(c->table);
}

/* "[3/12] sph at 100: norms.density.l1 0.0203, 0.01 CPU-s; about 2 min left" */
static void show_progress(const struct kith_campaign *c, const struct kith_job *job,
                          const struct kith_point *p) {
  char text[32];
  const bool terminal = isatty(STDERR_FILENO);
  if (c->quiet || (p == NULL && !terminal)) return;
  fprintf(stderr, "%s[%d/%d] %s at %s", terminal ? "\r\033[K" : "", c->n_done + (p == NULL), c->n_jobs,
          job->label, job->value);
  if (p != NULL && p->failed) fprintf(stderr, " failed: %s", p->why);
  if (p != NULL && !p->failed)
    fprintf(stderr, ": %s %.4g, %.3g CPU-s", c->column[KITH_MEASURES], p->value[KITH_MEASURES],
            p->value[KITH_CPU_SECONDS]);
  if (p != NULL && c->n_done < c->n_jobs)
    fprintf(stderr, "; about %s left",
            kith_text_seconds(text, c->seconds_run / c->weight_run * c->weight_left));
  if (p != NULL) fputc('\n', stderr);
  fflush(stderr);
}

/* ---- from outside ---- */

kith_status kith_campaign_open(struct kith_campaign *c, int n_measures, const char *const *measure,
                               int n_jobs, double weight) {
  static const char *const common[KITH_MEASURES] = {"cpu_seconds", "pair_evaluations", "nodes", "steps",
                                                    "energy_drift"};
  char path[KITH_PATH + 16];
  snprintf(path, sizeof path, "%s/runs", c->directory);
  KITH_TRY(kith_directory_make(path));
  snprintf(path, sizeof path, "%s/points.csv", c->directory);
  c->table = fopen(path, "w");
  if (c->table == NULL) KITH_FAIL(BAD_FILE, "%s: %s", path, strerror(errno));
  c->n_jobs = n_jobs, c->weight_left = weight;
  for (int k = 0; k < KITH_MEASURES; ++k) c->column[c->n_columns++] = common[k];
  for (int k = 0; k < n_measures; ++k) c->column[c->n_columns++] = measure[k];
  fputs("method,value,status,why,settings", c->table);
  for (int k = 0; k < c->n_columns; ++k) fprintf(c->table, ",%s", c->column[k]);
  fputc('\n', c->table);
  setenv("OMP_WAIT_POLICY", "passive", 0); /* small runs on few cores: threads that wait must sleep */
  return KITH_OK;
}

kith_status kith_campaign_run(struct kith_campaign *c, const struct kith_job *job, struct kith_point *p) {
  char path[KITH_JOB_PATH], failure[KITH_JOB_PATH + 16], report[KITH_JOB_PATH + 16];
  const double begun = kith_seconds();
  *p = (struct kith_point){0};
  run_directory(c, job, path);
  snprintf(failure, sizeof failure, "%s.failed", path);
  snprintf(report, sizeof report, "%s/report.json", path);
  p->failed = earlier_failure(failure, p->why);
  const bool found = p->failed || access(report, R_OK) == 0;
  if (!found) {
    show_progress(c, job, NULL);
    KITH_TRY(run_new(c, job, path, failure, p));
    c->weight_run += job->weight, c->seconds_run += kith_seconds() - begun;
  }
  for (int k = 0; k < c->n_columns; ++k)
    if (p->failed || kith_report_measure(report, c->column[k], &p->value[k]) != KITH_OK) p->value[k] = NAN;
  ++c->n_done, c->n_failed += p->failed, c->weight_left -= job->weight;
  put_point(c, job, p);
  if (!found) show_progress(c, job, p);
  return KITH_OK;
}

kith_status kith_campaign_close(struct kith_campaign *c) {
  if (c->table == NULL) return KITH_OK;
  const bool written = ferror(c->table) == 0, closed = fclose(c->table) == 0;
  c->table = NULL;
  return written && closed ? KITH_OK : kith_fail(KITH_BAD_FILE, "%s/points.csv: cannot write", c->directory);
}
