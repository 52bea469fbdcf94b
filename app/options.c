#include "app/options.h"

#include <argp.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "app/version.h"

enum { KEY_UNTIL = 256, KEY_STEPS, KEY_RESTART, KEY_CHECK, KEY_PROFILE, KEY_TRACE, KEY_THREADS, KEY_SET };

static const struct argp_option table[] = {
    {"set", KEY_SET, "KEY=VALUE", 0, "use VALUE for KEY of the scene (dotted: method.kernel=cubic); repeatable", 0},
    {"output", 'o', "DIR", 0, "write results to DIR (default: out/SCENE)", 0},
    {"threads", KEY_THREADS, "N", 0, "threads (default: all cores)", 0},
    {"until", KEY_UNTIL, "T", 0, "stop at time T", 0},
    {"steps", KEY_STEPS, "N", 0, "stop after step N", 0},
    {"restart", KEY_RESTART, "FILE", 0, "go on from a checkpoint", 0},
    {"check", KEY_CHECK, 0, 0, "verify every structure after every rebuild", 0},
    {"profile", KEY_PROFILE, 0, 0, "end with the table of stages", 0},
    {"trace", KEY_TRACE, "FILE", 0, "write trace events for Perfetto or a browser's tracing page", 0},
    {"quiet", 'q', 0, 0, "no progress, only the closing table", 0},
    {0}};

static double number(struct argp_state *state, const char *option, const char *text, double least) {
  char *end;
  const double value = strtod(text, &end);
  if (end == text || *end != '\0' || !isfinite(value) || value < least)
    argp_failure(state, KITH_EXIT_USAGE, 0, "--%s: %s is not a number of at least %g", option, text, least);
  return value;
}

static long whole(struct argp_state *state, const char *option, const char *text, long least) {
  const double value = number(state, option, text, (double)least);
  if (value != floor(value) || value > 1e15) argp_failure(state, KITH_EXIT_USAGE, 0, "--%s: %s is not a whole number", option, text);
  return (long)value;
}

static error_t parse(int key, char *text, struct argp_state *state) {
  struct kith_options *o = state->input;
  switch (key) {
    case 'o': o->directory = text; break;
    case 'q': o->quiet = true; break;
    case KEY_UNTIL: o->until = number(state, "until", text, 0); break;
    case KEY_STEPS: o->steps = whole(state, "steps", text, 0); break;
    case KEY_THREADS: o->threads = (int)whole(state, "threads", text, 1); break;
    case KEY_RESTART: o->restart = text; break;
    case KEY_CHECK: o->check = true; break;
    case KEY_PROFILE: o->profile = true; break;
    case KEY_TRACE: o->trace = text; break;
    case KEY_SET:
      if (strchr(text, '=') == NULL) argp_failure(state, KITH_EXIT_USAGE, 0, "--set %s: not KEY=VALUE", text);
      if (o->n_overrides == KITH_MAX_OVERRIDES) argp_failure(state, KITH_EXIT_USAGE, 0, "--set: more than %d", KITH_MAX_OVERRIDES);
      o->overrides[o->n_overrides++] = text;
      break;
    case ARGP_KEY_ARG:
      if (o->verb == NULL) o->verb = text;
      else if (o->subject == NULL) o->subject = text;
      else argp_failure(state, KITH_EXIT_USAGE, 0, "%s: one argument too many", text);
      break;
    case ARGP_KEY_END:
      if (o->verb == NULL) argp_failure(state, KITH_EXIT_USAGE, 0, "no verb: run, plan, list, bench or validate (see --help)");
      break;
    default: return ARGP_ERR_UNKNOWN;
  }
  return 0;
}

static void print_version(FILE *out, struct argp_state *state) {
  (void)state;
  fprintf(out, "kith %s (%s)\n", kith_version(), kith_build());
}

void kith_options_parse(struct kith_options *options, int argc, char **argv) {
  static const struct argp argp = {
      table, parse, "run SCENE\nplan SCENE\nlist [FAMILY]\nbench\nvalidate [SUITE]",
      "The life of particle connectivity in a time-stepping SPH mini-app.\v"
      "run       runs a scene and compares it with its exact solution\n"
      "plan      shows what a scene will build and why, memory, dt; nothing runs\n"
      "list      the members of all families, or of one; 'list scene': every key of a scene\n"
      "bench     node updates per second, stage by stage, beside reference loops\n"
      "validate  runs the scenes with their tolerances\n\n"
      "Exit codes: 0 ok, 1 the run failed, 2 usage or scene, 3 out of tolerance.",
      0, 0, 0};
  *options = (struct kith_options){.until = -1, .steps = -1};
  argp_program_version_hook = print_version;
  argp_err_exit_status = KITH_EXIT_USAGE;
  argp_parse(&argp, argc, argv, 0, NULL, options);
}
