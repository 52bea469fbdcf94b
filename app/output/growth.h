/* growth.h - DIR/growth.csv: the amplitude of the mode that a scene measures (growth or mcnally, measure.h),
 * at some 100 times of a run; DIR/growth.png and .pdf: beside linear theory if the scene knows its rate. */
#ifndef KITH_APP_OUTPUT_GROWTH_H
#define KITH_APP_OUTPUT_GROWTH_H

#include "app/simulation/simulation.h"
#include "lib/io/csv.h"

struct kith_growth {
  const struct kith_scene *scene; /* NULL: the scene measures no mode */
  enum kith_measure measure;
  struct kith_csv_log log; /* on rank 0 */
  double every, next;
  bool sampled; /* by this process */
};

/* Opens the table. BAD_FILE as in history.h. */
kith_status kith_growth_open(struct kith_growth *growth, const char *directory,
                             const struct kith_simulation *simulation, bool restarted);
/* Is the amplitude wanted at this time? The same on all ranks. */
bool kith_growth_due(const struct kith_growth *growth, double time);
/* Appends a row. Called on all ranks; amplitude: of rank 0. */
kith_status kith_growth_add(struct kith_growth *growth, uint64_t step, double time, double amplitude);
/* Draws the picture, if this process has added a row. first: amplitude at the start, which grows as
 * cosh(rate t). */
kith_status kith_growth_draw(struct kith_growth *growth, const char *directory, double first);

#endif
