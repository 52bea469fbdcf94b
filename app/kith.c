/* kith.c - the program `kith`: carries out the verbs that make many runs (validate, chart, stress), and hands
 * the others over to the program of the scene's dimension (kith-1d, kith-2d or kith-3d, beside it). */
#define _GNU_SOURCE /* memfd_create */
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include "app/cli/options.h"
#include "app/cli/process.h"
#include "app/scene/params.h"

#define X(name, argument, doc) [KITH_VERB_##name] = kith_##name,
static enum kith_exit (*const act[KITH_N_VERBS])(const struct kith_options *) = {KITH_STUDY_VERBS(X)};

/* Copies a scene that is given as a pipe into memory, since a pipe can be read once and a scene is read
 * twice. The copy takes the place of the descriptor that the word of the command line names, so that messages
 * have this word; of a pipe with a name of its own, the path of the copy replaces the word. */
static kith_status keep_pipe(struct kith_options *options, char path[64]) {
  enum { PIECE = 1 << 16 };
  static char piece[PIECE];
  struct stat status;
  if (stat(options->subject, &status) != 0 || S_ISREG(status.st_mode) || S_ISDIR(status.st_mode))
    return KITH_OK;
  if (options->ranks > 1)
    KITH_FAIL(BAD_INPUT, "%s: not a file, which several ranks could read", options->subject);
  const int from = open(options->subject, O_RDONLY | O_CLOEXEC), to = memfd_create("scene", 0);
  ssize_t n = 0;
  while (from >= 0 && to >= 0 && (n = read(from, piece, PIECE)) > 0 && write(to, piece, (size_t)n) == n)
    continue;
  if (from < 0 || to < 0 || n != 0) KITH_FAIL(BAD_INPUT, "%s: cannot be read", options->subject);
  close(from);
  int named = strcmp(options->subject, "/dev/stdin") == 0 ? STDIN_FILENO : -1;
  sscanf(options->subject, "/dev/fd/%d", &named);
  if (named >= 0 && dup2(to, named) == named) return KITH_OK;
  snprintf(path, 64, "/proc/self/fd/%d", to);
  for (char **word = options->arguments + 1; *word != NULL; ++word)
    if (*word == options->subject) *word = path;
  options->subject = path;
  return KITH_OK;
}

/* Becomes the program of the scene's dimension, or, without a scene, that of the most dimensions which was
 * built, with the same words of the command line. Binds threads to cores for a single process only: each of
 * several would bind its threads to the first cores. */
static kith_status hand_over(struct kith_options *options) {
  struct kith_programs programs;
  char path[KITH_PATH + 16], kept[64];
  int dimension = 3;
  const bool of_scene = options->subject != NULL && strstr(options->verb->argument, "SCENE") != NULL;
  if (of_scene) {
    KITH_TRY(keep_pipe(options, kept));
    KITH_TRY(kith_scene_dimension(options->subject, options->n_overrides, options->overrides, &dimension));
  }
  KITH_TRY(kith_programs_find(&programs));
  snprintf(path, sizeof path, "%s%dd", programs.prefix, dimension);
  while (!of_scene && access(path, X_OK) != 0 && dimension > 1)
    snprintf(path, sizeof path, "%s%dd", programs.prefix, --dimension);
  if (options->ranks <= 1 && getenv("OMPI_COMM_WORLD_SIZE") == NULL) setenv("OMP_PROC_BIND", "true", 0);
  if (access(path, F_OK) != 0)
    KITH_FAIL(BAD_FILE, "%s is not built: ./kith build builds all, cmake those of -DKITH_DIMENSIONS", path);
  execv(path, options->arguments);
  KITH_FAIL(BAD_FILE, "cannot start %s", path);
}

int main(int argc, char **argv) {
  struct kith_options options;
  signal(SIGCHLD, SIG_DFL); /* inherited as ignored, it would hide how children end */
  const int verb = kith_options_parse(&options, argc, argv);
  if (act[verb] != NULL) return kith_exit_code(act[verb](&options));
  if (verb == KITH_VERB_build || verb == KITH_VERB_test) {
    fprintf(stderr, "kith: %s: done by the script ./kith of the source tree\n", options.verb->name);
    return KITH_EXIT_USAGE;
  }
  const kith_status status = hand_over(&options); /* comes back only if it failed */
  fprintf(stderr, "kith: %s\n", kith_failure());
  return status == KITH_BAD_INPUT ? KITH_EXIT_USAGE : KITH_EXIT_FAILED;
}
