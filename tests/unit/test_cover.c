/* Covers: every pair of values of two factors occurs, counted here; and they are few. */
#include "app/validate_cover.h"

#include <string.h>

#include "tests/check.h"

/* At least as many rows as the two largest factors have pairs, at most half as many again (what a greedy cover of these takes). */
static void check_cover(int n, const int *count) {
  int *row = NULL, *again = NULL, rows = 0, rows_again = 0, largest = 0, second = 0;
  CHECK_OK(kith_cover(n, count, &row, &rows));
  CHECK_OK(kith_cover(n, count, &again, &rows_again));
  CHECK(rows == rows_again && memcmp(row, again, (size_t)(rows * n) * sizeof *row) == 0);
  for (int k = 0; k < rows * n; ++k) CHECK(row[k] >= 0 && row[k] < count[k % n]);
  for (int f = 0; f < n; ++f)
    for (int g = f + 1; g < n; ++g)
      for (int pair = 0; pair < count[f] * count[g]; ++pair) {
        bool met = false;
        for (int r = 0; r < rows; ++r)
          met = met || (row[r * n + f] == pair / count[g] && row[r * n + g] == pair % count[g]);
        CHECK(met);
      }
  for (int f = 0; f < n; ++f) {
    if (count[f] > largest)
      second = largest, largest = count[f];
    else
      second = KITH_MAX(second, count[f]);
  }
  CHECK(rows >= largest * second && 2 * rows <= 3 * largest * second);
  kith_free(&row);
  kith_free(&again);
}

int main(void) {
  int *row = NULL, rows = 0;
  const int few[] = {3}, many[9] = {1, 1, 1, 1, 1, 1, 1, 1, 1};
  CHECK_STATUS(KITH_BAD_INPUT, kith_cover(1, few, &row, &rows));
  CHECK_STATUS(KITH_BAD_INPUT, kith_cover(9, many, &row, &rows));
  check_cover(2, (const int[]){3, 4});
  check_cover(2, (const int[]){1, 1});
  check_cover(3, (const int[]){1, 5, 1});
  check_cover(5, (const int[]){13, 6, 2, 9, 3});
  check_cover(8, (const int[]){2, 2, 7, 2, 2, 2, 2, 6});
  return check_failed();
}
