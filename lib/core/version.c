/* The version of the library, and what the build system has compiled it with. */
#include "lib/core/version.h"

#include <stddef.h>
#include "commit.h" /* KITH_COMMIT: the build makes it */

#define TEXT_OF(number) #number
#define TEXT(number) TEXT_OF(number)

const char *kith_version(void) {
  return TEXT(KITH_VERSION_MAJOR) "." TEXT(KITH_VERSION_MINOR) "." TEXT(KITH_VERSION_PATCH);
}

const char *kith_compiler(void) {
#ifdef __clang__
  return "clang " __clang_version__;
#else
  return "gcc " __VERSION__;
#endif
}

const char *kith_commit(void) {
  return sizeof KITH_COMMIT > 1 ? KITH_COMMIT : NULL;
}

const char *kith_flags(void) {
  return KITH_FLAGS;
}
