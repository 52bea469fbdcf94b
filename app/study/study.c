/* study.c - jobs as child processes, and the numbers of their reports; from suites to points, what is kept of
 * runs, and what is written. */
#include "app/study/study.h"

#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "app/cli/text.h"
#include "app/scene/config.h"
#include "lib/core/version.h"
#include "lib/io/atomic_file.h"

kith_status kith_job_set(struct kith_job *job, const char *assignment) {
  const size_t used = strlen(job->settings), length = strlen(assignment);
  int *count = strncmp(assignment, "ranks=", 6) == 0     ? &job->ranks
               : strncmp(assignment, "threads=", 8) == 0 ? &job->threads
                                                         : NULL;
  if (count != NULL) {
    char *end;
    const long value = strtol(strchr(assignment, '=') + 1, &end, 10);
    if (*end != '\0' || value < 1 || value > KITH_MAX_STARTED)
      KITH_FAIL(BAD_INPUT, "%.80s: not one of 1 to %d", assignment, KITH_MAX_STARTED);
    *count = (int)value;
    return KITH_OK;
  }
  if (strchr(assignment, '=') == NULL || strchr(assignment, '\n') != NULL)
    KITH_FAIL(BAD_INPUT, "'%.80s' is not key=value on one line", assignment);
  if (used + length + 2 > sizeof job->settings)
    KITH_FAIL(BAD_INPUT, "%.80s: the settings of a run are too long", assignment);
  kith_text_add(job->settings, sizeof job->settings, "%s\n", assignment);
  return KITH_OK;
}

/* Finds why a run failed: the last line of its log that begins with "kith: " and is no warning, or its
 * end. */
static void find_reason(const char *log, double cpu_limit, struct kith_job_end *end) {
  char line[2100];
  FILE *file = fopen(log, "r");
  end->told = end->code == -SIGXCPU || (end->code == -SIGKILL && cpu_limit > 0);
  snprintf(end->why, sizeof end->why, end->code < 0 ? "ended by signal %d" : "exit code %d", abs(end->code));
  if (end->told)
    snprintf(end->why, sizeof end->why, "took more processor time than a run may have");
  else if (end->code == -SIGKILL)
    snprintf(end->why, sizeof end->why, "killed from outside");
  while (file != NULL && end->code > 0 && fgets(line, sizeof line, file) != NULL) {
    if (strncmp(line, "kith: ", 6) != 0 || strncmp(line, "kith: warning: ", 15) == 0) continue;
    line[strcspn(line, "\n")] = '\0';
    char *state = strstr(line, "; its state is in "); /* a snapshot, which is deleted */
    if (state != NULL) *state = '\0';
    snprintf(end->why, sizeof end->why, "%.1000s", line + 6);
    end->told = true;
  }
  if (file != NULL) fclose(file);
}

kith_status kith_job_run(const struct kith_programs *programs, const struct kith_job *job, const char *verb,
                         const char *directory, const char *log, double cpu_limit, struct kith_job_end *end) {
  char text[4 * KITH_JOB_SETTINGS], *words[KITH_JOB_SETTINGS / 2] = {0};
  FILE *f = fmemopen(text, sizeof text, "w"); /* a word on each line */
  if (f == NULL) KITH_FAIL(NO_MEMORY, "no memory for the words of a run");
  fprintf(f, "%s%dd\n%s\n%s\n", programs->prefix, job->dimension, verb, job->scene);
  if (strcmp(verb, "run") == 0) fputs("--quiet\n", f); /* plan has nothing else to say */
  fprintf(f, "--set=dimension=%d\n--set=output.plot=false", job->dimension);
  if (job->threads > 0) fprintf(f, "\n--threads=%d", job->threads);
  if (job->ranks > 1 && directory != NULL) fprintf(f, "\n--ranks=%d", job->ranks);
  if (job->steps > 0 && directory != NULL) fprintf(f, "\n--steps=%d", job->steps);
  if (job->restart[0] != '\0') fprintf(f, "\n--restart=%s", job->restart);
  if (directory != NULL) fprintf(f, "\n-o\n%s\n--overwrite", directory);
  for (const char *s = job->settings; *s != '\0'; s += strcspn(s, "\n") + 1)
    fprintf(f, "\n--set=%.*s", (int)strcspn(s, "\n"), s);
  if (fclose(f) != 0) KITH_FAIL(BAD_INPUT, "the settings of a run are too long");
  int n = 0;
  for (char *rest = text; rest != NULL;) words[n++] = strsep(&rest, "\n");
  unlink(log);
  if (directory != NULL) { /* otherwise a restart would continue the history of an earlier run there */
    char history[KITH_JOB_PATH + 16];
    snprintf(history, sizeof history, "%s/history.csv", directory);
    unlink(history);
  }
  setenv("OMP_WAIT_POLICY", "passive", 0); /* small runs on few cores: threads that wait must sleep */
  const kith_status status = kith_process_run(words, log, cpu_limit, &end->code);
  const int code = end->code;
  if (status != KITH_OK || code == 0) return status;
  find_reason(log, cpu_limit, end);
  if (code == 127) KITH_FAIL(BAD_FILE, "cannot start %s%dd", programs->prefix, job->dimension);
  if (code == -SIGINT || code == -SIGTERM || code == -SIGHUP || strncmp(end->why, "stopped; go on", 14) == 0)
    KITH_FAIL(BAD_FILE, "a run was stopped from outside, see %s", log);
  if (strstr(end->why, KITH_CLAIMED) != NULL) /* that of a study which was killed, and is about to end */
    KITH_FAIL(BAD_FILE, "%s", end->why);
  return KITH_OK;
}

kith_status kith_job_check(const struct kith_programs *programs, const struct kith_job *job, const char *file,
                           const char *what) {
  char log[64];
  struct kith_job_end end = {0};
  FILE *said = tmpfile();
  if (said == NULL) KITH_FAIL(BAD_FILE, "no temporary file: %s", strerror(errno));
  snprintf(log, sizeof log, "/proc/self/fd/%d", fileno(said));
  const kith_status status = kith_job_run(programs, job, "plan", NULL, log, 0, &end);
  fclose(said);
  if (status != KITH_OK || end.code != KITH_EXIT_USAGE) return status;
  if (file == NULL) KITH_FAIL(BAD_INPUT, "%s", end.why);
  KITH_FAIL(BAD_INPUT, "%s:%d: %s %s: %s", file, job->line, what, job->label, end.why);
}

int kith_measure_parse(const char *measure, char key[2][128]) {
  int end[3] = {0}, n = 3;
  if (strcmp(measure, "shock") == 0) measure = "norms.shock_radius / norms.shock_exact - 1";
  sscanf(measure, "%127s %n/ %127s %n- 1 %n", key[0], &end[0], key[1], &end[1], &end[2]);
  while (n > 0 && (end[n - 1] == 0 || measure[end[n - 1]] != '\0')) --n;
  return n;
}

/* The value below `object` at a dotted path; NULL if there is none. Borrowed. */
static const json_t *at(const json_t *object, const char *path) {
  for (const char *key = path; object != NULL && *key != '\0';) {
    const size_t length = strcspn(key, ".");
    object = json_object_getn(object, key, length);
    key += length + (key[length] == '.');
  }
  return object;
}

kith_status kith_report_measure(const char *path, const char *measure, double *value) {
  char key[2][128];
  double number[2] = {NAN, 1};
  const char *missing = NULL, *what = "";
  json_error_t error;
  const int parts = kith_measure_parse(measure, key), n_keys = parts > 1 ? 2 : 1;
  json_t *report = json_load_file(path, 0, &error);
  *value = NAN;
  if (report == NULL) KITH_FAIL(BAD_FILE, "%s:%d: %s", path, error.line, error.text);
  for (int k = 0; k < n_keys && missing == NULL; ++k) {
    const json_t *found = at(report, key[k]);
    if (json_is_number(found))
      number[k] = json_number_value(found);
    else
      missing = key[k], what = found == NULL ? "not there" : json_is_null(found) ? "null" : "not a number";
  }
  json_decref(report);
  if (missing != NULL) KITH_FAIL(BAD_FILE, "%s: %s is %s", path, missing, what);
  *value = parts > 2 ? fabs(number[0] / number[1] - 1) : number[0] / number[1];
  return KITH_OK;
}

/* FNV-1a, 64 bits. */
static uint64_t hash(uint64_t h, const char *bytes, size_t n) {
  for (size_t k = 0; k < n; ++k) h = (h ^ (unsigned char)bytes[k]) * UINT64_C(0x100000001b3);
  return h;
}

static uint64_t hash_file(uint64_t h, const char *path) {
  char bytes[4096];
  FILE *file = fopen(path, "rb");
  for (size_t n; file != NULL && (n = fread(bytes, 1, sizeof bytes, file)) > 0;) h = hash(h, bytes, n);
  if (file != NULL) fclose(file);
  return h;
}

/* Hashes the tables that `file` of a material names: one, or one for each dimension. */
static uint64_t hash_tables(uint64_t h, const struct kith_config_node *file) {
  char path[4096];
  if (file == NULL) return h;
  if (file->text != NULL) h = hash_file(h, kith_config_beside(file, path, sizeof path));
  for (const struct kith_config_node *child = file->first; child != NULL; child = child->next)
    h = hash_tables(h, child);
  return h;
}

/* Hashes the scene with its bases and settings, and the tables of its materials. A setting that is wrong is
 * left to the run to report. */
static kith_status hash_scene(uint64_t *h, const struct kith_job *job) {
  struct kith_config *scene;
  char *text = NULL, line[KITH_JOB_SETTINGS];
  KITH_TRY(kith_config_read(&scene, job->scene));
  for (const char *s = job->settings; *s != '\0'; s += strcspn(s, "\n") + 1) {
    snprintf(line, sizeof line, "%.*s", (int)strcspn(s, "\n"), s);
    kith_config_override(scene, line);
  }
  const struct kith_config_node *materials = kith_config_at(scene, "materials");
  for (const struct kith_config_node *m = materials != NULL ? materials->first : NULL; m != NULL; m = m->next)
    *h = hash_tables(*h, kith_config_child(m, "file"));
  const kith_status status = kith_config_emit(scene->root, false, &text);
  if (status == KITH_OK) *h = hash(*h, text, strlen(text));
  kith_free(&text);
  kith_config_destroy(&scene);
  return status;
}

/* Writes DIR/runs/sph-limited-100-0123456789abcdef: method, value, hash of all that the run depends on. */
static kith_status run_directory(const struct kith_study *s, const struct kith_job *job,
                                 char path[KITH_JOB_PATH]) {
  char text[KITH_PATH + 8], *name = path + snprintf(path, KITH_JOB_PATH, "%s/runs/", s->directory);
  uint64_t key = UINT64_C(0xcbf29ce484222325);
  KITH_TRY(hash_scene(&key, job));
  snprintf(text, sizeof text, "%s%dd", s->programs.prefix, job->dimension);
  key = hash_file(key, text); /* a commit does not tell what was changed after it */
  snprintf(text, sizeof text, "%s %s %d %d %d\n", kith_version(), kith_commit() != NULL ? kith_commit() : "",
           job->dimension, job->threads, KITH_MAX(job->ranks, 1));
  key = hash(hash(key, text, strlen(text)), job->settings, strlen(job->settings));
  snprintf(name, KITH_JOB_PATH - (size_t)(name - path), "%s-%s-%016" PRIx64, job->label, job->value, key);
  for (char *c = name; *c != '\0'; ++c)
    if (strchr("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.-+", *c) == NULL) *c = '-';
  if (name[0] == '.') name[0] = '-';
  return KITH_OK;
}

/* Removes the snapshots of a run: those of a hundred runs fill a disk. */
static void remove_snapshots(const char *directory) {
  DIR *entries = opendir(directory);
  if (entries == NULL) return;
  for (struct dirent *e; (e = readdir(entries)) != NULL;)
    if (strncmp(e->d_name, "snapshot", strlen("snapshot")) == 0) unlinkat(dirfd(entries), e->d_name, 0);
  closedir(entries);
}

/* Runs the job into PATH.part, and renames that to PATH; of a failure the reason is kept, if a run that is
 * tried again would have it, too. */
static kith_status run_new(const struct kith_study *s, double cpu_limit, const struct kith_job *job,
                           const char *path, const char *failure, struct kith_point *p) {
  char part[KITH_JOB_PATH + 8], log[KITH_JOB_PATH + 8];
  struct kith_job_end end = {0};
  snprintf(part, sizeof part, "%s.part", path);
  snprintf(log, sizeof log, "%s.log", path);
  KITH_TRY(kith_job_run(&s->programs, job, "run", part, log, cpu_limit, &end));
  remove_snapshots(part);
  p->failed = end.code != 0;
  snprintf(p->why, sizeof p->why, "%.255s", end.why);
  if (p->failed && !end.told) return KITH_OK;
  FILE *file = p->failed ? fopen(failure, "w") : NULL;
  bool kept = p->failed ? file != NULL && fputs(p->why, file) != EOF : rename(part, path) == 0;
  if (file != NULL) kept = fclose(file) == 0 && kept;
  return kept ? KITH_OK : kith_fail(KITH_BAD_FILE, "%s: %s", p->failed ? failure : path, strerror(errno));
}

static bool earlier_failure(const char *path, char why[256]) {
  FILE *file = fopen(path, "r");
  if (file == NULL) return false;
  why[fread(why, 1, 255, file)] = '\0';
  fclose(file);
  return true;
}

void kith_study_put_quoted(FILE *out, const char *text) {
  fputc('"', out);
  for (const char *s = text; *s != '\0'; ++s) {
    if (*s == '"') fputc('"', out);
    fputc((unsigned char)*s < ' ' ? ' ' : *s, out);
  }
  fputc('"', out);
}

static kith_status put_point(struct kith_study *s, const struct kith_suite *suite, const struct kith_job *job,
                             const struct kith_point *p) {
  struct kith_csv_log *table = &s->table;
  const char *const texts[] = {job->label, job->value, p->failed ? "failed" : "ok", p->why, job->settings};
  if (s->n > 1) kith_study_put_quoted(table->file, suite->name), fputc(',', table->file);
  for (size_t k = 0; k < sizeof texts / sizeof *texts; ++k) {
    if (k > 0) fputc(',', table->file);
    kith_study_put_quoted(table->file, texts[k]);
  }
  for (int k = 0; k < KITH_MEASURES + suite->n_measures; ++k) fprintf(table->file, ",%.9g", p->value[k]);
  return kith_csv_log_row(table);
}

/* Prints "[3/12] sph at 100: norms.density.l1 0.0203, 0.01 CPU-s". */
static void show_progress(const struct kith_study *s, const struct kith_suite *suite,
                          const struct kith_job *job, const struct kith_point *p) {
  if (s->options->quiet) return;
  fprintf(stderr, "[%d/%d] %s at %s", s->n_done, s->n_jobs, job->label, job->value);
  if (p->failed)
    fprintf(stderr, " failed: %s\n", p->why);
  else
    fprintf(stderr, ": %s %.4g, %.3g CPU-s\n", suite->measure[0], p->value[KITH_MEASURES],
            p->value[KITH_CPU_SECONDS]);
}

static const char *const common[KITH_MEASURES] = {"cpu_seconds", "pair_evaluations", "nodes", "steps",
                                                  "energy_drift"};

static kith_status prepare(struct kith_study *s) {
  char path[KITH_PATH + 16], names[1024] = "";
  snprintf(path, sizeof path, "%s/runs", s->directory);
  KITH_TRY(kith_directory_make(path));
  KITH_TRY(kith_directory_claim(s->directory, &s->lock));
  strcat(strcat(names, s->n > 1 ? "sweep," : ""), "method,value,status,why,settings");
  for (int k = 0; k < KITH_MEASURES; ++k) strcat(strcat(names, ","), common[k]);
  for (int k = 0; k < s->suite->n_measures; ++k)
    strcat(strcat(names, ","), s->n > 1 ? "measure" : s->suite->measure[k]);
  for (int k = 0; k < s->n; ++k) s->n_jobs += s->suite[k].n_methods * s->suite[k].n_values;
  return kith_csv_log_open(&s->table, s->directory, "points.csv", names, NULL);
}

/* Runs a job, or reads what an earlier study has of it. A run that fails is a point too. */
static kith_status run_job(struct kith_study *s, double cpu_limit, const struct kith_suite *suite,
                           struct kith_job *job, struct kith_point *p) {
  char path[KITH_JOB_PATH], failure[KITH_JOB_PATH + 16], report[KITH_JOB_PATH + 16];
  if (job->threads == 0) job->threads = KITH_MAX(s->options->threads, 1);
  KITH_TRY(run_directory(s, job, path));
  snprintf(failure, sizeof failure, "%s.failed", path);
  snprintf(report, sizeof report, "%s/report.json", path);
  p->failed = earlier_failure(failure, p->why);
  const bool found = p->failed || access(report, R_OK) == 0;
  if (!found) KITH_TRY(run_new(s, cpu_limit, job, path, failure, p));
  for (int k = 0; k < KITH_MEASURES + suite->n_measures; ++k) {
    const char *measure = k < KITH_MEASURES ? common[k] : suite->measure[k - KITH_MEASURES];
    if (!p->failed && kith_report_measure(report, measure, &p->value[k]) == KITH_OK) continue;
    p->value[k] = NAN;
    if (k < KITH_MEASURES || p->failed) continue; /* the numbers common to all studies may be missing */
    snprintf(p->why, sizeof p->why, "%.250s", kith_failure());
    p->failed = true;
  }
  ++s->n_done, s->n_failed += p->failed;
  if (!found) show_progress(s, suite, job, p);
  return put_point(s, suite, job, p);
}

/* Runs all jobs, the first values of all methods first: a study that is interrupted has something of each. */
static kith_status run_all(struct kith_study *s, double cpu_limit) {
  for (struct kith_suite *suite = s->suite; suite < s->suite + s->n; ++suite)
    for (int v = 0; v < suite->n_values; ++v)
      for (int j = v; j < suite->n_methods * suite->n_values; j += suite->n_values)
        KITH_TRY(run_job(s, cpu_limit, suite, &suite->job[j], &suite->point[j]));
  return kith_csv_log_close(&s->table);
}

static kith_status write_all(const struct kith_study *s, const struct kith_study_verb *verb) {
  char path[KITH_PATH + 16];
  struct kith_atomic_file *file;
  if (verb->draw != NULL) KITH_TRY(verb->draw(s));
  snprintf(path, sizeof path, "%s/%s.md", s->directory, verb->name);
  KITH_TRY(kith_atomic_file_open(&file, path));
  verb->put(file->stream, s, true);
  KITH_TRY(kith_atomic_file_commit(&file, false));
  verb->put(stdout, s, false);
  printf("\n%d runs, %d failed; %s\n", s->n_jobs, s->n_failed, path);
  return KITH_OK;
}

void kith_study_clear(struct kith_study *study) {
  for (struct kith_suite *s = study->suite; s < study->suite + study->n; ++s)
    KITH_FREE(&s->job, &s->point, &s->code);
  kith_free(&study->suite);
  study->n = 0;
}

static kith_status carry_out(struct kith_study *s, const struct kith_study_verb *verb, enum kith_exit *code) {
  KITH_TRY(verb->read(s));
  KITH_TRY(prepare(s));
  *code = KITH_EXIT_FAILED;
  KITH_TRY(run_all(s, verb->cpu_limit));
  KITH_TRY(write_all(s, verb));
  *code = verb->verdict(s);
  return KITH_OK;
}

enum kith_exit kith_study_run(const struct kith_study_verb *verb, const struct kith_options *options) {
  struct kith_study s = {.options = options};
  enum kith_exit code = KITH_EXIT_USAGE;
  const bool listing = options->subject != NULL && strcmp(options->subject, "list") == 0;
  kith_status status = kith_programs_find(&s.programs);
  if (status == KITH_OK) status = listing ? verb->list(&s) : carry_out(&s, verb, &code);
  if (status == KITH_OK && listing) code = KITH_EXIT_OK;
  if (status == KITH_NO_MEMORY) code = KITH_EXIT_FAILED;
  if (status != KITH_OK) fprintf(stderr, "kith: %s\n", kith_failure());
  kith_csv_log_close(&s.table);
  if (s.lock > 0) close(s.lock);
  kith_study_clear(&s);
  return code;
}
