/* version.h - what this program is and how it was built. */
#ifndef KITH_APP_CLI_VERSION_H
#define KITH_APP_CLI_VERSION_H

const char *kith_version(void);    /* "0.1.0" */
const char *kith_build_text(void); /* compiler and flags */
const char *kith_compiler(void);   /* name and version */
const char *kith_flags(void);

#endif
