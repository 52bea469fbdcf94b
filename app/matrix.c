#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include "app/matrix.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include "app/config.h"
#include "app/version.h"
#include "app/words.h"

const struct kith_metric kith_metrics[KITH_N_METRICS] = {
#define X(name, path, doc) {#name, path, doc},
    KITH_METRIC_LIST(X)
#undef X
};
const char kith_metric_words[] = ""
#define X(name, path, doc) "|" #name
    KITH_METRIC_LIST(X)
#undef X
    ;

int kith_metric_find(const char *name) {
  return kith_words_find(kith_metric_words, name);
}

/* --- jobs --- */

static kith_status set_ranks(struct kith_job *job, const char *value) {
  enum { MOST = 4096 };
  char *end;
  const long ranks = strtol(value, &end, 10);
  if (end == value || *end != '\0' || ranks < 1 || ranks > MOST)
    KITH_FAIL(BAD_INPUT, "ranks: '%s' is not one of 1 to %d processes", value, MOST);
  job->ranks = (int)ranks;
  return KITH_OK;
}

kith_status kith_job_set(struct kith_job *job, const char *key, const char *value) {
  if (strcmp(key, "ranks") == 0) return set_ranks(job, value);
  if (job->n_settings == KITH_JOB_SETTINGS)
    KITH_FAIL(BAD_INPUT, "more than %d settings for a run", KITH_JOB_SETTINGS);
  const int length = snprintf(job->setting[job->n_settings], KITH_JOB_SETTING, "%s=%s", key, value);
  if (length >= KITH_JOB_SETTING)
    KITH_FAIL(BAD_INPUT, "%s: a setting of more than %d letters", key, KITH_JOB_SETTING - 1);
  ++job->n_settings;
  return KITH_OK;
}

/* FNV-1a, 64 bits. */
static uint64_t hash(uint64_t h, const void *bytes, size_t n) {
  for (size_t k = 0; k < n; ++k) h = (h ^ ((const unsigned char *)bytes)[k]) * UINT64_C(0x100000001b3);
  return h;
}

static uint64_t hash_file(uint64_t h, const char *path) {
  char block[4096];
  FILE *file = fopen(path, "rb");
  if (file == NULL) return h;
  for (size_t n; (n = fread(block, 1, sizeof block, file)) > 0;) h = hash(h, block, n);
  fclose(file);
  return h;
}

uint64_t kith_matrix_key(const struct kith_matrix *m, const struct kith_job *job) {
  const int numbers[] = {job->dimension, m->threads};
  uint64_t h = hash(hash_file(UINT64_C(0xcbf29ce484222325), job->scene), numbers, sizeof numbers);
  for (int k = 0; k < job->n_settings; ++k) h = hash(h, job->setting[k], strlen(job->setting[k]) + 1);
  if (job->ranks > 1) h = hash(h, &job->ranks, sizeof job->ranks);
  return h;
}

/* --- the file --- */

static void put_names(FILE *f) {
  fputs("key,version,method,x,status,why,settings", f);
  for (int k = 0; k < KITH_N_METRICS; ++k) fprintf(f, ",%s", kith_metrics[k].name);
  fputc('\n', f);
}

static void put_point(FILE *f, const struct kith_point *p, const struct kith_job *job) {
  fprintf(f, "%016" PRIx64 ",%s,", p->key, kith_version());
  kith_csv_quoted(f, p->method);
  fprintf(f, ",%.9g,%s,", p->x, p->failed ? "failed" : "ok");
  kith_csv_quoted(f, p->why);
  char all[KITH_JOB_SETTINGS * KITH_JOB_SETTING], *to = all;
  *to = '\0';
  for (int k = 0; k < job->n_settings; ++k) to += sprintf(to, "%s%s", k > 0 ? " " : "", job->setting[k]);
  fputc(',', f);
  kith_csv_quoted(f, all);
  for (int k = 0; k < KITH_N_METRICS; ++k) fprintf(f, ",%.17g", p->value[k]);
  fputc('\n', f);
}

static void read_point(const struct kith_csv *csv, int row, const int column[6 + KITH_N_METRICS],
                       struct kith_point *p) {
  *p = (struct kith_point){.key = strtoull(kith_csv_at(csv, row, column[0]), NULL, 16)};
  snprintf(p->method, sizeof p->method, "%s", kith_csv_at(csv, row, column[2]));
  p->x = strtod(kith_csv_at(csv, row, column[3]), NULL);
  p->failed = strcmp(kith_csv_at(csv, row, column[4]), "ok") != 0;
  snprintf(p->why, sizeof p->why, "%s", kith_csv_at(csv, row, column[5]));
  for (int k = 0; k < KITH_N_METRICS; ++k) p->value[k] = strtod(kith_csv_at(csv, row, column[6 + k]), NULL);
}

static kith_status find_columns(const struct kith_csv *csv, const char *path,
                                int column[6 + KITH_N_METRICS]) {
  static const char *const names[] = {"key", "version", "method", "x", "status", "why"};
  for (int k = 0; k < 6 + KITH_N_METRICS; ++k) {
    const char *name = k < 6 ? names[k] : kith_metrics[k - 6].name;
    column[k] = kith_csv_column(csv, name);
    if (column[k] < 0)
      KITH_FAIL(BAD_FILE, "%s: not of this version, it has no column '%s'; take another directory", path,
                name);
  }
  return KITH_OK;
}

static kith_status read_points(struct kith_matrix *m, const char *path, size_t *whole) {
  struct kith_csv *csv;
  int column[6 + KITH_N_METRICS];
  KITH_TRY(kith_csv_read(&csv, path, true));
  *whole = csv->whole;
  kith_status status = find_columns(csv, path, column);
  if (status == KITH_OK) status = kith_resize(&m->point, 0, (size_t)csv->n_rows, sizeof *m->point);
  for (int r = 0; status == KITH_OK && r < csv->n_rows; ++r)
    if (strcmp(kith_csv_at(csv, r, column[1]), kith_version()) == 0)
      read_point(csv, r, column, &m->point[m->n++]);
  kith_csv_destroy(&csv);
  return status;
}

static kith_status open_file(struct kith_matrix *m) {
  char path[KITH_PATH + 16];
  struct stat status;
  snprintf(path, sizeof path, "%s/points.csv", m->directory);
  m->lock = open(path, O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (m->lock < 0) KITH_FAIL(BAD_FILE, "%s: %s", path, strerror(errno));
  if (flock(m->lock, LOCK_EX | LOCK_NB) != 0) KITH_FAIL(BAD_FILE, "%s: another process writes it", path);
  if (fstat(m->lock, &status) != 0 || !S_ISREG(status.st_mode)) KITH_FAIL(BAD_FILE, "%s: not a file", path);
  size_t whole = 0;
  if (status.st_size > 0) {
    KITH_TRY(read_points(m, path, &whole));
    if (ftruncate(m->lock, (off_t)whole) != 0) KITH_FAIL(BAD_FILE, "%s: %s", path, strerror(errno));
  }
  m->file = fdopen(m->lock, "a");
  if (m->file == NULL) KITH_FAIL(BAD_FILE, "%s: %s", path, strerror(errno));
  if (whole == 0) put_names(m->file);
  return fflush(m->file) == 0 ? KITH_OK : kith_fail(KITH_BAD_FILE, "%s: %s", path, strerror(errno));
}

kith_status kith_matrix_open(struct kith_matrix **out, const char *directory, int threads, double cpu_limit) {
  struct kith_matrix *m = NULL;
  char runs[KITH_PATH + 8];
  *out = NULL;
  KITH_TRY(kith_resize(&m, 0, 1, sizeof *m));
  m->threads = KITH_MAX(threads, 1), m->cpu_limit = cpu_limit, m->lock = -1;
  snprintf(m->directory, sizeof m->directory, "%s", directory);
  snprintf(runs, sizeof runs, "%s/runs", directory);
  kith_status status = kith_programs_find(&m->programs);
  if (status == KITH_OK) status = kith_directory_make(runs);
  if (status == KITH_OK) status = open_file(m);
  if (status != KITH_OK) kith_matrix_close(&m);
  *out = m;
  return status;
}

void kith_matrix_close(struct kith_matrix **matrix) {
  struct kith_matrix *m = *matrix;
  if (m == NULL) return;
  if (m->file != NULL)
    fclose(m->file);
  else if (m->lock >= 0)
    close(m->lock);
  kith_free(&m->point);
  kith_free(matrix);
}

const struct kith_point *kith_matrix_find(const struct kith_matrix *m, uint64_t key) {
  for (int k = m->n - 1; k >= 0; --k)
    if (m->point[k].key == key) return &m->point[k];
  return NULL;
}

/* --- runs --- */

kith_status kith_job_start(const struct kith_matrix *m, const struct kith_job *job, const char *verb,
                           const char *directory, const char *log, int *code) {
  char program[KITH_PATH + 8], threads[16], dimension[16], ranks[16];
  const char *words[2 * KITH_JOB_SETTINGS + 16];
  int n = 0;
  snprintf(program, sizeof program, "%s%dd", m->programs.prefix, job->dimension);
  snprintf(threads, sizeof threads, "%d", m->threads);
  snprintf(dimension, sizeof dimension, "dimension=%d", job->dimension);
  words[n++] = program, words[n++] = verb, words[n++] = job->scene, words[n++] = "--quiet";
  words[n++] = "--threads", words[n++] = threads, words[n++] = "--set", words[n++] = dimension;
  words[n++] = "--set", words[n++] = "output.plot=false";
  snprintf(ranks, sizeof ranks, "%d", job->ranks);
  if (job->ranks > 1 && strcmp(verb, "run") == 0) words[n++] = "--ranks", words[n++] = ranks;
  for (int k = 0; k < job->n_settings; ++k) words[n++] = "--set", words[n++] = job->setting[k];
  if (directory != NULL) words[n++] = "-o", words[n++] = directory;
  words[n] = NULL;
  unlink(log);
  return kith_process_run((char *const *)words, log, m->cpu_limit, code);
}

void kith_log_reason(const char *log, int code, char why[256]) {
  static const char mark[] = "kith: ";
  char line[1024];
  FILE *file = fopen(log, "r");
  snprintf(why, 256, code < 0 ? "ended by signal %d" : "exit code %d", abs(code));
  if (code == -SIGXCPU || code == -SIGKILL)
    snprintf(why, 256, "took more processor time than a run may have");
  if (file == NULL) return;
  while (code > 0 && fgets(line, sizeof line, file) != NULL) {
    if (strncmp(line, mark, strlen(mark)) != 0 || strstr(line, "kith: warning: ") == line) continue;
    line[strcspn(line, "\n")] = '\0';
    char *state = strstr(line, "; its state is in "); /* which goes */
    if (state != NULL) *state = '\0';
    snprintf(why, 256, "%.255s", line + strlen(mark));
  }
  fclose(file);
}

/* "  cost          about 47.1 s: ..." of a plan, in seconds. */
static double planned_seconds(const char *log) {
  static const struct {
    const char *name;
    double seconds;
  } units[] = {{"us", 1e-6}, {"ms", 1e-3}, {"s", 1}, {"min", 60}, {"h", 3600}}; /* of kith_text_seconds */
  char line[512], unit[8];
  double value = NAN, seconds = NAN;
  FILE *file = fopen(log, "r");
  if (file == NULL) return NAN;
  while (fgets(line, sizeof line, file) != NULL) {
    if (sscanf(line, " cost about %lf %7[a-z]", &value, unit) != 2) continue;
    for (size_t k = 0; k < sizeof units / sizeof *units; ++k)
      if (strcmp(unit, units[k].name) == 0) seconds = value * units[k].seconds;
  }
  fclose(file);
  return seconds;
}

kith_status kith_job_plan(const struct kith_programs *programs, int threads, const struct kith_job *job,
                          int *code, double *seconds, char why[256]) {
  const struct kith_matrix bare = {.programs = *programs, .threads = threads};
  char log[64];
  const int file = memfd_create("plan", 0); /* what it prints leaves no trace */
  if (file < 0) KITH_FAIL(INTERNAL, "no file in memory: %s", strerror(errno));
  snprintf(log, sizeof log, "/proc/self/fd/%d", file);
  const kith_status status = kith_job_start(&bare, job, "plan", NULL, log, code);
  *seconds = status == KITH_OK && *code == 0 ? planned_seconds(log) : NAN;
  if (status == KITH_OK && *code != 0) kith_log_reason(log, *code, why);
  close(file);
  KITH_TRY(status);
  if (*code == 127 || *code < 0) KITH_FAIL(BAD_FILE, "cannot start %s%dd", programs->prefix, job->dimension);
  return KITH_OK;
}

static double number_at(const struct kith_config *report, const char *path) {
  const struct kith_config_node *node = kith_config_at(report, path);
  return node != NULL && node->kind == KITH_CONFIG_SCALAR && !node->null ? strtod(node->text, NULL) : NAN;
}

static kith_status read_report(struct kith_point *p, const char *path) {
  struct kith_config *report;
  KITH_TRY(kith_config_read(&report, path));
  for (int k = 0; k < KITH_N_METRICS; ++k) {
    p->value[k] = number_at(report, kith_metrics[k].path);
    const double exact = number_at(report, "norms.shock_exact"), start = number_at(report, "kinetic.start");
    if (strcmp(kith_metrics[k].name, "shock") == 0)
      p->value[k] = exact > 0 ? fabs(p->value[k] / exact - 1) : NAN;
    if (strcmp(kith_metrics[k].name, "kinetic.change") == 0)
      p->value[k] = start > 0 ? fabs(p->value[k] / start - 1) : NAN;
  }
  kith_config_destroy(&report);
  return KITH_OK;
}

/* Snapshots of a hundred runs fill a disk. */
static void drop_snapshots(const char *directory) {
  DIR *entries = opendir(directory);
  if (entries == NULL) return;
  for (struct dirent *e; (e = readdir(entries)) != NULL;)
    if (strncmp(e->d_name, "snapshot", strlen("snapshot")) == 0) unlinkat(dirfd(entries), e->d_name, 0);
  closedir(entries);
}

/* "sph-limited-100-0123abcd" */
static void run_name(const struct kith_job *job, uint64_t key, char name[160]) {
  int n = snprintf(name, 128, "%s-%.6g", job->method, job->x);
  for (char *c = name; *c != '\0'; ++c)
    if (strchr("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.-+", *c) == NULL) *c = '-';
  if (name[0] == '.') name[0] = '-';
  snprintf(name + KITH_MIN(n, 127), 16, "-%08x", (unsigned)(key >> 32));
}

static kith_status add(struct kith_matrix *m, const struct kith_point *p, const struct kith_job *job) {
  KITH_TRY(kith_resize(&m->point, (size_t)m->n, (size_t)m->n + 1, sizeof *m->point));
  m->point[m->n++] = *p;
  put_point(m->file, p, job);
  if (fflush(m->file) != 0 || fsync(m->lock) != 0)
    KITH_FAIL(BAD_FILE, "%s/points.csv: cannot write: %s", m->directory, strerror(errno));
  return KITH_OK;
}

kith_status kith_matrix_run(struct kith_matrix *m, const struct kith_job *job, struct kith_point *p) {
  char name[160], directory[KITH_PATH + 176], path[KITH_PATH + 200], log[KITH_PATH + 184];
  int code;
  *p = (struct kith_point){.key = kith_matrix_key(m, job), .x = job->x};
  snprintf(p->method, sizeof p->method, "%s", job->method);
  run_name(job, p->key, name);
  snprintf(directory, sizeof directory, "%s/runs/%s", m->directory, name);
  snprintf(path, sizeof path, "%s/report.json", directory);
  snprintf(log, sizeof log, "%s.log", directory);
  unlink(path);
  KITH_TRY(kith_job_start(m, job, "run", directory, log, &code));
  if (code != 0) kith_log_reason(log, code, p->why);
  if (code == -SIGINT || code == -SIGTERM || code == -SIGHUP || code == 127 ||
      strncmp(p->why, "stopped by signal", strlen("stopped by signal")) == 0)
    KITH_FAIL(BAD_FILE, "a run was stopped from outside, see %s", log);
  p->failed = code != 0 || read_report(p, path) != KITH_OK;
  for (int k = 0; p->failed && k < KITH_N_METRICS; ++k) p->value[k] = NAN;
  if (p->failed && code == 0) snprintf(p->why, sizeof p->why, "%.255s", kith_failure());
  drop_snapshots(directory);
  return add(m, p, job);
}
