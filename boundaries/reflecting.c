/* Reflecting: mirror images across one face, or unfolded across both: image n is x + n L (even) or mirrored
 * (odd). */
#include "boundaries/images.h"

#include <math.h>

/* Odd images are written from their own face, so that a node on the face has its nearest image exactly there.
 */
static bool image_of(const struct kith_boundary *boundary, int n, double *sign, double *shift) {
  const double lower = boundary->lower, upper = boundary->upper, length = upper - lower;
  if (!(boundary->at_lower && boundary->at_upper) && n != (boundary->at_lower ? -1 : 1)) return false;
  *sign = n % 2 == 0 ? 1 : -1;
  *shift = n % 2 == 0 ? n * length : n > 0 ? 2 * upper + (n - 1) * length : 2 * lower + (n + 1) * length;
  return true;
}

static kith_status ghosts(struct kith_boundary *boundary, struct kith_nodes *nodes, double reach_factor) {
  return kith_images_ghosts(boundary, nodes, reach_factor, image_of);
}

/* The interval where nodes may be: open-ended on a side that does not act. */
static double lowest(const struct kith_boundary *boundary) {
  return boundary->at_lower ? boundary->lower : -INFINITY;
}
static double highest(const struct kith_boundary *boundary) {
  return boundary->at_upper ? boundary->upper : INFINITY;
}

static bool violated(const struct kith_boundary *boundary, const struct kith_nodes *nodes) {
  const double *x = nodes->position->f64 + boundary->axis;
  const double low = lowest(boundary), high = highest(boundary);
  bool any = false;
#pragma omp parallel for schedule(static) reduction(|| : any)
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    any = any || !(x[(size_t)i * NDIM] >= low && x[(size_t)i * NDIM] <= high);
  return any;
}

/* Mirrors *x until it is between low and high; true if that took an odd number of reflections. */
static bool fold(double *x, double low, double high) {
  bool odd = false;
  while (*x < low || *x > high) {
    *x = *x < low ? 2 * low - *x : 2 * high - *x;
    odd = !odd;
  }
  return odd;
}

/* Mirrors the node's vectors and tensors of the state. */
static void flip(struct kith_nodes *nodes, kith_index i, int axis) {
  for (int f = 0; f < nodes->n_fields; ++f) {
    struct kith_field *field = nodes->fields[f];
    if (field->spec.role != KITH_STATE) continue;
    if (field->spec.kind == KITH_VECTOR) field->f64[(size_t)i * NDIM + axis] *= -1;
    if (field->spec.kind == KITH_TENSOR)
      for (int b = 0; b < NDIM; ++b) {
        if (b == axis) continue;
        field->f64[((size_t)i * NDIM + axis) * NDIM + b] *= -1;
        field->f64[((size_t)i * NDIM + b) * NDIM + axis] *= -1;
      }
  }
}

static kith_status enforce(struct kith_boundary *boundary, struct kith_nodes *nodes, double *moved_by) {
  (void)moved_by; /* a mirrored node was moved by the flow */
  double *x = nodes->position->f64 + boundary->axis;
  const double low = lowest(boundary), high = highest(boundary);
  const double far = KITH_MOST_IMAGES * (boundary->upper - boundary->lower);
  kith_index lost = INT32_MAX;
  bool any = false;
#pragma omp parallel for schedule(static) reduction(min : lost) reduction(|| : any)
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    double *xi = &x[(size_t)i * NDIM];
    if (*xi >= low && *xi <= high) continue;
    if (!(*xi >= low - far && *xi <= high + far)) {
      lost = KITH_MIN(lost, i);
      continue;
    }
    if (fold(xi, low, high)) flip(nodes, i, boundary->axis);
    any = true;
  }
  if (any) ++nodes->positions;
  return lost < INT32_MAX ? kith_images_lost(boundary, nodes, lost) : KITH_OK;
}

const struct kith_boundary_ops kith_boundary_reflecting = {
    .name = "reflecting",
    .doc = "a mirror: no flow through the face",
    .ghosts = ghosts,
    .violated = violated,
    .enforce = enforce,
    .keeps_lists = true,
};
