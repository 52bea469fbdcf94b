/* text.h - text for people: wrapped at blanks to 100 columns, quantities with units. */
#ifndef KITH_APP_CLI_TEXT_H
#define KITH_APP_CLI_TEXT_H

#include <stdio.h>

enum { KITH_TEXT_WIDTH = 100 };

/* `label` at the left, the text behind column `indent`, wrapped there. */
void kith_text_wrapped(FILE *out, int indent, const char *label, const char *text);
/* "4.66 MiB" and "22.7 ms"; returns `text`. */
const char *kith_text_bytes(char text[32], double bytes);
const char *kith_text_seconds(char text[32], double seconds);
/* A number of a table behind a blank; what is 0 is not there: "-". */
void kith_text_cell(FILE *out, int width, int digits, double value);

#endif
