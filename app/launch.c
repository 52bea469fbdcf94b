#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* execvp */
#endif
#include "app/launch.h"

#include <errno.h>
#include <limits.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Not bound to cores: threads of a rank would all have to share one. */
static kith_status become_mpirun(const struct kith_options *options) {
  enum { MOST_WORDS = 512 };
  char self[PATH_MAX], number[16], *words[MOST_WORDS];
  const ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1);
  if (length <= 0) KITH_FAIL(BAD_FILE, "/proc/self/exe: %s", strerror(errno));
  self[length] = '\0';
  snprintf(number, sizeof number, "%d", options->ranks);
  char *const first[] = {"mpirun", "--quiet", "--oversubscribe", "--bind-to", "none", "-n", number, self};
  int n = 0;
  for (; n < (int)(sizeof first / sizeof *first); ++n) words[n] = first[n];
  for (char **word = options->arguments + 1; *word != NULL; ++word) {
    if (n + 1 == MOST_WORDS) KITH_FAIL(BAD_INPUT, "more than %d words", MOST_WORDS);
    words[n++] = *word;
  }
  words[n] = NULL;
  fflush(NULL);
  execvp(words[0], words);
  KITH_FAIL(UNSUPPORTED, "--ranks %d: mpirun cannot be started: %s", options->ranks, strerror(errno));
}

/* A part of the machine, but no more than this rank was bound to. */
static int threads_of_rank(int beside) {
  const int cores = (int)sysconf(_SC_NPROCESSORS_ONLN);
  return KITH_MIN(omp_get_num_procs(), KITH_MAX(1, cores / beside));
}

kith_status kith_launch(struct kith_ranks **ranks, const struct kith_options *options) {
  *ranks = NULL;
  if (options->ranks > 1 && kith_ranks_launched() == 1) return become_mpirun(options);
  KITH_TRY(kith_ranks_create(ranks));
  const int size = kith_ranks_size(*ranks);
  if (size > 1 && options->threads == 0 && getenv("OMP_NUM_THREADS") == NULL)
    omp_set_num_threads(threads_of_rank(kith_ranks_beside(*ranks)));
  if (options->ranks > 0 && options->ranks != size)
    return kith_ranks_agree(
        *ranks, kith_fail(KITH_BAD_INPUT, "--ranks %d, but %d processes were started", options->ranks, size));
  return KITH_OK;
}
