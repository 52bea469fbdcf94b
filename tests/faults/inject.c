/* inject.c - runs a command, and makes its n-th system call fail, or simulates a power loss at its n-th call.
 *
 *   inject CLASS N DIRECTORY COMMAND...
 *
 * Only calls on files below DIRECTORY are counted, of all processes and threads that the command starts. With
 * N = 0 none fails. Ends with the code of the command. If KITH_FAULT_LOG names a file, a line is written to
 * it for each call that counts, with its class and file.
 *
 * `power` counts all classes: at the n-th call all processes are killed, and each file gets the content it
 * had when it was last synced, or none if it never was. Names of files are the present ones, or, with
 * `power-names`, those that their directory had when it was last synced.
 *
 * It uses ptrace and a seccomp filter, so that calls from inside libraries are intercepted too, and ends with
 * code 77 where these are not available. */
#define _GNU_SOURCE
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/user.h>
#include <sys/wait.h>
#include <unistd.h>

#ifndef __x86_64__
int main(void) {
  return 77;
}
#else

/* call, class, its error, and the argument that is a path (-1: the first argument is a descriptor; 4 for
 * mmap: the fifth is) */
#define CALLS(X)                   \
  X(open, "open", EMFILE, 0)       \
  X(openat, "open", EMFILE, 1)     \
  X(creat, "open", EMFILE, 0)      \
  X(write, "write", ENOSPC, -1)    \
  X(pwrite64, "write", ENOSPC, -1) \
  X(writev, "write", ENOSPC, -1)   \
  X(pwritev, "write", ENOSPC, -1)  \
  X(read, "read", EIO, -1)         \
  X(pread64, "read", EIO, -1)      \
  X(mmap, "map", ENOMEM, 4)        \
  X(fsync, "sync", EIO, -1)        \
  X(fdatasync, "sync", EIO, -1)    \
  X(rename, "name", EIO, 0)        \
  X(renameat, "name", EIO, 1)      \
  X(renameat2, "name", EIO, 1)     \
  X(link, "name", EIO, 0)          \
  X(linkat, "name", EIO, 1)        \
  X(unlink, "name", EIO, 0)        \
  X(unlinkat, "name", EIO, 1)      \
  X(mkdir, "name", EIO, 0)         \
  X(ftruncate, "size", ENOSPC, -1) \
  X(fallocate, "size", ENOSPC, -1) \
  X(flock, "size", ENOLCK, -1)     \
  X(close, "close", EIO, -1)
static const struct call {
  long number;
  const char *class;
  int error, path;
} calls[] = {
#define X(name, class, error, path) {SYS_##name, class, error, path},
    CALLS(X)
#undef X
};
enum { CALLS_N = sizeof calls / sizeof *calls, MOST = 4096 };

/* ---- content of files and names that are certainly on the disk */

struct content {
  char key[64]; /* inode and time of birth, as numbers of inodes are used again */
  size_t size;
  char *bytes;
};
struct entry {
  char name[256], key[64];
};
static struct content contents[MOST];
static struct entry entries[MOST];
static int n_contents, n_entries;

__attribute__((noreturn)) static void die(const char *what) {
  fprintf(stderr, "inject: %s: %s\n", what, strerror(errno));
  exit(77);
}

static void key_of(int at, const char *name, int flags, char key[64]) {
  struct statx s;
  key[0] = '\0';
  if (statx(at, name, flags, STATX_INO | STATX_BTIME, &s) == 0)
    snprintf(key, 64, "%llu-%lld-%u", (unsigned long long)s.stx_ino, (long long)s.stx_btime.tv_sec,
             s.stx_btime.tv_nsec);
}

static struct content *content_of(const char *key) {
  for (int k = 0; k < n_contents; ++k)
    if (strcmp(contents[k].key, key) == 0) return &contents[k];
  return NULL;
}

static void list_names(const char *directory) {
  DIR *d = opendir(directory);
  n_entries = 0;
  for (struct dirent *e; d != NULL && (e = readdir(d)) != NULL && n_entries < MOST;) {
    if (e->d_type == DT_DIR) continue;
    struct entry *to = &entries[n_entries++];
    snprintf(to->name, sizeof to->name, "%s", e->d_name);
    key_of(dirfd(d), e->d_name, AT_SYMLINK_NOFOLLOW, to->key);
  }
  if (d != NULL) closedir(d);
}

/* Stores what a process is about to sync: a file or a directory. */
static void store_synced(const char *path) {
  struct stat s;
  char key[64];
  if (stat(path, &s) != 0) return;
  if (S_ISDIR(s.st_mode)) {
    list_names(path);
    return;
  }
  key_of(AT_FDCWD, path, 0, key);
  struct content *c = content_of(key);
  if (c == NULL && n_contents < MOST) c = &contents[n_contents++];
  const int fd = open(path, O_RDONLY);
  if (c == NULL || fd < 0) die(path);
  snprintf(c->key, sizeof c->key, "%s", key);
  c->bytes = realloc(c->bytes, (size_t)s.st_size + 1);
  const ssize_t n = c->bytes != NULL ? pread(fd, c->bytes, (size_t)s.st_size, 0) : -1;
  if (n < 0) die(path);
  c->size = (size_t)n;
  close(fd);
}

/* Removes all files and writes them again. Hard links to one inode become separate files, which has no
 * effect. */
static void lose_power(const char *directory, bool names_too) {
  static struct entry lasting[MOST];
  const int n_lasting = n_entries;
  memcpy(lasting, entries, sizeof lasting);
  list_names(directory);
  if (chdir(directory) != 0) return; /* not created yet */
  for (int k = 0; k < n_entries; ++k) unlink(entries[k].name);
  const struct entry *all = names_too ? lasting : entries;
  for (int k = 0; k < (names_too ? n_lasting : n_entries); ++k) {
    const struct content *c = content_of(all[k].key);
    FILE *f = fopen(all[k].name, "wb");
    if (f == NULL || (c != NULL && fwrite(c->bytes, 1, c->size, f) != c->size) || fclose(f) != 0)
      die(all[k].name);
  }
}

/* ---- the command */

static void trace_and_execute(char **words) {
  struct sock_filter filter[CALLS_N + 3];
  int n = 0;
  filter[n++] = (struct sock_filter)BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr));
  for (int k = 0; k < CALLS_N; ++k, ++n)
    filter[n] = (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, (uint32_t)calls[k].number,
                                             (uint8_t)(CALLS_N - k), 0);
  filter[n++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
  filter[n++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRACE);
  const struct sock_fprog program = {(unsigned short)n, filter};
  if (ptrace(PTRACE_TRACEME, 0, NULL, NULL) != 0) die("ptrace");
  raise(SIGSTOP);
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 ||
      prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) != 0)
    die("seccomp");
  execvp(words[0], words);
  die(words[0]);
}

/* The absolute path of a call: an argument, or the name of an open file. */
static void path_of(pid_t process, const struct call *call, const struct user_regs_struct *regs,
                    char path[1024]) {
  const unsigned long long arguments[] = {regs->rdi, regs->rsi, regs->rdx, regs->r10, regs->r8};
  char link[64];
  path[0] = '\0';
  if (call->path < 0 || call->path == 4) {
    const int descriptor = (int)arguments[call->path < 0 ? 0 : 4];
    if (descriptor < 3) return;
    snprintf(link, sizeof link, "/proc/%d/fd/%d", process, descriptor);
    const ssize_t n = readlink(link, path, 1023);
    path[n > 0 ? n : 0] = '\0';
    return;
  }
  struct iovec here = {path, 1023}, there = {(void *)(uintptr_t)arguments[call->path], 1023};
  ssize_t n = process_vm_readv(process, &here, 1, &there, 1, 0);
  if (n <= 0) { /* the page ends there */
    there.iov_len = 4096 - (arguments[call->path] & 4095);
    n = process_vm_readv(process, &here, 1, &there, 1, 0);
  }
  path[n > 0 ? n : 0] = '\0';
  if (path[0] == '/' || path[0] == '\0') return;
  char relative[1024];
  snprintf(relative, sizeof relative, "%s", path);
  snprintf(link, sizeof link, "/proc/%d/cwd", process);
  n = readlink(link, path, 1023);
  n = n > 0 ? n : 0;
  snprintf(path + n, (size_t)(1024 - n), "/%s", relative);
}

struct order {
  const char *class, *directory;
  long n, count;
  bool power, names;
  FILE *log;
};

/* Handles a call that may count; true if the power fails at it. */
static bool handle_call(struct order *o, pid_t process) {
  struct user_regs_struct regs;
  char path[1024], link[64];
  const struct call *call = calls;
  if (ptrace(PTRACE_GETREGS, process, NULL, &regs) != 0) return false;
  while (call->number != (long)regs.orig_rax) ++call;
  path_of(process, call, &regs, path);
  const size_t length = strlen(o->directory);
  if (strncmp(path, o->directory, length) != 0) return false;
  if (strstr(path, ".so") != NULL) return false; /* the dynamic loader searches directories */
  if (!o->power && strcmp(call->class, o->class) != 0) return false;
  ++o->count;
  if (o->log != NULL) fprintf(o->log, "%s %s\n", call->class, path);
  if (o->count == o->n && o->power) return true;
  if (o->power && strcmp(call->class, "sync") == 0) {
    snprintf(link, sizeof link, "/proc/%d/fd/%d", process, (int)regs.rdi);
    store_synced(link);
  }
  if (o->count != o->n) return false;
  regs.orig_rax = (unsigned long long)-1, regs.rax = (unsigned long long)-(long long)call->error;
  ptrace(PTRACE_SETREGS, process, NULL, &regs);
  return false;
}

int main(int argc, char **argv) {
  if (argc < 5) return 77;
  struct order o = {.class = argv[1], .directory = argv[3], .n = atol(argv[2])};
  o.names = strcmp(o.class, "power-names") == 0, o.power = o.names || strcmp(o.class, "power") == 0;
  const char *log = getenv("KITH_FAULT_LOG");
  o.log = log != NULL ? fopen(log, "we") : NULL;
  const long options = PTRACE_O_TRACESECCOMP | PTRACE_O_TRACECLONE | PTRACE_O_TRACEFORK |
                       PTRACE_O_TRACEVFORK | PTRACE_O_TRACEEXEC | PTRACE_O_EXITKILL;
  const pid_t child = fork();
  if (child == 0) trace_and_execute(argv + 4);
  int status, code = 77;
  if (child < 0 || waitpid(child, &status, 0) != child || !WIFSTOPPED(status) ||
      ptrace(PTRACE_SETOPTIONS, child, NULL, (void *)options) != 0)
    die("ptrace");
  ptrace(PTRACE_CONT, child, NULL, NULL);
  bool gone = false;
  for (pid_t process; (process = waitpid(-1, &status, __WALL)) > 0;) {
    if (!WIFSTOPPED(status)) {
      if (process == child) code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      continue;
    }
    const int signal = WSTOPSIG(status), event = status >> 16;
    if (event == PTRACE_EVENT_SECCOMP && !gone) gone = handle_call(&o, process);
    if (gone) {
      kill(process, SIGKILL);
      continue;
    }
    ptrace(PTRACE_CONT, process, NULL, (void *)(long)(event != 0 || signal == SIGSTOP ? 0 : signal));
  }
  if (gone) lose_power(o.directory, o.names);
  if (o.log != NULL) fclose(o.log);
  return code;
}
#endif
