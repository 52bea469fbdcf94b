/* test_chart_front.c - the Pareto front, against its definition; orders of convergence and costs, against
 * powers that are known; verdicts of sweeps. */
#include <stdlib.h>
#include <string.h>
#include "app/study/study.h"
#include "tests/check.h"

enum { MOST = 60 };

static bool usable(double a, double b) {
  return isfinite(a) && isfinite(b) && a > 0 && b > 0;
}

/* The definition of a dominated point, pair by pair. */
static bool dominated(int n, const double *cost, const double *error, int k) {
  for (int j = 0; j < n; ++j)
    if (usable(cost[j], error[j]) && cost[j] <= cost[k] && error[j] <= error[k] &&
        (cost[j] < cost[k] || error[j] < error[k]))
      return true;
  return false;
}

/* Few different values, so that there are ties of all kinds; some points are not usable. */
static void check_front(int n, unsigned seed) {
  double cost[MOST], error[MOST];
  bool on[MOST];
  srand(seed);
  for (int k = 0; k < n; ++k) {
    cost[k] = rand() % 8, error[k] = rand() % 8;
    if (rand() % 10 == 0) error[k] = NAN;
    if (rand() % 10 == 0) cost[k] = INFINITY;
  }
  kith_pareto_front(n, cost, error, on);
  for (int k = 0; k < n; ++k) CHECK(on[k] == (usable(cost[k], error[k]) && !dominated(n, cost, error, k)));
}

static void check_orders(void) {
  const double resolution[] = {10, 20, 35, 80};
  double error[4];
  for (int k = 0; k < 4; ++k) error[k] = 3 * pow(resolution[k], -1.7);
  CHECK(fabs(kith_order(4, resolution, error) - 1.7) < 1e-12); /* round-off */
  error[1] = NAN;
  CHECK(fabs(kith_order(4, resolution, error) - 1.7) < 1e-12);
  CHECK(isnan(kith_order(2, resolution, error)));
  const double same[] = {10, 10};
  CHECK(isnan(kith_order(2, same, (const double[]){1, 2})));
}

static void check_costs(void) {
  const double resolution[] = {10, 20, 40}, cost[] = {1, 8, 64},
               error[] = {0.4, 0.2, 0.1}; /* cost = 0.064 / error^3 */
  struct kith_cost_at_error p = kith_cost_at_error_of(3, resolution, cost, error, 0.15);
  CHECK(p.between && fabs(p.cost - 0.064 / pow(0.15, 3)) < 1e-9 && fabs(p.resolution - 4 / 0.15) < 1e-9);
  p = kith_cost_at_error_of(3, resolution, cost, error, 0.2);
  CHECK(fabs(p.cost - 8) < 1e-12 && fabs(p.resolution - 20) < 1e-12);
  p = kith_cost_at_error_of(3, resolution, cost, error, 0.5);
  CHECK(!p.between && p.cost == 1 && p.resolution == 10);
  CHECK(isnan(kith_cost_at_error_of(3, resolution, cost, error, 0.09).cost));
  CHECK(isnan(kith_cost_at_error_of(0, resolution, cost, error, 0.2).cost));
  const double dips[] = {0.4, 0.1, 0.3}, late[] = {0.1, 0.4, 0.1};
  CHECK(isnan(kith_cost_at_error_of(3, resolution, cost, dips, 0.2).cost));
  p = kith_cost_at_error_of(3, resolution, cost, late, 0.2);
  CHECK(p.between && p.cost > 8 && p.cost < 64);
  const double holes[] = {0.4, NAN, 0.1}; /* interpolated across the unusable point */
  p = kith_cost_at_error_of(3, resolution, cost, holes, 0.2);
  CHECK(p.between && fabs(p.cost - 8) < 1e-9);
}

static void check_answer(const struct kith_suite *s, const char *wanted) {
  char text[128];
  kith_sweep_answer(s, 0, text);
  CHECK(strcmp(text, wanted) == 0);
}

static void check_sweeps(void) {
  static struct kith_job job[6];
  static struct kith_point point[6];
  struct kith_suite s = {
      .n_methods = 1, .n_values = 6, .job = job, .point = point, .at_most = 0.5, .at_least = NAN};
  for (int k = 0; k < 6; ++k) {
    snprintf(job[k].value, sizeof job[k].value, "%d", k + 1);
    point[k].value[KITH_MEASURES] = 0.1 * (k + 1);
  }
  check_answer(&s, "to 5"); /* 0.5 itself passes */
  s.named_values = true;
  check_answer(&s, "5 of 6");
  s.named_values = false;
  point[2].failed = true;
  check_answer(&s, "4 of 6");
  point[0].value[KITH_MEASURES] = NAN;
  check_answer(&s, "3 of 6");
  s.at_least = 0.5, s.at_most = NAN;
  check_answer(&s, "2 of 6");
  s.of_first = true, s.at_most = 3, s.at_least = NAN;
  point[0].value[KITH_MEASURES] = 0.1, point[2].value[KITH_MEASURES] = 0.25, point[2].failed = false;
  check_answer(&s, "to 3");
  s.at_most = 100;
  check_answer(&s, "all (6)");
  s.at_most = 0;
  check_answer(&s, "none");
}

int main(void) {
  for (unsigned seed = 1; seed <= 200; ++seed) check_front((int)(seed % MOST), seed);
  check_orders();
  check_costs();
  check_sweeps();
  return check_failed();
}
