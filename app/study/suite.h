/* suite.h - what a chart or a stress sweep runs: a scene, methods, and values of what is varied; and what came
 * of it.
 *
 * A suite for `kith chart` is a small YAML file:
 *
 *   scene: sod                        # a scene of inputs, or a path, relative to the suite's folder
 *   dimension: 1                      # none: the scene's
 *   settings: {scheme.cfl: 0.2}       # for every run; keys as in --set, or nested; and `ranks`: processes
 *   methods:                          # names for settings; none: one method, the scene's
 *     - {name: sph alpha 1, settings: {method.viscosity.name: monaghan}}
 *   resolution: [50, 100, 200]        # ascending
 *   norms: [density.l1, velocity.l1]  # what is charted: norms of the report
 *   targets: [0.01, 0.02]             # for each norm the error at which costs are compared; none: chosen
 *   reference_codes:                  # points of other codes, measured elsewhere, that are shown beside
 *     - {code: SWIFT, version: v1, machine: 2 cores, resolution: 50, cpu_seconds: 3, norms: {density.l1:
 *     0.1}}
 *
 * Any scene is a suite too: every hydro package at three resolutions around the scene's own.
 *
 * A file of sweeps for `kith stress` has `methods` as above and `sweeps`, a list of
 *
 *   - name: cfl-sod
 *     parameter: Courant number              # what is varied
 *     scene: sod
 *     dimension: 1
 *     settings: {resolution: 100}            # for every run
 *     measure: norms.density.l1              # as in job.h
 *     at_most: 1.1                           # or at_least: what still counts as working
 *     of_first: true                         # the measure over its value at the first value of the method
 *     reason: errors of the steps stay below a tenth of those of the nodes
 *     values: {scheme.cfl: [0.1, 0.2, 0.3]}  # from mild to hard; or a list of {value: 10, settings: {...}}
 *
 * The order in which settings apply: settings, --set of the command line, method, value. */
#ifndef KITH_APP_STUDY_SUITE_H
#define KITH_APP_STUDY_SUITE_H

#include "app/cli/options.h"
#include "app/study/job.h"

enum { KITH_SUITE_MEASURES = 8, KITH_SUITE_METHODS = 100, KITH_SUITE_VALUES = 64 };

/* What the report of a run says: these columns, then the measures of the suite. */
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
  bool named_values;        /* a value is a word, and x its position */
  struct kith_job *job;     /* owned; job[m * n_values + v] */
  struct kith_point *point; /* owned; of the same jobs, zero until they have run (study.h) */
  int n_measures, n_codes;
  char measure[KITH_SUITE_MEASURES][64];
  double target[KITH_SUITE_MEASURES]; /* 0: chosen from the points */
  struct kith_reference_code *code;   /* owned */
  /* of a sweep */
  char parameter[64], reason[256];
  double at_most, at_least; /* one of them; the other is NaN */
  bool of_first;
};

/* A suite or a scene, by path or by name: NAME.yaml of inputs/suites, then of inputs. Of the options the
 * overrides count. BAD_INPUT with one line for whatever is wrong in the file itself; what scenes say of their
 * settings, kith_job_check tells. */
kith_status kith_suite_read(struct kith_suite *out, const struct kith_programs *programs, const char *subject,
                            const struct kith_options *options);
/* The sweeps of a file, or the one called `only`; *sweeps is kith_resize memory, also after a failure. */
kith_status kith_sweeps_read(struct kith_suite **sweeps, int *n, const struct kith_programs *programs,
                             const char *path, const char *only, const struct kith_options *options);
/* Accepts one of zeros. */
void kith_suite_clear(struct kith_suite *suite);
/* Prints the suites there are. */
void kith_suite_list(const struct kith_programs *programs);
/* Is it a path to a YAML file rather than a name? */
bool kith_suite_is_path(const char *name);

#endif
