/* csv.h - tables of comma-separated values: a line of names, then rows of as many values, without quotes.
 *
 * A table is written row by row while a run goes on, and read back by the names of its columns. A last line
 * without its newline was not finished by the process that wrote it, and does not count. */
#ifndef KITH_IO_CSV_H
#define KITH_IO_CSV_H

#include <stdio.h>
#include "lib/core/base.h"

/* ---- reading ---- */

struct kith_csv {
  char *text; /* owned */
  int n_columns, n_rows;
  char **cell; /* owned; (1 + n_rows) * n_columns views of text, the names first */
};

/* BAD_FILE for what cannot be read: no names, or a row of another length, with its line. */
kith_status kith_csv_read(struct kith_csv *out, const char *path);
void kith_csv_clear(struct kith_csv *csv);
/* Position of the column `name`, or -1. */
int kith_csv_column(const struct kith_csv *csv, const char *name);
/* View; row -1: the name of the column. */
const char *kith_csv_at(const struct kith_csv *csv, int row, int column);

/* ---- writing ---- */

struct kith_csv_log {
  FILE *file; /* NULL: closed */
  char *path; /* owned */
};

/* `names`: of the columns, with commas. A new file replaces an old one. With `last` the table is continued:
 * rows whose column "step" is at most *last are kept, others and an unfinished one are removed; BAD_FILE if
 * its columns are not these. An empty file, or none, is begun. */
kith_status kith_csv_log_open(struct kith_csv_log *out, const char *path, const char *names,
                              const uint64_t *last);
/* After the values of a row were printed to `file`: ends it. BAD_FILE if it could not be written. */
kith_status kith_csv_log_row(struct kith_csv_log *log);
/* BAD_FILE if the last of it could not be written; closed in any case. A closed log: nothing to do. */
kith_status kith_csv_log_close(struct kith_csv_log *log);

#endif
