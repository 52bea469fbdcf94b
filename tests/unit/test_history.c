/* The history: what is written, and how a restart continues it. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "app/history.h"
#include "tests/check.h"

static char path[] = "history-test-XXXXXX";

static void add(struct kith_history *h, uint64_t first, uint64_t last) {
  for (uint64_t s = first; s <= last; ++s) {
    struct kith_history_row row = {.step = s,
                                   .time = (double)s / 10,
                                   .dt = 0.1,
                                   .limiter = "courant",
                                   .kinetic = 1,
                                   .internal = 2,
                                   .potential = -4,
                                   .work = 0.5,
                                   .nodes = 8,
                                   .ghosts = 4,
                                   .entries = 100,
                                   .rebuilds = 1,
                                   .seconds = 0.5};
    row.momentum[0] = -3;
    row.angular[0] = 5, row.angular[1] = 6, row.angular[2] = 7, row.velocity_over_sound = 0.25;
    CHECK_OK(kith_history_add(h, &row));
  }
}

static const char *text(void) {
  static char all[8192];
  FILE *f = fopen(path, "r");
  CHECK(f != NULL);
  all[f != NULL ? fread(all, 1, sizeof all - 1, f) : 0] = '\0';
  if (f != NULL) fclose(f);
  return all;
}

static void write_text(const char *s) {
  FILE *f = fopen(path, "w");
  CHECK(f != NULL && fputs(s, f) >= 0 && fclose(f) == 0);
}

static void whole_run(uint64_t last) {
  struct kith_history *h = NULL;
  CHECK_OK(kith_history_open(&h, path));
  add(h, 0, last);
  CHECK_OK(kith_history_close(&h));
  CHECK(h == NULL);
}

static void format(void) {
  static const char *const row =
      NDIM == 1
          ? "\n2,0.20000000000000001,0.10000000000000001,courant,1,2,-4,0.5,-1.5,-3,0.25,8,4,100,1,0.5\n"
      : NDIM == 2
          ? "\n2,0.20000000000000001,0.10000000000000001,courant,1,2,-4,0.5,-1.5,-3,0,7,0.25,8,4,100,1,0.5\n"
          : "\n2,0.20000000000000001,0.10000000000000001,courant,1,2,-4,0.5,-1.5,-3,0,0,5,6,7,0.25,8,4,100,1,0.5\n";
  int title = 0, commas = 0;
  whole_run(2);
  CHECK(strncmp(text(), "step,time,dt,limiter,", 21) == 0 && strstr(text(), row) != NULL);
  for (const char *s = text(); *s != '\n'; ++s) title += *s == ',';
  for (const char *s = row + 1; *s != '\n'; ++s) commas += *s == ',';
  CHECK(title == commas);
}

/* Stopped at step 9 or in the midst of writing a row, restarted from 5: like the run that was never stopped.
 */
static void restart(const char *torn) {
  char uninterrupted[8192], stopped[8192];
  struct kith_history *h = NULL;
  whole_run(12);
  strcpy(uninterrupted, text());
  whole_run(9);
  snprintf(stopped, sizeof stopped, "%s%s", text(), torn);
  write_text(stopped);
  CHECK_OK(kith_history_continue(&h, path, 5));
  add(h, 6, 12);
  CHECK_OK(kith_history_close(&h));
  CHECK(strcmp(uninterrupted, text()) == 0);
}

/* A row that was cut and would count as an earlier step: 1 of 10. */
static void torn_row(void) {
  char expected[8192];
  struct kith_history *h = NULL;
  whole_run(9);
  strcpy(expected, text());
  FILE *f = fopen(path, "a");
  CHECK(f != NULL && fputs("1", f) >= 0 && fclose(f) == 0);
  CHECK_OK(kith_history_continue(&h, path, 20));
  CHECK_OK(kith_history_close(&h));
  CHECK(strcmp(expected, text()) == 0);
}

static void strange(void) {
  struct kith_history *h = NULL;
  char title[256];
  whole_run(0);
  snprintf(title, sizeof title, "%.*s", (int)(strchr(text(), '\n') - text() + 1), text());
  unlink(path);
  CHECK_OK(kith_history_continue(&h, path, 5)); /* not there */
  CHECK_OK(kith_history_close(&h));
  CHECK(strcmp(text(), title) == 0);
  write_text("");
  CHECK_OK(kith_history_continue(&h, path, 5));
  CHECK_OK(kith_history_close(&h));
  CHECK(strcmp(text(), title) == 0);
  write_text("a,b\n1,2\n");
  CHECK_STATUS(KITH_BAD_FILE, kith_history_continue(&h, path, 5));
  CHECK(h == NULL && strcmp(text(), "a,b\n1,2\n") == 0);
  CHECK_STATUS(KITH_BAD_FILE, kith_history_open(&h, "no/such/history.csv"));
  CHECK_STATUS(KITH_BAD_FILE,
               kith_history_continue(&h, "no/such/history.csv", 1)); /* no directory: cannot begin */
  CHECK_STATUS(KITH_BAD_FILE, kith_history_open(&h, "/dev/full"));
  CHECK(h == NULL);
  CHECK_OK(kith_history_close(&h));
}

int main(void) {
  CHECK(mkstemp(path) >= 0);
  format();
  restart("");
  restart("10,1,0.1,cour");
  torn_row();
  strange();
  unlink(path);
  return check_failed();
}
