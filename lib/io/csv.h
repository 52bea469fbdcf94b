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

/* DIRECTORY/FILE. `names`: of the columns, with commas. A new file replaces an old one. With `last` the table
 * is continued: rows whose first column, a step, is at most *last are kept, others and an unfinished one are
 * removed; BAD_FILE if its columns are not these. A file without a whole line, or none, is begun. */
kith_status kith_csv_log_open(struct kith_csv_log *out, const char *directory, const char *file,
                              const char *names, const uint64_t *last);
/* After the values of a row were printed to `file`: ends it. BAD_FILE if it could not be written. */
kith_status kith_csv_log_row(struct kith_csv_log *log);
/* What was written is on the disk. A closed log: nothing to do. */
kith_status kith_csv_log_sync(struct kith_csv_log *log);
/* BAD_FILE if the last of it could not be written; closed in any case. A closed log: nothing to do. */
kith_status kith_csv_log_close(struct kith_csv_log *log);

#endif
