/* report.h - what a run was, what it cost and how right it is: DIR/report.json for programs, a table for
 * people.
 *
 * Keys of the file, in this order:
 *   scene dimension package kernel scheme ranks threads nodes steps time wall_seconds cpu_seconds
 *   node_updates_per_second pairs_per_node pair_evaluations energy_drift momentum_drift angular_momentum_drift
 *   kinetic.{start,end,rebound}   velocity_over_sound.{largest,end}
 *   norms.{density,velocity,pressure,energy,speed}.{l1,l2,linf}
 *   norms.{nodes,blip,shock_radius,shock_exact,density_peak,speed_peak}
 *   measures.<name>               those that the scene asks for (measure.h)
 *   stages.<path>.{seconds,calls}   (with several ranks those of rank 0, and min, mean, max: seconds of the quickest, mean and busiest rank)
 *   ledger.<name>   floors version compiler flags
 *   ranks_detail.<name>.{min,mean,max}   ranks_detail.<name>   (ranks_detail.h)
 * norms is null without an exact solution; a number that is not finite is null.
 *
 * Drifts are the largest over the run. Energy: with that of forces from outside and less the work of a piston,
 * relative to the total at the start, or to that work if it is larger. Momentum: along axes without walls and without such forces, to the larger
 * sum m |v| of then and now. Angular momentum: |L - L(start)| about the middle of the domain (or the point that pulls), to the larger sum m |r x v| of then and
 * now; null in 1-D and where walls or frozen nodes turn the gas; in a periodic box see kith_totals.
 * rebound: the largest rise of the kinetic energy above its least value until then, in units of that at the start (null if that is 0):
 * a flow that nothing drives must not speed up. velocity_over_sound: largest |v| / c of a node, over the run and at the end. */
#ifndef KITH_APP_REPORT_H
#define KITH_APP_REPORT_H

#include <stdio.h>
#include "app/ranks_detail.h"
#include "app/stage_times.h"
#include "validation/measure.h"
#include "validation/norms.h"

struct kith_report_entry {
  const char *name;
  double value;
};

/* Plain data; strings and arrays are borrowed. A text that is NULL is null in the file. */
struct kith_report {
  const char *scene, *package, *kernel, *scheme;
  int dimension, ranks, threads;
  uint64_t nodes, steps, rejected;
  double time; /* the scene's, at the end */
  double wall_seconds, cpu_seconds;
  double node_updates_per_second; /* nodes * steps / wall_seconds */
  double pairs_per_node, pair_evaluations;
  double energy_drift, momentum_drift, angular_momentum_drift;
  struct {
    double start, end, rebound;
  } kinetic;
  struct {
    double largest, end;
  } velocity_over_sound;
  bool compared; /* norms are there */
  struct kith_norms norms;
  const bool *measured; /* [KITH_N_MEASURES] borrowed; NULL: nothing is */
  double measure[KITH_N_MEASURES];
  int n_stages;
  const struct kith_stage *stages;            /* of the profile, in tree order */
  const struct kith_stage_times *stage_times; /* of all ranks, n_stages of them; NULL: one process */
  const struct kith_ranks_detail *ranks_detail;
  int n_ledger;
  const struct kith_report_entry *ledger;
  uint64_t floors; /* values that were lifted to a floor: 0, a run stops at such a value and says where */
  const char *version, *compiler, *flags;
};

/* DIR/report.json, whole or not at all. */
kith_status kith_report_write(const struct kith_report *report, const char *path);
/* The closing table of at most 100 columns; names that are too long are cut. */
void kith_report_print(const struct kith_report *report, FILE *out);

#endif
