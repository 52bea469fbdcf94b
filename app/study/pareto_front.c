/* pareto_front.c - the Pareto front by its definition, and lines through logarithms. */
#include "app/study/study.h"

#include <math.h>

static bool is_point(double a, double b) {
  return isfinite(a) && isfinite(b) && a > 0 && b > 0;
}

void kith_pareto_front(int n, const double *cost, const double *error, bool *on) {
  for (int k = 0; k < n; ++k) {
    on[k] = is_point(cost[k], error[k]);
    for (int j = 0; j < n && on[k]; ++j)
      on[k] = !(is_point(cost[j], error[j]) && cost[j] <= cost[k] && error[j] <= error[k] &&
                (cost[j] < cost[k] || error[j] < error[k]));
  }
}

double kith_order(int n, const double *resolution, const double *error) {
  double m = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (int k = 0; k < n; ++k) {
    if (!is_point(resolution[k], error[k])) continue;
    const double x = log(resolution[k]), y = log(error[k]);
    m += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  const double spread = m * sxx - sx * sx;
  return m >= 2 && spread > 1e-12 * m * sxx ? -(m * sxy - sx * sy) / spread : NAN;
}

struct kith_cost_at_error kith_cost_at_error_of(int n, const double *resolution, const double *cost,
                                                const double *error, double target) {
  int above = -1, below = -1; /* the last point above the target, and the one after it */
  for (int k = 0; k < n; ++k) {
    if (!is_point(cost[k], error[k])) continue;
    if (error[k] > target)
      above = k, below = -1;
    else if (below < 0)
      below = k;
  }
  if (below < 0) return (struct kith_cost_at_error){NAN, NAN, false};
  if (above < 0) return (struct kith_cost_at_error){cost[below], resolution[below], false};
  const double part = log(error[above] / target) / log(error[above] / error[below]);
  return (struct kith_cost_at_error){cost[above] * pow(cost[below] / cost[above], part),
                                     resolution[above] * pow(resolution[below] / resolution[above], part),
                                     true};
}
