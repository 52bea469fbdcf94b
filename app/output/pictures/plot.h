/* plot.h - the picture of a run: curves of the nodes beside the exact solution, and maps.
 *
 * Written to the directory, NAME being plot, or frame_NNNN with its name before each file and a '_':
 *
 *   profile.dat  a row for each node, or for 20000 of them if there are more: its place, and the value of
 *                each curve. The place is x, or, in a radial picture, the distance from the center; the
 *                velocity is then that away from the center, or around the axis of a vortex
 *   exact.dat    the same columns of the exact solution, at 2001 places. They go as far as the nodes; in a
 *                radial picture with an exact shock, to 1.6 times its radius at most
 *   mean.dat     the same columns, of means over all nodes in bins of the place, weighted by volume; not in
 *                1-D
 *   map_K.bin    pixels of panel K (from 1), if that is a map (map.h): float, row by row
 *   NAME.gp      from which gnuplot makes NAME.png and NAME.pdf; it can be changed and run again there
 *
 * What goes wrong with gnuplot is a warning on stderr. */
#ifndef KITH_APP_OUTPUT_PICTURES_PLOT_H
#define KITH_APP_OUTPUT_PICTURES_PLOT_H

#include "app/scene/picture.h"
#include "validation/norms.h"

/* All borrowed. */
struct kith_plot {
  const char *scene, *frame; /* frame: name of one picture of many; NULL: plot */
  const struct kith_picture *picture;
  double time, resolution; /* resolution: nodes per unit length */
  struct kith_profile_view nodes;
  const struct kith_exact_ops *exact; /* NULL: no exact solution */
  const void *solution;
  const struct kith_window *window; /* maps of errors show the nodes in it */
  const struct kith_norms *norms;   /* NULL: not shown */
};

/* Writes the data and the script, and runs gnuplot. BAD_FILE: a file that cannot be written. */
kith_status kith_plot_write(const struct kith_plot *plot, const char *directory);

#endif
