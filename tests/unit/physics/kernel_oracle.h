/* kernel_oracle.h - the oracle for kernels, from other definitions than those of the library: B-splines by de
 * Boor's recurrence, Wendland functions by their integral operator I f(r) = int_r^1 t f(t) dt, constants by
 * quadrature, ideal lattices from their basis vectors. */
#ifndef KITH_TEST_PHYSICS_KERNEL_ORACLE_H
#define KITH_TEST_PHYSICS_KERNEL_ORACLE_H

#include <gsl/gsl_integration.h>
#include <math.h>
#include "physics/kernel.h"
#include "tests/unit/solve.h"

/* M_n(x), the centered cardinal B-spline of order n, from M_(n - 1). */
static inline double oracle_bspline(int n, double x) {
  if (x < -0.5 * n || x >= 0.5 * n) return 0; /* half open: each point is in one interval of order 1 */
  if (n == 1) return 1;
  return ((0.5 * n + x) * oracle_bspline(n - 1, x + 0.5) + (0.5 * n - x) * oracle_bspline(n - 1, x - 0.5)) /
         (n - 1);
}

enum { ORACLE_TERMS = 16 };
struct oracle_kernel {
  int order;                                    /* of the B-spline; 0: Wendland */
  long double w[ORACLE_TERMS], g[ORACLE_TERMS]; /* Wendland: coefficients of w and of w' / q */
  double unit;             /* B-spline: w = unit M_n(n q / 2) is (1 - q)^(n - 1) close to q = 1 */
  double constant, spread; /* C, H / (2 sigma) */
};

/* p <- int_r^1 t p(t) dt. */
static inline void oracle_integrate(long double *p) {
  long double q[ORACLE_TERMS] = {0};
  for (int k = 0; k + 2 < ORACLE_TERMS; ++k) q[0] += p[k] / (k + 2), q[k + 2] -= p[k] / (k + 2);
  for (int k = 0; k < ORACLE_TERMS; ++k) p[k] = q[k];
}

static inline double oracle_polynomial(const long double *p, double x) {
  long double sum = 0;
  for (int k = ORACLE_TERMS - 1; k >= 0; --k) sum = sum * x + p[k];
  return (double)sum;
}

static inline double oracle_w(const struct oracle_kernel *k, double q) {
  if (q >= 1) return 0;
  return k->order > 0 ? k->unit * oracle_bspline(k->order, 0.5 * k->order * q) : oracle_polynomial(k->w, q);
}

/* Returns w'(q) / q; 0 at q = 0, where it is only multiplied by a separation of 0. */
static inline double oracle_g(const struct oracle_kernel *k, double q) {
  if (q >= 1 || q == 0) return 0;
  if (k->order == 0) return oracle_polynomial(k->g, q);
  const double x = 0.5 * k->order * q;
  return 0.5 * k->order / q * k->unit *
         (oracle_bspline(k->order - 1, x + 0.5) - oracle_bspline(k->order - 1, x - 0.5));
}

/* The surface of the unit sphere. */
static inline double oracle_sphere(void) {
  return NDIM == 1 ? 2 : NDIM == 2 ? 2 * M_PI : 4 * M_PI;
}

/* Integral of f(q) q^power over [0, 1] by Gauss-Legendre quadrature on 30 pieces. All knots (1/2, 3/5, 1/5,
 * 2/3, 1/3) are between pieces, so that it is exact for the polynomials of the kernels. */
static inline double oracle_quadrature(double (*f)(const void *context, double q), const void *context,
                                       int power) {
  gsl_integration_glfixed_table *table = gsl_integration_glfixed_table_alloc(10);
  double sum = 0, q, weight;
  for (int piece = 0; piece < 30; ++piece)
    for (size_t p = 0; p < 10; ++p) {
      gsl_integration_glfixed_point(piece / 30.0, (piece + 1) / 30.0, p, &q, &weight, table);
      sum += weight * f(context, q) * pow(q, power);
    }
  gsl_integration_glfixed_table_free(table);
  return sum;
}

static inline double oracle_w_of(const void *kernel, double q) {
  return oracle_w(kernel, q);
}

static inline struct oracle_kernel oracle_kernel(enum kith_kernel kernel) {
  struct oracle_kernel k = {0};
  const int smoothness = (int)kernel - KITH_KERNEL_wendland_c2 + 1; /* 1, 2, 3 for C2, C4, C6 */
  if (smoothness < 1) {
    k.order = (int)kernel - KITH_KERNEL_cubic + 4;
    k.unit = 1;
    for (int f = 1; f < k.order; ++f) k.unit *= f / (0.5 * k.order);
  } else {
    const int power = NDIM / 2 + smoothness + 1;
    k.w[0] = 1;
    for (int f = 0; f < power; ++f)
      for (int c = f + 1; c > 0; --c) k.w[c] -= k.w[c - 1];
    for (int f = 0; f < smoothness; ++f) {
      for (int c = 0; c < ORACLE_TERMS; ++c) k.g[c] = -k.w[c]; /* d/dr I f = - r f */
      oracle_integrate(k.w);
    }
    const long double at_zero = k.w[0];
    for (int c = 0; c < ORACLE_TERMS; ++c) k.w[c] /= at_zero, k.g[c] /= at_zero;
  }
  const double mass = oracle_quadrature(oracle_w_of, &k, NDIM - 1),
               inertia = oracle_quadrature(oracle_w_of, &k, NDIM + 1);
  k.constant = 1 / (oracle_sphere() * mass);
  k.spread = 0.5 / sqrt(inertia / (NDIM * mass)); /* sigma^2 = <r^2> / d */
  return k;
}

/* The volume of the unit ball. */
static inline double oracle_ball(void) {
  return oracle_sphere() / NDIM;
}

/* Sum of w over the other nodes of the ideal lattice with one node per unit volume: line, triangular,
 * face-centered cubic. */
static inline double oracle_lattice_others(const struct oracle_kernel *k, double support) {
  const double basis[3][3][3] = {
      {{1, 0, 0}}, {{1, 0, 0}, {0.5, sqrt(0.75), 0}}, {{0, 1, 1}, {1, 0, 1}, {1, 1, 0}}};
  const double cell = NDIM == 1 ? 1 : NDIM == 2 ? sqrt(0.75) : 2; /* volume */
  const double scale = pow(cell, -1.0 / NDIM);
  const int cells = (int)ceil(2 * support) + 2;
  double sum = 0;
  for (int a = -cells; a <= cells; ++a)
    for (int b = NDIM > 1 ? -cells : 0; b <= (NDIM > 1 ? cells : 0); ++b)
      for (int c = NDIM > 2 ? -cells : 0; c <= (NDIM > 2 ? cells : 0); ++c) {
        double r2 = 0;
        for (int x = 0; x < NDIM; ++x) {
          const double y =
              scale * (a * basis[NDIM - 1][0][x] + b * basis[NDIM - 1][1][x] + c * basis[NDIM - 1][2][x]);
          r2 += y * y;
        }
        if (a != 0 || b != 0 || c != 0) sum += oracle_w(k, sqrt(r2) / support);
      }
  return sum;
}

/* Makes moments more isotropic as kith_invert_moments does (lib/core/symmetric.h); returns s. */
static inline double truth_even(double m[NDIM][NDIM]) {
  double det = m[0][0], trace = 0, square = 0;
#if NDIM == 2
  det = m[0][0] * m[1][1] - m[0][1] * m[1][0];
#elif NDIM == 3
  det = 0;
  for (int a = 0; a < 3; ++a)
    det += m[0][a] * (m[1][(a + 1) % 3] * m[2][(a + 2) % 3] - m[1][(a + 2) % 3] * m[2][(a + 1) % 3]);
#endif
  for (int a = 0; a < NDIM; ++a) {
    trace += m[a][a];
    for (int b = 0; b < NDIM; ++b) square += m[a][b] * m[a][b];
  }
  const double s = fmax(0, 1 - det / pow(trace / NDIM, NDIM) / 0.5);
  for (int a = 0; a < NDIM; ++a)
    for (int b = 0; b < NDIM; ++b) m[a][b] = (1 - s) * m[a][b] + (a == b ? s * square / trace : 0);
  return s;
}

#endif
