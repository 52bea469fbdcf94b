/* test_profile.c - the profile: the tree of stages, counters, imbalance of threads; and its trace, which
 * jansson reads back. Oracle: stages of known number and duration. */
#include "tests/check.h"
#include "lib/core/profile.h"
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static void spin(double seconds) {
  const double end = kith_seconds() + seconds;
  while (kith_seconds() < end) {
  }
}

static bool is_json(const char *text) {
  json_t *json = json_loads(text, 0, NULL);
  const bool is = json != NULL;
  json_decref(json);
  return is;
}

/* Counts a word without strstr, which under sanitizers measures the rest of the text at each call. */
static int occurrences(const char *text, const char *word) {
  const size_t length = strlen(word);
  int n = 0;
  for (const char *c = text; *c != '\0'; ++c) n += *c == *word && strncmp(c, word, length) == 0;
  return n;
}

static struct kith_profile *some_steps(bool trace) {
  struct kith_profile *p = NULL;
  CHECK_OK(kith_profile_create(&p, 2, trace));
  char other[] = "rows"; /* the same name at another address is the same stage */
  kith_profile_count(p, "nodes", 12);
  for (int k = 0; k < 3; ++k) {
    kith_profile_begin(p, "step");
    kith_profile_begin(p, "connectivity");
    kith_profile_begin(p, k == 1 ? other : "rows");
    spin(0.002);
    kith_profile_count(p, "pairs", 10);
    kith_profile_count(p, "candidates", 100);
    kith_profile_thread(p, 0, 1.0, 2.0);
    kith_profile_thread(p, 1, 1.0, 4.0);
    kith_profile_end(p);
    kith_profile_end(p);
    spin(0.001);
    /* another parent makes it another stage */
    if (k == 2) kith_profile_begin(p, "rows"), kith_profile_end(p);
    kith_profile_end(p);
  }
  kith_profile_begin(p, "output");
  kith_profile_end(p);
  kith_profile_begin(p, "step"); /* the stage is entered again, and stays open */
  kith_profile_begin(p, "connectivity");
  kith_profile_begin(p, "pairs");
  return p;
}

static void check_tree(void) {
  struct kith_profile *p = some_steps(false);
  spin(0.001);
  const struct kith_stage *s;
  const int n = kith_profile_stages(p, &s);
  const char *const paths[] = {
      "step",  "step/connectivity", "step/connectivity/rows", "step/connectivity/pairs", "step/rows",
      "output"};
  const int depth[] = {0, 1, 2, 2, 1, 0}, parent[] = {-1, 0, 1, 1, 0, -1}, calls[] = {4, 4, 3, 1, 1, 1};
  CHECK(n == 6);
  for (int k = 0; k < n && k < 6; ++k) {
    CHECK(strcmp(s[k].path, paths[k]) == 0 && strstr(s[k].path, s[k].name) != NULL);
    CHECK(s[k].depth == depth[k] && s[k].parent == parent[k] && s[k].calls == (uint64_t)calls[k]);
    /* -1e-9: rounding of sums below 1 s */
    CHECK(s[k].self_seconds >= -1e-9 && s[k].self_seconds <= s[k].seconds);
  }
  CHECK(s[2].seconds >= 0.006 && s[1].seconds >= s[2].seconds + s[3].seconds && s[3].seconds >= 0.001);
  CHECK(s[0].self_seconds >= 0.003);
  CHECK_CLOSE(s[2].imbalance, 1.5, 1e-15); /* threads were busy for 3 and 9: 9 over the mean of 6 */
  CHECK(s[1].imbalance == 0);
  const struct kith_counter *c;
  CHECK(kith_profile_counters(p, &c) == 3);
  CHECK(strcmp(c[0].name, "nodes") == 0 && c[0].path[0] == '\0' && c[0].total == 12);
  CHECK(strcmp(c[1].name, "pairs") == 0 && strcmp(c[1].path, paths[2]) == 0 && c[1].total == 30);
  CHECK(strcmp(c[2].name, "candidates") == 0 && strcmp(c[2].path, paths[2]) == 0 && c[2].total == 300);
  CHECK(kith_profile_counted(p, paths[2], "pairs") == 30 && kith_profile_counted(p, "step/", "pairs") == 30);
  CHECK(kith_profile_counted(p, "step", "pairs") == 0 && kith_profile_counted(NULL, "step/", "pairs") == 0);
  kith_profile_destroy(&p);
  CHECK(p == NULL);
}

static void check_unbalanced(void) {
  struct kith_profile *p = NULL;
  CHECK_OK(kith_profile_create(&p, 1, true));
  kith_profile_end(p);
  CHECK(strstr(kith_failure(), "never began") != NULL);
  kith_profile_thread(p, 1, 0, 1); /* no such thread */
  kith_profile_thread(p, -1, 0, 1);
  kith_profile_begin(p, "a");
  kith_profile_end(p);
  kith_profile_end(p);
  kith_profile_begin(p, "b");
  const struct kith_stage *s;
  CHECK(kith_profile_stages(p, &s) == 2 && s[1].depth == 0 && s[1].calls == 1);
  kith_profile_destroy(&p);
  kith_profile_begin(NULL, "a"); /* a NULL profile is allowed everywhere */
  kith_profile_count(NULL, "a", 1);
  kith_profile_thread(NULL, 0, 0, 1);
  kith_profile_end(NULL);
  const struct kith_counter *c;
  CHECK(kith_profile_stages(NULL, &s) == 0 && kith_profile_counters(NULL, &c) == 0);
  kith_profile_destroy(&p);
}

/* With many stages and counters arrays grow, and keep names and busy times. */
static void check_growth(void) {
  static char name[500][8];
  struct kith_profile *p = NULL;
  CHECK_OK(kith_profile_create(&p, 1, false));
  for (int k = 0; k < 500; ++k) {
    snprintf(name[k], sizeof name[k], "s%d", k);
    kith_profile_begin(p, name[k]);
    kith_profile_count(p, name[k], k);
    kith_profile_thread(p, 0, 0, 1);
    if (k % 2 == 0) kith_profile_end(p);
  }
  const struct kith_stage *s;
  const struct kith_counter *c;
  CHECK(kith_profile_stages(p, &s) == 500 && kith_profile_counters(p, &c) == 500);
  for (int k = 0; k < 500; ++k) {
    CHECK(s[k].imbalance == 1);
    CHECK(c[k].path == s[k].path && strstr(c[k].path, c[k].name) != NULL);
  }
  CHECK(s[499].depth == 249);
  kith_profile_destroy(&p);
}

static void check_trace(void) {
  char text[1 << 14] = "";
  FILE *file = fmemopen(text, sizeof text, "w");
  struct kith_profile *p = some_steps(true);
  fputc('[', file);
  kith_profile_write_events(p, 0, file);
  fputc(']', file);
  fclose(file);
  CHECK(is_json(text));
  /* Each of 11 ended stages, 3 open ones and 3 busy times of the second thread is there once. */
  CHECK(occurrences(text, "\"ph\":\"X\"") == 17 && occurrences(text, "\"ph\":\"M\"") == 3);
  CHECK(occurrences(text, "\"tid\":1,\"ts\"") == 3 && occurrences(text, "\"dur\"") == 17);
  CHECK(occurrences(text, "\"path\":\"step/connectivity/rows\"") == 6);
  kith_profile_destroy(&p);
}

/* A stage that only another process has entered: it has no calls until this process enters it, too. */
static void check_added(void) {
  struct kith_profile *p = NULL;
  const struct kith_stage *s;
  CHECK_OK(kith_profile_create(&p, 1, false));
  kith_profile_begin(p, "step");
  kith_profile_end(p);
  for (int k = 0; k < 2; ++k) CHECK_OK(kith_profile_add(p, "step/cull/far"));
  CHECK_OK(kith_profile_add(p, "step"));
  CHECK(kith_profile_stages(p, &s) == 3 && strcmp(s[2].path, "step/cull/far") == 0);
  CHECK(strcmp(s[2].name, "far") == 0 && s[2].calls == 0 && s[2].parent == 1 && s[0].calls == 1);
  kith_profile_begin(p, "step");
  kith_profile_begin(p, "cull");
  CHECK(kith_profile_stages(p, &s) == 3 && s[1].calls == 1);
  kith_profile_destroy(&p);
}

/* A trace holds 2^18 events at most, and tells how many more there were. */
static void check_bounded(void) {
  struct kith_profile *p = NULL;
  char *text = NULL;
  size_t size = 0;
  FILE *file = open_memstream(&text, &size);
  CHECK_OK(kith_profile_create(&p, 1, true));
  for (int k = 0; k < (1 << 18) + 5; ++k) kith_profile_begin(p, "a"), kith_profile_end(p);
  kith_profile_write_events(p, 0, file);
  fclose(file);
  CHECK(occurrences(text, "\"ph\":\"X\"") == 1 << 18);
  const char *last = strrchr(text, '\n'); /* each event has a line */
  CHECK(last != NULL && last[-1] == ',' && is_json(last + 1));
  CHECK(last != NULL && strstr(last, "\"name\":\"left_out\",\"args\":{\"events\":5}") != NULL);
  free(text);
  kith_profile_destroy(&p);
}

/* Events of two processes in one array; times count from the origin, and those of the trace are those of the
 * stage, although it began before the alignment. */
static void check_processes(void) {
  struct kith_profile *p = NULL;
  char text[4096] = "";
  FILE *file = fmemopen(text, sizeof text, "w");
  CHECK_OK(kith_profile_create(&p, 1, true));
  spin(0.01);
  const double before = kith_seconds();
  spin(0.01);
  kith_profile_align(p, before);
  kith_profile_begin_since(p, "a", before);
  kith_profile_end(p);
  const struct kith_stage *s;
  CHECK(kith_profile_stages(p, &s) == 1 && s[0].seconds >= 0.01);
  fprintf(file, "[");
  kith_profile_write_events(p, 3, file);
  fprintf(file, ",");
  kith_profile_write_events(p, 4, file);
  fprintf(file, "]");
  fclose(file);
  CHECK(is_json(text) && occurrences(text, "\"pid\":3") == 3 && occurrences(text, "\"pid\":4") == 3);
  const char *start = strstr(text, "\"ts\":"), *length = strstr(text, "\"dur\":");
  CHECK(start != NULL && atof(start + 5) == 0);
  CHECK(length != NULL && fabs(atof(length + 6) - 1e6 * s[0].seconds) <= 0.001); /* of three digits */
  kith_profile_destroy(&p);
}

int main(void) {
  check_tree();
  check_unbalanced();
  check_growth();
  check_trace();
  check_added();
  check_bounded();
  check_processes();
  return check_failed();
}
