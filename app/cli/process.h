/* process.h - processes and directories: where the programs kith-1d, kith-2d and kith-3d are, running one of
 * them or gnuplot, and directories that one process writes to. */
#ifndef KITH_APP_CLI_PROCESS_H
#define KITH_APP_CLI_PROCESS_H

#include "lib/core/base.h"

enum { KITH_PATH = 768 };

struct kith_programs {
  char prefix[KITH_PATH]; /* ".../kith-": "1d" and so on follow */
  char inputs[KITH_PATH]; /* ".../inputs" */
};

/* Finds the programs beside this one, and `inputs` above it, below share/kith, or else in the current
 * folder. */
kith_status kith_programs_find(struct kith_programs *programs);
/* Are `a` and `b` the same existing file or directory? */
bool kith_is_same_file(const char *a, const char *b);
/* Creates a directory and its parents where they do not exist. */
kith_status kith_directory_make(const char *path);
/* What the message of kith_directory_claim has if another process writes there. */
#define KITH_CLAIMED ": another run writes there"
/* Makes this process the only one that writes to a directory until *lock is closed or the process ends.
 * BAD_FILE if another one writes there. */
kith_status kith_directory_claim(const char *path, int *lock);

/* Runs the command words[0], words[1]... (ended by NULL), appends its output to the file `log`, and waits for
 * it. *code: its exit code, or minus the signal that ended it; 127: it could not be started. cpu_limit:
 * seconds of processor time after which SIGXCPU ends it; 0: none. It ends when this process ends. */
kith_status kith_process_run(char *const *words, const char *log, double cpu_limit, int *code);

/* Seconds since this process began, to a hundredth: they include the loading of the program before main. 0 if
 * they are not known, or so many that the launcher must have built the programs before it became this one. */
double kith_process_age(void);

/* Runs gnuplot on DIRECTORY/NAME.gp, which draws the pictures that it names there. UNSUPPORTED if there is no
 * gnuplot; BAD_FILE if it fails: what it says is left in NAME.log. */
kith_status kith_gnuplot_run(const char *directory, const char *name);

#endif
