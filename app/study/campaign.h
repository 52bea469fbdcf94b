/* campaign.h - many runs, each a process of its own, and the numbers that their reports hold. Charts, stress
 * sweeps and validation all run through it.
 *
 * A job is a scene with settings. A measure is what is read from the report of its run:
 *
 *   norms.density.l1         the number at a dotted key of report.json
 *   A / B                    the ratio of two keys
 *   A / B - 1                |A / B - 1|, the relative difference
 *   shock                    short for norms.shock_radius / norms.shock_exact - 1
 *
 * DIR/points.csv has one line for each job. A run goes to DIR/runs/NAME.part and gets the directory
 * DIR/runs/NAME once it has finished, without its snapshots; NAME ends with a hash of the scene's text, of
 * the settings and of the program's version. A job whose directory is there is read, not run again, so a
 * campaign that was interrupted goes on, and it may grow. A failed run leaves its reason in
 * DIR/runs/NAME.failed; remove that file to try it again. What a run prints is in DIR/runs/NAME.log. */
#ifndef KITH_APP_STUDY_CAMPAIGN_H
#define KITH_APP_STUDY_CAMPAIGN_H

#include <stdio.h>
#include "app/cli/process.h"

enum { KITH_JOB_SETTINGS = 4096, KITH_JOB_LABEL = 128, KITH_JOB_PATH = KITH_PATH + 256, KITH_COLUMNS = 24 };

struct kith_job {
  char scene[KITH_JOB_PATH];
  char label[KITH_JOB_LABEL], value[48]; /* the method, and the value of what is varied */
  double x;                              /* that value as a number, or its position */
  double weight;                         /* expected cost, in any unit */
  int line;                              /* of the file that the job is from; 0: none */
  int dimension, ranks, threads, steps;  /* ranks 0: one process; threads 0: all; steps 0: no limit */
  char restart[KITH_JOB_PATH];           /* checkpoint; "": none */
  char settings[KITH_JOB_SETTINGS];      /* key=value as --set takes them, each ended by a newline */
};
/* Adds key=value; the key `ranks` gives the number of processes. BAD_INPUT if it does not fit. */
kith_status kith_job_set(struct kith_job *job, const char *assignment);
/* Adds settings separated by blanks. */
kith_status kith_job_set_words(struct kith_job *job, const char *settings);
/* Starts `verb` (run, or plan, which takes no directory) of the job and waits; what it prints is in `log`.
 * *code: its exit code, or minus the signal that ended it; why: the reason if that is not 0. BAD_FILE if the
 * program cannot be started, or was interrupted from outside. */
kith_status kith_job_run(const struct kith_programs *programs, const struct kith_job *job, const char *verb,
                         const char *directory, const char *log, double cpu_limit, int *code, char why[256]);
/* What `kith plan` says of a job: BAD_INPUT with its message if it refuses the settings. */
kith_status kith_job_check(const struct kith_programs *programs, const struct kith_job *job);

/* "density.l1|...": what can stand behind "norms.". */
extern const char kith_norm_choices[];
/* A measure of a report. BAD_FILE if it is not there. */
kith_status kith_report_measure(const char *report, const char *measure, double *value);

/* Each point has these columns, then the measures of the campaign. */
enum { KITH_CPU_SECONDS, KITH_PAIR_EVALUATIONS, KITH_NODES, KITH_STEPS, KITH_ENERGY_DRIFT, KITH_MEASURES };
struct kith_point {
  bool failed;
  char why[256];              /* of the failure */
  double value[KITH_COLUMNS]; /* NaN: not in the report */
};

struct kith_campaign {
  struct kith_programs programs;
  char directory[KITH_PATH];
  double cpu_limit; /* seconds of processor time for a run; 0: none */
  bool quiet;
  int n_columns, n_jobs, n_done, n_failed;
  const char *column[KITH_COLUMNS];            /* measures, borrowed */
  double weight_left, weight_run, seconds_run; /* for the time that is left */
  FILE *table;
};

/* Makes the directory and DIR/points.csv. n_jobs and weight: all that will be run. */
kith_status kith_campaign_open(struct kith_campaign *campaign, int n_measures, const char *const *measure,
                               int n_jobs, double weight);
/* Runs a job, or reads what an earlier campaign has of it, with a line of progress on stderr. A run that
 * fails is a point; an error is what keeps points from being made. */
kith_status kith_campaign_run(struct kith_campaign *campaign, const struct kith_job *job,
                              struct kith_point *point);
/* BAD_FILE if the table could not be written. Accepts one that was not opened. */
kith_status kith_campaign_close(struct kith_campaign *campaign);
/* A CSV field in quotes. */
void kith_csv_quoted(FILE *out, const char *text);

#endif
