/* csv.h - a table of comma-separated values: a line of names, then rows.
 *
 * Fields may be quoted ("", doubled inside); lines that start with # are comments. With whole_lines, a last line without its
 * newline is a row that was not finished by who wrote it: it is left out, and `whole` says where it starts. */
#ifndef KITH_APP_CSV_H
#define KITH_APP_CSV_H

#include <stdio.h>
#include "lib/core/base.h"

struct kith_csv {
  char *text; /* owned; the cells point into it */
  int n_columns, n_rows;
  char **cell; /* owned; (1 + n_rows) * n_columns, the names first */
  int *line;   /* owned; of each row in the file, the names first */
  size_t whole;
};

/* BAD_INPUT, with file and line, for what cannot be read: no names, a row of another length, an open quote. */
kith_status kith_csv_read(struct kith_csv **out, const char *path, bool whole_lines);
void kith_csv_destroy(struct kith_csv **csv);
/* Position of the column `name`, or -1. */
int kith_csv_column(const struct kith_csv *csv, const char *name);
/* View. */
const char *kith_csv_at(const struct kith_csv *csv, int row, int column);
/* A field, quoted; what is not printable becomes a blank. */
void kith_csv_quoted(FILE *out, const char *text);

#endif
