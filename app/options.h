/* options.h - the command line: a verb, its subject, options. Parsed by argp. */
#ifndef KITH_APP_OPTIONS_H
#define KITH_APP_OPTIONS_H

#include "lib/core/base.h"

enum { KITH_MAX_OVERRIDES = 64, KITH_MAX_THREADS = 1024, KITH_MAX_RANKS = 1000000 };

/* Between ranks: seconds that a message takes however short it is, bytes per second. A common cluster network unless told otherwise:
 * 100 Gbit/s, a rank on each node. */
struct kith_network {
  double latency, bandwidth;
};
#define KITH_NETWORK      \
  (struct kith_network) { \
    2e-6, 1e10            \
  }

/* Exit codes of the program. */
enum kith_exit { KITH_EXIT_OK = 0, KITH_EXIT_FAILED = 1, KITH_EXIT_USAGE = 2, KITH_EXIT_TOLERANCE = 3 };

struct kith_options {
  const char *verb;    /* run, plan, list, ... */
  const char *subject; /* scene file, family, suite; NULL if not given */
  int n_overrides;
  const char *overrides[KITH_MAX_OVERRIDES]; /* key=value */
  const char *directory;                     /* -o; NULL: out/<scene's name> */
  const char *restart;                       /* checkpoint file or NULL */
  const char *trace;                         /* file or NULL */
  double until;                              /* < 0: the scene's */
  long steps;                                /* < 0: no limit */
  int threads;                               /* 0: all */
  int ranks;                                 /* 0: as many as were started */
  struct kith_network network;               /* that plans and forecasts are made for */
  char **arguments;                          /* as given, with the program first, ended by NULL */
  bool check, profile, quiet;
  bool yes; /* start what takes long */
};

/* What the program can do. A table of them ends with a NULL name; usage and help are made from it. */
struct kith_verb {
  const char *name, *subject, *doc; /* subject as in "run SCENE"; "": none */
  enum kith_exit (*act)(const struct kith_options *options);
};

/* Returns the verb that was asked for. Ends the process with code 2 and one line on stderr if the command
 * line is wrong; with 0 for --help and --version. */
const struct kith_verb *kith_options_parse(struct kith_options *options, int argc, char **argv,
                                           const struct kith_verb *verbs);

#endif
