/* test_cells.c - the grid of cells: numbers of cells, cells of positions (also on faces and outside), and
 * neighboring cells. Oracle: brute force over all cells, with boxes and integer arithmetic. Also boxes that
 * are joined. */
#include "lib/domain/cells.h"

#include <stdlib.h>

#include "tests/check.h"
#include "tests/unit/lib/domain/cell_box.h"

enum { SHIFTS = NDIM == 1 ? 3 : NDIM == 2 ? 9 : 27 };

static void fill(double *x, double value) {
  for (int a = 0; a < NDIM; ++a) x[a] = value;
}

/* A grid of unit cells. */
static struct kith_cells grid(const int *count, const bool *periodic) {
  double lower[NDIM], upper[NDIM];
  for (int a = 0; a < NDIM; ++a) lower[a] = -1, upper[a] = count[a] - 1;
  struct kith_cells cells = {0};
  CHECK_OK(kith_cells_init(&cells, lower, upper, periodic, 1, 1 << 20));
  for (int a = 0; a < NDIM; ++a) CHECK(cells.count[a] == count[a]);
  return cells;
}

static void test_counts(void) {
  double lower[NDIM], upper[NDIM];
  const bool periodic[NDIM] = {false};
  struct kith_cells cells = {0};
  fill(lower, 0);
  fill(upper, 1);
  for (int m = 1; m <= 1000; ++m) { /* 1 / (1 / m) may be rounded to below m */
    const double edge = 1.0 / m;
    CHECK_OK(kith_cells_init(&cells, lower, upper, periodic, edge, INT32_MAX));
    CHECK(cells.count[0] == m);
    if (check_failures > 3) return;
  }
  CHECK_OK(kith_cells_init(&cells, lower, upper, periodic, 0.1, INT32_MAX));
  CHECK(cells.count[0] == 10);
  uint64_t random = 1;
  for (int k = 0; k < 1000; ++k) { /* edges are in [edge, 2 edge), and fill the box up to rounding */
    const double edge = 0.02 + 0.5 * check_random(&random);
    CHECK_OK(kith_cells_init(&cells, lower, upper, periodic, edge, INT32_MAX));
    CHECK(cells.edge[0] >= edge * (1 - 1e-8) && cells.edge[0] < 2 * edge);
    CHECK_CLOSE(cells.edge[0] * (double)cells.count[0], 1, 1e-14);
  }
  CHECK_OK(kith_cells_init(&cells, lower, upper, periodic, 7, INT32_MAX)); /* a box thinner than a cell */
  CHECK(cells.n == 1 && cells.edge[0] == 1);
  CHECK_OK(kith_cells_init(&cells, lower, upper, periodic, INFINITY, INT32_MAX));
  CHECK(cells.n == 1);
  for (int64_t most = 1; most < 5000; most = 3 * most + 1) {
    CHECK_OK(kith_cells_init(&cells, lower, upper, periodic, 1e-200, most));
    CHECK(cells.n <= most && 4 * NDIM * cells.n >= most); /* a cube: at worst the next lower power */
  }
}

static void test_bad_input(void) {
  double lower[NDIM], upper[NDIM];
  const bool periodic[NDIM] = {false};
  struct kith_cells cells = {0};
  fill(lower, 0);
  fill(upper, 1);
  const double bad_edges[] = {0, -1, NAN};
  for (int k = 0; k < 3; ++k)
    CHECK_STATUS(KITH_BAD_INPUT, kith_cells_init(&cells, lower, upper, periodic, bad_edges[k], 100));
  CHECK_STATUS(KITH_BAD_INPUT, kith_cells_init(&cells, lower, upper, periodic, 0.1, 0));
  CHECK_STATUS(KITH_BAD_INPUT, kith_cells_init(&cells, lower, upper, periodic, 0.1, INT64_C(1) << 40));
  const double bad_uppers[] = {0, -1, NAN, INFINITY};
  for (int k = 0; k < 4; ++k) {
    upper[NDIM - 1] = bad_uppers[k];
    CHECK_STATUS(KITH_BAD_INPUT, kith_cells_init(&cells, lower, upper, periodic, 0.1, 100));
  }
  CHECK(cells.n == 0); /* unchanged */
}

static bool inside(const struct kith_box *box, const double *x, const struct kith_cells *cells) {
  for (int a = 0; a < NDIM; ++a)
    if (x[a] < box->lower[a] || x[a] > box->upper[a] || (x[a] == box->upper[a] && x[a] < cells->upper[a]))
      return false;
  return true;
}

/* Exactly one cell contains a position, and it is the one that is found: at random places, on all faces, and
 * one rounding beside them. */
static void test_unique(void) {
  const bool periodic[NDIM] = {true};
  double lower[NDIM], upper[NDIM];
  for (int a = 0; a < NDIM; ++a) lower[a] = -0.7 + 0.1 * a, upper[a] = 0.9 + 0.3 * a;
  struct kith_cells cells;
  CHECK_OK(kith_cells_init(&cells, lower, upper, periodic, 0.3, 1000));
  uint64_t random = 7;
  for (int k = 0; k < 3000; ++k) {
    double x[NDIM];
    for (int a = 0; a < NDIM; ++a) {
      x[a] = lower[a] + (upper[a] - lower[a]) * check_random(&random);
      const int64_t face = (int64_t)(check_random(&random) * (double)(cells.count[a] + 1));
      if (k % 4 > 0) x[a] = kith_cells_face(&cells, a, face);
      if (k % 4 == 2) x[a] = nextafter(x[a], -INFINITY);
      if (k % 4 == 3) x[a] = nextafter(x[a], INFINITY);
      x[a] = KITH_MIN(KITH_MAX(x[a], lower[a]), a == 0 ? nextafter(upper[a], lower[a]) : upper[a]);
    }
    int owners = 0;
    for (int64_t c = 0; c < cells.n; ++c) {
      const struct kith_box box = cell_box(&cells, c);
      if (!inside(&box, x, &cells)) continue;
      ++owners;
      CHECK(kith_cells_of(&cells, x) == c);
    }
    CHECK(owners == 1);
  }
}

/* Beyond the end of an axis positions are wrapped if it is periodic, and clamped if it is open. */
static void test_outside(void) {
  const struct {
    double x;
    int64_t clamped, wrapped;
  } cases[] = {{-1, 0, 0},    {3, 3, 0},          {-1.5, 0, 3},       {nextafter(-1, -2), 0, 3},
               {5.5, 3, 2},   {-40.5, 0, 0},      {1e300, 3, -2},     {-1e300, 0, -2},
               {NAN, -1, -1}, {INFINITY, -1, -1}, {-INFINITY, -1, -1}};
  for (int kind = 0; kind < 2 * NDIM; ++kind) {
    const int axis = kind / 2, wraps = kind % 2;
    int count[NDIM];
    bool periodic[NDIM];
    for (int a = 0; a < NDIM; ++a) count[a] = 4 + (a != axis), periodic[a] = (a == axis) == wraps;
    const struct kith_cells cells = grid(count, periodic);
    double x[NDIM];
    const int64_t stride = axis == 0 ? 1 : axis == 1 ? 5 : 25;
    fill(x, -0.5);
    CHECK(kith_cells_of(&cells, x) == 0);
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
      x[axis] = cases[k].x;
      const int64_t wanted = wraps ? cases[k].wrapped : cases[k].clamped, c = kith_cells_of(&cells, x);
      /* -2: so far away that any cell of the row is right */
      CHECK(wanted == -2 ? c >= 0 && c < 4 * stride && c % stride == 0
                         : c == (wanted < 0 ? -1 : wanted * stride));
    }
  }
}

/* Does the image of cell d touch cell c, and is it not c itself? */
static bool touches(const struct kith_cells *cells, int64_t c, int64_t d, const int *shift) {
  int64_t at_c[NDIM], at_d[NDIM];
  kith_grid_place(cells->count, c, at_c);
  kith_grid_place(cells->count, d, at_d);
  bool same = true;
  for (int a = 0; a < NDIM; ++a) {
    const int64_t apart = at_d[a] + shift[a] * cells->count[a] - at_c[a];
    if (apart < -1 || apart > 1 || (shift[a] != 0 && !cells->periodic[a])) return false;
    same = same && apart == 0;
  }
  return !same;
}

static int code_of(const int *shift, int sign) {
  int code = 0;
  for (int a = NDIM - 1; a >= 0; --a) code = 3 * code + 1 + sign * shift[a];
  return code;
}

/* met[c][d][shift] counts what kith_cells_neighbors lists, and must agree with `touches`; of each two
 * neighbors one must be in the forward half of the other. */
static void check_neighbors(const struct kith_cells *cells) {
  const size_t n = (size_t)cells->n;
  int *met = calloc(n * n * SHIFTS, sizeof *met), *forward = calloc(n * n * SHIFTS, sizeof *forward);
  for (size_t c = 0; c < n; ++c) {
    struct kith_cell_image image[KITH_CELL_NEIGHBORS];
    int n_forward = -1;
    const int all = kith_cells_neighbors(cells, (int64_t)c, image, &n_forward);
    for (int k = 0; k < all; ++k) {
      const size_t at = (c * n + (size_t)image[k].cell) * SHIFTS + (size_t)code_of(image[k].shift, 1);
      ++met[at];
      forward[at] += k < n_forward;
    }
  }
  for (size_t c = 0; c < n; ++c)
    for (size_t d = 0; d < n; ++d)
      for (int code = 0; code < SHIFTS; ++code) {
        int shift[NDIM], rest = code;
        for (int a = 0; a < NDIM; ++a, rest /= 3) shift[a] = rest % 3 - 1;
        const bool neighbors = touches(cells, (int64_t)c, (int64_t)d, shift);
        const size_t at = (c * n + d) * SHIFTS + (size_t)code;
        const size_t back = (d * n + c) * SHIFTS + (size_t)code_of(shift, -1);
        CHECK(met[at] == neighbors);
        CHECK(forward[at] + forward[back] == neighbors);
      }
  free(met);
  free(forward);
}

/* All combinations of 1, 2, 3 and 4 cells, periodic or not. */
static void test_neighbors(void) {
  const int kinds = NDIM == 1 ? 8 : NDIM == 2 ? 64 : 512;
  for (int kind = 0; kind < kinds; ++kind) {
    int count[NDIM], rest = kind;
    bool periodic[NDIM];
    for (int a = 0; a < NDIM; ++a, rest /= 8) count[a] = 1 + rest % 4, periodic[a] = rest / 4 % 2;
    const struct kith_cells cells = grid(count, periodic);
    if (cells.n <= 27) check_neighbors(&cells); /* the cost of the oracle is quadratic */
    for (int64_t c = 0; c < cells.n; ++c) {
      int64_t k[NDIM];
      kith_grid_place(cells.count, c, k);
      CHECK(kith_grid_number(cells.count, k) == c);
      for (int a = 0; a < NDIM; ++a)
        for (int side = -1; side <= 1; side += 2) {
          const int64_t d = kith_cells_beside(&cells, c, a, side);
          CHECK(d >= 0 ? kith_cells_beside(&cells, d, a, -side) == c : !periodic[a]);
        }
    }
    if (check_failures > 0) return;
  }
}

/* The forward half comes in the order +x, the three of +y, the nine of +z. With 3 cells along each axis these
 * are all cells after the middle one. */
static void test_half_shell_order(void) {
  int count[NDIM];
  bool periodic[NDIM];
  for (int a = 0; a < NDIM; ++a) count[a] = 3, periodic[a] = false;
  const struct kith_cells cells = grid(count, periodic);
  const int64_t middle = cells.n / 2;
  struct kith_cell_image image[KITH_CELL_NEIGHBORS];
  int n_forward = 0;
  CHECK(kith_cells_neighbors(&cells, middle, image, &n_forward) == KITH_CELL_NEIGHBORS);
  CHECK(n_forward == KITH_CELL_NEIGHBORS / 2);
  for (int k = 0; k < n_forward; ++k) {
    CHECK(image[k].cell == middle + 1 + k);
    CHECK(image[n_forward + k].cell == middle - 1 - k);
  }
}

/* An empty box adds nothing to another one, also if that is empty. */
static void test_empty_boxes(void) {
  const struct kith_box empty = kith_box_empty();
  struct kith_box none = empty, one = empty, other = empty;
  for (int a = 0; a < NDIM; ++a) one.lower[a] = -1 - a, one.upper[a] = 2;
  kith_box_join(&none, &empty);
  kith_box_join(&one, &empty);
  kith_box_join(&other, &one);
  for (int a = 0; a < NDIM; ++a) {
    CHECK(none.lower[a] == INFINITY && none.upper[a] == -INFINITY);
    CHECK(one.lower[a] == -1 - a && one.upper[a] == 2);
    CHECK(other.lower[a] == one.lower[a] && other.upper[a] == one.upper[a]);
  }
}

int main(void) {
  test_counts();
  test_bad_input();
  test_unique();
  test_outside();
  test_neighbors();
  test_half_shell_order();
  test_empty_boxes();
  return check_failed();
}
