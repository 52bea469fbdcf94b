/* kith.c - the program `kith`: carries out what makes many runs (validate, chart, stress), and starts the
 * program of the scene's dimension (kith-1d, kith-2d or kith-3d, which stand beside it) for the rest. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "app/cli/options.h"
#include "app/cli/process.h"
#include "app/scene/params.h"

#define ACT_STUDY(name) [KITH_VERB_##name] = kith_##name,
#define ACT_SCENE(name)
#define ACT_LAUNCHER(name)
#define X(name, runs, argument, doc) ACT_##runs(name)
static enum kith_exit (*const act[KITH_N_VERBS])(const struct kith_options *) = {KITH_VERB_LIST(X)};

/* Becomes the program of a dimension, with the same words. One process has its threads bound to cores; of
 * several, each would bind its threads to the first ones. */
static kith_status hand_over(const struct kith_options *options) {
  struct kith_programs programs;
  char path[KITH_PATH + 8];
  int dimension = 3; /* without a scene: of the built-in one, or any */
  if (options->subject != NULL && strstr(options->verb->argument, "SCENE") != NULL)
    KITH_TRY(kith_scene_dimension(options->subject, options->n_overrides, options->overrides, &dimension));
  KITH_TRY(kith_programs_find(&programs));
  snprintf(path, sizeof path, "%s%dd", programs.prefix, dimension);
  if (options->ranks <= 1 && getenv("OMPI_COMM_WORLD_SIZE") == NULL) setenv("OMP_PROC_BIND", "true", 0);
  execv(path, options->arguments);
  KITH_FAIL(BAD_FILE, "cannot start %s", path);
}

int main(int argc, char **argv) {
  struct kith_options options;
  const int verb = kith_options_parse(&options, argc, argv);
  if (act[verb] != NULL) return act[verb](&options);
  if (options.verb->runs == KITH_RUNS_LAUNCHER) {
    fprintf(stderr, "kith: %s: done by the script ./kith of the source tree\n", options.verb->name);
    return KITH_EXIT_USAGE;
  }
  const kith_status status = hand_over(&options); /* comes back only if it failed */
  fprintf(stderr, "kith: %s\n", kith_failure());
  return status == KITH_BAD_INPUT ? KITH_EXIT_USAGE : KITH_EXIT_FAILED;
}
