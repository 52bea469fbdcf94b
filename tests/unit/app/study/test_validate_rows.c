/* test_validate_rows.c - groups of rows of a validation suite: in the shipped suite of ranks, every two
 * values of two factors occur in one run (a covering array), which is counted here. */
#include <string.h>
#include "app/study/validate_rows.h"
#include "tests/check.h"

enum { FACTORS = 5, MOST_ROWS = 400 };

/* The values of all factors in one run: the row it is compared with, ranks, threads, and settings. */
struct combination {
  char value[FACTORS][KITH_JOB_LABEL];
};

static void read_combination(const struct kith_row *row, struct combination *c) {
  char words[sizeof row->varied], *rest = words;
  memset(c, 0, sizeof *c);
  snprintf(c->value[0], sizeof c->value[0], "%s", row->like);
  memcpy(words, row->varied, sizeof words);
  for (int f = 1; f < FACTORS && *rest != '\0'; ++f) {
    const size_t length = strcspn(rest, " ");
    snprintf(c->value[f], sizeof c->value[f], "%.*s", (int)length, rest);
    rest += length + (rest[length] == ' ');
  }
}

/* Any value of f that occurs must occur together with any value of g that occurs. Returns the number of
 * pairs. */
static int check_pairs(const struct combination *run, int n, int f, int g) {
  int pairs = 0;
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      bool met = false;
      for (int k = 0; k < n; ++k)
        met |= strcmp(run[k].value[f], run[a].value[f]) == 0 && strcmp(run[k].value[g], run[b].value[g]) == 0;
      if (!met) fprintf(stderr, "%s and %s never meet\n", run[a].value[f], run[b].value[g]);
      CHECK(met);
      pairs += met;
    }
  return pairs;
}

/* Runs of a group begin with its first row and end with its last. */
static void check_group(const struct kith_row *rows, int n_rows, const char *first, const char *last,
                        int n_wanted) {
  static struct combination run[MOST_ROWS];
  bool inside = false;
  int n = 0;
  for (int k = 0; k < n_rows && n < MOST_ROWS; ++k) {
    inside |= strcmp(rows[k].job.label, first) == 0;
    if (inside && rows[k].like[0] != '\0') read_combination(&rows[k], &run[n++]);
    if (inside && k + 1 < n_rows && strcmp(rows[k].like, last) == 0 && strcmp(rows[k + 1].like, last) != 0)
      break;
  }
  CHECK(n == n_wanted);
  for (int f = 0; f < FACTORS; ++f)
    for (int g = f + 1; g < FACTORS; ++g) check_pairs(run, n, f, g);
}

int main(void) {
  struct kith_programs programs;
  struct kith_row *rows = NULL;
  int n = 0;
  char path[KITH_PATH + 32];
  CHECK_OK(kith_programs_find(&programs));
  snprintf(path, sizeof path, "%s/validation/ranks.yaml", programs.inputs);
  CHECK_OK(kith_rows_read_file(&rows, &n, path, &programs));
  CHECK(n >= 279);
  check_group(rows, n, "sod-1d", "materials-3d", 14 * 9);
  check_group(rows, n, "one-sod-1d", "one-materials-3d", 14 * 3);
  check_group(rows, n, "default-sod-1d", "default-no-cull", 15 * 5);
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < k; ++j) CHECK(strcmp(rows[k].job.label, rows[j].job.label) != 0);
  kith_free(&rows);
  return check_failed();
}
