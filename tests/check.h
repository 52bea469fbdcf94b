/* check.h - the whole test framework. It prints nothing unless a check fails; main returns check_failed().
 *
 * CHECK(a == b);                       CHECK_CLOSE(got, wanted, tolerance);  (absolute)
 * CHECK_OK(kith_call(...));            CHECK_STATUS(KITH_BAD_INPUT, kith_call(...)); */
#ifndef KITH_TESTS_CHECK_H
#define KITH_TESTS_CHECK_H

#include <math.h>
#include <stdio.h>
#include <string.h>
#include "lib/core/base.h"

static int check_failures;

#define CHECK(condition)                                                      \
  do {                                                                        \
    if (!(condition)) {                                                       \
      ++check_failures;                                                       \
      fprintf(stderr, "%s:%d: failed: %s\n", __FILE__, __LINE__, #condition); \
    }                                                                         \
  } while (0)

#define CHECK_CLOSE(got, wanted, tolerance)                                                        \
  do {                                                                                             \
    const double check_got_ = (got), check_wanted_ = (wanted);                                     \
    if (!(fabs(check_got_ - check_wanted_) <= (tolerance))) {                                      \
      ++check_failures;                                                                            \
      fprintf(stderr, "%s:%d: %s is %.17g, wanted %.17g, off by %.3g\n", __FILE__, __LINE__, #got, \
              check_got_, check_wanted_, check_got_ - check_wanted_);                              \
    }                                                                                              \
  } while (0)

#define CHECK_STATUS(wanted, call)                                             \
  do {                                                                         \
    const kith_status check_status_ = (call);                                  \
    if (check_status_ != (wanted)) {                                           \
      ++check_failures;                                                        \
      fprintf(stderr, "%s:%d: %s gave '%s' (%s)\n", __FILE__, __LINE__, #call, \
              kith_status_text(check_status_), kith_failure());                \
    }                                                                          \
  } while (0)

#define CHECK_OK(call) CHECK_STATUS(KITH_OK, call)

/* Does the message of the last failure contain these words? Prints the message if not. */
static inline bool check_says(const char *words) {
  const bool says = strstr(kith_failure(), words) != NULL;
  if (!says) fprintf(stderr, "no '%s' in: %s\n", words, kith_failure());
  return says;
}

/* Checks that `what`, which gave this status, was refused with exactly this message; one that ends with a
 * blank is the beginning of a list. */
static inline void check_message(const char *what, kith_status status, const char *wanted) {
  const size_t length = strlen(wanted), whole = length > 0 && wanted[length - 1] == ' ' ? 0 : 1;
  if (status == KITH_BAD_INPUT && strncmp(kith_failure(), wanted, length + whole) == 0) return;
  ++check_failures;
  fprintf(stderr, "%s\n  gave   %s: %s\n  wanted %s\n", what, kith_status_text(status),
          status == KITH_OK ? "" : kith_failure(), wanted);
}

/* Random numbers in [0, 1) from splitmix64: a test draws the same ones on every machine. */
static inline double check_random(uint64_t *state) {
  uint64_t z = (*state += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

static inline int check_failed(void) {
  if (check_failures > 0) fprintf(stderr, "%d checks failed\n", check_failures);
  return check_failures > 0;
}

#endif
