/* Periodic: image n is shifted by n L. Nodes belong to the half-open box: one at the upper face is moved to
 * the lower one. */
#include "boundaries/images.h"

#include <math.h>

static bool image_of(const struct kith_boundary *boundary, int n, double *sign, double *shift) {
  *sign = 1;
  *shift = n * (boundary->upper - boundary->lower);
  return true;
}

/* x minus whole lengths, in [lower, upper). A value that rounds to the upper face is put on the lower one,
 * which is the same point. */
static double wrapped(double x, double lower, double upper) {
  const double length = upper - lower;
  double y = x - floor((x - lower) / length) * length;
  if (y < lower) y += length;
  return y >= lower && y < upper ? y : lower;
}

static void put_back(const struct kith_boundary *boundary, struct kith_nodes *nodes, kith_index i,
                     double *moved_by) {
  const size_t k = (size_t)i * NDIM + (size_t)boundary->axis;
  const double old = nodes->position->f64[k], now = wrapped(old, boundary->lower, boundary->upper);
  nodes->position->f64[k] = now;
  if (moved_by != NULL) moved_by[k] += now - old;
}

const struct kith_boundary_ops kith_boundary_periodic = {
    .name = "periodic",
    .doc = "what leaves on one side returns on the other",
    KITH_IMAGES,
    .has_faces = true,
    .wraps = true,
};
