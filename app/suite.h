/* suite.h - what a chart runs: a scene, methods, and a matrix of settings and resolutions. A small YAML file:
 *
 *   scene: sod                        # of the directory inputs, or a path (from the suite's folder, or from here)
 *   dimension: 1                      # none: the scene's
 *   settings: {scheme.cfl: 0.2}       # for every run; keys as in --set, or nested; and `ranks`: processes
 *   methods:                          # a name for several settings; none: one method, the scene's
 *     - {name: sph alpha 1, settings: {method.viscosity.name: monaghan}}
 *   matrix:                           # every combination of these, for every method
 *     method.kernel: [wendland-c2, quintic]
 *     resolution: [50, 100, 200]      # required
 *   norms: [density.l1, velocity.l1]  # what is charted (metrics of matrix.h)
 *   targets: [0.01, 0.02]             # one for each norm: errors to ask the price of; none: chosen from the points
 *   others: peers.csv                 # points of other codes (others.h)
 *
 * Any scene is a suite too: every hydro package there is, at three resolutions around the scene's own.
 * --set of the command line comes after `settings`, before methods and matrix. */
#ifndef KITH_APP_SUITE_H
#define KITH_APP_SUITE_H

#include "app/config.h"
#include "app/matrix.h"

enum { KITH_SUITE_NORMS = 8, KITH_SUITE_AXES = 8, KITH_SUITE_RESOLUTIONS = 64 };

/* One direction of the matrix: the children of a list. */
struct kith_axis {
  const struct kith_config_node *list; /* of settings with names (the methods), or of values of `key` */
  const char *key;                     /* NULL: the methods */
};

struct kith_suite {
  struct kith_config *config; /* owned; the axes are views of it */
  char name[100], scene_name[100], scene[KITH_PATH], others[KITH_PATH];
  int dimension;
  int n_axes;
  struct kith_axis axis[KITH_SUITE_AXES];
  int64_t n_methods; /* product of the axes */
  int n_resolutions; /* ascending */
  double resolution[KITH_SUITE_RESOLUTIONS];
  int n_norms, norm[KITH_SUITE_NORMS];
  double target[KITH_SUITE_NORMS]; /* 0: choose one */
  int n_overrides;
  const char *const *overrides; /* borrowed */
};

/* A suite or a scene, by path, or by name: NAME.yaml of inputs/suites, then of inputs. BAD_INPUT with one line for whatever is wrong
 * with the file itself; what the scene says of its settings is found by those who start it. */
kith_status kith_suite_read(struct kith_suite **out, const struct kith_programs *programs,
                            const char *subject, int n_overrides, const char *const *overrides);
void kith_suite_destroy(struct kith_suite **suite);

/* The position on an axis of method m, 0 <= m < n_methods. */
int kith_suite_position(const struct kith_suite *suite, int64_t m, int axis);
/* The job of method m at a resolution. */
kith_status kith_suite_job(const struct kith_suite *suite, int64_t m, double resolution,
                           struct kith_job *job);
/* The suites there are, for people. */
kith_status kith_suite_list(const struct kith_programs *programs);

#endif
