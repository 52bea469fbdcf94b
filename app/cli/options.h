/* options.h - the command line: the table of verbs and the table of options.
 *
 * Parsing (options.c, by getopt_long), help, the refusal of an option that a verb does not take, and the
 * dispatch in app/kith.c and app/main.c follow from them. A verb is one line here and a function kith_<verb>;
 * an option is one line here and a member of struct kith_options. */
#ifndef KITH_APP_CLI_OPTIONS_H
#define KITH_APP_CLI_OPTIONS_H

#include <limits.h>
#include "lib/core/base.h"

/* Verbs: name, argument (in brackets if it may be left out), doc. Three lists, by what carries verbs out: the
 * program of the scene's dimension, the program kith, which starts those, the script ./kith. */
#define KITH_SCENE_VERBS(X)                                                                            \
  X(run, "SCENE", "run a scene and compare it with its exact solution")                                \
  X(plan, "SCENE",                                                                                     \
    "predict what a scene builds and why, its memory, time step and cost; nothing is written")         \
  X(bench, "", "measure time and bytes of each stage, beside plain loops and the bandwidth of memory") \
  X(list, "[FAMILY]", "show what a scene can choose from; 'list scene': every key of a scene")
#define KITH_STUDY_VERBS(X)                                                                 \
  X(validate, "[SUITE|FILE]",                                                               \
    "run scenes and compare their errors with bounds; 'validate list': suites and keys")    \
  X(chart, "SUITE", "compare methods by error against cost; 'chart list': suites and keys") \
  X(stress, "[SWEEP|FILE]",                                                                 \
    "find where methods stop working, by one parameter; 'stress list': sweeps and keys")
#define KITH_LAUNCHER_VERBS(X)       \
  X(build, "", "build the programs") \
  X(test, "[quick]",                 \
    "build with gcc, with sanitizers and with clang, and test each (quick: gcc only); more words go to ctest")
#define KITH_VERB_LIST(X) KITH_SCENE_VERBS(X) KITH_STUDY_VERBS(X) KITH_LAUNCHER_VERBS(X)

enum kith_verb_id {
#define X(name, argument, doc) KITH_VERB_##name,
  KITH_VERB_LIST(X)
#undef X
      KITH_N_VERBS
};
struct kith_verb {
  const char *name, *argument, *doc;
};

/* KITH_MAX_STARTED: ranks that a run starts by itself; a plan starts none of its ranks. */
enum { KITH_MAX_OVERRIDES = 64, KITH_MAX_THREADS = 1024, KITH_MAX_RANKS = 1000000, KITH_MAX_STARTED = 4096 };

struct kith_options {
  const struct kith_verb *verb;
  const char *subject; /* scene file, family, suite; NULL if not given */
  int n_overrides;
  const char *overrides[KITH_MAX_OVERRIDES]; /* key=value */
  const char *directory;                     /* NULL: the verb's default */
  const char *restart;                       /* checkpoint file or NULL */
  const char *trace;                         /* file or NULL */
  double until;                              /* < 0: as the scene says */
  double walltime;                           /* minutes; 0: no limit */
  double watchdog;                           /* seconds; 0: none */
  int steps;                                 /* < 0: no limit */
  int threads;                               /* 0: not given */
  int ranks;                                 /* 0: as many as were started */
  int jobs;                                  /* of ./kith */
  bool check, profile, quiet, overwrite, help, version;
  char **arguments; /* the words as given, with the program first, ended by NULL */
};

/* Options: name, letter (0: none), argument (0: none), kind (SETTING: "key=value", may be repeated), least
 * and greatest value, member of struct kith_options, verbs that take it (~0u: all), doc. */
#define KITH_OPTION_LIST(X)                                                                                \
  X(set, 0, "KEY=VALUE", SETTING, 0, 0, overrides, F(run) | F(plan) | F(bench) | F(chart) | F(stress),     \
    "use VALUE for KEY of the scene: method.kernel=cubic (repeatable); KEY?=VALUE: if it has a meaning")   \
  X(output, 'o', "DIR", TEXT, 0, 0, directory, F(run) | F(validate) | F(chart) | F(stress),                \
    "write results to DIR (default: below out)")                                                           \
  X(ranks, 0, "N", COUNT, 1, KITH_MAX_RANKS, ranks, F(run) | F(plan),                                      \
    "processes, started by mpirun (default: 1, or those of a mpirun around kith); plan: those to predict") \
  X(threads, 0, "N", COUNT, 1, KITH_MAX_THREADS, threads,                                                  \
    F(run) | F(plan) | F(bench) | F(chart) | F(stress),                                                    \
    "threads of each process (default: its part of the cores, one for 2,000 nodes; chart, stress: 1)")     \
  X(until, 0, "T", NUMBER, 0, 1e300, until, F(run) | F(plan), "stop at time T")                            \
  X(steps, 0, "N", COUNT, 0, INT_MAX, steps, F(run) | F(bench), "stop after step N")                       \
  X(walltime, 0, "MINUTES", NUMBER, 0.001, 1e9, walltime, F(run),                                          \
    "stop with a checkpoint two steps before this time has passed")                                        \
  X(watchdog, 0, "SECONDS", NUMBER, 0.01, 1e9, watchdog, F(run),                                           \
    "a rank that waits longer than this for others prints where, and goes on waiting")                     \
  X(restart, 0, "FILE", TEXT, 0, 0, restart, F(run),                                                       \
    "continue from a checkpoint, or from that in a directory")                                             \
  X(overwrite, 0, 0, FLAG, 0, 0, overwrite, F(run),                                                        \
    "start anew in a directory with the checkpoint of an earlier run, and replace its results")            \
  X(check, 0, 0, FLAG, 0, 0, check, F(run), "verify all structures after every rebuild")                   \
  X(profile, 0, 0, FLAG, 0, 0, profile, F(run), "end with a table of the time of each stage on all ranks") \
  X(trace, 0, "FILE", TEXT, 0, 0, trace, F(run),                                                           \
    "write trace events of all ranks for Perfetto or a browser's tracing page")                            \
  X(quiet, 'q', 0, FLAG, 0, 0, quiet, F(run) | F(chart) | F(stress),                                       \
    "no progress, only the results at the end")                                                            \
  X(jobs, 'j', "N", COUNT, 1, 9999, jobs, F(build) | F(test),                                              \
    "compile N files, and run N tests, at a time (default: about as many as there are cores)")             \
  X(help, 'h', 0, FLAG, 0, 0, help, ~0u, "this help; kith VERB --help, or kith help VERB: that of a verb") \
  X(version, 'V', 0, FLAG, 0, 0, version, ~0u, "version, commit, compiler and flags")

enum kith_exit { KITH_EXIT_OK = 0, KITH_EXIT_FAILED = 1, KITH_EXIT_USAGE = 2, KITH_EXIT_TOLERANCE = 3 };

/* Each verb is carried out by the function of its name. */
#define X(name, argument, doc) enum kith_exit kith_##name(const struct kith_options *options);
KITH_SCENE_VERBS(X)
KITH_STUDY_VERBS(X)
#undef X

/* Parses the command line. Ends the process itself with one line and code 2 if something is wrong, and,
 * through kith_exit_code, after --help and --version. */
enum kith_verb_id kith_options_parse(struct kith_options *options, int argc, char **argv);

/* Returns the exit code of a program that would end with `code`: prints a line and turns OK into FAILED if
 * standard output could not be written. */
enum kith_exit kith_exit_code(enum kith_exit code);

#endif
