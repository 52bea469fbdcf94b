/* vec.h - small vectors: NDIM doubles each, as plain arrays. Loops over NDIM unroll. */
#ifndef KITH_CORE_VEC_H
#define KITH_CORE_VEC_H

#include <math.h>
#include "lib/core/base.h"

/* An axis-aligned box; empty: lower is INFINITY and upper -INFINITY on all axes. */
struct kith_box {
  double lower[NDIM], upper[NDIM];
};

static inline double kith_dot(const double *a, const double *b) {
  double s = 0;
  for (int k = 0; k < NDIM; ++k) s += a[k] * b[k];
  return s;
}

static inline double kith_norm(const double *a) {
  return sqrt(kith_dot(a, a));
}

/* |a - b|^2 */
static inline double kith_distance2(const double *a, const double *b) {
  double s = 0;
  for (int k = 0; k < NDIM; ++k) s += (a[k] - b[k]) * (a[k] - b[k]);
  return s;
}

/* r^NDIM, without a loop, so that callers vectorize. */
static inline double kith_pow_dim(double r) {
  return NDIM == 1 ? r : NDIM == 2 ? r * r : r * r * r;
}

/* The length whose NDIM-th power is v. If v is multiplied by 2^(k NDIM), the result is multiplied by 2^k
 * exactly; cbrt and pow do not promise that. */
static inline double kith_root_dim(double v) {
  int exponent;
  if (NDIM < 3) return NDIM == 1 ? v : sqrt(v);
  const double part = frexp(v, &exponent);
  const int rest = (exponent % 3 + 3) % 3;
  return ldexp(cbrt(ldexp(part, rest)), (exponent - rest) / 3);
}

/* Volume of the NDIM-ball of radius 1: 2, pi, 4 pi / 3. */
static inline double kith_ball(void) {
  return NDIM == 1 ? 2.0 : NDIM == 2 ? 3.14159265358979323846 : 4.18879020478639098462;
}

static inline struct kith_box kith_box_empty(void) {
  struct kith_box b;
  for (int k = 0; k < NDIM; ++k) b.lower[k] = INFINITY, b.upper[k] = -INFINITY;
  return b;
}

static inline void kith_box_include(struct kith_box *b, const double *x) {
  for (int k = 0; k < NDIM; ++k) {
    b->lower[k] = KITH_MIN(b->lower[k], x[k]);
    b->upper[k] = KITH_MAX(b->upper[k], x[k]);
  }
}

/* Enlarges b to the smallest box that holds both; an empty one adds nothing. */
static inline void kith_box_join(struct kith_box *b, const struct kith_box *other) {
  for (int k = 0; k < NDIM; ++k) {
    b->lower[k] = KITH_MIN(b->lower[k], other->lower[k]);
    b->upper[k] = KITH_MAX(b->upper[k], other->upper[k]);
  }
}

/* The volume of the box with a margin on all sides. */
static inline double kith_box_volume(const struct kith_box *b, double margin) {
  double volume = 1;
  for (int k = 0; k < NDIM; ++k) volume *= b->upper[k] - b->lower[k] + 2 * margin;
  return volume;
}

/* Is the gap between two boxes at most `margin` along each axis? */
static inline bool kith_box_near(const struct kith_box *a, const struct kith_box *b, double margin) {
  bool near = true;
  for (int k = 0; k < NDIM; ++k)
    near = near && a->lower[k] - margin <= b->upper[k] && a->upper[k] + margin >= b->lower[k];
  return near;
}

#endif
