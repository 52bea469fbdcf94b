/* base.h - what all of kith shares: dimension, index types, status, error messages, aligned memory.
 *
 * Sources are compiled three times, with KITH_NDIM 1, 2 and 3, but for those that know no dimension (see
 * CMakeLists.txt), which are compiled once. A vector is NDIM doubles, a field of vectors is double[n][NDIM],
 * flattened.
 *
 * Errors: functions return a kith_status. KITH_FAIL records one line and returns its code; KITH_TRY passes a
 * failure on. The message is kept per thread, like errno: it is the only state outside of objects. */
#ifndef KITH_CORE_BASE_H
#define KITH_CORE_BASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef KITH_NDIM /* a source without it is compiled once */
#define NDIM KITH_NDIM
#endif

typedef int32_t kith_index; /* a node of this process: internal or ghost */
/* Loops over fewer nodes than this stay on one thread: waking the others costs more than they save. */
enum { KITH_FEW = 1000 };
/* The same for loops that only copy or compare a number or two of each node. */
enum { KITH_FEW_COPIES = 8192 };
/* The first index of part `part` where 0 .. n - 1 is divided into `parts` equal parts. */
static inline kith_index kith_part_start(kith_index n, int part, int parts) {
  return (kith_index)((int64_t)n * part / parts);
}
/* A loop that wants few of many nodes goes over them in stretches of this length, and skips a stretch in
 * which it wants none. */
enum { KITH_STRETCH = 128 };
/* Are value[begin] .. value[end - 1] all 0? There is no early exit, so that the compiler vectorizes the
 * loop. */
static inline bool kith_all_zero(const uint8_t *value, kith_index begin, kith_index end) {
  uint8_t any = 0;
  for (kith_index i = begin; i < end; ++i) any |= value[i];
  return any == 0;
}

/* code, what it means */
#define KITH_STATUS_LIST(X)                                   \
  X(OK, "success")                                            \
  X(NO_MEMORY, "out of memory")                               \
  X(BAD_INPUT, "the scene or the command line is wrong")      \
  X(BAD_FILE, "a file cannot be read or written")             \
  X(STALE, "a structure is older than what it was made from") \
  X(OUTGROWN, "a support outgrew the connectivity")           \
  X(DIVERGED, "the run left the physical range")              \
  X(UNSUPPORTED, "not available")                             \
  X(INTERNAL, "a defect in kith")

typedef enum kith_status {
#define X(name, text) KITH_##name,
  KITH_STATUS_LIST(X)
#undef X
} kith_status;

const char *kith_status_text(kith_status status);

/* Records the message and returns `status`. The message is one line without a newline. */
kith_status kith_fail(kith_status status, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* The same for a failure of the node with this id; -1: of none. */
kith_status kith_fail_node(kith_status status, int64_t id, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* The line of the last failure on this thread; empty if there was none. View, valid until the next
 * failure. */
const char *kith_failure(void);
/* The id of the node that it was of; -1: of none. */
int64_t kith_failed_node(void);

#define KITH_FAIL(code, ...) return kith_fail(KITH_##code, __VA_ARGS__)
#define KITH_FAIL_NODE(code, id, ...) return kith_fail_node(KITH_##code, id, __VA_ARGS__)
#define KITH_TRY(call)                                        \
  do {                                                        \
    const kith_status kith_try_status_ = (call);              \
    if (kith_try_status_ != KITH_OK) return kith_try_status_; \
  } while (0)

/* Gives an array of 64-byte aligned memory a new size: `count` elements of `size` bytes, of which the first
 * `keep` are those of before; all other bytes are zero. p is the address of the pointer to the array (NULL:
 * there is none yet), which is replaced, and on failure left as it was. count 0 frees the array. */
kith_status kith_resize(void *p, size_t keep, size_t count, size_t size);
/* Room for at least `count` elements of an array that grows: kith_resize, with a little to spare, if
 * *capacity, the elements that there is room for, is less. */
kith_status kith_grow(void *p, size_t *capacity, size_t keep, size_t count, size_t size);
/* As kith_grow, but the contents are lost where the array moves, and on failure. */
kith_status kith_reserve(void *p, size_t *capacity, size_t count, size_t size);
/* Frees the array whose pointer is at the address p, and sets that pointer to NULL. It may be NULL
 * already. */
void kith_free(void *p);
/* kith_free for each of these addresses, in their order. */
#define KITH_FREE(...) \
  kith_free_all((void *[]){__VA_ARGS__}, sizeof((void *[]){__VA_ARGS__}) / sizeof(void *))
void kith_free_all(void *const *p, size_t n);

#define KITH_MIN(a, b) ((a) < (b) ? (a) : (b))
#define KITH_MAX(a, b) ((a) > (b) ? (a) : (b))

/* The position of the first of the ascending entries node[from] .. node[to - 1] that is >= j, or `to`. It is
 * written without branches, because half of them would be mispredicted; of `?:` gcc makes one. */
static inline size_t kith_lower_bound(const kith_index *node, size_t from, size_t to, kith_index j) {
  if (from == to) return from;
  const kith_index *at = node + from;
  for (size_t n = to - from; n > 1; n -= n / 2) at += (n / 2) & -(size_t)(at[n / 2 - 1] < j);
  return (size_t)(at - node) + (*at < j);
}

/* Inlined into its caller for certain, so that it is compiled for the caller's instruction set. */
#define KITH_INLINE __attribute__((always_inline)) static inline

/* Functions that take most of the time and call no others carry KITH_HOT: they are compiled for several
 * instruction sets, of which one is picked when the program starts. They must be static, and no two of them
 * in the program may have the same name: clang 14 does not link others. */
#if defined(__x86_64__) && !defined(KITH_SANITIZE)
#define KITH_HOT __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define KITH_HOT
#endif

#endif
