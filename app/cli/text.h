/* text.h - text for people: wrapped at blanks to 100 columns, quantities with units. */
#ifndef KITH_APP_CLI_TEXT_H
#define KITH_APP_CLI_TEXT_H

#include <stdio.h>

enum { KITH_TEXT_WIDTH = 100 };

/* Prints `label` at the left, and `text` behind column `indent`, wrapped there. */
void kith_text_wrapped(int indent, const char *label, const char *text);
/* Prints a line of a list of facts: two blanks, `label`, and from column 16 on the text. */
__attribute__((format(printf, 2, 3))) void kith_text_line(const char *label, const char *format, ...);
/* Appends to the text in an array of `size` bytes. What does not fit is cut off. */
__attribute__((format(printf, 3, 4))) void kith_text_add(char *text, size_t size, const char *format, ...);
/* Appends an item of a list, with `between` in front unless it is the first. */
__attribute__((format(printf, 4, 5))) void kith_text_join(char *text, size_t size, const char *between,
                                                          const char *format, ...);
/* Writes "4.7 MiB" and "22.7 ms"; returns `text`. */
const char *kith_text_bytes(char text[32], double bytes);
const char *kith_text_seconds(char text[32], double seconds);
/* Writes a word as a shell takes it: in quotes if it has anything but letters, digits and a few signs. */
void kith_text_word(FILE *out, const char *word);
/* Writes a blank and a number of a table, or "-" unless it is above 0. */
void kith_text_cell(FILE *out, int width, int digits, double value);

#endif
