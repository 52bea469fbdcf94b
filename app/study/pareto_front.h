/* pareto_front.h - what a cloud of points of error and cost says: its Pareto front, orders of convergence,
 * the cost at an error. Plain numbers; what is not finite or not positive is no point. */
#ifndef KITH_APP_STUDY_PARETO_FRONT_H
#define KITH_APP_STUDY_PARETO_FRONT_H

#include "lib/core/base.h"

/* on[k] is true if no other point is at most as expensive and at most as wrong, and better in one of the two;
 * of equal points all are on the front. O(n^2). */
void kith_pareto_front(int n, const double *cost, const double *error, bool *on);
/* Observed order of convergence: minus the slope of the least-squares line through log error over log
 * resolution. NaN for fewer than two points at different resolutions. */
double kith_order(int n, const double *resolution, const double *error);

/* Where one method reaches an error of `target`: the resolution (they ascend) from which on its error stays
 * at or below it, between two points on a straight line of logarithms. An error that dips below and rises
 * again does not count. */
struct kith_cost_at_error {
  double cost, resolution; /* NaN: never reached */
  bool between;            /* two points; else at the first one already */
};
struct kith_cost_at_error kith_cost_at_error_of(int n, const double *resolution, const double *cost,
                                                const double *error, double target);

#endif
