/* plan_parts.h - what the parts of `kith plan` share: the scene as it is simulated, and its lines. */
#ifndef KITH_APP_PLAN_PARTS_H
#define KITH_APP_PLAN_PARTS_H

#include "app/plan/forecast.h"

struct kith_plan {
  struct kith_scene *scene;
  struct kith_scene *coarse;           /* NULL: the scene itself is simulated; else at a lower resolution */
  double node_ratio, resolution_ratio; /* of the scene to the simulation */
  struct kith_profile *profile;
  struct kith_simulation *simulation;
  struct kith_cells cells;    /* of the ranks, unless there is a coarse scene */
  struct kith_ledger started; /* when the first rates were there */
  double full_dt;             /* the limit by the first rates; the first step takes a fraction of it */
  double evaluation;          /* seconds of one evaluation at the start */
  double growth;              /* mean time of an evaluation along the run over that at the start */
};

/* Prints "  label         text". An empty label continues the line above. */
__attribute__((format(printf, 2, 3))) void kith_plan_line(const char *label, const char *format, ...);
/* Is a stage at the top, and of the evaluations that were measured, without the first rates? */
bool kith_plan_measured(const struct kith_stage *stage);

#endif
