/* The front against its definition, orders and prices of known powers, targets; verdicts of ladders. */
#include <stdlib.h>
#include <string.h>
#include "app/front.h"
#include "app/stress.h"
#include "tests/check.h"

enum { MOST = 60 };

static bool usable(double a, double b) {
  return isfinite(a) && isfinite(b) && a > 0 && b > 0;
}

/* The definition, pair by pair. */
static bool dominated(int n, const double *cost, const double *error, int k) {
  for (int j = 0; j < n; ++j)
    if (usable(cost[j], error[j]) && cost[j] <= cost[k] && error[j] <= error[k] &&
        (cost[j] < cost[k] || error[j] < error[k]))
      return true;
  return false;
}

/* Few values, so that ties of every kind are there; some are no points. */
static void check_front(int n, unsigned seed) {
  double cost[MOST], error[MOST];
  bool on[MOST];
  srand(seed);
  for (int k = 0; k < n; ++k) {
    cost[k] = rand() % 8, error[k] = rand() % 8;
    if (rand() % 10 == 0) error[k] = NAN;
    if (rand() % 10 == 0) cost[k] = INFINITY;
  }
  CHECK(kith_front(n, cost, error, on) == KITH_OK);
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

static void check_prices(void) {
  const double resolution[] = {10, 20, 40}, cost[] = {1, 8, 64},
               error[] = {0.4, 0.2, 0.1}; /* cost = 0.064 / error^3 */
  struct kith_price p = kith_price_of(3, resolution, cost, error, 0.15);
  CHECK(p.between && fabs(p.cost - 0.064 / pow(0.15, 3)) < 1e-9 && fabs(p.resolution - 4 / 0.15) < 1e-9);
  p = kith_price_of(3, resolution, cost, error, 0.2);
  CHECK(fabs(p.cost - 8) < 1e-12 && fabs(p.resolution - 20) < 1e-12);
  p = kith_price_of(3, resolution, cost, error, 0.5);
  CHECK(!p.between && p.cost == 1 && p.resolution == 10);
  CHECK(isnan(kith_price_of(3, resolution, cost, error, 0.09).cost));
  CHECK(isnan(kith_price_of(0, resolution, cost, error, 0.2).cost));
  const double dips[] = {0.4, 0.1, 0.3}, late[] = {0.1, 0.4, 0.1};
  CHECK(isnan(kith_price_of(3, resolution, cost, dips, 0.2).cost));
  p = kith_price_of(3, resolution, cost, late, 0.2);
  CHECK(p.between && p.cost > 8 && p.cost < 64);
  const double holes[] = {0.4, NAN, 0.1}; /* the line goes over the hole */
  p = kith_price_of(3, resolution, cost, holes, 0.2);
  CHECK(p.between && fabs(p.cost - 8) < 1e-9);
}

static void check_targets(void) {
  const double error[] = {0.3, 0.09, 0.04, 0.015}; /* two methods */
  CHECK(fabs(kith_target(2, 2, error) - 0.02) <
        1e-15); /* 0.1 and 0.2 cross one, 0.02 the other: the smallest of the best */
  const double both[] = {0.3, 0.02, 0.08, 0.015};
  CHECK(fabs(kith_target(2, 2, both) - 0.02) < 1e-15);
  CHECK(kith_target(1, 1, error) == 0);
  CHECK(kith_target(1, 2, (const double[]){NAN, NAN}) == 0);
}

static void check_answer(const struct kith_ladder *l, const char *wanted) {
  char text[128];
  kith_ladder_answer(l, 0, text);
  CHECK(strcmp(text, wanted) == 0);
}

static void check_ladders(void) {
  static const struct kith_sweep most = {.name = "x", .metric = "blip", .gate = KITH_AT_MOST, .bound = 0.5};
  struct kith_sweep sweep = most;
  struct kith_ladder *l = calloc(1, sizeof *l);
  const int blip = kith_metric_find("blip");
  l->sweep = &sweep, l->n = 6;
  for (int k = 0; k < 6; ++k) {
    sweep.rung[k] = (struct kith_rung){k + 1, NULL, ""};
    l->point[0][k].value[blip] = 0.1 * (k + 1);
  }
  kith_ladder_judge(l);
  CHECK(l->pass[0][4] && !l->pass[0][5]); /* 0.5 itself passes */
  check_answer(l, "to 5");
  l->point[0][2].failed = true;
  kith_ladder_judge(l);
  check_answer(l, "to 2, 4 - 5");
  l->point[0][0].value[blip] = NAN;
  kith_ladder_judge(l);
  check_answer(l, "2, 4 - 5");
  sweep.gate = KITH_AT_LEAST;
  kith_ladder_judge(l);
  check_answer(l, "5 - 6");
  sweep.gate = KITH_OF_FIRST, sweep.bound = 3;
  l->point[0][0].value[blip] = 0.1, l->point[0][2].failed = false;
  l->point[0][2].value[blip] = 0.25;
  kith_ladder_judge(l);
  check_answer(l, "to 3");
  sweep.bound = 100;
  kith_ladder_judge(l);
  check_answer(l, "all (6)");
  sweep.bound = 0;
  kith_ladder_judge(l);
  check_answer(l, "none");
  free(l);
}

/* The table itself: metrics that are there, ladders that fit, words without blanks. */
static void check_sweeps(void) {
  for (int k = 0; k < kith_n_sweeps; ++k) {
    const struct kith_sweep *s = &kith_sweeps[k];
    int n = 0;
    CHECK(kith_metric_find(s->metric) >= 0 && s->bound > 0 && s->reason != NULL && s->dimension >= 1 &&
          s->dimension <= 3);
    while (n < KITH_RUNGS && s->rung[n].settings != NULL) ++n;
    CHECK(n >= 3 && n < KITH_RUNGS);
    for (int j = 0; j < k; ++j) CHECK(strcmp(kith_sweeps[j].name, s->name) != 0);
  }
  CHECK(kith_n_stress_methods <= KITH_STRESS_METHODS);
}

int main(void) {
  for (unsigned seed = 1; seed <= 200; ++seed) check_front((int)(seed % MOST), seed);
  check_orders();
  check_prices();
  check_targets();
  check_ladders();
  check_sweeps();
  return check_failed();
}
