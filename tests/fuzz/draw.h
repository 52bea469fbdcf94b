/* draw.h - for fuzzing: random numbers, and words of a list. */
#ifndef KITH_TEST_FUZZ_DRAW_H
#define KITH_TEST_FUZZ_DRAW_H

#include <string.h>
#include "tests/check.h"

/* One of 0 ... n - 1; 0 if there is none. */
static inline size_t below(uint64_t *seed, size_t n) {
  return (size_t)(check_random(seed) * (double)n);
}

/* Writes one of the words, between which are semicolons; none is longer than 63 letters. */
static inline void draw_word(const char *words, uint64_t *seed, char word[64]) {
  size_t n = 1;
  for (const char *c = words; *c != '\0'; ++c) n += *c == ';';
  for (size_t k = below(seed, n); k > 0; --k) words = strchr(words, ';') + 1;
  snprintf(word, 64, "%.*s", (int)strcspn(words, ";"), words);
}

#endif
