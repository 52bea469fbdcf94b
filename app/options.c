#include "app/options.h"

#include <argp.h>
#include <getopt.h>
#include <math.h>
#include <omp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "app/version.h"
#include "app/words.h"

enum {
  KEY_UNTIL = 256,
  KEY_STEPS,
  KEY_RESTART,
  KEY_CHECK,
  KEY_PROFILE,
  KEY_TRACE,
  KEY_THREADS,
  KEY_RANKS,
  KEY_NETWORK,
  KEY_SET,
  KEY_YES,
  N_KEYS = 32
};

static const struct argp_option table[] = {
    {0, 0, 0, 0, "A scene:", 1},
    {"set", KEY_SET, "KEY=VALUE", 0,
     "use VALUE for KEY of the scene (dotted: method.kernel=cubic); repeatable", 1},
    {"threads", KEY_THREADS, "N", 0, "threads (default: all cores, shared among ranks)", 1},
    {0, 0, 0, 0, "A run:", 2},
    {"ranks", KEY_RANKS, "N", 0,
     "processes, started by mpirun (default: 1, or those of mpirun -n N kith run)", 2},
    {"output", 'o', "DIR", 0, "write results to DIR (default: out/SCENE)", 2},
    {"until", KEY_UNTIL, "T", 0, "stop at time T", 2},
    {"steps", KEY_STEPS, "N", 0, "stop after step N", 2},
    {"restart", KEY_RESTART, "FILE", 0, "go on from a checkpoint", 2},
    {"check", KEY_CHECK, 0, 0, "verify every structure after every rebuild", 2},
    {"profile", KEY_PROFILE, 0, 0, "end with the table of stages, of all ranks", 2},
    {"trace", KEY_TRACE, "FILE", 0,
     "write trace events of all ranks for Perfetto or a browser's tracing page", 2},
    {"quiet", 'q', 0, 0, "no progress, only the closing table", 2},
    {"network", KEY_NETWORK, "S,B", 0,
     "plan: ranks whose messages take S seconds and B bytes per second (default: 2e-6,1e10)", 2},
    {0, 0, 0, 0, "A chart or a stress:", 3},
    {"yes", KEY_YES, 0, 0, "start many runs, or long ones, without being asked", 3},
    {0}};

struct parse {
  struct kith_options *options;
  const struct kith_verb *verbs, *verb;
};

/* One line, and code 2. */
__attribute__((noreturn, format(printf, 1, 2))) static void refuse(const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  fputs("kith: ", stderr);
  vfprintf(stderr, format, arguments);
  fputc('\n', stderr);
  va_end(arguments);
  exit(KITH_EXIT_USAGE);
}

static double number(const char *option, const char *text, double least) {
  char *end;
  const double value = strtod(text, &end);
  if (end == text || *end != '\0' || !isfinite(value) || value < least)
    refuse("--%s: '%s' is not a number of at least %g", option, text, least);
  return value;
}

static long whole(const char *option, const char *text, long least, long most) {
  const double value = number(option, text, (double)least);
  if (value != floor(value)) refuse("--%s: '%s' is not a whole number", option, text);
  if (value > (double)most) refuse("--%s: '%s' is more than %ld", option, text, most);
  return (long)value;
}

/* "2e-6,1e10" */
static struct kith_network network(const char *text) {
  char latency[64] = "", *comma = strchr(text, ',');
  if (comma == NULL) refuse("--network: '%s' is not SECONDS,BYTES_PER_SECOND", text);
  snprintf(latency, sizeof latency, "%.*s", (int)KITH_MIN(comma - text, 63), text);
  const struct kith_network net = {number("network", latency, 0), number("network", comma + 1, 1)};
  return net;
}

static void add_override(struct kith_options *o, const char *text) {
  if (strchr(text, '=') == NULL) refuse("--set: '%s' is not KEY=VALUE", text);
  if (o->n_overrides == KITH_MAX_OVERRIDES) refuse("--set: more than %d of them", KITH_MAX_OVERRIDES);
  o->overrides[o->n_overrides++] = text;
}

/* ---- verbs ---- */

static void verb_words(const struct kith_verb *verbs, char words[256]) {
  words[0] = '\0';
  for (const struct kith_verb *v = verbs; v->name != NULL; ++v) {
    const size_t used = strlen(words);
    snprintf(words + used, 256 - used, "|%s", v->name);
  }
}

static const struct kith_verb *find_verb(const struct kith_verb *verbs, const char *name) {
  char words[256], told[256], near[64];
  verb_words(verbs, words);
  kith_words_tell(words, told, sizeof told);
  if (name == NULL) refuse("no verb; one of %s (see --help)", told);
  for (const struct kith_verb *v = verbs; v->name != NULL; ++v)
    if (strcmp(v->name, name) == 0) return v;
  if (kith_words_nearest(words, name, near, sizeof near))
    refuse("%.60s: unknown verb; did you mean '%s'?", name, near);
  refuse("%.60s: unknown verb; one of %s", name, told);
}

static void usage_texts(const struct kith_verb *verbs, char usage[512], char about[2048]) {
  int u = 0,
      a = snprintf(about, 2048, "The life of particle connectivity in a time-stepping SPH mini-app.\v");
  for (const struct kith_verb *v = verbs; v->name != NULL; ++v) {
    u += snprintf(usage + u, (size_t)(512 - u), "%s%s%s%s", v == verbs ? "" : "\n", v->name,
                  v->subject[0] != '\0' ? " " : "", v->subject);
    a += snprintf(about + a, (size_t)(2048 - a), "  %-9s %s\n", v->name, v->doc);
  }
  snprintf(about + a, (size_t)(2048 - a),
           "\nExit codes: 0 ok, 1 the run failed, 2 usage or scene, 3 out of tolerance.");
}

/* ---- options ---- */

/* The options as getopt has them, with those of argp itself. */
static void known_options(struct option known[N_KEYS], char words[512]) {
  static const struct option own[] = {
      {"help", no_argument, 0, 'h'}, {"usage", no_argument, 0, 'u'}, {"version", no_argument, 0, 'V'}, {0}};
  int n = 0;
  for (const struct argp_option *o = table; o->name != NULL || o->doc != NULL; ++o)
    if (o->name != NULL)
      known[n++] = (struct option){o->name, o->arg != NULL ? required_argument : no_argument, NULL, o->key};
  memcpy(known + n, own, sizeof own);
  words[0] = '\0';
  for (const struct option *o = known; o->name != NULL; ++o) {
    const size_t used = strlen(words);
    snprintf(words + used, 512 - used, "|%s", o->name);
  }
}

/* An option that is not known, or lacks its value: in one line, which argp would not do. */
static void check_options(int argc, char **argv) {
  struct option known[N_KEYS];
  char words[512], near[64], name[64];
  known_options(known, words);
  opterr = 0;
  for (int c; (c = getopt_long(argc, argv, "-:o:qV", known, NULL)) != -1;) {
    const char *given = argv[KITH_MAX(optind - 1, 1)];
    if (c == ':') refuse("%.60s: its value is missing", given);
    if (c != '?' || optopt == '?') continue; /* -? is help */
    if (optopt != 0 && strchr(given, '=') != NULL) refuse("%.60s: this option takes no value", given);
    if (optopt != 0) refuse("-%c: unknown option (see --help)", optopt);
    snprintf(name, sizeof name, "%.*s", (int)KITH_MIN(strcspn(given + 2, "="), sizeof name - 1), given + 2);
    if (kith_words_nearest(words, name, near, sizeof near))
      refuse("--%s: unknown option; did you mean '--%s'?", name, near);
    refuse("--%s: unknown option (see --help)", name);
  }
}

static error_t parse(int key, char *text, struct argp_state *state) {
  struct parse *p = state->input;
  struct kith_options *o = p->options;
  switch (key) {
    case 'o':
      o->directory = text;
      break;
    case 'q':
      o->quiet = true;
      break;
    case KEY_UNTIL:
      o->until = number("until", text, 0);
      break;
    case KEY_STEPS:
      o->steps = whole("steps", text, 0, 1000000000000000);
      break;
    case KEY_THREADS:
      o->threads = (int)whole("threads", text, 1, KITH_MAX_THREADS);
      break;
    case KEY_RANKS:
      o->ranks = (int)whole("ranks", text, 1, KITH_MAX_RANKS);
      break;
    case KEY_NETWORK:
      o->network = network(text);
      break;
    case KEY_RESTART:
      o->restart = text;
      break;
    case KEY_CHECK:
      o->check = true;
      break;
    case KEY_PROFILE:
      o->profile = true;
      break;
    case KEY_TRACE:
      o->trace = text;
      break;
    case KEY_YES:
      o->yes = true;
      break;
    case KEY_SET:
      add_override(o, text);
      break;
    case ARGP_KEY_ARG:
      if (o->verb == NULL)
        o->verb = text, p->verb = find_verb(p->verbs, text);
      else if (o->subject == NULL && p->verb->subject[0] != '\0')
        o->subject = text;
      else
        refuse("%.60s: one argument too many", text);
      break;
    case ARGP_KEY_END:
      p->verb = find_verb(p->verbs, o->verb);
      break;
    default:
      return ARGP_ERR_UNKNOWN;
  }
  return 0;
}

static void print_version(FILE *out, struct argp_state *state) {
  (void)state;
  fprintf(out, "kith %s (%s)\n", kith_version(), kith_build());
}

const struct kith_verb *kith_options_parse(struct kith_options *options, int argc, char **argv,
                                           const struct kith_verb *verbs) {
  char usage[512], about[2048], name[] = "kith", *started_as = argv[0];
  struct parse p = {options, verbs, NULL};
  const struct argp argp = {table, parse, usage, about, 0, 0, 0};
  *options = (struct kith_options){.until = -1, .steps = -1, .network = KITH_NETWORK};
  usage_texts(verbs, usage, about);
  argp_program_version_hook = print_version;
  argp_err_exit_status = KITH_EXIT_USAGE;
  check_options(argc, argv);
  argv[0] = name; /* whichever of the three this is */
  argp_parse(&argp, argc, argv, 0, NULL, &p);
  argv[0] = started_as;
  options->arguments = argv;
  if (omp_get_max_threads() > KITH_MAX_THREADS && options->threads == 0)
    refuse("OMP_NUM_THREADS: more than %d", KITH_MAX_THREADS);
  return p.verb;
}
