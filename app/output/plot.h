/* plot.h - the picture of a run: density, velocity, pressure and specific energy of the nodes over the exact
 * curve.
 *
 * Written to the directory: profile.dat (a row a node: place, density, velocity, pressure, energy; of more
 * than 20000 nodes 20000), exact.dat (the same columns of the exact solution, dense) and plot.gp (figure.h),
 * from which gnuplot makes plot.png; it can be changed and run again there by hand. The place is x; for a
 * radial solution the distance from its center, as far as 1.6 radii of the exact shock, and the velocity is
 * the one along that. What goes wrong with gnuplot is a warning on stderr. */
#ifndef KITH_APP_OUTPUT_PLOT_H
#define KITH_APP_OUTPUT_PLOT_H

#include "validation/norms.h"

/* All borrowed. */
struct kith_plot {
  const char *scene;
  double time, resolution; /* resolution: nodes per unit length, 0: not shown */
  struct kith_profile_view nodes;
  const struct kith_exact_ops *exact; /* NULL: no exact solution */
  const void *solution;
  const struct kith_norms *norms; /* NULL: not shown */
};

/* Writes the data and the script, and runs gnuplot. BAD_FILE: a file that cannot be written. */
kith_status kith_plot_write(const struct kith_plot *plot, const char *directory);

#endif
