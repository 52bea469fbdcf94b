/* csv.h - tables of comma-separated values: a line of names, then rows of as many values, without quotes.
 *
 * A table is written row by row while a run goes on. A last line without its newline was not finished by the
 * process that wrote it, and does not count. */
#ifndef KITH_IO_CSV_H
#define KITH_IO_CSV_H

#include <stdio.h>
#include "lib/core/base.h"

struct kith_csv_log {
  FILE *file; /* NULL: closed */
  char *path; /* owned */
};

/* Opens the table DIRECTORY/FILE, whose columns have these names, separated by commas. If `last` is NULL, a
 * new file replaces an old one. Otherwise the table is continued: rows whose first column, a step, is at
 * most *last are kept, and later and unfinished ones are removed. BAD_FILE if its columns have other names.
 * A file without a whole line is begun anew. */
kith_status kith_csv_log_open(struct kith_csv_log *out, const char *directory, const char *file,
                              const char *names, const uint64_t *last);
/* Ends a row, whose values the caller has printed to `file`. BAD_FILE if it could not be written. */
kith_status kith_csv_log_row(struct kith_csv_log *log);
/* Waits until all rows are on the disk. Does nothing if the log is closed. */
kith_status kith_csv_log_sync(struct kith_csv_log *log);
/* Closes the log in any case; BAD_FILE if the last rows could not be written. Does nothing if it is closed.
 * */
kith_status kith_csv_log_close(struct kith_csv_log *log);

#endif
