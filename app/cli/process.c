/* process.c - child processes by fork and execv, pictures by gnuplot. */
#include "app/cli/process.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>
#include "lib/io/child.h"

kith_status kith_programs_find(struct kith_programs *p) {
  char self[PATH_MAX];
  if (realpath("/proc/self/exe", self) == NULL) KITH_FAIL(BAD_FILE, "/proc/self/exe: %s", strerror(errno));
  *strrchr(self, '/') = '\0';
  snprintf(p->prefix, sizeof p->prefix, "%.700s/kith-", self);
  static const char *const places[] = {"../inputs", "../../inputs", "../../../inputs",
                                       "../share/kith/inputs"};
  for (size_t k = 0; k < sizeof places / sizeof *places; ++k) {
    snprintf(p->inputs, sizeof p->inputs, "%.700s/%s", self, places[k]);
    if (access(p->inputs, R_OK) == 0) return KITH_OK;
  }
  snprintf(p->inputs, sizeof p->inputs, "inputs");
  return KITH_OK;
}

bool kith_is_same_file(const char *a, const char *b) {
  struct stat x, y;
  return stat(a, &x) == 0 && stat(b, &y) == 0 && x.st_dev == y.st_dev && x.st_ino == y.st_ino;
}

kith_status kith_directory_make(const char *path) {
  char part[KITH_PATH];
  struct stat status;
  if ((size_t)snprintf(part, sizeof part, "%s", path) >= sizeof part)
    KITH_FAIL(BAD_FILE, "%.60s...: the path is too long", path);
  for (char *slash = part + 1; (slash = strchr(slash, '/')) != NULL; ++slash) {
    *slash = '\0';
    const int error = mkdir(part, 0777) == 0 ? 0 : errno;
    if (error != 0 && access(part, F_OK) != 0) KITH_FAIL(BAD_FILE, "%s: %s", part, strerror(error));
    *slash = '/';
  }
  if (mkdir(part, 0777) != 0 && errno != EEXIST) KITH_FAIL(BAD_FILE, "%s: %s", path, strerror(errno));
  if (stat(path, &status) != 0 || !S_ISDIR(status.st_mode)) KITH_FAIL(BAD_FILE, "%s: not a directory", path);
  return KITH_OK;
}

kith_status kith_directory_claim(const char *path, int *lock) {
  *lock = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (*lock < 0) KITH_FAIL(BAD_FILE, "%s: cannot open it: %s", path, strerror(errno));
  if (flock(*lock, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return KITH_OK;
  KITH_FAIL(BAD_FILE, "%s" KITH_CLAIMED "; wait for it, or give -o DIR", path);
}

/* In the child: sends output to the log, then becomes another program. */
static void become(char *const *words, const char *log, double cpu_limit) {
  const int file = open(log, O_WRONLY | O_CREAT | O_APPEND, 0666);
  if (file >= 0) dup2(file, STDOUT_FILENO), dup2(file, STDERR_FILENO);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (cpu_limit > 0) {
    const rlim_t seconds = (rlim_t)ceil(cpu_limit);
    setrlimit(RLIMIT_CPU, &(struct rlimit){seconds, seconds + 5});
  }
  execv(words[0], words);
  _exit(127);
}

kith_status kith_process_run(char *const *words, const char *log, double cpu_limit, int *code) {
  fflush(NULL);
  const pid_t child = fork();
  if (child < 0) KITH_FAIL(BAD_FILE, "cannot start %s: %s", words[0], strerror(errno));
  if (child == 0) become(words, log, cpu_limit);
  *code = kith_child_wait(child);
  return KITH_OK;
}

double kith_process_age(void) {
  char text[1024] = "";
  unsigned long long begun = 0; /* in clock ticks after boot: field 22 of stat, the 20th after the name */
  struct timespec now;
  FILE *f = fopen("/proc/self/stat", "r");
  if (f == NULL || clock_gettime(CLOCK_BOOTTIME, &now) != 0) return 0;
  const size_t length = fread(text, 1, sizeof text - 1, f);
  fclose(f);
  text[length] = '\0';
  const char *field = strrchr(text, ')');
  for (int k = 0; k < 20 && field != NULL; ++k) field = strchr(field + 1, ' ');
  if (field == NULL || sscanf(field, "%llu", &begun) != 1) return 0;
  const double age =
      (double)now.tv_sec + 1e-9 * (double)now.tv_nsec - (double)begun / (double)sysconf(_SC_CLK_TCK);
  return age > 0 && age < 5 ? age : 0;
}

kith_status kith_gnuplot_run(const char *directory, const char *name) {
  char script[64], log[KITH_PATH + 64];
  char *const words[] = {"/usr/bin/env", "-C", (char *)(uintptr_t)directory, "gnuplot", script, NULL};
  int code = 0;
  if (access(directory, X_OK) != 0) KITH_FAIL(BAD_FILE, "%s: no directory to draw in", directory);
  snprintf(script, sizeof script, "%s.gp", name);
  snprintf(log, sizeof log, "%.*s/%s.log", KITH_PATH, directory, name);
  unlink(log);
  KITH_TRY(kith_process_run(words, log, 0, &code));
  if (code != 0 && code != 127) KITH_FAIL(BAD_FILE, "no picture, gnuplot failed; see %s", log);
  unlink(log);
  if (code == 127)
    KITH_FAIL(UNSUPPORTED, "no picture: gnuplot cannot be run; %s is in %s", script, directory);
  return KITH_OK;
}
