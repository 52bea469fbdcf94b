/* job.h - one of many runs: a scene with settings, started as a process of its own, and the numbers that its
 * report holds. Charts, stress sweeps and validation are made of jobs.
 *
 * A measure is what is read from the report of a run:
 *
 *   norms.density.l1         the number at a dotted key of report.json
 *   A / B                    the ratio of two keys
 *   A / B - 1                |A / B - 1|, the relative difference
 *   shock                    short for norms.shock_radius / norms.shock_exact - 1 */
#ifndef KITH_APP_STUDY_JOB_H
#define KITH_APP_STUDY_JOB_H

#include "app/cli/process.h"

enum { KITH_JOB_SETTINGS = 4096, KITH_JOB_LABEL = 128, KITH_JOB_PATH = KITH_PATH + 256 };

struct kith_job {
  char scene[KITH_JOB_PATH];
  char label[KITH_JOB_LABEL], value[48]; /* the method, and the value of what is varied */
  double x;                              /* that value as a number, or its position */
  int line;                              /* of the file that the method is from */
  int dimension, ranks, threads;         /* ranks 0: one process; threads 0: all */
  int steps;                             /* 0: no limit */
  char restart[KITH_JOB_PATH];           /* checkpoint; "": none */
  char settings[KITH_JOB_SETTINGS];      /* key=value as --set takes them, each ended by a newline */
};
/* Adds key=value; the key `ranks` gives the number of processes. BAD_INPUT if it does not fit. */
kith_status kith_job_set(struct kith_job *job, const char *assignment);
/* Adds settings separated by blanks. */
kith_status kith_job_set_words(struct kith_job *job, const char *settings);
/* Starts `verb` (run, or plan, which takes no directory) of the job and waits; what it prints is in `log`.
 * *code: its exit code, or minus the signal that ended it; why: the reason if that is not 0. BAD_FILE if the
 * program cannot be started, or was interrupted from outside. cpu_limit: seconds of processor time; 0:
 * none. */
kith_status kith_job_run(const struct kith_programs *programs, const struct kith_job *job, const char *verb,
                         const char *directory, const char *log, double cpu_limit, int *code, char why[256]);
/* What `kith plan` says of a job: BAD_INPUT with its message if it refuses the settings. */
kith_status kith_job_check(const struct kith_programs *programs, const struct kith_job *job);
/* A measure of a report. BAD_FILE if it is not there. */
kith_status kith_report_measure(const char *report, const char *measure, double *value);

#endif
