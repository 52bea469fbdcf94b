/* comparison.h - a run beside its exact solution: norms, measures and the picture, from all nodes on rank
 * 0. */
#ifndef KITH_APP_RUN_COMPARISON_H
#define KITH_APP_RUN_COMPARISON_H

#include "app/output/report.h"

struct kith_comparison {
  const struct kith_scene *scene;
  void *exact;              /* solution; NULL: the scene has none */
  struct kith_nodes *whole; /* all nodes, after gather, on rank 0 of several; NULL: those of the simulation */
};

kith_status kith_comparison_init(struct kith_comparison *comparison, const struct kith_scene *scene);
void kith_comparison_clear(struct kith_comparison *comparison);

/* What measures are compared with at the end, of the start of a run. Collective. */
kith_status kith_comparison_start(struct kith_comparison *comparison,
                                  const struct kith_simulation *simulation,
                                  struct kith_conservation_baseline *baseline);
/* Before the others, at the end of a run. Collective. */
kith_status kith_comparison_gather(struct kith_comparison *comparison,
                                   const struct kith_simulation *simulation);
/* Norms and measures. By rank 0. */
kith_status kith_comparison_report(const struct kith_comparison *comparison,
                                   const struct kith_simulation *simulation,
                                   const struct kith_conservation_baseline *baseline,
                                   struct kith_report *report);
/* By rank 0; a picture that cannot be drawn is a warning. */
void kith_comparison_draw(const struct kith_comparison *comparison, const struct kith_simulation *simulation,
                          const struct kith_report *report, const char *directory);

#endif
