/* process.h - programs that the program starts: where they are, a run as a process of its own, and what its report says.
 *
 * What validates, charts and stresses runs scenes as anybody would: kith-1d, kith-2d or kith-3d on a scene file, into a directory. */
#ifndef KITH_APP_PROCESS_H
#define KITH_APP_PROCESS_H

#include "lib/core/base.h"

enum { KITH_PATH = 768 };

struct kith_programs {
  char prefix[KITH_PATH]; /* ".../kith-": "1d" and so on follow */
  char inputs[KITH_PATH]; /* ".../inputs" */
};

/* The programs beside this one; `inputs` below it, above it, or in the working directory. */
kith_status kith_programs_find(struct kith_programs *programs);
/* A directory with all above it; none of them needs to be new. */
kith_status kith_directory_make(const char *path);

/* Runs words[0] with its words (the last one NULL), what it prints added to the file `log`, and waits for it. *code: its exit code, or
 * minus the signal that ended it; 127: it could not be started. cpu_limit: seconds of processor time after which it is ended by
 * SIGXCPU; 0: none. It ends with this process. */
kith_status kith_process_run(char *const *words, const char *log, double cpu_limit, int *code);

/* The number at a dotted path of a report (JSON is YAML). BAD_FILE if there is none, or it is null. */
kith_status kith_report_number(const char *path, const char *key, double *value);

#endif
