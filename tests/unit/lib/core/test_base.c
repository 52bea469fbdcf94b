/* test_base.c - status codes, messages and aligned memory: contents after growing and shrinking, failures
 * that quote the last one, sizes that do not fit. */
#include "tests/check.h"
#include <string.h>

/* A failure may quote the last one. */
static void check_quoted_failure(void) {
  CHECK_STATUS(KITH_BAD_FILE, kith_fail(KITH_BAD_FILE, "the %s", "reason"));
  CHECK_STATUS(KITH_DIVERGED,
               kith_fail(KITH_DIVERGED, "a longer beginning than that: %s, and an end", kith_failure()));
  CHECK(strcmp(kith_failure(), "a longer beginning than that: the reason, and an end") == 0);
  CHECK(kith_failed_node() == -1);
  CHECK_STATUS(KITH_DIVERGED, kith_fail_node(KITH_DIVERGED, 7, "node %d: %s", 7, kith_failure()));
  CHECK(kith_failed_node() == 7 && strncmp(kith_failure(), "node 7: a longer", 16) == 0);
  char list[4096] = ""; /* a list that is too long is cut between two of its words */
  while (strlen(list) < sizeof list - 8) strcat(list, "words, ");
  CHECK_STATUS(KITH_BAD_FILE, kith_fail(KITH_BAD_FILE, "%s", list));
  CHECK(strlen(kith_failure()) > 1900 && strcmp(strrchr(kith_failure(), 's'), "s, ...") == 0);
  CHECK_STATUS(KITH_BAD_FILE, kith_fail(KITH_BAD_FILE, "of no node"));
  CHECK(kith_failed_node() == -1);
}

/* Arrays of all sizes, from those on the heap to those in pages of 2 MiB, keep their contents when they grow
 * and shrink, and what is added is zero. */
static void check_sizes(void) {
  static const size_t count[] = {100,    20000,   200000, 500000, 300000, 1500000,
                                 700000, 2000000, 150000, 10,     200000};
  uint64_t *a = NULL;
  size_t kept = 0;
  for (size_t k = 0; k < sizeof count / sizeof *count; ++k) {
    CHECK_OK(kith_resize(&a, kept, count[k], sizeof *a));
    CHECK((uintptr_t)a % 64 == 0);
    size_t wrong = 0;
    for (size_t i = 0; i < count[k]; ++i) wrong += a[i] != (i < kept ? i + 1 : 0);
    CHECK(wrong == 0);
    for (size_t i = 0; i < count[k]; ++i) a[i] = i + 1;
    kept = k + 1 < sizeof count / sizeof *count ? KITH_MIN(count[k], count[k + 1]) : 0;
    if (k % 3 == 1) kept -= kept / 5;
  }
  kith_free(&a);
}

int main(void) {
  check_sizes();
  double *a = NULL;
  CHECK_OK(kith_resize(&a, 0, 3, sizeof *a));
  CHECK((uintptr_t)a % 64 == 0 && a[0] == 0 && a[2] == 0);
  a[0] = 1, a[1] = 2, a[2] = 3;
  CHECK_OK(kith_resize(&a, 2, 5, sizeof *a));
  CHECK(a[0] == 1 && a[1] == 2 && a[2] == 0 && a[4] == 0);
  CHECK_STATUS(KITH_NO_MEMORY, kith_resize(&a, 2, SIZE_MAX / 4, sizeof *a));
  CHECK(a != NULL && a[1] == 2 && strstr(kith_failure(), "do not fit") != NULL);
  kith_free(&a);
  CHECK(a == NULL);
  check_quoted_failure();
  return check_failed();
}
