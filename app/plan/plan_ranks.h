/* plan_ranks.h - what `kith plan` knows of a scene, and what it prints with --ranks N. */
#ifndef KITH_APP_PLAN_PLAN_RANKS_H
#define KITH_APP_PLAN_PLAN_RANKS_H

#include <string.h>
#include "app/plan/forecast.h"

struct kith_plan {
  struct kith_scene *scene;
  struct kith_scene *coarse; /* the scene at a lower resolution, which is simulated instead; or NULL */
  double node_ratio,
      resolution_ratio; /* of the scene to the simulation; 1 if the scene itself is simulated */
  struct kith_profile *profile;
  struct kith_simulation *simulation;
  struct kith_cells cells;    /* of the ranks, unless there is a coarse scene */
  struct kith_ledger started; /* as it was after the first rates */
  double full_dt;             /* the limit by the first rates; the first step takes a fraction of it */
  double evaluation;          /* seconds of one evaluation at the start */
  double growth;              /* mean time of an evaluation along the run over that at the start */
  double needed;              /* part of the updates that block steps need along the run; NaN: unknown */
};

/* Is a stage of the profile at the top, and part of the evaluations that were measured? The first rates, in
 * the stage "start", are not. */
static inline bool kith_plan_measured(const struct kith_stage *stage) {
  return stage->depth == 0 && strcmp(stage->path, "start") != 0;
}

/* Prints what each partitioner would make of the scene on the ranks of the options, which may be thousands
 * (forecast.h). Of a scene that is too large to be laid out, only the partitioner that it chooses. */
kith_status kith_plan_ranks(struct kith_plan *plan, const struct kith_options *options);

#endif
