/* Fuzzing of whole runs: whatever a scene has, its run ends within a time limit, with code 0, or with
 * one line and code 1 or 2; and a run can be continued from the checkpoint that it left.
 *
 *   fuzz-run-2d SCENES [N [SEED]]   N runs (100; 80 with sanitizers); run k of seed S is run 1 of S + k - 1
 *
 * Scenes are those of the folder SCENES, with some dozens of nodes. Keys, as `kith list scene` prints them,
 * get other values, and in every sixth run the text is changed. Each run is a process of its own. */
#define _GNU_SOURCE
#include <ctype.h>
#include <dirent.h>
#include <fcntl.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include "app/cli/options.h"
#include "app/scene/scene.h"
#include "tests/fuzz/draw.h"

#ifdef KITH_SANITIZE
/* no limit of memory: sanitizers reserve terabytes of addresses */
enum { SECONDS = 300, MEGABYTES = 0, RUNS = 80 };
#else
enum { SECONDS = 100, MEGABYTES = 600, RUNS = 100 };
#endif
enum { MOST = 256, LONGEST = 1 << 15, PATH = 512, SETTING = 336, CHANGES = 5, STEPS = 3 };

/* ---- keys, from the reference of scenes */

struct key {
  char path[128]; /* '#': index in a list; '$': name of a material */
  char choices[512];
  bool number;
};
static struct key keys[MOST];
static int n_keys;

/* Reads a line of the reference, "  # key: default   # doc; in [0, 1]": its depth, and the values it may
 * have. */
static void read_key(char *line, struct key *into, int *depth, bool *item) {
  const size_t blanks = strspn(line, " ");
  char *word = line + blanks;
  *item = strncmp(word, "- ", 2) == 0;
  *depth = (int)blanks + 2 * *item;
  if (*item || strncmp(word, "# ", 2) == 0) word += 2;
  const char *choices = strstr(word, "one of "), *of = strstr(word, "; in ");
  *into = (struct key){.number = of != NULL};
  if (choices != NULL) snprintf(into->choices, sizeof into->choices, "%s", choices + strlen("one of "));
  into->choices[strcspn(into->choices, ";\n")] = '\0';
  word[strcspn(word, ":")] = '\0';
  snprintf(into->path, sizeof into->path, "%.60s", strcmp(word, "NAME") == 0 ? "$" : word);
}

static void read_keys(void) {
  static char text[1 << 17];
  FILE *f = fmemopen(text, sizeof text - 1, "w");
  struct {
    int depth;
    char path[100];
  } above[16] = {{-1, ""}};
  int n_above = 1;
  if (f == NULL) abort();
  kith_scene_reference(f);
  fclose(f);
  char *rest = strchr(text, '\n') + 1;
  for (char *line; (line = strsep(&rest, "\n")) != NULL && *line != '\0';) {
    struct key key;
    int depth;
    bool item;
    read_key(line, &key, &depth, &item);
    while (above[n_above - 1].depth >= depth) --n_above;
    if (item) strcat(above[n_above - 1].path, "#.");
    char name[64];
    snprintf(name, sizeof name, "%.60s", key.path);
    snprintf(key.path, sizeof key.path, "%s%s", above[n_above - 1].path, name);
    above[n_above].depth = depth;
    snprintf(above[n_above++].path, sizeof above->path, "%.90s.", key.path);
    if (n_keys == MOST || n_above == 16) abort();
    keys[n_keys++] = key;
  }
}

/* ---- scenes */

struct seed_scene {
  char path[PATH], text[LONGEST], material[40];
  bool based; /* on another file beside it */
  double resolution;
};
static struct seed_scene scenes[MOST];
static int n_scenes;

/* Reads a scene and sets some dozens of nodes; scenes that do not exist in this dimension are left out. */
static void add_scene(const char *folder, const char *name) {
  struct seed_scene *s = &scenes[n_scenes];
  struct kith_scene *scene;
  char dimension[] = "dimension=0";
  const char *overrides[] = {dimension};
  dimension[strlen(dimension) - 1] = (char)('0' + NDIM);
  snprintf(s->path, sizeof s->path, "%.200s/%.200s", folder, name);
  if (strstr(name, ".yaml") == NULL || n_scenes == MOST - 1) return;
  if (kith_scene_read(&scene, s->path, 1, overrides) != KITH_OK) return;
  double volume = 1;
  for (int a = 0; a < NDIM; ++a) volume *= scene->domain.upper[a] - scene->domain.lower[a];
  s->resolution = pow((NDIM == 1 ? 40 : NDIM == 2 ? 100 : 150) / volume, 1.0 / NDIM);
  snprintf(s->material, sizeof s->material, "%s", scene->material_name[0]);
  FILE *f = fopen(s->path, "r");
  const size_t n = f != NULL ? fread(s->text, 1, LONGEST / 2, f) : 0;
  if (f != NULL) fclose(f);
  s->text[n] = '\0';
  s->based = strncmp(s->text, "base:", 5) == 0 || strstr(s->text, "\nbase:") != NULL;
  kith_scene_destroy(&scene);
  ++n_scenes;
}

static void read_scenes(const char *folder) {
  struct dirent **found;
  const int n = scandir(folder, &found, NULL, alphasort);
  for (int k = 0; k < n; ++k) add_scene(folder, found[k]->d_name), free(found[k]);
  if (n >= 0) free(found);
}

/* ---- changes */

static const char numbers[] =
    "0;1;2;3;0.5;-1;4;7;0.1;10;100;1e-3;1e3;1e-9;1e9;1e30;1e-30;1e300;1e-300;-0.0;1.4;0.01;1000000;nan";
static const char others[] =
    "true;false;~;[];{};x;'1 + 0.1*sin(6*x)';'1/x';'r < 0.3';[1, 2];[0, 0, 0];[1, 1, 1];[-1, -1, -1];"
    "[0.5, 0];['-x', '-y', '-z'];open;reflecting;periodic;inflow;outflow;{kind: piston, velocity: 0.5};"
    "{kind: piston, velocity: -2};[periodic, open];[inflow, outflow];[open, reflecting];"
    "{kind: outflow, pressure_far: 1};{kind: inflow, density: 1, pressure: 1, velocity: [1, 0, 0]};"
    "always|displacement;self|connected;padded:width=2;density;[density-error, velocity];"
    "[{name: conduction, conductivity: 1}];[{name: viscosity, dynamic: 0.1}];"
    "[{name: p, at: [0, 0, 0], along: [1, 0, 0]}];[{energy: 1, over: ball, spacings: 2}];{x: [0, 0.5]};"
    "hybrid:morton";

static void draw_value(const struct key *key, uint64_t *seed, char value[64]) {
  const bool right = below(seed, 8) > 0;
  int n = 1;
  for (const char *c = key->choices; *c != '\0'; ++c) n += *c == ',';
  if (right && key->choices[0] != '\0') {
    const char *c = key->choices;
    for (size_t k = below(seed, (size_t)n); k > 0; --k) c = strchr(c, ',') + 2;
    snprintf(value, 64, "%.*s", (int)strcspn(c, ","), c);
  } else if (right && key->number) {
    draw_word(numbers, seed, value);
  } else {
    draw_word(below(seed, 3) == 0 ? numbers : others, seed, value);
  }
}

static void draw_setting(const struct seed_scene *scene, uint64_t *seed, char text[SETTING]) {
  const struct key *key;
  char value[64], path[200] = "";
  do /* millions of nodes across, which are refused for want of memory, would take minutes with sanitizers */
    key = &keys[below(seed, (size_t)n_keys)];
  while (MEGABYTES == 0 && strcmp(key->path, "domain.across") == 0);
  for (const char *c = key->path; *c != '\0'; ++c) {
    const size_t n = strlen(path);
    const char letter[] = {*c == '#' ? (char)('0' + below(seed, 2)) : *c, '\0'};
    snprintf(path + n, sizeof path - n, "%s", *c == '$' ? scene->material : letter);
  }
  draw_value(key, seed, value);
  snprintf(text, SETTING, "%s%s%s", path, below(seed, 4) == 0 ? "=" : "?=", value);
}

/* Removes a piece of the text, copies it, changes a letter of it, or changes a number. */
static void change_text(char *text, uint64_t *seed) {
  const size_t n = strlen(text), at = below(seed, n), wanted = 1 + below(seed, 30),
               length = KITH_MIN(wanted, n - at);
  char copy[LONGEST], piece[64];
  snprintf(piece, sizeof piece, "%.*s", (int)length, text + at);
  size_t from = at, to = at + length;
  switch (below(seed, 4)) {
    case 0:
      piece[0] = '\0';
      break;
    case 1:
      from = to = below(seed, n);
      break;
    case 2:
      piece[below(seed, length)] = (char)(' ' + below(seed, 95));
      break;
    default:
      while (from < n && !isdigit((unsigned char)text[from])) ++from;
      to = from + strspn(text + from, "0123456789.e");
      draw_word(numbers, seed, piece);
  }
  snprintf(copy, sizeof copy, "%.*s%s%s", (int)from, text, piece, text + to);
  strcpy(text, copy);
}

/* ---- runs */

struct run {
  char directory[PATH], path[PATH], restart[PATH], settings[CHANGES + 5][SETTING];
  struct kith_options options;
  int log;
};

static void draw_run(struct run *run, uint64_t *seed) {
  struct seed_scene *scene = &scenes[below(seed, (size_t)n_scenes)];
  struct kith_options *o = &run->options;
  int n = 0;
  *o = (struct kith_options){.directory = run->directory,
                             .until = -1,
                             .threads = 1,
                             .steps = 1 + (int)below(seed, STEPS),
                             .check = below(seed, 8) == 0,
                             .quiet = true,
                             .overwrite = true};
  o->subject = scene->path;
  if (!scene->based && below(seed, 6) == 0) {
    char text[LONGEST];
    strcpy(text, scene->text);
    for (size_t k = 1 + below(seed, 3); k > 0; --k) change_text(text, seed);
    FILE *f = fopen(run->path, "w");
    if (f == NULL || fputs(text, f) < 0 || fclose(f) != 0) abort();
    o->subject = run->path;
  }
  snprintf(run->settings[n++], SETTING, "dimension=%d", NDIM);
  snprintf(run->settings[n++], SETTING, "resolution=%g", scene->resolution);
  /* exact solutions would take most of the time */
  if (below(seed, 8) > 0) snprintf(run->settings[n++], SETTING, "exact=~");
  for (size_t k = below(seed, CHANGES + 1); k > 0; --k) draw_setting(scene, seed, run->settings[n++]);
  snprintf(run->settings[n++], SETTING, "output.checkpoint_at_end=true");
  if (below(seed, 200) > 0) snprintf(run->settings[n++], SETTING, "output.plot=false");
  for (int k = 0; k < n; ++k) o->overrides[o->n_overrides++] = run->settings[k];
}

/* The child process, with limits of time and of memory, enough for some thousand nodes. */
static void run_in_child(const struct run *run) {
  static char program[] = "fuzz-run", *words[] = {program, NULL};
  struct kith_options o = run->options;
  const int nowhere = open("/dev/null", O_WRONLY);
  o.arguments = words;
  dup2(nowhere, STDOUT_FILENO), dup2(run->log, STDERR_FILENO);
  setrlimit(RLIMIT_CPU, &(struct rlimit){SECONDS, SECONDS});
  setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0});
  if (MEGABYTES > 0) setrlimit(RLIMIT_AS, &(struct rlimit){MEGABYTES * 1000000ul, MEGABYTES * 1000000ul});
  alarm(20 * SECONDS);
  exit((int)kith_run(&o));
}

/* Standard error must have any warnings, and then exactly one line if the code is not 0. */
static bool is_reported_well(char *said, int code) {
  int lines = 0;
  for (char *line, *rest = said; (line = strsep(&rest, "\n")) != NULL && (*line != '\0' || rest != NULL);) {
    if (strncmp(line, "kith: warning: ", 15) == 0 && lines == 0) continue;
    if (strncmp(line, "kith: ", 6) != 0 || strncmp(line, "kith: crashed", 13) == 0) return false;
    ++lines;
  }
  return lines == (code != 0);
}

/* Makes a run; returns its code, or -1 if it did not end as it should. */
static int try(const struct run *run, const char *what, uint64_t seed) {
  static char said[1 << 16], kept[1 << 16];
  int status = 0;
  if (ftruncate(run->log, 0) != 0 || lseek(run->log, 0, SEEK_SET) != 0) abort();
  fflush(NULL);
  const pid_t child = fork();
  if (child == 0) run_in_child(run);
  if (child < 0 || waitpid(child, &status, 0) != child) abort();
  const ssize_t n = pread(run->log, said, sizeof said - 1, 0);
  said[KITH_MAX(n, (ssize_t)0)] = '\0';
  memcpy(kept, said, sizeof said);
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  if (code >= 0 && code <= 2 && is_reported_well(said, code) && !(code == 2 && run->options.restart != NULL))
    return code;
  fprintf(stderr, "FAILED: seed %llu, %s: %s %d: %.2000s\n  run %s --steps %d%s", (unsigned long long)seed,
          what, code >= 0 ? "code" : "signal", code >= 0 ? code : WTERMSIG(status), kept,
          run->options.subject, run->options.steps, run->options.check ? " --check" : "");
  for (int k = 0; k < run->options.n_overrides; ++k)
    fprintf(stderr, " --set \"%s\"", run->options.overrides[k]);
  fprintf(stderr, "\n");
  return -1;
}

int main(int argc, char **argv) {
  static struct run run;
  char place[] = "/dev/shm/kith-fuzz-XXXXXX", other[] = "/tmp/kith-fuzz-XXXXXX";
  const char *in = mkdtemp(place) != NULL ? place : mkdtemp(other);
  const long runs = argc > 2 ? atol(argv[2]) : RUNS;
  const uint64_t first = argc > 3 ? strtoull(argv[3], NULL, 10) : 1;
  long ended[3] = {0}, resumed = 0, failed = 0;
  omp_set_num_threads(1);
  if (argc < 2 || in == NULL) return 2;
  read_keys();
  read_scenes(argv[1]);
  snprintf(run.directory, sizeof run.directory, "%s/out", in);
  snprintf(run.path, sizeof run.path, "%s/scene.yaml", in);
  snprintf(run.restart, sizeof run.restart, "%s/out/checkpoint.kith", in);
  run.log = memfd_create("log", MFD_CLOEXEC);
  for (long k = 0; k < runs; ++k) {
    uint64_t seed = (first + (uint64_t)k) * 0xd1342543de82ef95u;
    draw_run(&run, &seed);
    const int code = try(&run, "run", first + (uint64_t)k);
    failed += code < 0;
    if (code >= 0) ++ended[code];
    if (code != 0) continue;
    run.options.restart = run.restart;
    run.options.steps += (int)below(&seed, 2);
    const int again = try(&run, "restart", first + (uint64_t)k);
    failed += again < 0, resumed += again == 0;
  }
  printf("%ld runs of %d-D: %ld ended with 0, %ld with 1, %ld with 2; %ld restarts with 0; %ld failed\n",
         runs, NDIM, ended[0], ended[1], ended[2], resumed, failed);
  char command[PATH];
  snprintf(command, sizeof command, "rm -rf '%s'", in);
  /* Runs must end in different ways, and some must succeed. */
  CHECK(n_keys > 100 && n_scenes > 20 && ended[0] > runs / 10 && resumed > runs / 20);
  return system(command) != 0 || failed > 0 || check_failed();
}
