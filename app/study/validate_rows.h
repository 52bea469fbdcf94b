/* validate_rows.h - what is validated: rows of a file, each a run and what is required of it. The
 * manual's page studies.md has their keys, which are in a table in validate_rows.c.
 *
 * A group has rows and factors, which are keys with lists of values. The keys of a group hold for its rows
 * where these do not have them, and its settings are applied before theirs. Each row is run as it is, on one
 * process with one thread, and then with varied factors: ROW.VALUE.VALUE... are as many runs as the longest
 * factor has values, and are compared with the first one. Run k of row i takes value k of the longest factor,
 * and value (i + k) mod n of every other factor with n values. So with enough rows any two values of two
 * factors meet in some run, if the numbers of their values have no common divisor. */
#ifndef KITH_APP_STUDY_VALIDATE_ROWS_H
#define KITH_APP_STUDY_VALIDATE_ROWS_H

#include "app/study/study.h"

enum kith_row_kind {
  KITH_ROW_VALUE, /* a measure of study.h */
  KITH_ROW_ORDER,
  KITH_ROW_SAME_NORMS,
  KITH_ROW_NOTHING /* only `same` */
};

struct kith_row {
  struct kith_job job; /* label: the row's name; dimension 0: no run of its own; threads 0: 1 if quick */
  char measure[96], source[256];
  bool quick;                   /* in the quick suite, which takes minutes */
  double at_most, at_least;     /* NaN if not given; one of them is, unless there is `prints` or no measure */
  char prints[32];              /* a figure as a document has it; "": none */
  double within;                /* relative to the figure; 0: to the last digit that it has */
  enum kith_row_kind kind;      /* of the measure */
  int number;                   /* N of the measure */
  char same[32];                /* as written */
  char like[KITH_JOB_LABEL];    /* "": nothing is compared */
  double tolerance;             /* of `same`; 0: bitwise */
  char restart[KITH_JOB_LABEL]; /* "": from the start */
  char varied[64];              /* the values of the group's factors; "": none is varied */
};

/* Prints the keys of a file of rows. */
void kith_rows_reference(void);
/* Reads the rows of a file. *rows: kith_resize memory, in the order of the runs, also after a failure. */
kith_status kith_rows_read_file(struct kith_row **rows, int *n, const char *path,
                                const struct kith_programs *programs);

#endif
