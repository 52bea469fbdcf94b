/* job.c - jobs as child processes, and the numbers of their reports. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* memfd_create */
#endif
#include "app/study/job.h"

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

/* ---- settings ---- */

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

/* ---- the process ---- */

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
  char *text, *words[KITH_JOB_SETTINGS / 2] = {0};
  size_t size;
  FILE *f = open_memstream(&text, &size); /* a word on each line */
  if (f == NULL) KITH_FAIL(NO_MEMORY, "no memory for the words of a run");
  fprintf(f, "%s%dd\n%s\n%s\n--quiet\n", programs->prefix, job->dimension, verb, job->scene);
  fprintf(f, "--set=dimension=%d\n--set=output.plot=false", job->dimension);
  if (job->threads > 0) fprintf(f, "\n--threads=%d", job->threads);
  if (job->ranks > 1 && directory != NULL) fprintf(f, "\n--ranks=%d", job->ranks);
  if (job->steps > 0) fprintf(f, "\n--steps=%d", job->steps);
  if (job->restart[0] != '\0') fprintf(f, "\n--restart=%s", job->restart);
  if (directory != NULL) fprintf(f, "\n-o\n%s", directory);
  for (const char *s = job->settings; *s != '\0'; s += strcspn(s, "\n") + 1)
    fprintf(f, "\n--set=%.*s", (int)strcspn(s, "\n"), s);
  fclose(f);
  int n = 0;
  for (char *rest = text; rest != NULL;) words[n++] = strsep(&rest, "\n");
  unlink(log);
  const kith_status status = kith_process_run(words, log, cpu_limit, code);
  free(text);
  if (status != KITH_OK || *code == 0) return status;
  find_reason(log, *code, why);
  if (*code == 127) KITH_FAIL(BAD_FILE, "cannot start %s%dd", programs->prefix, job->dimension);
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
