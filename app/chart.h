/* chart.h - error against cost: `kith chart SCENE|SUITE`, and `kith chart list`.
 *
 * Runs the matrix of a suite (suite.h), each run a process of its own, one at a time so that they do not share caches and memory, with one
 * thread unless --threads says otherwise. A run that fails is a point with the reason. All points are kept at once in DIR/points.csv
 * (matrix.h): a chart that was interrupted goes on when it is started again. DIR: -o, or out/chart/NAME.
 *
 * Before anything runs: the files are read, and `kith plan` looks at every method at the coarsest resolution (where there are many: at
 * each value of each list with the first of the others). A value that works in no combination is refused, with its line. More than 1000
 * runs, or more than an hour by the estimate of those plans, need --yes.
 *
 *   DIR/chart.html   one page: panels, who is on the front, what an error costs, observed orders, all points
 *   DIR/chart.svg    its panels      DIR/chart.png  the same by gnuplot (DIR/plot.gp)      DIR/chart.csv  its points
 *
 * Errors are charted against CPU-seconds, against pair evaluations (which no machine changes) and against resolution. */
#ifndef KITH_APP_CHART_H
#define KITH_APP_CHART_H

#include "app/front.h"
#include "app/options.h"
#include "app/others.h"
#include "app/suite.h"

/* What is drawn. Point (m, r) of method m at resolution r is point[m * n_resolutions + r]. */
struct kith_chart {
  const struct kith_suite *suite; /* borrowed */
  struct kith_others others;
  int threads, n_methods, n_failed;
  char (*label)[KITH_METHOD_TEXT]; /* owned */
  struct kith_point *point;        /* owned */
  char machine[100];
};

/* Exit code: 0; 1 if a run failed or the results cannot be written; 2 if the suite or the command line is wrong. */
enum kith_exit kith_chart(const struct kith_options *options);

/* --- chart_words.c --- */
enum { KITH_COSTS = 2, KITH_CHART_TEXT = 2048 };
extern const int kith_cost_metrics[KITH_COSTS]; /* positions of cpu_seconds and pair_evaluations */
const struct kith_point *kith_chart_point(const struct kith_chart *chart, int m, int r);
/* A metric of all points, or of those of one method; values[n_methods * n_resolutions] or [n_resolutions]. */
void kith_chart_values(const struct kith_chart *chart, int metric, double *values);
/* Which points are on the front of a norm against a cost. */
kith_status kith_chart_front(const struct kith_chart *chart, int norm, int cost, bool *on);
/* "sod, 1-D, L1 error of density 0.01: mfm, resolution about 130, 3.1 CPU-seconds; ..." */
kith_status kith_chart_sentence(const struct kith_chart *chart, int norm, char text[KITH_CHART_TEXT]);
/* "sph at 50 and 100, mfm at 200" */
kith_status kith_chart_front_names(const struct kith_chart *chart, int norm, int cost,
                                   char text[KITH_CHART_TEXT]);
/* Which points of other codes lie above the front in CPU-seconds, and which do not; "" if there are none. */
void kith_chart_others_sentence(const struct kith_chart *chart, int norm, char text[KITH_CHART_TEXT]);
/* The observed order of method m: over all its points, and between the last two. NaN: too few points. */
void kith_chart_order(const struct kith_chart *chart, int m, int norm, double *all, double *last);

/* --- chart_page.c --- */
/* chart.html, chart.svg, chart.csv, plot.gp. */
kith_status kith_chart_write(const struct kith_chart *chart, const char *directory);

#endif
