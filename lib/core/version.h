/* version.h - which kith this is: numbers for the preprocessor, and what the linked library says of itself.
 *
 * CMakeLists.txt reads the numbers from here. */
#ifndef KITH_CORE_VERSION_H
#define KITH_CORE_VERSION_H

#define KITH_VERSION_MAJOR 0
#define KITH_VERSION_MINOR 2
#define KITH_VERSION_PATCH 0

const char *kith_version(void);  /* "0.2.0" */
const char *kith_commit(void);   /* of the sources, "-dirty" behind it if they differ; NULL: not known */
const char *kith_compiler(void); /* name and version */
const char *kith_flags(void);    /* build type and flags */

#endif
