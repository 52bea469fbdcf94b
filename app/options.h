/* options.h - the command line: a verb, its subject, options. Parsed by argp. */
#ifndef KITH_APP_OPTIONS_H
#define KITH_APP_OPTIONS_H

#include "lib/core/base.h"

enum { KITH_MAX_OVERRIDES = 64 };

/* Exit codes of the program. */
enum kith_exit { KITH_EXIT_OK = 0, KITH_EXIT_FAILED = 1, KITH_EXIT_USAGE = 2, KITH_EXIT_TOLERANCE = 3 };

struct kith_options {
  const char *verb;    /* run, plan, list, bench, validate */
  const char *subject; /* scene file, family, suite; NULL if not given */
  int n_overrides;
  const char *overrides[KITH_MAX_OVERRIDES]; /* key=value */
  const char *directory; /* -o; NULL: out/<scene's name> */
  const char *restart;   /* checkpoint file or NULL */
  const char *trace;     /* file or NULL */
  double until;          /* < 0: the scene's */
  long steps;            /* < 0: no limit */
  int threads;           /* 0: all */
  bool check, profile, quiet;
};

/* Ends the process with code 2 and one line on stderr if the command line is wrong; with 0 for --help and --version. */
void kith_options_parse(struct kith_options *options, int argc, char **argv);

#endif
