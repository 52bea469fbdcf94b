/* study.h - what `kith chart` and `kith stress` have in common: the jobs of suites run one after the other,
 * and a text and a figure are written of the points.
 *
 * DIR/points.csv has one line for each job. A run goes to DIR/runs/NAME.part and gets the directory
 * DIR/runs/NAME once it has finished, without its snapshots; NAME ends with a hash of the scene's text, of
 * the settings and of the program's version. A job whose directory is there is read, not run again, so a
 * study that was interrupted goes on, and it may grow. A failed run leaves its reason in DIR/runs/NAME.failed;
 * remove that file to try it again. What a run prints is in DIR/runs/NAME.log. */
#ifndef KITH_APP_STUDY_STUDY_H
#define KITH_APP_STUDY_STUDY_H

#include <stdio.h>
#include "app/study/suite.h"

struct kith_study {
  const struct kith_options *options;
  struct kith_programs programs;
  char directory[KITH_PATH];
  int n;
  struct kith_suite *suite; /* owned */
  int n_jobs, n_done, n_failed;
  FILE *table; /* points.csv */
};

/* What differs. */
struct kith_study_verb {
  const char *name;                              /* of the text, NAME.md */
  double cpu_limit;                              /* seconds of processor time for a run; 0: none */
  kith_status (*list)(struct kith_study *study); /* prints what can be studied */
  kith_status (*read)(struct kith_study *study); /* suites, the directory; nothing is written yet */
  kith_status (*draw)(const struct kith_study *study);
  void (*put)(FILE *out, const struct kith_study *study, bool to_file); /* to DIR/NAME.md, or to stdout */
  enum kith_exit (*verdict)(const struct kith_study *study);
};

/* Exit code: that of `verdict`, 1 if the results cannot be written, 2 if what is read is wrong. */
enum kith_exit kith_study_run(const struct kith_study_verb *verb, const struct kith_options *options);

/* Of stress sweeps: which points of a method pass, and the measure as it is judged (shown); of_first: over
 * its first value. */
void kith_sweep_judge(const struct kith_suite *sweep, const struct kith_point *point, bool *pass,
                      double *shown);
/* "to 0.6", "20 - 40, 90", "none", "all (1000)"; where values have names "6 of 8". */
void kith_sweep_answer(const struct kith_suite *sweep, const bool *pass, char text[128]);

#endif
