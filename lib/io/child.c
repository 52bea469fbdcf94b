/* child.c - fork, work, wait. */
#include "lib/io/child.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

/* The OpenMP library of clang registers each process, also a forked one, by a file in shared memory, which
 * it removes in its exit handler. A child that ends by _exit, or becomes another program, does not run that.
 * Such files pile up; and one that is empty, since its process could write no files, ends a later process
 * with the same number by SIGBUS. */
static void forget_openmp(pid_t child) {
#ifdef __clang__
  char name[64];
  snprintf(name, sizeof name, "/__KMP_REGISTERED_LIB_%d_%d", (int)child, (int)getuid());
  shm_unlink(name);
#endif
  (void)child;
}

enum { UNKNOWN = 255 }; /* the code of a child that someone else has waited for */

int kith_child_wait(pid_t child) {
  siginfo_t ended; /* waitid leaves the child waitable, so that no other process has its number yet */
  int status = 0;
  pid_t taken;
  while (waitid(P_PID, (id_t)child, &ended, WEXITED | WNOWAIT) < 0 && errno == EINTR) continue;
  forget_openmp(child);
  while ((taken = waitpid(child, &status, 0)) < 0 && errno == EINTR) continue;
  if (taken < 0) return UNKNOWN;
  return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
}

int kith_child_run(int (*work)(void *), void *of) {
  const pid_t child = fork();
  if (child < 0) return work(of);
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    dup2(open("/dev/null", O_WRONLY | O_CLOEXEC), STDERR_FILENO);
    _exit(work(of));
  }
  return kith_child_wait(child);
}
