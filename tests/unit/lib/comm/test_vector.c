/* test_vector.c - vectors of SUNDIALS over three arrays. Oracles: each operation element by element, and
 * reductions as plain long double sums; the view must be the arrays themselves; sums must not depend on the
 * number of threads. */
#include <omp.h>
#include "lib/comm/vector.h"
#include "tests/check.h"

enum { PARTS = 3, WIDTH = 5 }; /* WIDTH: numbers of an element in all arrays */
static double *array[PARTS];

/* A number between -1 and 1, never 0. */
static double noise(uint64_t *state) {
  *state = *state * 6364136223846793005u + 1442695040888963407u;
  return ((double)(*state >> 11) + 0.5) * 0x1p-52 - 1;
}

static int width(int part) {
  return part == 2 ? 1 : 2;
}

static void create_vectors(int n, struct kith_vectors **set) {
  struct kith_vector_part part[PARTS];
  for (int p = 0; p < PARTS; ++p) {
    array[p] = NULL;
    CHECK_OK(kith_resize(&array[p], 0, (size_t)n * (size_t)width(p) + 1, sizeof(double)));
    part[p] = (struct kith_vector_part){&array[p], (int64_t)n * width(p)};
  }
  CHECK_OK(kith_vectors_create(set, NULL, PARTS, part));
}

static void destroy_vectors(struct kith_vectors **set) {
  kith_vectors_destroy(set);
  for (int p = 0; p < PARTS; ++p) kith_free(&array[p]);
}

static void fill(N_Vector v, int n, uint64_t seed) {
  for (int part = 0; part < PARTS; ++part)
    for (int k = 0; k < n * width(part); ++k) kith_vector_numbers(v, part)[k] = noise(&seed);
}

/* Applies all operations, then checks each element of the results and accumulates what the reductions must
 * return. */
static void operations(int n) {
  struct kith_vectors *set;
  create_vectors(n, &set);
  N_Vector x = kith_vector_clone(set), y = kith_vector_clone(set), z[9];
  for (int k = 0; k < 9; ++k) z[k] = kith_vector_clone(set);
  CHECK(set->bytes == 11 * (size_t)n * WIDTH * sizeof(double) && N_VGetLength(x) == (int64_t)n * WIDTH);
  fill(x, n, 1), fill(y, n, 2);
  double c[] = {0.5, -2, 3};
  N_Vector terms[] = {x, y, x};
  N_VLinearSum(2, x, -3, y, z[0]), N_VConst(7, z[1]), N_VProd(x, y, z[2]), N_VDiv(x, y, z[3]);
  N_VScale(-2, x, z[4]), N_VAbs(x, z[5]), N_VInv(x, z[6]), N_VAddConst(x, 4, z[7]);
  CHECK(N_VLinearCombination(3, c, terms, z[8]) == 0);
  long double dot = 0, squares = 0, magnitudes = 0, largest = 0, least = INFINITY;
  for (int part = 0; part < PARTS; ++part)
    for (int k = 0; k < n * width(part); ++k) {
      const double a = kith_vector_numbers(x, part)[k], b = kith_vector_numbers(y, part)[k];
      const double wanted[] = {2 * a - 3 * b, 7,     a * b, a / b,          -2 * a,
                               fabs(a),       1 / a, a + 4, 3.5 * a - 2 * b};
      /* Each operation rounds once, the linear combination a few times. */
      for (int o = 0; o < 9; ++o)
        CHECK_CLOSE(kith_vector_numbers(z[o], part)[k], wanted[o], 4e-15 * fmax(1, fabs(wanted[o])));
      dot += (long double)a * b, squares += (long double)a * b * a * b, magnitudes += fabsl((long double)a);
      largest = fmaxl(largest, fabsl((long double)a)), least = fminl(least, (long double)a);
    }
  const double length = (double)n * WIDTH;
  CHECK_CLOSE(N_VDotProd(x, y), (double)dot, 1e-15 * length);
  CHECK_CLOSE(N_VL1Norm(x), (double)magnitudes, 1e-15 * length);
  CHECK_CLOSE(N_VWL2Norm(x, y), sqrt((double)squares), 1e-13 * sqrt(length));
  CHECK_CLOSE(N_VWrmsNorm(x, y), n > 0 ? sqrt((double)squares / length) : 0, 1e-13);
  CHECK(N_VMaxNorm(x) == (double)largest && N_VMin(x) == (double)least);
  N_VLinearCombination(3, c, terms, x); /* SUNDIALS allows the result to be the first term */
  for (int part = 0; part < PARTS; ++part)
    for (int k = 0; k < n * width(part); ++k)
      CHECK(kith_vector_numbers(x, part)[k] == kith_vector_numbers(z[8], part)[k]);
  N_VDestroy(x), N_VDestroy(y);
  for (int k = 0; k < 9; ++k) N_VDestroy(z[k]);
  CHECK(set->bytes == 0);
  destroy_vectors(&set);
}

/* The view reads and writes the arrays themselves, also after they have moved in memory. */
static void view_follows_arrays(void) {
  enum { n = 100 };
  struct kith_vectors *set;
  create_vectors(n, &set);
  fill(set->view, n, 3);
  N_Vector copy = N_VClone(set->view);
  N_VScale(1, set->view, copy);
  CHECK(set->bytes == (size_t)n * WIDTH * sizeof(double));
  for (int p = 0; p < PARTS; ++p) {
    double *moved = NULL;
    CHECK_OK(kith_resize(&moved, 0, (size_t)n * (size_t)width(p), sizeof(double)));
    kith_free(&array[p]);
    array[p] = moved;
    CHECK(kith_vector_numbers(set->view, p) == moved);
  }
  N_VScale(2, copy, set->view);
  for (int i = 0; i < n; ++i) CHECK(array[2][i] == 2 * kith_vector_numbers(copy, 2)[i]);
  N_VDestroy(copy);
  destroy_vectors(&set);
}

/* Sums are bitwise identical for 1, 2 and 3 threads. */
static void threads(void) {
  enum { N = 20011 };
  double first[4] = {0};
  struct kith_vectors *set;
  create_vectors(N, &set);
  N_Vector x = kith_vector_clone(set), y = kith_vector_clone(set);
  fill(x, N, 4), fill(y, N, 5);
  for (int n = 1; n <= 3; ++n) {
    omp_set_num_threads(n);
    const double sums[4] = {N_VDotProd(x, y), N_VL1Norm(x), N_VWL2Norm(x, y), N_VWrmsNorm(x, y)};
    for (int k = 0; k < 4; ++k) {
      CHECK(n == 1 || sums[k] == first[k]);
      first[k] = sums[k];
    }
  }
  N_VDestroy(x), N_VDestroy(y);
  destroy_vectors(&set);
}

/* With a NaN, norms are infinite or NaN: a solver must not take it for a small residual. */
static void not_a_number(void) {
  enum { N = 4097 };
  struct kith_vectors *set;
  create_vectors(N, &set);
  N_Vector x = kith_vector_clone(set);
  fill(x, N, 6);
  kith_vector_numbers(x, 1)[N / 2] = NAN;
  CHECK(N_VMaxNorm(x) == INFINITY && N_VMin(x) == -INFINITY);
  CHECK(isnan(N_VDotProd(x, x)) && isnan(N_VL1Norm(x)));
  N_VDestroy(x);
  destroy_vectors(&set);
}

int main(void) {
  static const int sizes[] = {0, 1, 7, 4096, 4097, 9000};
  for (int k = 0; k < 6; ++k) operations(sizes[k]);
  view_follows_arrays();
  threads();
  not_a_number();
  return check_failed();
}
