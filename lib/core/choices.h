/* choices.h - lists of choices "a|b|c": the position of one, the nearest one to a misspelled word,
 * formatting.
 *
 * '-' and '_' are the same letter, '-' is what is shown; empty choices (a leading '|') do not count. */
#ifndef KITH_CORE_CHOICES_H
#define KITH_CORE_CHOICES_H

#include "lib/core/base.h"

/* Joins the words of a list of (name, word, doc): KITH_LATTICE_LIST(KITH_AS_LISTED_CHOICE) is
 * "|cubic|bcc|fcc" and so on. */
#define KITH_AS_LISTED_CHOICE(name, word, doc) "|" #word

/* Takes the next of the words that are joined by '|' in *words: it may be empty, or have blanks around it.
 * false if there is none left. *words moves behind it, and is NULL behind the last one. */
bool kith_next_word(const char **words, const char **word, size_t *length);
/* Are the first `length` letters of `text` the whole of `name`? */
bool kith_name_is(const char *name, const char *text, size_t length);
/* Position of a choice, or -1. */
int kith_choices_index(const char *choices, const char *word);
/* The choice with the fewest letters changed, left out, added or swapped with their neighbor (optimal string
 * alignment), if these are at most a third of the letters, rounded up. The case of letters does not count.
 * false: none is near. */
bool kith_choices_suggest(const char *choices, const char *word, char *out, size_t size);
/* "a, b, c" */
void kith_choices_format(const char *choices, char *out, size_t size);

#endif
