/* validate_rows.h - what is validated: rows of a file, each a run and what is asked of it.
 *
 *   rows:
 *     - {name: sod-100, dimension: 1, scene: sod, settings: "resolution=100 arrangement=equal-spacing",
 *        measure: norms.velocity.l1, at_most: 0.02, source: where the bound comes from}
 *     - {name: sod-order, measure: order 4, at_least: 0.9}
 *
 * Settings are those of --set, parted by blanks. A row without a scene asks the last run once more. Measures:
 *   a key of the report    the number there
 *   shock                  |norms.shock_radius / norms.shock_exact - 1|
 *   order N                of convergence through the last N values that rows with a resolution have measured
 *   same                   largest relative difference of the L1 norms between the last two runs
 *   threads                how many bytes of a checkpoint differ between 1 and 2 threads
 *   restart N              how many lines of history differ if the run is restarted behind step N */
#ifndef KITH_APP_VALIDATE_ROWS_H
#define KITH_APP_VALIDATE_ROWS_H

#include "app/config.h"

enum kith_row_kind {
  KITH_ROW_VALUE,
  KITH_ROW_SHOCK,
  KITH_ROW_ORDER,
  KITH_ROW_SAME,
  KITH_ROW_THREADS,
  KITH_ROW_RESTART
};

struct kith_row {
  char name[64], scene[64], settings[512], measure[64], source[256];
  bool quick;               /* in the suite of minutes */
  int dimension;            /* 0: no run of its own */
  double at_most, at_least; /* one of them; the other is NaN */
  enum kith_row_kind kind;  /* of the measure */
  int number;               /* N of the measure */
};

/* Reads a file. *rows is memory of kith_resize. BAD_INPUT with file, line and key. */
kith_status kith_rows_read_file(struct kith_row **rows, int *n, const char *path);

#endif
