/* Nested timers and counters: a tree of timers, and for a trace the list of what each thread did. */
#include "lib/core/profile.h"

#include <inttypes.h>
#include <string.h>
#include <time.h>

#if defined KITH_LIKWID
#define LIKWID_PERFMON
#include <likwid-marker.h>
#define MARK_BEGIN(timer) _Pragma("omp parallel") LIKWID_MARKER_START((timer)->path)
#define MARK_END(timer) _Pragma("omp parallel") LIKWID_MARKER_STOP((timer)->path)
#elif defined KITH_CALIPER
#include <caliper/cali.h>
#define MARK_BEGIN(timer) CALI_MARK_BEGIN((timer)->name)
#define MARK_END(timer) CALI_MARK_END((timer)->name)
#else
#define MARK_BEGIN(timer) ((void)0)
#define MARK_END(timer) ((void)0)
#endif
#ifndef LIKWID_MARKER_INIT
#define LIKWID_MARKER_INIT ((void)0)
#define LIKWID_MARKER_CLOSE ((void)0)
#endif

struct timer {
  const char *name;
  char *path;                  /* behind the busy times */
  struct timer *parent, *next; /* next: in tree order, children behind their parent */
  int depth;
  bool open;
  uint64_t calls;
  double start, seconds;
  double busy[]; /* [threads] */
};

struct event {
  const struct timer *timer;
  double start, stop;
};

/* Written by one thread only, so each has a cache line of its own. */
struct row {
  _Alignas(64) struct event *events;
  size_t n, capacity;
  uint64_t left_out; /* for want of memory, or because there are MOST_EVENTS */
};
enum { MOST_EVENTS = 1 << 18 }; /* of a thread: some 40 MB of a trace */

struct kith_profile {
  double origin; /* of the clock of a trace */
  int threads;
  bool trace, incomplete;   /* incomplete: for want of memory */
  struct timer *root, *now; /* root: parent of all root stages, not reported; now: the present stage */
  int skipped;      /* begins that failed for lack of memory: their ends must not close another stage */
  struct row *rows; /* [threads] */
  struct kith_stage *stages; /* as many as timers, so that kith_profile_stages cannot fail */
  struct kith_counter *counters;
  size_t n_timers, n_counters, counters_capacity;
};

double kith_seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* A new timer below `parent` (NULL: the root), behind all that are there. The path is "parent/name"; that of
 * a root stage is its name, that of its parent empty. */
static kith_status add_timer(struct kith_profile *p, struct timer *parent, const char *name,
                             struct timer **out) {
  const char *above = parent != NULL ? parent->path : "";
  const size_t busy = (size_t)p->threads * sizeof(double), length = strlen(above) + strlen(name) + 2;
  struct timer *t = NULL, *before = parent;
  KITH_TRY(kith_resize(&p->stages, 0, p->n_timers + 1, sizeof *p->stages));
  KITH_TRY(kith_resize(&t, 0, 1, sizeof *t + busy + length));
  t->name = name;
  t->path = (char *)t->busy + busy;
  snprintf(t->path, length, "%s%s%s", above, above[0] != '\0' ? "/" : "", name);
  t->parent = parent;
  t->depth = parent != NULL ? parent->depth + 1 : -1;
  while (before != NULL && before->next != NULL && before->next->depth >= t->depth) before = before->next;
  if (before != NULL) t->next = before->next, before->next = t;
  ++p->n_timers;
  *out = t;
  return KITH_OK;
}

kith_status kith_profile_create(struct kith_profile **out, int threads, bool trace) {
  struct kith_profile *p = NULL;
  *out = NULL;
  KITH_TRY(kith_resize(&p, 0, 1, sizeof *p));
  p->threads = KITH_MAX(threads, 1);
  p->trace = trace;
  p->origin = kith_seconds();
  kith_status status = kith_resize(&p->rows, 0, (size_t)p->threads, sizeof *p->rows);
  if (status == KITH_OK) status = add_timer(p, NULL, "", &p->root);
  p->now = p->root;
  LIKWID_MARKER_INIT;
  *out = p;
  if (status != KITH_OK) kith_profile_destroy(out);
  return status;
}

void kith_profile_destroy(struct kith_profile **profile) {
  struct kith_profile *p = *profile;
  if (p == NULL) return;
  LIKWID_MARKER_CLOSE;
  for (struct timer *t = p->root, *next; t != NULL; t = next) next = t->next, kith_free(&t);
  for (int r = 0; p->rows != NULL && r < p->threads; ++r) kith_free(&p->rows[r].events);
  KITH_FREE(&p->rows, &p->stages, &p->counters);
  kith_free(profile);
}

void kith_profile_align(struct kith_profile *profile, double origin) {
  if (profile != NULL) profile->origin = origin;
}

static inline bool same(const char *a, const char *b) {
  return a == b || strcmp(a, b) == 0;
}

/* The stage of this name, of so many letters, below `parent`; NULL: there is none. */
static struct timer *find(struct timer *parent, const char *name, size_t length) {
  struct timer *child = parent->next;
  while (child != NULL && child->depth > parent->depth &&
         !(child->parent == parent &&
           (child->name == name || (strncmp(child->name, name, length) == 0 && child->name[length] == '\0'))))
    child = child->next;
  return child != NULL && child->parent == parent ? child : NULL;
}

kith_status kith_profile_add(struct kith_profile *p, const char *path) {
  struct timer *parent = p->root;
  for (const char *part = path; *part != '\0';) {
    const size_t length = strcspn(part, "/");
    struct timer *child = find(parent, part, length);
    if (child == NULL) {
      char name[64];
      snprintf(name, sizeof name, "%.*s", (int)length, part);
      KITH_TRY(add_timer(p, parent, name, &child));
      child->name =
          child->path + strlen(child->path) - strlen(name); /* the only one that is not a constant */
    }
    parent = child;
    part += length + (part[length] == '/');
  }
  return KITH_OK;
}

static void enter(struct kith_profile *p, const char *name, uint64_t calls, double since) {
  if (p == NULL) return;
  struct timer *child = find(p->now, name, strlen(name));
  if (p->skipped > 0 || (child == NULL && add_timer(p, p->now, name, &child) != KITH_OK)) {
    ++p->skipped;
    p->incomplete = true;
    return;
  }
  p->now = child;
  child->open = true;
  child->calls += calls;
  child->start = since > 0 ? since : kith_seconds();
  MARK_BEGIN(child);
}

void kith_profile_begin(struct kith_profile *profile, const char *name) {
  enter(profile, name, 1, 0);
}

void kith_profile_begin_since(struct kith_profile *profile, const char *name, double since) {
  enter(profile, name, 1, since);
}

void kith_profile_resume(struct kith_profile *profile, const char *name) {
  enter(profile, name, 0, 0);
}

static void record(struct kith_profile *p, int thread, double start, double stop) {
  struct row *row = &p->rows[thread];
  if (!p->trace) return;
  if (row->n < MOST_EVENTS &&
      kith_grow(&row->events, &row->capacity, row->n, row->n + 1, sizeof *row->events) == KITH_OK)
    row->events[row->n++] = (struct event){p->now, start, stop};
  else
    ++row->left_out;
}

void kith_profile_end(struct kith_profile *p) {
  if (p == NULL) return;
  const double stop = kith_seconds();
  struct timer *t = p->now;
  if (p->skipped > 0) {
    --p->skipped;
    return;
  }
  if (t == p->root) {
    (void)kith_fail(KITH_INTERNAL, "a stage of the profile was ended that never began");
    return;
  }
  MARK_END(t);
  t->seconds += stop - t->start;
  t->open = false;
  record(p, 0, t->start, stop);
  p->now = t->parent;
}

void kith_profile_thread(struct kith_profile *p, int thread, double start, double stop) {
  if (p == NULL || thread < 0 || thread >= p->threads || p->skipped > 0) return;
  p->now->busy[thread] += stop - start;
  if (thread > 0) record(p, thread, start, stop); /* of the first thread the event is the stage itself */
}

void kith_profile_count(struct kith_profile *p, const char *counter, double amount) {
  if (p == NULL || p->skipped > 0) return;
  struct kith_counter *c = p->counters, *end = c + p->n_counters;
  while (c < end && !(c->path == p->now->path && same(c->name, counter))) ++c;
  if (c == end) {
    if (kith_grow(&p->counters, &p->counters_capacity, p->n_counters, p->n_counters + 1, sizeof *c) !=
        KITH_OK) {
      p->incomplete = true;
      return;
    }
    c = &p->counters[p->n_counters++];
    *c = (struct kith_counter){counter, p->now->path, 0};
  }
  c->total += amount;
}

/* Threads that reported nothing count as idle. */
static double imbalance_of(const struct timer *t, int threads) {
  double most = 0, sum = 0;
  for (int r = 0; r < threads; ++r) {
    most = KITH_MAX(most, t->busy[r]);
    sum += t->busy[r];
  }
  return sum > 0 ? most * threads / sum : 0;
}

bool kith_profile_is_whole(const struct kith_profile *profile) {
  return profile == NULL || !profile->incomplete;
}

int kith_profile_stages(const struct kith_profile *p, const struct kith_stage **out) {
  int n = 0, parent = -1;
  *out = p != NULL ? p->stages : NULL;
  if (p == NULL) return 0;
  const double now = kith_seconds();
  for (const struct timer *t = p->root->next; t != NULL; t = t->next, parent = n++) {
    while (parent >= 0 && p->stages[parent].depth >= t->depth) parent = p->stages[parent].parent;
    const double seconds = t->seconds + (t->open ? now - t->start : 0);
    p->stages[n] = (struct kith_stage){.path = t->path,
                                       .name = t->name,
                                       .depth = t->depth,
                                       .parent = parent,
                                       .calls = t->calls,
                                       .seconds = seconds,
                                       .self_seconds = seconds,
                                       .imbalance = imbalance_of(t, p->threads)};
    if (parent >= 0) p->stages[parent].self_seconds -= seconds;
  }
  return n;
}

const char *kith_profile_present(const struct kith_profile *profile) {
  return profile->now != profile->root ? profile->now->path : "";
}

int kith_profile_counters(const struct kith_profile *profile, const struct kith_counter **out) {
  *out = profile != NULL ? profile->counters : NULL;
  return profile != NULL ? (int)profile->n_counters : 0;
}

double kith_profile_counted(const struct kith_profile *p, const char *path, const char *counter) {
  const size_t length = strlen(path) + (path[0] == '\0' || path[strlen(path) - 1] != '/');
  double total = 0;
  for (size_t c = 0; p != NULL && c < p->n_counters; ++c)
    if (strncmp(p->counters[c].path, path, length) == 0 && same(p->counters[c].name, counter))
      total += p->counters[c].total;
  return total;
}

static void write_event(const struct kith_profile *p, FILE *file, int process, int row, struct event event) {
  fprintf(file, ",\n{\"ph\":\"X\",\"pid\":%d,\"tid\":%d,\"ts\":%.3f,\"dur\":%.3f,", process, row,
          1e6 * (event.start - p->origin), 1e6 * (event.stop - event.start));
  fprintf(file, "\"name\":\"%s\",\"args\":{\"path\":\"%s\"}}", event.timer->name, event.timer->path);
}

static void write_name(FILE *file, int process, int row, const char *what, const char *name, int number) {
  fprintf(file, "{\"ph\":\"M\",\"pid\":%d,\"tid\":%d,\"name\":\"%s\",\"args\":{\"name\":\"%s %d\"}}", process,
          row, what, name, number);
}

void kith_profile_write_events(const struct kith_profile *p, int process, FILE *file) {
  const double now = kith_seconds();
  write_name(file, process, 0, "process_name", "kith, rank", process);
  for (int r = 0; r < p->threads; ++r) {
    fputs(",\n", file);
    write_name(file, process, r, "thread_name", "thread", r);
    for (size_t e = 0; e < p->rows[r].n; ++e) write_event(p, file, process, r, p->rows[r].events[e]);
    if (p->rows[r].left_out > 0)
      fprintf(file,
              ",\n{\"ph\":\"M\",\"pid\":%d,\"tid\":%d,\"name\":\"left_out\",\"args\":{\"events\":%" PRIu64
              "}}",
              process, r, p->rows[r].left_out);
  }
  for (const struct timer *t = p->now; t != p->root; t = t->parent) /* open stages, as if they ended here */
    write_event(p, file, process, 0, (struct event){t, t->start, now});
}
