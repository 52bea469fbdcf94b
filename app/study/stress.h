/* stress.h - where a method stops working: `kith stress [SWEEP|FILE]`, all sweeps of
 * inputs/stress/sweeps.yaml by default; `kith stress list`.
 *
 * A sweep varies one parameter of one scene, from mild to hard, for every method; a bound on a measure says
 * what still counts as working. The answer is which values pass: up to which one, as a rule. A run that
 * fails, or takes more than two minutes of processor time, does not pass, and the reason is kept. Sweeps and
 * methods are data (suite.h). What was interrupted goes on when it is started again (campaign.h).
 *
 * On stdout, and in DIR/stress.md (-o, out/stress by default): a table, sweep by method; the file has also
 * the bounds, and why runs did not pass. DIR/points.csv has all runs, DIR/stress.png and stress.svg the
 * measures. */
#ifndef KITH_APP_STUDY_STRESS_H
#define KITH_APP_STUDY_STRESS_H

#include "app/cli/options.h"
#include "app/study/suite.h"

/* Which points of a method pass, and the measure as it is judged (shown); of_first: over its first value. */
void kith_sweep_judge(const struct kith_suite *sweep, const struct kith_point *point, bool *pass,
                      double *shown);
/* "to 0.6", "20 - 40, 90", "none", "all (1000)"; where values have names "6 of 8". */
void kith_sweep_answer(const struct kith_suite *sweep, const bool *pass, char text[128]);

/* Exit code: 0; 3 if a method does not even pass the first value of a sweep; 1 if the results cannot be
 * written; 2 for an unknown sweep, or settings that no run takes. */
enum kith_exit kith_stress(const struct kith_options *options);

#endif
