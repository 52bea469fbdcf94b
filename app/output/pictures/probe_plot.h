/* probe_plot.h - pictures of probes, from DIR/probes.h5: DIR/probe_NAME.gp, and from it .png and .pdf.
 *
 *   a point   its fields over time; the exact solution beside them
 *   a line    its fields along it at up to five times from the first sample to the last; the exact solution
 *             at the last one
 *   a plane, or the plane of the first two edges through the middle of a grid   maps at the last sample
 *
 * Curves are drawn from probe_NAME.dat: time or place, the fields, those of the exact solution; two blank
 * lines between times. Maps from probe_NAME_K.bin: float, row by row. */
#ifndef KITH_APP_OUTPUT_PICTURES_PROBE_PLOT_H
#define KITH_APP_OUTPUT_PICTURES_PROBE_PLOT_H

#include "app/scene/scene.h"

/* Draws all probes of the scene that are to be drawn and were sampled. solution: exact, NULL: none. Called by
 * one process. BAD_FILE: a file that cannot be read or written. */
kith_status kith_probes_draw(const struct kith_scene *scene, const void *solution, const char *directory);

#endif
