/* Tables: written, stopped, and continued by a restart. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "lib/io/csv.h"
#include "tests/check.h"

static char path[] = "csv-test-XXXXXX";

static void put(const char *text) {
  FILE *f = fopen(path, "w");
  CHECK(f != NULL && fputs(text, f) >= 0 && fclose(f) == 0);
}

static const char *text(void) {
  static char all[8192];
  FILE *f = fopen(path, "r");
  CHECK(f != NULL);
  all[f != NULL ? fread(all, 1, sizeof all - 1, f) : 0] = '\0';
  if (f != NULL) fclose(f);
  return all;
}

static bool said(const char *words) {
  const bool found = strstr(kith_failure(), words) != NULL;
  if (!found) fprintf(stderr, "no '%s' in: %s\n", words, kith_failure());
  return found;
}

static const char names[] = "step,word,x";

static void add(struct kith_csv_log *log, uint64_t first, uint64_t last) {
  for (uint64_t s = first; s <= last; ++s) {
    fprintf(log->file, "%d,1,%g", (int)s, 0.1 * (double)s);
    CHECK_OK(kith_csv_log_row(log));
  }
}

static void whole(uint64_t last) {
  struct kith_csv_log log;
  CHECK_OK(kith_csv_log_open(&log, ".", path, names, NULL));
  add(&log, 0, last);
  CHECK_OK(kith_csv_log_close(&log));
  CHECK_OK(kith_csv_log_close(&log));
}

/* Stopped at step 9 or while a row was written, restarted from 5: like the table that was never stopped. */
static void restart(const char *torn) {
  char uninterrupted[8192], stopped[8192];
  struct kith_csv_log log;
  whole(12);
  strcpy(uninterrupted, text());
  whole(9);
  snprintf(stopped, sizeof stopped, "%s%s", text(), torn);
  put(stopped);
  CHECK_OK(kith_csv_log_open(&log, ".", path, names, &(uint64_t){5}));
  add(&log, 6, 12);
  CHECK_OK(kith_csv_log_close(&log));
  CHECK(strcmp(uninterrupted, text()) == 0);
}

/* A row that was cut off and would count as an earlier step: 1 of 10. Restarts that keep all, or nothing. */
static void torn_row(void) {
  char expected[8192], torn[8200];
  struct kith_csv_log log;
  whole(9);
  strcpy(expected, text());
  snprintf(torn, sizeof torn, "%s1", expected);
  put(torn);
  CHECK_OK(kith_csv_log_open(&log, ".", path, names, &(uint64_t){20}));
  CHECK_OK(kith_csv_log_close(&log));
  CHECK(strcmp(expected, text()) == 0);
  put("step,word,x\n7,1,1\n");
  CHECK_OK(kith_csv_log_open(&log, ".", path, names, &(uint64_t){6}));
  CHECK_OK(kith_csv_log_close(&log));
  CHECK(strcmp(text(), "step,word,x\n") == 0);
}

static void strange(void) {
  const uint64_t step = 5;
  struct kith_csv_log log;
  unlink(path);
  for (int k = 0; k < 2; ++k) { /* not there; empty */
    CHECK_OK(kith_csv_log_open(&log, ".", path, names, &step));
    CHECK_OK(kith_csv_log_close(&log));
    CHECK(strcmp(text(), "step,word,x\n") == 0);
    put("");
  }
  static const char *const others[] = {"a,b\n1,2\n",    "step,word\n1,2\n", "step,word,x,y\n",
                                       "word,step,x\n", "word,stepx\n",     "word\n"};
  for (size_t k = 0; k < sizeof others / sizeof *others; ++k) {
    put(others[k]);
    CHECK(kith_csv_log_open(&log, ".", path, names, &step) == KITH_BAD_FILE &&
          said("its columns are not step,word,x"));
    CHECK(log.file == NULL && strcmp(text(), others[k]) == 0);
  }
  CHECK_STATUS(KITH_BAD_FILE, kith_csv_log_open(&log, "no/such", "a.csv", names, NULL));
  CHECK_STATUS(KITH_BAD_FILE,
               kith_csv_log_open(&log, "no/such", "a.csv", names, &step)); /* cannot be begun */
  CHECK_STATUS(KITH_BAD_FILE, kith_csv_log_open(&log, "/dev", "full", names, NULL));
  CHECK(log.file == NULL);
  CHECK_OK(kith_csv_log_close(&log));
}

int main(void) {
  CHECK(mkstemp(path) >= 0);
  restart("");
  restart("10,1,0.");
  torn_row();
  strange();
  unlink(path);
  return check_failed();
}
