/* test_csv.c - tables in CSV files that a restart continues. Oracle: the table of a run that was never
 * stopped. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "lib/io/csv.h"
#include "tests/unit/files.h"

static char path[] = "csv-test-XXXXXX";

static const char *read_text(void) {
  static char all[8192];
  all[load(path, all, sizeof all - 1)] = '\0';
  return all;
}

static const char names[] = "step,word,x";

static void add(struct kith_csv_log *log, uint64_t first, uint64_t last) {
  for (uint64_t s = first; s <= last; ++s) {
    fprintf(log->file, "%d,1,%g", (int)s, 0.1 * (double)s);
    CHECK_OK(kith_csv_log_row(log));
  }
}

static void write_table(uint64_t last) {
  struct kith_csv_log log;
  CHECK_OK(kith_csv_log_open(&log, ".", path, names, NULL));
  add(&log, 0, last);
  CHECK_OK(kith_csv_log_close(&log));
  CHECK_OK(kith_csv_log_close(&log));
}

/* A run that stopped at step 9, perhaps while it wrote a row, and restarts from step 5 has the table of a run
 * that was never stopped. */
static void restart(const char *torn) {
  char uninterrupted[8192], stopped[8192];
  struct kith_csv_log log;
  write_table(12);
  strcpy(uninterrupted, read_text());
  write_table(9);
  snprintf(stopped, sizeof stopped, "%s%s", read_text(), torn);
  write_text(path, stopped);
  CHECK_OK(kith_csv_log_open(&log, ".", path, names, &(uint64_t){5}));
  add(&log, 6, 12);
  CHECK_OK(kith_csv_log_close(&log));
  CHECK(strcmp(uninterrupted, read_text()) == 0);
}

/* A row that was cut off, and looks like an earlier step (1 of 10), is removed; restarts may keep all rows or
 * none. */
static void torn_row(void) {
  char expected[8192], torn[8200];
  struct kith_csv_log log;
  write_table(9);
  strcpy(expected, read_text());
  snprintf(torn, sizeof torn, "%s1", expected);
  write_text(path, torn);
  CHECK_OK(kith_csv_log_open(&log, ".", path, names, &(uint64_t){20}));
  CHECK_OK(kith_csv_log_close(&log));
  CHECK(strcmp(expected, read_text()) == 0);
  write_text(path, "step,word,x\n7,1,1\n");
  CHECK_OK(kith_csv_log_open(&log, ".", path, names, &(uint64_t){6}));
  CHECK_OK(kith_csv_log_close(&log));
  CHECK(strcmp(read_text(), "step,word,x\n") == 0);
}

static void unusual_files(void) {
  const uint64_t step = 5;
  struct kith_csv_log log;
  unlink(path);
  for (int k = 0; k < 2; ++k) { /* the file is missing; it is empty */
    CHECK_OK(kith_csv_log_open(&log, ".", path, names, &step));
    CHECK_OK(kith_csv_log_close(&log));
    CHECK(strcmp(read_text(), "step,word,x\n") == 0);
    write_text(path, "");
  }
  static const char *const unfinished[] = {"step,word,x", "st"}; /* the line of names */
  for (size_t k = 0; k < sizeof unfinished / sizeof *unfinished; ++k) {
    write_text(path, unfinished[k]);
    CHECK_OK(kith_csv_log_open(&log, ".", path, names, &step));
    CHECK_OK(kith_csv_log_close(&log));
    CHECK(strcmp(read_text(), "step,word,x\n") == 0);
  }
  static const char *const others[] = {"a,b\n1,2\n",    "step,word\n1,2\n", "step,word,x,y\n",
                                       "word,step,x\n", "word,stepx\n",     "word\n"};
  for (size_t k = 0; k < sizeof others / sizeof *others; ++k) {
    write_text(path, others[k]);
    CHECK(kith_csv_log_open(&log, ".", path, names, &step) == KITH_BAD_FILE &&
          check_says("its columns are not step,word,x"));
    CHECK(log.file == NULL && strcmp(read_text(), others[k]) == 0);
  }
  CHECK_STATUS(KITH_BAD_FILE, kith_csv_log_open(&log, "no/such", "a.csv", names, NULL));
  /* a table in a missing directory cannot be created either */
  CHECK_STATUS(KITH_BAD_FILE, kith_csv_log_open(&log, "no/such", "a.csv", names, &step));
  CHECK_STATUS(KITH_BAD_FILE, kith_csv_log_open(&log, "/dev", "full", names, NULL));
  CHECK(log.file == NULL);
  CHECK_OK(kith_csv_log_close(&log));
}

int main(void) {
  CHECK(mkstemp(path) >= 0);
  restart("");
  restart("10,1,0.");
  torn_row();
  unusual_files();
  unlink(path);
  return check_failed();
}
