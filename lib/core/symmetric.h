/* symmetric.h - symmetric matrices of NDIM x NDIM, stored as their upper triangle: xx, xy, xz, yy, yz, zz. */
#ifndef KITH_CORE_SYMMETRIC_H
#define KITH_CORE_SYMMETRIC_H

#include "lib/core/vec.h"

enum { KITH_SYMMETRIC_SIZE = NDIM * (NDIM + 1) / 2 };

/* The index of entry (a, b), which is also that of (b, a). */
KITH_INLINE int kith_symmetric_at(int a, int b) {
  const int low = KITH_MIN(a, b), high = KITH_MAX(a, b);
  return low * NDIM - low * (low - 1) / 2 + high - low;
}

/* r.G.r for r = (x, y, z), of which y and z do not count in fewer dimensions. The entries of G are `stride`
 * apart. */
KITH_INLINE double kith_symmetric_form(const double *restrict g, int stride, double x, double y, double z) {
  return NDIM == 1   ? g[0] * x * x
         : NDIM == 2 ? g[0] * x * x + g[2 * stride] * y * y + 2 * (g[stride] * x * y)
                     : g[0] * x * x + g[3 * stride] * y * y + g[5 * stride] * z * z +
                           2 * (g[stride] * x * y + g[2 * stride] * x * z + g[4 * stride] * y * z);
}

/* out = factor G v; the entries of G are `stride` apart. For loops over pairs, which vectorize. */
KITH_INLINE void kith_symmetric_times(double factor, const double *restrict g, int stride,
                                      const double *restrict v, double *restrict out) {
  for (int a = 0; a < NDIM; ++a) {
    double sum = 0;
    for (int b = 0; b < NDIM; ++b) sum += g[kith_symmetric_at(a, b) * stride] * v[b];
    out[a] = factor * sum;
  }
}

/* out += G v. */
KITH_INLINE void kith_symmetric_add(const double *g, const double *v, double *out) {
  for (int a = 0, m = 0; a < NDIM; ++a)
    for (int b = a; b < NDIM; ++b, ++m) {
      out[a] += g[m] * v[b];
      if (b != a) out[b] += g[m] * v[a];
    }
}

KITH_INLINE double kith_symmetric_determinant(const double *m) {
#if NDIM == 1
  return m[0];
#elif NDIM == 2
  return m[0] * m[2] - m[1] * m[1];
#else
  return m[0] * (m[3] * m[5] - m[4] * m[4]) + m[1] * (m[2] * m[4] - m[1] * m[5]) +
         m[2] * (m[1] * m[4] - m[2] * m[3]);
#endif
}

KITH_INLINE double kith_symmetric_trace(const double *m) {
  double trace = 0;
  for (int a = 0; a < NDIM; ++a) trace += m[kith_symmetric_at(a, a)];
  return trace;
}

/* The inverse of a positive matrix. If the matrix is close to singular, that is, if its determinant is not
 * more than `least` times trace^NDIM, the result is zero, and false is returned. (The determinant of an
 * isotropic matrix is (trace / NDIM)^NDIM.) */
KITH_INLINE bool kith_invert_symmetric(const double *m, double least, double *inverse) {
  const double det = kith_symmetric_determinant(m);
  for (int k = 0; k < KITH_SYMMETRIC_SIZE; ++k) inverse[k] = 0;
  if (!(det > least * kith_pow_dim(kith_symmetric_trace(m)))) return false;
#if NDIM == 1
  inverse[0] = 1 / det;
#elif NDIM == 2
  inverse[0] = m[2] / det, inverse[1] = -m[1] / det, inverse[2] = m[0] / det;
#else
  inverse[0] = (m[3] * m[5] - m[4] * m[4]) / det, inverse[1] = (m[2] * m[4] - m[1] * m[5]) / det;
  inverse[2] = (m[1] * m[4] - m[2] * m[3]) / det, inverse[3] = (m[0] * m[5] - m[2] * m[2]) / det;
  inverse[4] = (m[1] * m[2] - m[0] * m[4]) / det, inverse[5] = (m[0] * m[3] - m[1] * m[1]) / det;
#endif
  return true;
}

/* The inverse of M = sum w x x over the neighbors of a node, for forces. Where they lie almost in a line or a
 * plane, as in the outermost row of gas that flies apart, M^-1 is so large across it that the row buckles,
 * whatever the time step is. So M is first made more isotropic,
 *     M' = (1 - s) M + s (tr M^2 / tr M) I,  s = max(0, 1 - e / 0.5),  e = det M / (tr M / d)^d,
 * where e is 1 if M is isotropic, 0.3 for a square lattice pressed together 4 : 1, and 0 if M is singular.
 * M' is M along such a line or plane. Zero and false for a node without neighbors. */
KITH_INLINE bool kith_invert_moments(const double *m, double *inverse) {
  const double trace = kith_symmetric_trace(m), scale = trace > 0 ? NDIM / trace : 0;
  double even[KITH_SYMMETRIC_SIZE], square = 0;
  for (int k = 0; k < KITH_SYMMETRIC_SIZE; ++k) even[k] = m[k] * scale;
  for (int a = 0; a < NDIM; ++a)
    for (int b = 0; b < NDIM; ++b) square += even[kith_symmetric_at(a, b)] * even[kith_symmetric_at(a, b)];
  const double s = KITH_MAX(0, 1 - kith_symmetric_determinant(even) / 0.5);
  for (int k = 0; k < KITH_SYMMETRIC_SIZE; ++k) even[k] *= 1 - s;
  for (int a = 0; a < NDIM; ++a) even[kith_symmetric_at(a, a)] += s * square / NDIM;
  const bool inverted = kith_invert_symmetric(even, 0, inverse);
  for (int k = 0; k < KITH_SYMMETRIC_SIZE; ++k) inverse[k] *= scale;
  return inverted;
}

#endif
