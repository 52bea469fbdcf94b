/* study.h - many runs. A job is one of them: a scene with settings, started as a process of its own, and the
 * numbers that its report holds. Charts, stress sweeps and validation are made of jobs.
 *
 * The manual's page studies.md has measures, the keys of suites and sweeps, which are in tables in suite.c,
 * and the order in which settings apply.
 *
 * DIR/points.csv has a line for each job, DIR/runs/NAME what it left but for its snapshots, NAME.log what it
 * printed, NAME.failed why it failed, if it says so; NAME ends with a hash of the scene, its bases and
 * tables, the settings, and the program with its commit. A job that is there is read, not run again: a study
 * that was interrupted goes on. */
#ifndef KITH_APP_STUDY_STUDY_H
#define KITH_APP_STUDY_STUDY_H

#include <stdio.h>
#include "app/cli/options.h"
#include "app/cli/process.h"
#include "lib/io/csv.h"

enum { KITH_JOB_SETTINGS = 4096, KITH_JOB_LABEL = 128, KITH_JOB_PATH = KITH_PATH + 256 };

struct kith_config_node; /* app/scene/config.h */

struct kith_job {
  char scene[KITH_JOB_PATH];
  char label[KITH_JOB_LABEL], value[48]; /* the method, and the value of what is varied */
  double x;                              /* that value as a number, or its position */
  int line;                              /* of its file: of the method, a sweep's value, or the row */
  int dimension, ranks, threads;         /* ranks 0: one process; threads 0: as `kith run` chooses */
  int steps;                             /* 0: no limit */
  char restart[KITH_JOB_PATH];           /* checkpoint; "": none */
  char settings[KITH_JOB_SETTINGS];      /* key=value as --set takes them, each ended by a newline */
};
/* Adds key=value; the keys `ranks` and `threads` set those of the process. BAD_INPUT if it does not fit. */
kith_status kith_job_set(struct kith_job *job, const char *assignment);
/* How a job has ended. */
struct kith_job_end {
  int code;       /* its exit code, or minus the signal that ended it */
  bool told;      /* it would fail again: its log says why, or it took too much processor time */
  char why[1024]; /* why it failed */
};
/* Starts `verb` for a job and waits until it has ended: `run`, which writes to the directory, or `plan`, for
 * which that is NULL. log and cpu_limit are as in kith_process_run. BAD_FILE if the program cannot be
 * started, was stopped from outside, or if another run writes to the directory. */
kith_status kith_job_run(const struct kith_programs *programs, const struct kith_job *job, const char *verb,
                         const char *directory, const char *log, double cpu_limit, struct kith_job_end *end);
/* Has `kith plan` check a job: BAD_INPUT "FILE:LINE: WHAT LABEL: its message" if it refuses the settings;
 * file NULL: the message alone. */
kith_status kith_job_check(const struct kith_programs *programs, const struct kith_job *job, const char *file,
                           const char *what);
/* Finds the keys A and B of a measure. Returns 1 if it is A, 2 if it is A / B, 3 if it is A / B - 1, and 0 if
 * it is none of these. */
int kith_measure_parse(const char *measure, char key[2][128]);
/* Reads a measure, as kith_measure_parse takes it, from a report. BAD_FILE if it is not there, null, or not a
 * number. */
kith_status kith_report_measure(const char *report, const char *measure, double *value);

enum { KITH_SUITE_MEASURES = 8, KITH_SUITE_METHODS = 100, KITH_SUITE_VALUES = 64 };

/* Numbers from the report of a run: these columns, then the measures of the suite. */
enum { KITH_CPU_SECONDS, KITH_PAIR_EVALUATIONS, KITH_NODES, KITH_STEPS, KITH_ENERGY_DRIFT, KITH_MEASURES };
struct kith_point {
  bool failed;
  char why[256];                                     /* of the failure */
  double value[KITH_MEASURES + KITH_SUITE_MEASURES]; /* NaN: not in the report */
};

struct kith_reference_code {
  char name[64], version[48], machine[96];
  double resolution, cpu_seconds;
  double norm[KITH_SUITE_MEASURES]; /* of the suite's measures; NaN: not known */
};

struct kith_suite {
  char file[KITH_JOB_PATH], name[100], scene[256]; /* scene: its name */
  int dimension, n_methods, n_values;
  bool named_values;        /* some value is no number; x of its job is its position in the list */
  struct kith_job *job;     /* owned; job[m * n_values + v] */
  struct kith_point *point; /* owned; of the job with the same index */
  int n_measures, n_codes;
  char measure[KITH_SUITE_MEASURES][64];
  double target[KITH_SUITE_MEASURES]; /* 0: none is given */
  struct kith_reference_code *code;   /* owned */
  /* of a sweep: */
  char parameter[64], reason[256];
  double at_most, at_least; /* one of them; the other is NaN */
  bool of_first;
};

struct kith_study {
  const struct kith_options *options;
  struct kith_programs programs;
  char directory[KITH_PATH];
  int n;
  struct kith_suite *suite; /* owned */
  int n_jobs, n_done, n_failed;
  int lock;                  /* of the directory; 0: none */
  struct kith_csv_log table; /* points.csv */
};

/* Reads a suite into study->suite, from a path, or from NAME.yaml in inputs/suites. BAD_INPUT for what is
 * wrong in the file itself; kith_job_check checks the settings. kith_study_clear is needed after a failure,
 * too. */
kith_status kith_suite_read(struct kith_study *study, const char *subject);
/* Reads the sweeps of a file, or the one called `only`, in the same way. */
kith_status kith_sweeps_read(struct kith_study *study, const char *path, const char *only);
/* Print the names of all suites and the keys of a suite; the keys of a file of sweeps. */
kith_status kith_suite_list(struct kith_study *study);
void kith_sweeps_reference(void);
/* Fails with BAD_INPUT "WHAT 'NAME'", and the nearest of "a|b|c", or all of them. */
kith_status kith_study_unknown(const char *what, const char *name, const char *choices);
/* BAD_INPUT "WHAT 'NAME': no folder inputsFOLDER" and where it is looked for, if it is not there. */
kith_status kith_study_inputs(const struct kith_programs *programs, const char *folder, const char *what,
                              const char *name);
/* Writes a text into a table: in quotes, and with blanks instead of control characters. */
void kith_study_put_quoted(FILE *out, const char *text);
/* Is it a path to a YAML file rather than a name? */
bool kith_suite_is_path(const char *name);
/* Finds the path of a scene: NAME of inputs, or a path relative to the folder of the file that `node` is in,
 * or to the working directory. */
kith_status kith_programs_scene(const struct kith_programs *programs, const struct kith_config_node *node,
                                const char *name, char path[KITH_JOB_PATH]);
void kith_study_clear(struct kith_study *study);

/* What differs between the verbs that are studies. */
struct kith_study_verb {
  const char *name;                                    /* of the text, NAME.md */
  double cpu_limit;                                    /* seconds of processor time for a run; 0: none */
  kith_status (*list)(struct kith_study *study);       /* prints what can be studied */
  kith_status (*read)(struct kith_study *study);       /* suites, the directory; nothing is written yet */
  kith_status (*draw)(const struct kith_study *study); /* NULL: no picture */
  void (*put)(FILE *out, const struct kith_study *study, bool to_file); /* to DIR/NAME.md, or to stdout */
  enum kith_exit (*verdict)(const struct kith_study *study);
};

/* Carries out a study. Returns the verdict, or 1 if results cannot be written, or 2 if the input is wrong. */
enum kith_exit kith_study_run(const struct kith_study_verb *verb, const struct kith_options *options);

/* Writes which values pass with method m: "none", "to 0.6", "all (1000)"; names, or with gaps: "6 of 8". */
void kith_sweep_answer(const struct kith_suite *sweep, int m, char text[128]);

/* ---- points of error and cost (pareto_front.c) ----
 * A point whose cost or error is not finite or not positive does not count. */

/* Sets on[k]: no other point is at most as expensive and as wrong, and better in one of the two. O(n^2). */
void kith_pareto_front(int n, const double *cost, const double *error, bool *on);
/* Observed order of convergence: minus the slope of the least-squares line through log error over log
 * resolution. NaN for fewer than two points at different resolutions. */
double kith_order(int n, const double *resolution, const double *error);

/* Where one method reaches an error of `target`: the resolution (they ascend) from which on its error stays
 * at or below it, between two points on a straight line of logarithms. */
struct kith_cost_at_error {
  double cost, resolution; /* NaN: never reached */
  bool between;            /* reached between two points; else by the first one already */
};
struct kith_cost_at_error kith_cost_at_error_of(int n, const double *resolution, const double *cost,
                                                const double *error, double target);

/* ---- do two runs end in the same state? (snapshot_diff.c) ---- */

struct kith_snapshot_diff {
  double difference; /* of the worst field: largest difference over largest value; 0: bitwise identical */
  char field[64];    /* its name */
  bool reordered;    /* the same ids are stored in another order */
};

/* Compares two snapshots (lib/io/snapshot.h), all fields of PartType0. `by_nodes`: node by node, wherever it
 * is stored; else bitwise, as they are stored, and the same time. Where only the bits or the order differ the
 * difference is DBL_MIN. Another number of nodes, other ids or other fields: the difference is infinite.
 * BAD_FILE: a file that is not there, or no snapshot. */
kith_status kith_snapshot_diff_files(const char *a, const char *b, bool by_nodes,
                                     struct kith_snapshot_diff *same);

#endif
