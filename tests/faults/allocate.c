/* allocate.c - to be preloaded: makes the n-th allocation of a kith process fail.
 *
 *   KITH_FAULT_N      n; 0: none
 *   KITH_FAULT_RANK   the rank (0)
 *   KITH_FAULT_COUNT  a file to which the number of allocations is written at the end
 *
 * Only allocations by kith itself, or by HDF5, SUNDIALS, libyaml, jansson, GSL or muParser, are counted, also
 * in child processes. Not those of MPI, OpenMP and the C library, which end the program with messages of
 * their own. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <link.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

void *__libc_malloc(size_t bytes);
void *__libc_calloc(size_t n, size_t bytes);
void *__libc_realloc(void *p, size_t bytes);
void *__libc_memalign(size_t alignment, size_t bytes);

enum { MOST = 32 };
static struct range { uintptr_t from, to; } ranges[MOST];
static int n_ranges;
static long wanted = -1, *count; /* shared with processes that this one forks */

static int note_object(struct dl_phdr_info *info, size_t size, void *data) {
  static const char *const libraries[] = {"libhdf5",    "libsundials", "libyaml",
                                          "libjansson", "libgsl",      "muparser"};
  bool counts = info->dlpi_name[0] == '\0';
  (void)size, (void)data;
  for (size_t k = 0; k < sizeof libraries / sizeof *libraries; ++k)
    counts = counts || strstr(info->dlpi_name, libraries[k]) != NULL;
  for (int k = 0; counts && k < info->dlpi_phnum; ++k) {
    const ElfW(Phdr) *p = &info->dlpi_phdr[k];
    if (p->p_type != PT_LOAD || !(p->p_flags & PF_X) || n_ranges == MOST) continue;
    ranges[n_ranges].from = info->dlpi_addr + p->p_vaddr;
    ranges[n_ranges].to = ranges[n_ranges].from + p->p_memsz;
    ++n_ranges;
  }
  return 0;
}

__attribute__((constructor)) static void start(void) {
  const char *n = getenv("KITH_FAULT_N"), *rank = getenv("KITH_FAULT_RANK"),
             *me = getenv("OMPI_COMM_WORLD_RANK");
  char self[1024] = "";
  if (n == NULL || readlink("/proc/self/exe", self, sizeof self - 1) <= 0 || strstr(self, "/kith-") == NULL)
    return;
  if (rank != NULL && (me == NULL || strcmp(rank, me) != 0)) return; /* another rank, or the launcher */
  dl_iterate_phdr(note_object, NULL);
  count = mmap(NULL, sizeof *count, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (count != MAP_FAILED) wanted = atol(n);
}

__attribute__((destructor)) static void finish(void) {
  const char *path = getenv("KITH_FAULT_COUNT");
  FILE *f = wanted >= 0 && path != NULL ? fopen(path, "w") : NULL;
  if (f != NULL) fprintf(f, "%ld\n", *count), fclose(f);
}

static bool fails(const void *caller) {
  if (wanted < 0) return false;
  for (int k = 0; k < n_ranges; ++k)
    if ((uintptr_t)caller >= ranges[k].from && (uintptr_t)caller < ranges[k].to) {
      if (__atomic_add_fetch(count, 1, __ATOMIC_RELAXED) != wanted) return false;
      errno = ENOMEM;
      if (getenv("KITH_FAULT_TRAP") != NULL) __builtin_trap();
      return true;
    }
  return false;
}

void *malloc(size_t bytes) {
  return fails(__builtin_return_address(0)) ? NULL : __libc_malloc(bytes);
}
void *calloc(size_t n, size_t bytes) {
  return fails(__builtin_return_address(0)) ? NULL : __libc_calloc(n, bytes);
}
void *realloc(void *p, size_t bytes) {
  return fails(__builtin_return_address(0)) ? NULL : __libc_realloc(p, bytes);
}
void *aligned_alloc(size_t alignment, size_t bytes) {
  return fails(__builtin_return_address(0)) ? NULL : __libc_memalign(alignment, bytes);
}
int posix_memalign(void **p, size_t alignment, size_t bytes) {
  if (fails(__builtin_return_address(0))) return ENOMEM;
  *p = __libc_memalign(alignment, bytes);
  return *p != NULL ? 0 : ENOMEM;
}
char *strdup(const char *text) {
  const size_t bytes = strlen(text) + 1;
  char *copy = fails(__builtin_return_address(0)) ? NULL : __libc_malloc(bytes);
  return copy != NULL ? memcpy(copy, text, bytes) : NULL;
}
