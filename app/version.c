#include "app/version.h"

#include "lib/core/base.h"

#define TEXT_(x) #x
#define TEXT(x) TEXT_(x)
#ifdef __clang__
#define COMPILER "clang " __clang_version__
#else
#define COMPILER "gcc " __VERSION__
#endif
#ifndef KITH_FLAGS
#define KITH_FLAGS "unknown"
#endif

const char *kith_version(void) {
  return KITH_VERSION;
}
const char *kith_build(void) {
  return TEXT(KITH_NDIM) "-D, " COMPILER ", " KITH_FLAGS;
}
const char *kith_compiler(void) {
  return COMPILER;
}
const char *kith_flags(void) {
  return KITH_FLAGS;
}
