/* validate_rows.h - what is validated: rows of a file, each a run and what is asked of it.
 *
 *   rows:
 *     - {name: sod-100, dimension: 1, scene: sod, settings: "resolution=100 arrangement=equal-spacing",
 *        measure: norms.velocity.l1, at_most: 0.02, source: where the bound comes from}
 *     - {name: sod-order, measure: order 4, at_least: 0.9}
 *     - {name: sod-4, dimension: 1, scene: sod, ranks: 4, same: 1e-11, like: sod-100}
 *
 * Settings are those of --set, parted by blanks. A row without a scene asks the last run once more. Measures:
 *   a key of the report    the number there; `A / B`: the ratio of two
 *   shock                  |norms.shock_radius / norms.shock_exact - 1|
 *   order N                of convergence through the last N values that rows with a resolution have measured
 *   same norms             largest relative difference of the L1 norms between the last two runs
 *   balance                largest imbalance (busiest rank over mean) that its looks have seen, but for the first
 *   threads                how many bytes of a checkpoint differ between 1 and 2 threads
 *   restart N              how many lines of history differ if the run is restarted behind step N
 * `same` is asked beside a measure, or instead of one: the last snapshot is that of the row `like`, an earlier one. `bits`: every field,
 * as it is stored, and as many entries of rows in the whole run; a number: node by node by id, within so much of the largest value of a field.
 *
 * A group of rows is run over values of factors: settings, `ranks` and `threads`.
 *
 *     - over: {ranks: [1, 2, 4], threads: [1, 2], partition.name: [kd, cart], neighbor.search: [tree, grid]}
 *       same: bits
 *       settings: "reproducible=true"
 *       rows:
 *         - {name: sod, dimension: 1, scene: sod}
 *         - {name: noh, dimension: 1, scene: noh, settings: "resolution=50"}
 *
 * What the group says holds for its rows where they say nothing; settings come before theirs. Every row is run as it is, by one process with one
 * thread; then with so many combinations of the factors that every pair of values of two factors occurs at least once, the rows
 * themselves being a factor (validate_cover.h). These are called ROW.RxT.VALUE..., and compared with the row. */
#ifndef KITH_APP_VALIDATE_ROWS_H
#define KITH_APP_VALIDATE_ROWS_H

#include "app/config.h"

enum kith_row_kind {
  KITH_ROW_VALUE,
  KITH_ROW_SHOCK,
  KITH_ROW_ORDER,
  KITH_ROW_SAME_NORMS,
  KITH_ROW_BALANCE,
  KITH_ROW_THREADS,
  KITH_ROW_RESTART,
  KITH_ROW_NOTHING /* but `same` */
};

struct kith_row {
  char name[96], scene[64], settings[512], measure[96], source[256];
  bool quick;               /* in the suite of minutes */
  int dimension;            /* 0: no run of its own */
  int ranks, threads;       /* 0: one process; all, or one for quick rows */
  double at_most, at_least; /* one of them; the other is NaN */
  enum kith_row_kind kind;  /* of the measure */
  int number;               /* N of the measure */
  char same[32], like[96];  /* as written; like "": nothing is compared */
  double tolerance;         /* of `same`; 0: to the byte */
  char varied[64];          /* values of its group's factors but ranks and threads; else "" */
};

/* Reads a file. *rows is memory of kith_resize, in the order of the runs. BAD_INPUT with file, line and key. */
kith_status kith_rows_read_file(struct kith_row **rows, int *n, const char *path);

#endif
