/* choices_of.h - for conformance tests: the values of a parameter that are worth trying. */
#ifndef KITH_TEST_CHOICES_OF_H
#define KITH_TEST_CHOICES_OF_H

#include "lib/core/choices.h"
#include "lib/core/param.h"

#include <stdio.h>
#include <string.h>

/* Writes value k beside the default: another choice, the other value of a flag, or 1 for an effect that is
 * off by default. false: there is no such value. */
static inline bool choice_of(const struct kith_param *p, int k, char *text, size_t size) {
  const bool off = p->fallback != NULL && strcmp(p->fallback, "0") == 0;
  const char *words = p->kind == KITH_PARAM_CHOICE ? p->allowed
                      : p->kind == KITH_PARAM_BOOL ? "false|true"
                      : off                        ? "1"
                                                   : "",
             *word;
  size_t length;
  while (kith_next_word(&words, &word, &length)) {
    if (length == 0 || (p->fallback != NULL && kith_name_is(p->fallback, word, length)) || k-- > 0) continue;
    snprintf(text, size, "%.*s", (int)length, word);
    return true;
  }
  return false;
}

#endif
