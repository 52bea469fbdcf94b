/* Periodic: image n is shifted by n L. Nodes belong to the half-open box: one at the upper face is moved to
 * the lower one. Images are ghosts, or shifts in the rows of their neighbors (lib/nodes/shifts.h). */
#include "boundaries/images.h"

#include <math.h>

struct periodic {
  bool shifts;
};
static const struct kith_param periodic_params[] = {
    {"images", KITH_PARAM_CHOICE, "ghosts", "ghosts|shifts",
     "images are nodes; or there are none, and row entries say by how many box lengths a neighbor is "
     "displaced",
     KITH_INTO(struct periodic, shifts), .restart_may_change = true},
    {0}};

static bool shifts(const void *settings) {
  return settings != NULL && ((const struct periodic *)settings)->shifts;
}

static bool are_shifts(const struct kith_boundary *boundary, const struct kith_nodes *nodes) {
  return nodes->shifts.wanted && shifts(boundary->settings);
}

static void measure(struct kith_boundary *boundary, const struct kith_nodes *nodes, double radius_factor) {
  (are_shifts(boundary, nodes) ? kith_images_measure_shifts : kith_images_measure)(boundary, nodes,
                                                                                   radius_factor);
}

static kith_status ghosts(struct kith_boundary *boundary, struct kith_nodes *nodes, double radius_factor) {
  return (are_shifts(boundary, nodes) ? kith_images_shifts : kith_images_ghosts)(boundary, nodes,
                                                                                 radius_factor);
}

static bool image_of(const struct kith_boundary *boundary, int n, double *sign, double *shift) {
  *sign = 1;
  *shift = n * (boundary->upper - boundary->lower);
  return true;
}

/* Moves x by whole lengths into [lower, upper). A value that rounds to the upper face is put on the lower
 * one, which is the same point. */
static double wrapped(double x, double lower, double upper) {
  const double length = upper - lower;
  double y = x - floor((x - lower) / length) * length;
  if (y < lower) y += length;
  return y >= lower && y < upper ? y : lower;
}

static void put_back(const struct kith_boundary *boundary, struct kith_nodes *nodes, kith_index i) {
  const size_t k = (size_t)i * NDIM + (size_t)boundary->axis;
  nodes->position->f64[k] = wrapped(nodes->position->f64[k], boundary->lower, boundary->upper);
}

const struct kith_boundary_ops kith_boundary_periodic = {
    .name = "periodic",
    .doc = "what leaves on one side returns on the other",
    KITH_SETTINGS(periodic_params, periodic),
    .measure = measure,
    .ghosts = ghosts,
    .enforce = kith_images_enforce,
    .image_of = image_of,
    .put_back = put_back,
    .shifts = shifts,
    .has_faces = true,
    .wraps = true,
};
