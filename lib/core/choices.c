/* Lists of choices "a|b|c". */
#include "lib/core/choices.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

enum { LONGEST = 31 };

static char shown(char c) {
  return c == '_' ? '-' : c;
}

/* The next choice; false at the end. *choices moves behind it. */
static bool next(const char **choices, const char **word, int *length) {
  const char *p = *choices + strspn(*choices, "|");
  *word = p;
  *length = (int)strcspn(p, "|");
  *choices = p + *length;
  return *length > 0;
}

bool kith_next_word(const char **words, const char **word, size_t *length) {
  if (*words == NULL) return false;
  *word = *words;
  *length = strcspn(*word, "|");
  *words = (*word)[*length] == '|' ? *word + *length + 1 : NULL;
  return true;
}

bool kith_name_is(const char *name, const char *text, size_t length) {
  for (size_t k = 0; k < length; ++k)
    if (name[k] == '\0' || shown(name[k]) != shown(text[k])) return false;
  return name[length] == '\0';
}

int kith_choices_index(const char *choices, const char *word) {
  const char *w;
  int length, index = 0;
  for (; next(&choices, &w, &length); ++index)
    if (kith_name_is(word, w, (size_t)length)) return index;
  return -1;
}

static int folded(char c) {
  return tolower((unsigned char)shown(c));
}

/* Optimal string alignment distance of a[n] and b[m], both at most LONGEST long, whatever their case. */
static int distance(const char *a, int n, const char *b, int m) {
  int d[LONGEST + 1][LONGEST + 1];
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= m; ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      const int changed = d[i - 1][j - 1] + (folded(a[i - 1]) != folded(b[j - 1]));
      d[i][j] = KITH_MIN(changed, 1 + KITH_MIN(d[i - 1][j], d[i][j - 1]));
      if (i > 1 && j > 1 && folded(a[i - 1]) == folded(b[j - 2]) && folded(a[i - 2]) == folded(b[j - 1]))
        d[i][j] = KITH_MIN(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[n][m];
}

static void copy(const char *word, int length, char *out, size_t size) {
  snprintf(out, size, "%.*s", length, word);
  for (; *out != '\0'; ++out) *out = shown(*out);
}

bool kith_choices_suggest(const char *choices, const char *word, char *out, size_t size) {
  const int n = (int)strnlen(word, LONGEST + 1);
  if (n > LONGEST) return false;
  const char *w, *best = NULL;
  int length, best_length = 0, fewest = KITH_MIN((n + 2) / 3 + 1, n); /* something must be right */
  while (next(&choices, &w, &length)) {
    if (length > LONGEST) continue;
    const int d = distance(word, n, w, length);
    if (d < fewest) fewest = d, best = w, best_length = length;
  }
  if (best != NULL) copy(best, best_length, out, size);
  return best != NULL;
}

void kith_choices_format(const char *choices, char *out, size_t size) {
  const char *w;
  int length;
  size_t used = 0;
  out[0] = '\0';
  while (used < size && next(&choices, &w, &length)) {
    if (used > 0) used += (size_t)snprintf(out + used, size - used, ", ");
    if (used < size) copy(w, length, out + used, size - used);
    used += (size_t)length;
  }
}
