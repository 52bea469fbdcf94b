/* Nested timers and counters: arrays of timers with links to parent, first child and next sibling. */
#include "lib/core/profile.h"

#include <string.h>
#include <time.h>

enum { NOWHERE = -1, TOP = 0 }; /* stage 0 is the parent of all root stages and is not reported */

struct timer {
  const char *name;
  char *path;                                       /* owned */
  int depth, parent, first_child, last_child, next; /* NOWHERE: none */
  int first_counter, last_counter;
  uint64_t calls;
  double start, seconds, cpu_start, cpu;
};

struct tally {
  struct kith_counter shown; /* stage: index of the timer here, not its index in tree order */
  int next;
};

struct event {
  int stage;
  double start, stop;
};

/* Written by one thread only, so each has a cache line of its own. */
struct row {
  _Alignas(64) double *busy; /* [stages] */
  int stages;
  struct event *events;
  size_t n_events, capacity;
};

struct kith_profile {
  double origin; /* of the clock of a trace */
  int threads;
  bool trace, cpu;
  int now;     /* the present stage */
  int skipped; /* begins that failed for lack of memory: their ends must not close another stage */
  int n_timers, timers_capacity, n_tallies, tallies_capacity;
  struct timer *timers;
  struct tally *tallies;
  struct row *rows; /* [threads] */
  /* What kith_profile_stages and _counters return: resized with timers and tallies, so that these cannot
   * fail. */
  struct kith_stage *stages;
  struct kith_counter *counters;
  int *place; /* [n_timers] index of a timer in tree order */
};

double kith_seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double cpu_now(const struct kith_profile *p) {
  struct timespec t;
  if (!p->cpu) return 0;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static kith_status room_for_timer(struct kith_profile *p) {
  if (p->n_timers < p->timers_capacity) return KITH_OK;
  const size_t n = (size_t)p->n_timers, capacity = 2 * n + 16;
  KITH_TRY(kith_resize(&p->timers, n, capacity, sizeof *p->timers));
  KITH_TRY(kith_resize(&p->stages, 0, capacity, sizeof *p->stages));
  KITH_TRY(kith_resize(&p->place, 0, capacity, sizeof *p->place));
  p->timers_capacity = (int)capacity;
  return KITH_OK;
}

/* "parent/name"; the path of a root is its name. */
static kith_status make_path(const char *parent, const char *name, char **out) {
  const size_t head = strlen(parent), tail = strlen(name);
  KITH_TRY(kith_resize(out, 0, head + tail + 2, 1));
  memcpy(*out, parent, head);
  if (head > 0) (*out)[head] = '/';
  memcpy(*out + head + (head > 0), name, tail + 1);
  return KITH_OK;
}

static kith_status add_timer(struct kith_profile *p, int parent, const char *name, int *out) {
  KITH_TRY(room_for_timer(p));
  struct timer *t = &p->timers[p->n_timers];
  *t = (struct timer){.name = name,
                      .depth = NOWHERE,
                      .parent = parent,
                      .first_child = NOWHERE,
                      .last_child = NOWHERE,
                      .next = NOWHERE,
                      .first_counter = NOWHERE,
                      .last_counter = NOWHERE};
  KITH_TRY(make_path(parent == NOWHERE ? "" : p->timers[parent].path, name, &t->path));
  *out = p->n_timers++;
  if (parent == NOWHERE) return KITH_OK;
  struct timer *above = &p->timers[parent];
  t->depth = above->depth + 1;
  if (above->last_child == NOWHERE)
    above->first_child = *out;
  else
    p->timers[above->last_child].next = *out;
  above->last_child = *out;
  return KITH_OK;
}

kith_status kith_profile_create(struct kith_profile **out, int threads, bool trace) {
  *out = NULL;
  struct kith_profile *p = NULL;
  KITH_TRY(kith_resize(&p, 0, 1, sizeof *p));
  p->threads = KITH_MAX(threads, 1);
  p->trace = trace;
  p->origin = kith_seconds();
  kith_status status = kith_resize(&p->rows, 0, (size_t)p->threads, sizeof *p->rows);
  if (status == KITH_OK) status = add_timer(p, NOWHERE, "", &p->now);
  if (status != KITH_OK) {
    kith_profile_destroy(&p);
    return status;
  }
  *out = p;
  return KITH_OK;
}

void kith_profile_destroy(struct kith_profile **profile) {
  struct kith_profile *p = *profile;
  if (p == NULL) return;
  for (int t = 0; t < p->n_timers; ++t) kith_free(&p->timers[t].path);
  for (int r = 0; p->rows != NULL && r < p->threads; ++r) {
    kith_free(&p->rows[r].busy);
    kith_free(&p->rows[r].events);
  }
  kith_free(&p->rows);
  kith_free(&p->timers);
  kith_free(&p->tallies);
  kith_free(&p->stages);
  kith_free(&p->counters);
  kith_free(&p->place);
  kith_free(profile);
}

void kith_profile_clock_cpu(struct kith_profile *profile) {
  if (profile != NULL) profile->cpu = true;
}

void kith_profile_align(struct kith_profile *profile) {
  if (profile != NULL) profile->origin = kith_seconds();
}

static inline bool same(const char *a, const char *b) {
  return a == b || strcmp(a, b) == 0;
}

static int find_child(const struct kith_profile *p, int parent, const char *name) {
  int c = p->timers[parent].first_child;
  while (c != NOWHERE && !same(p->timers[c].name, name)) c = p->timers[c].next;
  return c;
}

static void enter(struct kith_profile *profile, const char *name, uint64_t calls) {
  if (profile == NULL) return;
  int child = profile->skipped > 0 ? NOWHERE : find_child(profile, profile->now, name);
  if (child == NOWHERE &&
      (profile->skipped > 0 || add_timer(profile, profile->now, name, &child) != KITH_OK)) {
    ++profile->skipped;
    return;
  }
  profile->now = child;
  profile->timers[child].calls += calls;
  profile->timers[child].cpu_start = cpu_now(profile);
  profile->timers[child].start = kith_seconds();
}

void kith_profile_begin(struct kith_profile *profile, const char *name) {
  enter(profile, name, 1);
}

void kith_profile_resume(struct kith_profile *profile, const char *name) {
  enter(profile, name, 0);
}

/* An event for which there is no memory is left out of the trace. */
static void record(struct row *row, int stage, double start, double stop) {
  if (row->n_events == row->capacity) {
    const size_t capacity = 2 * row->capacity + 256;
    if (kith_resize(&row->events, row->n_events, capacity, sizeof *row->events) != KITH_OK) return;
    row->capacity = capacity;
  }
  row->events[row->n_events++] = (struct event){stage, start, stop};
}

void kith_profile_end(struct kith_profile *profile) {
  if (profile == NULL) return;
  const double stop = kith_seconds();
  if (profile->skipped > 0) {
    --profile->skipped;
    return;
  }
  if (profile->now == TOP) {
    (void)kith_fail(KITH_INTERNAL, "a stage of the profile was ended that never began");
    return;
  }
  struct timer *t = &profile->timers[profile->now];
  t->seconds += stop - t->start;
  t->cpu += cpu_now(profile) - t->cpu_start;
  if (profile->trace) record(&profile->rows[0], profile->now, t->start, stop);
  profile->now = t->parent;
}

void kith_profile_thread(struct kith_profile *profile, int thread, double start, double stop) {
  if (profile == NULL || thread < 0 || thread >= profile->threads || profile->skipped > 0) return;
  struct row *row = &profile->rows[thread];
  if (row->stages <= profile->now) {
    const int stages = 2 * profile->now + 16;
    if (kith_resize(&row->busy, (size_t)row->stages, (size_t)stages, sizeof *row->busy) != KITH_OK) return;
    row->stages = stages;
  }
  row->busy[profile->now] += stop - start;
  if (profile->trace) record(row, profile->now, start, stop);
}

static kith_status add_tally(struct kith_profile *p, const char *name, int *out) {
  if (p->n_tallies == p->tallies_capacity) {
    const size_t n = (size_t)p->n_tallies, capacity = 2 * n + 16;
    KITH_TRY(kith_resize(&p->tallies, n, capacity, sizeof *p->tallies));
    KITH_TRY(kith_resize(&p->counters, 0, capacity, sizeof *p->counters));
    p->tallies_capacity = (int)capacity;
  }
  *out = p->n_tallies++;
  p->tallies[*out] = (struct tally){{name, p->now, 0}, NOWHERE};
  struct timer *here = &p->timers[p->now];
  if (here->last_counter == NOWHERE)
    here->first_counter = *out;
  else
    p->tallies[here->last_counter].next = *out;
  here->last_counter = *out;
  return KITH_OK;
}

void kith_profile_count(struct kith_profile *profile, const char *counter, double amount) {
  if (profile == NULL || profile->skipped > 0) return;
  int c = profile->timers[profile->now].first_counter;
  while (c != NOWHERE && !same(profile->tallies[c].shown.name, counter)) c = profile->tallies[c].next;
  if (c == NOWHERE && add_tally(profile, counter, &c) != KITH_OK) return;
  profile->tallies[c].shown.total += amount;
}

/* Threads that reported nothing count as idle. */
static double imbalance_of(const struct kith_profile *p, int stage) {
  double most = 0, sum = 0;
  for (int r = 0; r < p->threads; ++r) {
    const double busy = stage < p->rows[r].stages ? p->rows[r].busy[stage] : 0;
    most = KITH_MAX(most, busy);
    sum += busy;
  }
  return sum > 0 ? most * p->threads / sum : 0;
}

static bool is_open(const struct kith_profile *p, int stage) {
  int t = p->now;
  while (t != TOP && t != stage) t = p->timers[t].parent;
  return t == stage;
}

/* Follows the tree: first child, else next sibling, else the next sibling of the closest ancestor that has
 * one. */
static int next_in_tree(const struct kith_profile *p, int t) {
  if (p->timers[t].first_child != NOWHERE) return p->timers[t].first_child;
  while (t != NOWHERE && p->timers[t].next == NOWHERE) t = p->timers[t].parent;
  return t == NOWHERE ? NOWHERE : p->timers[t].next;
}

int kith_profile_stages(const struct kith_profile *profile, const struct kith_stage **out) {
  *out = NULL;
  if (profile == NULL) return 0;
  const double now = kith_seconds(), cpu = cpu_now(profile);
  int n = 0;
  profile->place[TOP] = NOWHERE;
  for (int t = next_in_tree(profile, TOP); t != NOWHERE; t = next_in_tree(profile, t)) {
    const struct timer *timer = &profile->timers[t];
    const bool open = is_open(profile, t);
    const double seconds = timer->seconds + (open ? now - timer->start : 0);
    const double busy = timer->cpu + (open ? cpu - timer->cpu_start : 0);
    const int parent = profile->place[timer->parent];
    profile->place[t] = n;
    profile->stages[n++] = (struct kith_stage){.path = timer->path,
                                               .name = timer->name,
                                               .depth = timer->depth,
                                               .parent = parent,
                                               .calls = timer->calls,
                                               .seconds = seconds,
                                               .self_seconds = seconds,
                                               .self_cpu = busy,
                                               .imbalance = imbalance_of(profile, t)};
    if (parent < 0) continue;
    profile->stages[parent].self_seconds -= seconds;
    profile->stages[parent].self_cpu -= busy;
  }
  *out = profile->stages;
  return n;
}

int kith_profile_counters(const struct kith_profile *profile, const struct kith_counter **out) {
  *out = NULL;
  if (profile == NULL) return 0;
  const struct kith_stage *stages;
  (void)kith_profile_stages(profile, &stages); /* sets the indices in tree order */
  int n = 0;
  for (int t = TOP; t != NOWHERE; t = next_in_tree(profile, t))
    for (int c = profile->timers[t].first_counter; c != NOWHERE; c = profile->tallies[c].next) {
      profile->counters[n] = profile->tallies[c].shown;
      profile->counters[n++].stage = profile->place[t];
    }
  *out = profile->counters;
  return n;
}

static void print_counters(FILE *out, const struct kith_counter *counters, int n, int stage, int depth) {
  for (int c = 0; c < n; ++c)
    if (counters[c].stage == stage)
      fprintf(out, "%*s. %-s %.10g\n", 2 * (depth + 1), "", counters[c].name, counters[c].total);
}

static void print_number(FILE *out, bool known, double number) {
  if (known)
    fprintf(out, " %9.2f", number);
  else
    fprintf(out, " %9s", "-");
}

void kith_profile_print(const struct kith_profile *profile, FILE *out, double node_steps) {
  const struct kith_counter *counters;
  const struct kith_stage *stages;
  const int n_counters = kith_profile_counters(profile, &counters), n = kith_profile_stages(profile, &stages);
  fprintf(out, "%-40s %10s %12s %7s %9s %9s\n", "stage", "calls", "seconds", "share", "ns/node", "imbalance");
  double root = 0;
  for (int s = 0; s < n; ++s) {
    const struct kith_stage *stage = &stages[s];
    if (stage->depth == 0) root = stage->seconds;
    fprintf(out, "%*s%-*s %10llu %12.6f %6.1f%%", 2 * stage->depth, "", KITH_MAX(40 - 2 * stage->depth, 1),
            stage->name, (unsigned long long)stage->calls, stage->seconds,
            root > 0 ? 100 * stage->seconds / root : 0);
    print_number(out, node_steps > 0, node_steps > 0 ? 1e9 * stage->seconds / node_steps : 0);
    print_number(out, stage->imbalance > 0, stage->imbalance);
    fprintf(out, "\n");
    print_counters(out, counters, n_counters, s, stage->depth);
  }
  print_counters(out, counters, n_counters, NOWHERE, -1);
}

static void write_string(FILE *file, const char *text) {
  fputc('"', file);
  for (const char *c = text; *c != '\0'; ++c)
    if (*c == '"' || *c == '\\')
      fprintf(file, "\\%c", *c);
    else if ((unsigned char)*c < ' ')
      fprintf(file, "\\u%04x", (unsigned)(unsigned char)*c);
    else
      fputc(*c, file);
  fputc('"', file);
}

static void write_event(const struct kith_profile *p, FILE *file, int process, int row,
                        const struct event *event) {
  fprintf(file, ",\n{\"ph\":\"X\",\"pid\":%d,\"tid\":%d,\"ts\":%.3f,\"dur\":%.3f,\"name\":", process, row,
          1e6 * (event->start - p->origin), 1e6 * (event->stop - event->start));
  write_string(file, p->timers[event->stage].name);
  fprintf(file, ",\"args\":{\"path\":");
  write_string(file, p->timers[event->stage].path);
  fprintf(file, "}}");
}

static void write_name(FILE *file, int process, int row, const char *what, const char *name, int number) {
  fprintf(file, "{\"ph\":\"M\",\"pid\":%d,\"tid\":%d,\"name\":\"%s\",\"args\":{\"name\":\"%s %d\"}}", process,
          row, what, name, number);
}

void kith_profile_write_events(const struct kith_profile *p, int process, FILE *file) {
  write_name(file, process, 0, "process_name", "kith, rank", process);
  for (int r = 0; r < p->threads; ++r) {
    fprintf(file, ",\n");
    write_name(file, process, r, "thread_name", "thread", r);
    for (size_t e = 0; e < p->rows[r].n_events; ++e) write_event(p, file, process, r, &p->rows[r].events[e]);
  }
  const double now = kith_seconds();
  for (int t = p->now; t != TOP; t = p->timers[t].parent) /* open stages, as if they ended here */
    write_event(p, file, process, 0, &(struct event){t, p->timers[t].start, now});
}

kith_status kith_profile_write_trace(const struct kith_profile *profile, const char *path) {
  if (profile == NULL) KITH_FAIL(BAD_INPUT, "no trace to write to '%s': profiling is off", path);
  char *part = NULL;
  const size_t size = strlen(path) + sizeof ".part";
  KITH_TRY(kith_resize(&part, 0, size, 1));
  snprintf(part, size, "%s.part", path);
  FILE *file = fopen(part, "w");
  bool ok = file != NULL;
  if (ok) {
    fprintf(file, "[\n");
    kith_profile_write_events(profile, 0, file);
    fprintf(file, "\n]\n");
    ok = ferror(file) == 0;
    ok = fclose(file) == 0 && ok;
    ok = ok && rename(part, path) == 0;
    if (!ok) remove(part);
  }
  kith_free(&part);
  if (!ok) KITH_FAIL(BAD_FILE, "cannot write the trace '%s'", path);
  return KITH_OK;
}
