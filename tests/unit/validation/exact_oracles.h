/* exact_oracles.h - for tests of exact solutions: laws that any solution must satisfy, jump conditions at
 * shocks and Euler's equations where the flow is smooth. They are independent of how a solution is found. */
#ifndef KITH_TEST_VALIDATION_EXACT_ORACLES_H
#define KITH_TEST_VALIDATION_EXACT_ORACLES_H

#include "tests/check.h"
#include "validation/exact/exact.h"

/* The state on axis 0, at x = d. */
static inline struct kith_exact_state at(const struct kith_exact_ops *ops, const void *self, double d,
                                         double time) {
  struct kith_exact_state s;
  const double x[NDIM] = {d};
  ops->state(self, x, time, &s);
  return s;
}

/* Mass, momentum and energy that enter a shock of this speed also leave it. */
static inline void check_shock(const struct kith_exact_state *a, const struct kith_exact_state *b,
                               double speed) {
  double flow[2][3];
  for (int k = 0; k < 2; ++k) {
    const struct kith_exact_state *s = k == 0 ? a : b;
    const double w = s->velocity[0] - speed;
    flow[k][0] = s->density * w;
    flow[k][1] = s->density * w * w + s->pressure;
    flow[k][2] = s->density * w * (s->energy + w * w / 2) + s->pressure * w;
  }
  for (int q = 0; q < 3; ++q)
    CHECK_CLOSE(flow[0][q], flow[1][q], 1e-11 * fabs(flow[1][q])); /* round-off, with cancellation */
}

/* Euler's equations by central differences, for smooth planar (j = 1) or radial flow. `width` is the length
 * over which the flow changes at radius r and time t; in time it changes at the rate 1 / t. */
static inline void check_euler(const struct kith_exact_ops *ops, const void *self, double r, double t,
                               double width, double gamma, int j) {
  const double dr = 1e-5 * width, dt = 1e-5 * t * width / (width + fabs(r));
  const struct kith_exact_state s = at(ops, self, r, t), e = at(ops, self, r + dr, t),
                                w = at(ops, self, r - dr, t);
  const struct kith_exact_state n = at(ops, self, r, t + dt), p = at(ops, self, r, t - dt);
  const double u = s.velocity[0], ut = (n.velocity[0] - p.velocity[0]) / (2 * dt);
  const double ur = (e.velocity[0] - w.velocity[0]) / (2 * dr), spread = ur + (j - 1) * u / r;
  const double lt = log(n.density / p.density) / (2 * dt), lr = log(e.density / w.density) / (2 * dr);
  const double ht = log(n.pressure / p.pressure) / (2 * dt), hr = log(e.pressure / w.pressure) / (2 * dr);
  /* Truncation is (1e-5 slope)^2 / 6 with logarithmic slopes of up to about 200, so 7e-7, and round-off 1e-11
   * slope. Both
   * grow with the number of widths that pass during t, as time and space derivatives cancel. */
  const double tolerance = 1e-6 * (1 + fabs(r) / width);
  CHECK_CLOSE(lt + u * lr + spread, 0, tolerance / t);
  CHECK_CLOSE(ht + u * hr + gamma * spread, 0, tolerance / t);
  const double push = s.pressure / s.density; /* per length: the acceleration by a pressure of one width */
  CHECK_CLOSE(ut + u * ur + push * hr, 0, tolerance * (push / width + fabs(u * ur)));
  CHECK_CLOSE(s.energy, s.pressure / ((gamma - 1) * s.density), 1e-14 * s.energy);
}

#endif
