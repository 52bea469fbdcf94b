/* Status codes, error messages and aligned memory. */
#include "lib/core/base.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

/* The last failure on this thread. */
static _Thread_local char failure[2048];
static _Thread_local int64_t failed_node = -1;

const char *kith_status_text(kith_status status) {
  static const char *const text[] = {
#define X(name, words) words,
      KITH_STATUS_LIST(X)
#undef X
  };
  return (size_t)status < sizeof text / sizeof text[0] ? text[status] : "unknown status";
}

static void record(int64_t id, const char *format, va_list arguments) {
  char line[sizeof failure]; /* the arguments may hold the line of the last failure */
  const bool whole = vsnprintf(line, sizeof line, format, arguments) < (int)sizeof line;
  memcpy(failure, line, sizeof failure);
  if (!whole) { /* a list is cut between two words */
    char *end = failure + sizeof failure - sizeof "...";
    *end = '\0';
    char *blank = strrchr(failure, ' ');
    strcpy(blank != NULL ? blank + 1 : end, "...");
  }
  failed_node = id;
}

kith_status kith_fail(kith_status status, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  record(-1, format, arguments);
  va_end(arguments);
  return status;
}

kith_status kith_fail_node(kith_status status, int64_t id, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  record(id, format, arguments);
  va_end(arguments);
  return status;
}

const char *kith_failure(void) {
  return failure;
}
int64_t kith_failed_node(void) {
  return failed_node;
}

enum { ALIGNMENT = 64, LARGE_PAGE = 1 << 21 }; /* bytes */

/* Arrays of 2 MiB and more are mapped in pages of that size where the system allows it: mapping 512 small
 * ones takes several times as long as to clear them, and all passes over large arrays are slower with
 * these. */
static void *allocate(size_t bytes) {
#ifdef MADV_HUGEPAGE
  const size_t page = LARGE_PAGE;
  if (bytes >= page && bytes <= SIZE_MAX - page) {
    void *p = aligned_alloc(page, (bytes + page - 1) / page * page);
    if (p != NULL) madvise(p, bytes / page * page, MADV_HUGEPAGE); /* advice: small pages do as well */
    return p;
  }
#endif
  return aligned_alloc(ALIGNMENT, bytes);
}

/* The operating system maps a page when it is first touched; all threads share that cost. */
static void zero(char *p, size_t bytes) {
  const size_t piece = (size_t)1 << 20;
#pragma omp parallel for schedule(static) if (bytes > 4 * piece)
  for (size_t at = 0; at < bytes; at += piece) memset(p + at, 0, KITH_MIN(piece, bytes - at));
}

kith_status kith_resize(void *p, size_t keep, size_t count, size_t size) {
  if (count == 0) {
    kith_free(p);
    return KITH_OK;
  }
  if (count > (SIZE_MAX - ALIGNMENT) / size)
    KITH_FAIL(NO_MEMORY, "%zu elements of %zu bytes do not fit in memory", count, size);
  void *old;
  memcpy(&old, p, sizeof old);
  const size_t bytes = (count * size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT,
               kept = old == NULL ? 0 : KITH_MIN(keep, count) * size;
  void *fresh = allocate(bytes);
  if (fresh == NULL) KITH_FAIL(NO_MEMORY, "cannot get %zu bytes of memory", bytes);
  if (kept > 0) memcpy(fresh, old, kept);
  free(old); /* before the new bytes are touched */
  zero((char *)fresh + kept, bytes - kept);
  memcpy(p, &fresh, sizeof fresh);
  return KITH_OK;
}

kith_status kith_grow(void *p, size_t *capacity, size_t keep, size_t count, size_t size) {
  if (count <= *capacity) return KITH_OK;
  const size_t wanted = count + count / 32 + 8;
  KITH_TRY(kith_resize(p, keep, wanted, size));
  *capacity = wanted;
  return KITH_OK;
}

kith_status kith_reserve(void *p, size_t *capacity, size_t count, size_t size) {
  if (count <= *capacity) return KITH_OK;
  kith_free(p); /* never both at a time */
  *capacity = 0;
  return kith_grow(p, capacity, 0, count, size);
}

void kith_free(void *p) {
  void *old;
  memcpy(&old, p, sizeof old);
  free(old);
  old = NULL;
  memcpy(p, &old, sizeof old);
}

void kith_free_all(void *const *p, size_t n) {
  for (size_t k = 0; k < n; ++k) kith_free(p[k]);
}
