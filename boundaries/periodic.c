/* Periodic: image n is shifted by n L. Nodes belong to the half-open box: one at the upper face is moved to
 * the lower one. */
#include "boundaries/images.h"

#include <math.h>

static bool image_of(const struct kith_boundary *boundary, int n, double *sign, double *shift) {
  *sign = 1;
  *shift = n * (boundary->upper - boundary->lower);
  return true;
}

static kith_status ghosts(struct kith_boundary *boundary, struct kith_nodes *nodes, double radius_factor) {
  return kith_images_ghosts(boundary, nodes, radius_factor, image_of);
}

static bool violated(const struct kith_boundary *boundary, const struct kith_nodes *nodes) {
  const double *x = nodes->position->f64 + boundary->axis;
  const double lower = boundary->lower, upper = boundary->upper;
  bool any = false;
#pragma omp parallel for schedule(static) reduction(|| : any)
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    any = any || !(x[(size_t)i * NDIM] >= lower && x[(size_t)i * NDIM] < upper);
  return any;
}

/* x minus whole lengths, in [lower, upper). A value that rounds to the upper face is put on the lower one,
 * which is the same point. */
static double wrapped(double x, double lower, double upper) {
  const double length = upper - lower;
  double y = x - floor((x - lower) / length) * length;
  if (y < lower) y += length;
  return y >= lower && y < upper ? y : lower;
}

static kith_status enforce(struct kith_boundary *boundary, struct kith_nodes *nodes, double *moved_by) {
  double *x = nodes->position->f64 + boundary->axis;
  const double lower = boundary->lower, upper = boundary->upper;
  const double far = KITH_MOST_IMAGES * (upper - lower);
  kith_index lost = INT32_MAX;
  bool any = false;
#pragma omp parallel for schedule(static) reduction(min : lost) reduction(|| : any)
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    const double old = x[(size_t)i * NDIM];
    if (old >= lower && old < upper) continue;
    if (!(old >= lower - far && old <= upper + far)) {
      lost = KITH_MIN(lost, i);
      continue;
    }
    const double now = wrapped(old, lower, upper);
    x[(size_t)i * NDIM] = now;
    if (moved_by != NULL) moved_by[(size_t)i * NDIM + boundary->axis] += now - old;
    any = true;
  }
  if (any) ++nodes->positions;
  return lost < INT32_MAX ? kith_images_lost(boundary, nodes, lost) : KITH_OK;
}

const struct kith_boundary_ops kith_boundary_periodic = {
    .name = "periodic",
    .doc = "what leaves on one side returns on the other",
    .ghosts = ghosts,
    .violated = violated,
    .enforce = enforce,
    .has_faces = true,
    .wraps = true,
};
