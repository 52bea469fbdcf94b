/* Signals of a run; mpirun as a child, so that it does not end the ranks before they have written. */
#define _GNU_SOURCE /* sigabbrev_np */
#include "app/run/signals.h"

#include <errno.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>
#include "lib/io/child.h"

static const int caught[] = {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2};
enum { CAUGHT = sizeof caught / sizeof *caught };

/* Globals that change, since signal handlers have no arguments of ours. */
static volatile sig_atomic_t stop, child;

/* Sets the handler of the signals that stop a run; those that are ignored, as nohup does, stay so. */
static void handle_with(void (*handler)(int), int flags) {
  struct sigaction action = {.sa_handler = handler, .sa_flags = flags}, before;
  for (int k = 0; k < CAUGHT; ++k)
    if (sigaction(caught[k], NULL, &before) == 0 && before.sa_handler != SIG_IGN)
      sigaction(caught[k], &action, NULL);
}

/* Is it the first signal, or at least a second after that? One that comes earlier is the same wish: who
 * stops a job may signal every process of it, and each passes its own on. Only functions that a handler
 * may call. */
static bool is_new(void) {
  static struct timespec first;
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  if (stop == 0) first = now;
  const double since = (double)(now.tv_sec - first.tv_sec) + 1e-9 * (double)(now.tv_nsec - first.tv_nsec);
  return stop == 0 || since >= 1;
}

/* The first signal stops the run after its step; the second has its usual effect, the end. */
static void on_signal(int number) {
  if (!is_new()) return;
  if (stop != 0) {
    handle_with(SIG_DFL, 0);
    raise(number);
  }
  stop = 1;
}

#ifndef KITH_SANITIZE /* sanitizers say more */
static const int crashes[] = {SIGSEGV, SIGBUS, SIGFPE, SIGABRT};

/* Prints one line for a crash, as of libraries that lack memory, and ends with the code of a run that failed;
 * where a core is wanted, by the signal, which leaves it. Calls only functions that a handler may call. */
static void on_crash(int number) {
  char line[160];
  struct rlimit core;
  sigset_t all;
  const char *end = stpcpy(stpcpy(stpcpy(line, "kith: crashed with signal "), sigabbrev_np(number)),
                           ", perhaps for want of memory; the last checkpoint, if there is one, goes on with "
                           "--restart\n");
  const ssize_t written = write(STDERR_FILENO, line, (size_t)(end - line));
  if (written > 0 && getrlimit(RLIMIT_CORE, &core) == 0 && core.rlim_cur > 0) {
    sigfillset(&all);
    signal(number, SIG_DFL);
    raise(number);
    pthread_sigmask(SIG_UNBLOCK, &all, NULL);
  }
  _exit(KITH_EXIT_FAILED);
}
#endif

void kith_signals_ignore(void) {
  signal(SIGXFSZ, SIG_IGN);
  signal(SIGPIPE, SIG_IGN);
#ifndef KITH_SANITIZE
  struct sigaction action = {.sa_handler = on_crash};
  sigfillset(&action.sa_mask); /* a crash of the handler ends the process at once */
  for (size_t k = 0; k < sizeof crashes / sizeof *crashes; ++k) sigaction(crashes[k], &action, NULL);
#endif
}

void kith_signals_catch(void) {
  handle_with(on_signal, SA_RESTART);
}

bool kith_signals_stop(void) {
  return stop != 0;
}

/* Passes a signal on to mpirun: first USR1, which mpirun gives to all ranks; then TERM, which ends them. */
static void pass_on(int number) {
  (void)number;
  if (is_new()) kill(child, stop++ == 0 ? SIGUSR1 : SIGTERM);
}

/* Becomes mpirun. Not in the foreground of the terminal: what it sends when a key is pressed would end the
 * ranks. Not with the locks in shared memory that PMIx takes by default: if a rank is killed while it starts,
 * mpirun waits for its lock for ever (openpmix issue 1233). */
static void become_mpirun(char *const *words) {
  setenv("PMIX_MCA_gds", "hash", 0);
  setenv("OMPI_MCA_opal_signal", "", 0); /* no traces of a rank that crashes: it is named below */
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  execvp(words[0], words);
  fprintf(stderr, "kith: --ranks: mpirun cannot be started: %s\n", strerror(errno));
  _exit(KITH_EXIT_FAILED);
}

/* Makes the words of mpirun. It binds no ranks to cores: the threads of a rank would all have to share
 * one. */
static kith_status words_of(int ranks, char *const *own, char **words, int most) {
  static char self[PATH_MAX], number[16];
  if (realpath("/proc/self/exe", self) == NULL) KITH_FAIL(BAD_FILE, "/proc/self/exe: %s", strerror(errno));
  snprintf(number, sizeof number, "%d", ranks);
  char *const first[] = {"mpirun", "--quiet", "--oversubscribe", "--bind-to", "none", "--stdin", "none", "-n",
                         number,   self};
  int n = 0;
  for (; n < (int)(sizeof first / sizeof *first); ++n) words[n] = first[n];
  for (char *const *word = own + 1; *word != NULL; ++word) {
    if (n + 1 == most) KITH_FAIL(BAD_INPUT, "more than %d words", most);
    words[n++] = *word;
  }
  words[n] = NULL;
  return KITH_OK;
}

/* Raises the limit of open files to mpirun's need, up to five a rank: else it neither starts all nor ends. */
static kith_status check_room(int ranks) {
  const int wanted = 50 + 5 * ranks;
  struct rlimit files;
  if (ranks > KITH_MAX_STARTED)
    KITH_FAIL(BAD_INPUT, "--ranks: %d is more than %d; start more by mpirun -n %d", ranks, KITH_MAX_STARTED,
              ranks);
  if (getrlimit(RLIMIT_NOFILE, &files) != 0 || files.rlim_cur >= (rlim_t)wanted) return KITH_OK;
  files.rlim_cur = (rlim_t)wanted;
  if (files.rlim_max >= files.rlim_cur && setrlimit(RLIMIT_NOFILE, &files) == 0) return KITH_OK;
  KITH_FAIL(BAD_INPUT, "--ranks %d: mpirun needs %d open files, and %llu are allowed (ulimit -Hn)", ranks,
            wanted, (unsigned long long)files.rlim_max);
}

kith_status kith_signals_launch(int ranks, char *const *own, enum kith_exit *code) {
  enum { MOST_WORDS = 512 };
  char *words[MOST_WORDS];
  KITH_TRY(check_room(ranks));
  KITH_TRY(words_of(ranks, own, words, MOST_WORDS));
  fflush(NULL);
  const pid_t mpirun = fork();
  if (mpirun < 0) KITH_FAIL(BAD_FILE, "--ranks %d: cannot start mpirun: %s", ranks, strerror(errno));
  if (mpirun == 0) become_mpirun(words);
  child = mpirun;
  handle_with(pass_on, SA_RESTART);
  const int result = kith_child_wait(mpirun), exited = result >= 0 ? result : 128 - result;
  *code = exited < 128 ? (enum kith_exit)exited : KITH_EXIT_FAILED;
  if (exited < 128 && stop < 2) return KITH_OK;
  if (stop != 0) KITH_FAIL(BAD_FILE, "stopped at once; what was written before is whole");
  KITH_FAIL(BAD_FILE,
            "a rank was ended by signal %d (%s); the last checkpoint, if there is one, goes on with "
            "--restart",
            exited - 128, strsignal(exited - 128));
}
