#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* prctl */
#endif
#include "app/process.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include "app/config.h"

kith_status kith_programs_find(struct kith_programs *p) {
  char self[KITH_PATH - 32];
  const ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1);
  if (length <= 0) KITH_FAIL(BAD_FILE, "/proc/self/exe: %s", strerror(errno));
  self[length] = '\0';
  char *end = strrchr(self, '-'), *slash = strrchr(self, '/');
  if (end == NULL || end < slash) KITH_FAIL(BAD_INPUT, "%s: not one of kith-1d, kith-2d, kith-3d", self);
  end[1] = '\0';
  snprintf(p->prefix, sizeof p->prefix, "%s", self);
  *slash = '\0';
  static const char *const places[] = {"../inputs", "../../inputs", "../../../inputs",
                                       "../share/kith/inputs"};
  for (size_t k = 0; k < sizeof places / sizeof *places; ++k) {
    snprintf(p->inputs, sizeof p->inputs, "%s/%s", self, places[k]);
    if (access(p->inputs, R_OK) == 0) return KITH_OK;
  }
  snprintf(p->inputs, sizeof p->inputs, "inputs");
  if (access(p->inputs, R_OK) == 0) return KITH_OK;
  KITH_FAIL(BAD_INPUT, "no directory 'inputs' above %s nor here", self);
}

kith_status kith_directory_make(const char *path) {
  char part[KITH_PATH];
  struct stat status;
  if ((size_t)snprintf(part, sizeof part, "%s", path) >= sizeof part)
    KITH_FAIL(BAD_FILE, "%.60s...: the path is too long", path);
  for (char *slash = part + 1; (slash = strchr(slash, '/')) != NULL; ++slash) {
    *slash = '\0';
    mkdir(part, 0777);
    *slash = '/';
  }
  if (mkdir(part, 0777) != 0 && errno != EEXIST) KITH_FAIL(BAD_FILE, "%s: %s", path, strerror(errno));
  if (stat(path, &status) != 0 || !S_ISDIR(status.st_mode)) KITH_FAIL(BAD_FILE, "%s: not a directory", path);
  return KITH_OK;
}

/* The child: what it prints goes to a file, then it is another program. */
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
  int result;
  while (waitpid(child, &result, 0) < 0)
    if (errno != EINTR) KITH_FAIL(BAD_FILE, "lost %s: %s", words[0], strerror(errno));
  *code = WIFEXITED(result) ? WEXITSTATUS(result) : -WTERMSIG(result);
  return KITH_OK;
}

kith_status kith_report_number(const char *path, const char *key, double *value) {
  struct kith_config *report = NULL;
  KITH_TRY(kith_config_read(&report, path));
  const struct kith_config_node *node = kith_config_at(report, key);
  const bool found = node != NULL && node->kind == KITH_CONFIG_SCALAR && !node->null;
  *value = found ? strtod(node->text, NULL) : NAN;
  kith_config_destroy(&report);
  if (!found) KITH_FAIL(BAD_FILE, "%s: no %s", path, key);
  return KITH_OK;
}
