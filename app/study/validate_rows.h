/* validate_rows.h - what is validated: rows of a file, each a run and what is required of it.
 *
 *   rows:
 *     - {name: sod-100, dimension: 1, scene: sod, settings: "resolution=100 arrangement=equal-spacing",
 *        measure: norms.velocity.l1, at_most: 0.02, source: where the bound comes from}
 *     - {name: sod-order, measure: order 4, at_least: 0.9}
 *     - {name: sod-4, dimension: 1, scene: sod, ranks: 4, same: 1e-11, like: sod-100}
 *
 *     - {name: sod-readme, dimension: 1, scene: sod, measure: norms.velocity.l1, prints: 0.0412}
 *
 * `prints` instead of a bound: the figure that a document has, to its last digit, or `within` a part of it.
 * Settings are those of --set, separated by blanks. A row without a scene measures the last run once more.
 * `steps: N` ends a run after step N; `restart: ROW` continues the last checkpoint of that row, one above.
 * Measures: those of study.h, and
 *   order N       of convergence through the last N values that rows with a resolution have measured
 *   same norms    largest relative difference of the L1 norms between the last two runs
 * `same` is required beside a measure, or instead of one: the last snapshot equals that of the row `like`, an
 * earlier one. `bits`: every field bitwise, as it is stored, and as many row entries in the whole run; a
 * number: node by node by id, within this fraction of the largest value of a field.
 *
 * A group of rows is run over values of factors: settings, `ranks` and `threads`.
 *
 *     - over: {ranks: [1, 2, 4], threads: [1, 2], partition.name: [kd, cart, morton, hilbert, graph]}
 *       same: bits
 *       settings: "reproducible=true"
 *       rows:
 *         - {name: sod, dimension: 1, scene: sod}
 *         - {name: noh, dimension: 1, scene: noh, settings: "resolution=50"}
 *
 * What the group says holds for its rows where they say nothing; its settings come before theirs. Every row
 * is run as it is, on one process with one thread, and compared with its runs ROW.VALUE.VALUE..., one for
 * each value of the longest factor: run k of row i takes value (i + k) mod n of every other factor with n
 * values. So with enough rows two values of any two factors meet, if these n have no common divisor. */
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
  double within;                /* part of the figure; 0: to its last digit */
  enum kith_row_kind kind;      /* of the measure */
  int number;                   /* N of the measure */
  char same[32];                /* as written */
  char like[KITH_JOB_LABEL];    /* "": nothing is compared */
  double tolerance;             /* of `same`; 0: bitwise */
  char restart[KITH_JOB_LABEL]; /* "": from the start */
  char varied[64];              /* its values of the group's factors; else "" */
};

/* Reads the rows of a file. *rows: kith_resize memory, in the order of the runs, also after a failure. */
kith_status kith_rows_read_file(struct kith_row **rows, int *n, const char *path,
                                const struct kith_programs *programs);

#endif
