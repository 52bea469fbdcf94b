/* test_lanes.c - transposition of four records, and separations of the nodes of a row, for rows of any
 * length. Oracle: plain indexing. */
#include "lib/core/lanes.h"
#include "tests/check.h"

static void transposes(void) {
  static const int order[] = {3, 0, 2, 1};
  double record[4][4];
  const double *from[4];
  kith_lanes to[4];
  for (int k = 0; k < 16; ++k) record[k / 4][k % 4] = 10 * (k / 4) + k % 4;
  for (int l = 0; l < 4; ++l) from[l] = record[order[l]];
  kith_lanes_transpose(from, to);
  for (int q = 0; q < 4; ++q)
    for (int l = 0; l < 4; ++l) CHECK(to[q][l] == record[order[l]][q]);
}

/* Rows of 0 to 9 nodes, also with the last node of the field, which is allocated as fields of nodes are. All
 * values are small integers, so equality is exact. */
static void separations(void) {
  enum { NODES = 7, STRIDE = 16 };
  static const kith_index row[] = {6, 0, 3, 3, 5, 1, 6, 2, 6};
  double *field = NULL, *to = NULL;
  CHECK_OK(kith_resize(&field, 0, NODES + 1, NDIM * sizeof *field));
  for (int k = 0; k < NODES * NDIM; ++k) field[k] = 100 + k;
  CHECK_OK(kith_resize(&to, 0, (NDIM + 1) * STRIDE, sizeof *to));
  for (size_t n = 0; n <= sizeof row / sizeof *row; ++n) {
    kith_lanes_separations(field, 4, row, NULL, NULL, n, to, STRIDE, to + NDIM * STRIDE);
    for (size_t k = 0; k < kith_lanes_padded(n); ++k) {
      const double apart = NDIM * (row[KITH_MIN(k, n - 1)] - 4); /* the difference along each axis */
      for (int a = 0; a < NDIM; ++a) CHECK(to[a * STRIDE + k] == apart);
      CHECK(to[NDIM * STRIDE + k] == NDIM * apart * apart);
    }
  }
  KITH_FREE(&field, &to);
}

int main(void) {
  transposes();
  separations();
  return check_failed();
}
