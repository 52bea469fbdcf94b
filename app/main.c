/* main.c - the programs kith-1d, kith-2d and kith-3d: the verbs that work on a scene of their dimension. */
#include <malloc.h>
#include <omp.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include "app/cli/options.h"

#define X(name, argument, doc) [KITH_VERB_##name] = kith_##name,
static enum kith_exit (*const act[KITH_N_VERBS])(const struct kith_options *) = {KITH_SCENE_VERBS(X)};

int main(int argc, char **argv) {
#ifdef M_MMAP_THRESHOLD /* freed large blocks return to the system, and leave no holes between others */
  mallopt(M_MMAP_THRESHOLD, 1 << 18);
#endif
  /* No file locks of HDF5, which some file systems of clusters refuse: a run has its directory to itself, and
   * what it publishes is whole. */
  setenv("HDF5_USE_FILE_LOCKING", "FALSE", 0);
  struct kith_options options;
  signal(SIGCHLD, SIG_DFL); /* inherited as ignored, it would hide how children end */
  const int verb = kith_options_parse(&options, argc, argv);
  if (act[verb] == NULL) {
    fprintf(stderr, "kith: %s: this is a program of one dimension; start kith %s\n", argv[0],
            options.verb->name);
    return KITH_EXIT_USAGE;
  }
  if (options.threads > 0) omp_set_num_threads(options.threads);
  if (omp_get_max_threads() > omp_get_thread_limit()) /* reports and rates count the threads that there are */
    omp_set_num_threads(omp_get_thread_limit());
  if (omp_get_max_threads() > KITH_MAX_THREADS || omp_get_max_threads() < 1) { /* beyond an int: negative */
    fprintf(stderr, "kith: OMP_NUM_THREADS: more than %d\n", KITH_MAX_THREADS);
    return KITH_EXIT_USAGE;
  }
  return kith_exit_code(act[verb](&options));
}
