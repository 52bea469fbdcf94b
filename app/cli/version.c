/* version.c - version, compiler and flags, as the build system defines them. */
#include "app/cli/version.h"

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
const char *kith_build_text(void) {
  return COMPILER ", " KITH_FLAGS;
}
const char *kith_compiler(void) {
  return COMPILER;
}
const char *kith_flags(void) {
  return KITH_FLAGS;
}
