/* words.h - lists of words "a|b|c": finding one, the one nearest to a slip of the pen, and telling them.
 *
 * '-' and '_' are the same letter, '-' is what is shown; empty words (a leading '|') do not count. */
#ifndef KITH_APP_WORDS_H
#define KITH_APP_WORDS_H

#include "lib/core/base.h"

/* Joins the names of a family list: KITH_SEARCH_LIST(KITH_AS_WORD) is "|tree|grid|brute". */
#define KITH_AS_WORD(name) "|" #name
/* The same for lists of (name, word, doc). */
#define KITH_AS_LISTED_WORD(name, word, doc) "|" #word

/* Position of a word, or -1. */
int kith_words_find(const char *words, const char *word);
/* The word with the fewest letters changed, left out, added or swapped with their neighbor (optimal string
 * alignment), if these are at most a third of the letters. false: nothing is near. */
bool kith_words_nearest(const char *words, const char *word, char *out, size_t size);
/* "a, b, c" */
void kith_words_tell(const char *words, char *out, size_t size);

#endif
