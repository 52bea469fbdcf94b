/* options.c - parsing of the command line and its help, from the tables of options.h. */
#include "app/cli/options.h"

#include <ctype.h>
#include <fcntl.h>
#include <getopt.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "app/cli/text.h"
#include "lib/core/choices.h"
#include "lib/core/param.h"
#include "lib/core/version.h"

#define X(name, argument, doc) {#name, argument, doc},
static const struct kith_verb verbs[KITH_N_VERBS] = {KITH_VERB_LIST(X)};
#undef X

/* What `kith VERB --help` adds: what the verb reads and writes, and examples. */
static const char *const details[KITH_N_VERBS] = {
    [KITH_VERB_run] =
        "Writes to DIR: snapshot_NNNN.hdf (ParaView, yt), snapshots.hdf.series, history.csv (a row for the "
        "start and for each step), report.json (errors, costs, counts), pictures, and a checkpoint every 15 "
        "minutes. INT, TERM, HUP, USR1 and USR2 stop it after the present step with a checkpoint. After the "
        "last step there is one only with output.checkpoint_at_end=true.\n"
        "  kith run inputs/sod.yaml --set method.package=crk --set resolution=400\n"
        "  kith run inputs/sedov.yaml --ranks 2 --threads 1 --profile --trace sedov.json\n"
        "  kith run inputs/sedov.yaml -o out/sedov --restart out/sedov/checkpoint.kith --until 0.1",
    [KITH_VERB_plan] =
        "Prints which structures are required by whom, memory, time step, the cost by a calibration run with "
        "fewer nodes, and settings that save time. With --ranks N: work, ghosts and neighbor ranks of each "
        "partitioner, and the memory of a rank.\n"
        "  kith plan inputs/sedov.yaml --set resolution=100\n"
        "  kith plan inputs/sedov.yaml --ranks 4096",
    [KITH_VERB_bench] =
        "Times 10 steps of a 3-D Sedov blast of 10^6 nodes (kith-1d bench, kith-2d bench: 1-D, 2-D).\n"
        "  kith bench --set resolution=100 --threads 1",
    [KITH_VERB_list] =
        "  kith list           all families and their members\n"
        "  kith list boundary  one family, with the parameters of its members\n"
        "  kith list scene     every key of a scene: default, meaning, range",
    [KITH_VERB_validate] =
        "A suite is a list of rows; a row is a scene, settings, a measure and a bound. Prints a line for "
        "each row, and writes validation.csv with norms and the reason of each bound. Default: suite quick.\n"
        "  kith validate full\n"
        "  kith validate readme      the figures that README and manual print\n"
        "  kith validate my-rows.yaml -o out/mine      rows of your own",
    [KITH_VERB_chart] =
        "Runs methods at several resolutions; writes chart.md, chart.png, points.csv. An interrupted chart "
        "continues when it is called again.\n"
        "  kith chart sod-1d\n"
        "  kith chart my-suite.yaml --set method.neighbors=50",
    [KITH_VERB_stress] =
        "Writes stress.md and points.csv: up to which value of a parameter each method works.\n"
        "  kith stress cfl-sod",
    [KITH_VERB_build] = "  ./kith build",
    [KITH_VERB_test] = "  ./kith test quick -R sod    only tests whose names hold `sod`"};

enum kind { FLAG, COUNT, NUMBER, TEXT, SETTING };
struct row {
  const char *name;
  int letter;
  const char *argument;
  enum kind kind;
  double least, most;
  unsigned verbs; /* a bit for each verb that takes it */
  const char *doc;
  size_t offset;
};
#define F(verb) 1u << KITH_VERB_##verb
#define X(name, letter, argument, kind, least, most, member, verbs, doc) \
  {#name, letter, argument, kind, least, most, verbs, doc, offsetof(struct kith_options, member)},
static const struct row rows[] = {KITH_OPTION_LIST(X)};
#undef X
#undef F
enum { N_ROWS = sizeof rows / sizeof rows[0], OPTION = 256 };

static const char VERBS[] = "" /* "|run|plan..." */
#define X(name, ...) "|" #name
    KITH_VERB_LIST(X),
                  OPTIONS[] = "" KITH_OPTION_LIST(X);
#undef X

/* Prints one line and ends with code 2. */
__attribute__((noreturn, format(printf, 1, 2))) static void refuse(const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  fputs("kith: ", stderr);
  vfprintf(stderr, format, arguments);
  fputc('\n', stderr);
  va_end(arguments);
  exit(KITH_EXIT_USAGE);
}

static double number(const struct row *row, const char *text) {
  char *end;
  const double value = strtod(text, &end);
  if (end == text || *end != '\0' || !isfinite(value) || value < row->least)
    refuse("--%s: '%.60s' is not a number of at least %g", row->name, text, row->least);
  if (row->kind == COUNT && value != floor(value))
    refuse("--%s: '%.60s' is not a whole number", row->name, text);
  if (value > row->most) refuse("--%s: '%.60s' is more than %.15g", row->name, text, row->most);
  return value;
}

/* Refuses an option that is given as a key: --set ranks=4. `until` and `output` are keys, too. */
static void refuse_as_key(const char *text) {
  const char *value = strchr(text, '=') + 1;
  for (const struct row *row = rows; row < rows + N_ROWS; ++row) {
    const bool key = kith_choices_index("until|output", row->name) >= 0,
               numeric = row->kind == COUNT || row->kind == NUMBER; /* steps=block: of scheme */
    if (key || !kith_name_is(row->name, text, strcspn(text, "?=")) ||
        (numeric && !isdigit((unsigned char)value[0])))
      continue;
    refuse("--set %.60s: not a key of a scene, but an option: --%s%s%.60s", text, row->name,
           row->argument != NULL ? " " : "", row->argument != NULL ? value : "");
  }
}

static void add_override(struct kith_options *o, const char *text) {
  if (strchr(text, '=') == NULL) refuse("--set: '%.60s' is not KEY=VALUE", text);
  refuse_as_key(text);
  if (o->n_overrides == KITH_MAX_OVERRIDES) refuse("--set: more than %d of them", KITH_MAX_OVERRIDES);
  o->overrides[o->n_overrides++] = text;
}

static void take_value(const struct row *row, const char *text, struct kith_options *o) {
  void *into = (char *)o + row->offset;
  if (row->kind == TEXT && text[0] == '\0') refuse("--%s: an empty name", row->name);
  if (row->kind == FLAG)
    *(bool *)into = true;
  else if (row->kind == COUNT)
    *(int *)into = (int)number(row, text);
  else if (row->kind == NUMBER)
    *(double *)into = number(row, text);
  else if (row->kind == TEXT)
    *(const char **)into = text;
  else
    add_override(o, text);
}

/* Writes "run, plan", the verbs that take an option. */
static const char *takers(const struct row *row, char text[128]) {
  text[0] = '\0';
  for (int v = 0; v < KITH_N_VERBS; ++v)
    if (row->verbs >> v & 1) kith_text_join(text, 128, ", ", "%s", verbs[v].name);
  return text;
}

static void print_option(const struct row *row, bool of_all) {
  char label[64], text[512], names[128];
  char letter[8] = "    ";
  if (row->letter != 0) snprintf(letter, sizeof letter, "-%c, ", row->letter);
  snprintf(label, sizeof label, "  %s--%s%s%s", letter, row->name, row->argument != NULL ? " " : "",
           row->argument != NULL ? row->argument : "");
  snprintf(text, sizeof text, of_all && row->verbs != ~0u ? "%s [%s]" : "%s", row->doc, takers(row, names));
  kith_text_wrapped(26, label, text);
}

static void print_help(const struct kith_verb *verb) {
  if (verb != NULL) {
    char lines[1024], *rest = lines;
    snprintf(lines, sizeof lines, "%s", details[verb - verbs]);
    printf("usage: kith %s%s%s [OPTION]...\n\n%s\n\n", verb->name, verb->argument[0] != '\0' ? " " : "",
           verb->argument, verb->doc);
    for (const char *line; (line = strsep(&rest, "\n")) != NULL;)
      if (line[0] == ' ')
        puts(line);
      else
        kith_text_wrapped(0, "", line);
    printf("\noptions:\n");
  } else {
    printf(
        "usage: kith VERB [ARGUMENT] [OPTION]...\n\n"
        "SPH in 1-D to 3-D that times and verifies how neighbor lists are built and kept valid.\n\n"
        "verbs:\n");
    for (const struct kith_verb *v = verbs; v < verbs + KITH_N_VERBS; ++v) {
      char label[64];
      snprintf(label, sizeof label, "  %s %s", v->name, v->argument);
      kith_text_wrapped(26, label, v->doc);
    }
    printf("\noptions, with the verbs that take them:\n");
  }
  for (int k = 0; k < N_ROWS; ++k)
    if (verb == NULL || rows[k].verbs >> (verb - verbs) & 1) print_option(&rows[k], verb == NULL);
  printf("\nexit codes: 0 ok, 1 the run or the build failed, 2 usage or scene, 3 out of tolerance\n");
}

static const struct kith_verb *find_verb(const char *name) {
  static const struct kith_param row = {.kind = KITH_PARAM_CHOICE, .allowed = VERBS, .size = sizeof(int)};
  char told[256];
  int v;
  kith_choices_format(VERBS, told, sizeof told);
  if (name == NULL) refuse("no verb; one of %s (see kith --help)", told);
  if (kith_param_parse(&row, name, &v) != KITH_OK) refuse("verb %s (see kith --help)", kith_failure());
  return &verbs[v];
}

/* Lists the options as getopt_long takes them. `letters` begins with "-:": arguments come in their order, and
 * a missing value is reported as ':'. */
static void list_options(struct option known[N_ROWS + 1], char letters[64]) {
  int n = snprintf(letters, 64, "-:");
  for (int k = 0; k < N_ROWS; ++k) {
    const bool valued = rows[k].argument != NULL;
    known[k] = (struct option){rows[k].name, valued ? required_argument : no_argument, NULL, OPTION + k};
    if (rows[k].letter != 0)
      n += snprintf(letters + n, (size_t)(64 - n), "%c%s", rows[k].letter, valued ? ":" : "");
  }
  known[N_ROWS] = (struct option){0};
}

/* Refuses an option that is not known, or that has a value and takes none. */
__attribute__((noreturn)) static void refuse_option(const char *given) {
  char near[64], name[64];
  if (optopt >= OPTION) refuse("%.60s: this option takes no value", given);
  if (optopt != 0) refuse("-%c: unknown option (see kith --help)", optopt);
  snprintf(name, sizeof name, "%.*s", (int)KITH_MIN(strcspn(given + 2, "="), sizeof name - 1), given + 2);
  if (kith_choices_suggest(OPTIONS, name, near, sizeof near))
    refuse("--%s: unknown option; did you mean '--%s'?", name, near);
  refuse("--%s: unknown option (see kith --help)", name);
}

static void take_word(struct kith_options *o, const char *word) {
  if (o->verb == NULL)
    o->verb = find_verb(word);
  else if (word[0] == '\0')
    refuse("%s: an empty argument", o->verb->name);
  else if (o->subject == NULL && o->verb->argument[0] != '\0')
    o->subject = word;
  else
    refuse("%.60s: one argument too many", word);
}

/* Checks that the options and words fit the verb. */
static void check_together(const struct kith_options *o, const bool *given) {
  char names[128];
  const struct kith_verb *verb = o->verb != NULL ? o->verb : find_verb(NULL);
  for (int k = 0; k < N_ROWS; ++k)
    if (given[k] && !(rows[k].verbs >> (verb - verbs) & 1))
      refuse("--%s: not an option of %s, but of %s", rows[k].name, verb->name, takers(&rows[k], names));
  if (o->subject == NULL && verb->argument[0] != '\0' && verb->argument[0] != '[')
    refuse("%s: %s is missing (see kith %s --help)", verb->name, verb->argument, verb->name);
}

/* Opens /dev/null for standard streams that are closed; otherwise the next file would get the descriptor of
 * one, and with it all messages. */
static void open_streams(void) {
  int descriptor;
  do descriptor = open("/dev/null", O_RDWR);
  while (descriptor >= 0 && descriptor <= STDERR_FILENO);
  if (descriptor >= 0) close(descriptor);
}

enum kith_exit kith_exit_code(enum kith_exit code) {
  if (fflush(stdout) == 0 && !ferror(stdout)) return code;
  fputs("kith: standard output cannot be written\n", stderr);
  return code == KITH_EXIT_OK ? KITH_EXIT_FAILED : code;
}

enum kith_verb_id kith_options_parse(struct kith_options *o, int argc, char **argv) {
  struct option known[N_ROWS + 1];
  char letters[64];
  bool given[N_ROWS] = {false};
  open_streams();
  list_options(known, letters);
  *o = (struct kith_options){.until = -1, .steps = -1, .arguments = argv};
  opterr = 0;
  for (int c; (c = getopt_long(argc, argv, letters, known, NULL)) != -1;) {
    if (c == ':') refuse("%.60s: its value is missing", argv[optind - 1]);
    if (c == '?') refuse_option(argv[KITH_MAX(optind - 1, 1)]);
    if (c == 1) {
      if (o->verb == NULL && strcmp(optarg, "help") == 0)
        o->help = true;
      else
        take_word(o, optarg);
      continue;
    }
    int k = c - OPTION;
    if (c < OPTION) /* a letter */
      for (k = 0; rows[k].letter != c;) ++k;
    given[k] = true;
    take_value(&rows[k], optarg, o);
  }
  if (o->version) {
    const char *commit = kith_commit();
    printf("kith %s (%s%s%s, %s)\n", kith_version(), commit != NULL ? commit : "", commit != NULL ? ", " : "",
           kith_compiler(), kith_flags());
  }
  if (o->help && !o->version) print_help(o->verb);
  if (o->version || o->help) exit(kith_exit_code(KITH_EXIT_OK));
  for (; optind < argc; ++optind) take_word(o, argv[optind]); /* after "--" */
  check_together(o, given);
  return (enum kith_verb_id)(o->verb - verbs);
}
