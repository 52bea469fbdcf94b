/* solve.h - for tests: a linear system by elimination, unlike the inverses of the library. */
#ifndef KITH_TESTS_SOLVE_H
#define KITH_TESTS_SOLVE_H

#include <math.h>

/* Solves A y = b for m right-hand sides b[.][c], by elimination with pivots; overwrites A and b. */
static inline void truth_solve(int n, double a[n][n], int m, double b[n][m]) {
  for (int c = 0; c < n; ++c) {
    int pivot = c;
    for (int r = c + 1; r < n; ++r)
      if (fabs(a[r][c]) > fabs(a[pivot][c])) pivot = r;
    for (int k = 0; k < n; ++k) {
      const double t = a[c][k];
      a[c][k] = a[pivot][k], a[pivot][k] = t;
    }
    for (int k = 0; k < m; ++k) {
      const double t = b[c][k];
      b[c][k] = b[pivot][k], b[pivot][k] = t;
    }
    for (int r = 0; r < n; ++r) {
      if (r == c) continue;
      const double f = a[r][c] / a[c][c];
      for (int k = 0; k < n; ++k) a[r][k] -= f * a[c][k];
      for (int k = 0; k < m; ++k) b[r][k] -= f * b[c][k];
    }
  }
  for (int r = 0; r < n; ++r)
    for (int k = 0; k < m; ++k) b[r][k] /= a[r][r];
}

#endif
