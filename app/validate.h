/* validate.h - the scenes with their tolerances: `kith validate [SUITE]`.
 *
 *   quick   1-D and small 2-D runs, a minute      full   every line of the table of targets, 3-D too
 *
 * A row starts the program of its dimension, which stands beside this one, on a scene of the directory
 * `inputs` (looked for beside the program and above it, then in the working directory), and reads what it
 * measures from the report. A row without a scene measures the last run once more; an order is the slope of
 * log error over log resolution through the rows before it.
 *
 * One line per row on stdout, and in DIR/validation.csv (-o, out/validate by default) with where the bound
 * comes from; what the runs print is in DIR/ROW.log. */
#ifndef KITH_APP_VALIDATE_H
#define KITH_APP_VALIDATE_H

#include "app/options.h"

/* Exit code: 0; 3 if a row is out of tolerance; 1 if a run failed or the results cannot be written; 2 for an
 * unknown suite. Suite `list` shows the suites and their rows. */
enum kith_exit kith_validate(const struct kith_options *options);

#endif
