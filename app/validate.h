/* validate.h - runs with their tolerances: `kith validate [SUITE]`.
 *
 *   quick   the quick rows of inputs/validation/targets.yaml: 1-D and small 2-D runs, a minute or two; the default
 *   full    all rows of it, 3-D too
 *   gates   inputs/validation/gates.yaml: what must hold for each package
 *   ranks   inputs/validation/ranks.yaml: runs of many processes against those of one
 *   FILE    rows of one's own, see validate_rows.h
 *
 * A row starts the program of its dimension, which stands beside this one, on a scene of the directory
 * `inputs` (looked for beside the program and above it, then in the working directory), and reads what it
 * measures from the report.
 *
 * One line per row on stdout, with the drift of energy and the floors of its run, and whether it ends as the row that it is compared with; and in DIR/validation.csv (-o, out/validate by default),
 * with all norms and where the bound comes from; what the runs print is in DIR/ROW.log. */
#ifndef KITH_APP_VALIDATE_H
#define KITH_APP_VALIDATE_H

#include "app/options.h"

/* Exit code: 0; 3 if a row is out of tolerance; 1 if a run failed or the results cannot be written; 2 for an
 * unknown suite or a wrong file. Suite `list` shows the suites, and the rows of `full`. */
enum kith_exit kith_validate(const struct kith_options *options);

#endif
