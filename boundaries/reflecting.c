/* Reflecting: mirror images across one face, or unfolded across both: image n is x + n L (even) or mirrored
 * (odd). Piston: a mirror on one side, whose face moves. */
#include "boundaries/images.h"

#include <math.h>

/* Odd images are computed from their own face, so that a node on the face has its nearest image exactly
 * there. */
static bool image_of(const struct kith_boundary *boundary, int n, double *sign, double *shift) {
  const double lower = boundary->lower, upper = boundary->upper, length = upper - lower;
  if (!(boundary->at_lower && boundary->at_upper) && n != (boundary->at_lower ? -1 : 1)) return false;
  *sign = n % 2 == 0 ? 1 : -1;
  *shift = n % 2 == 0 ? n * length : n > 0 ? 2 * upper + (n - 1) * length : 2 * lower + (n + 1) * length;
  return true;
}

static kith_status ghosts(struct kith_boundary *boundary, struct kith_nodes *nodes, double radius_factor) {
  return kith_images_ghosts(boundary, nodes, radius_factor, image_of);
}

/* The interval for nodes: unbounded on a side that does not act. */
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

/* The reflections that bring x between low and high, as one map x -> sign * x + shift. */
static void fold(double x, double low, double high, double *sign, double *shift) {
  *sign = 1, *shift = 0;
  while (x < low || x > high) {
    const double face = x < low ? low : high;
    x = 2 * face - x;
    *sign = -*sign;
    *shift = 2 * face - *shift;
  }
}

/* Maps all fields of the node, also positions and velocities that schemes keep from the start of a step. */
static void mirror(struct kith_nodes *nodes, kith_index i, int axis, double sign, double shift,
                   double velocity) {
  for (int f = 0; f < nodes->n_fields; ++f) {
    double *value = nodes->fields[f]->f64;
    const enum kith_kind kind = nodes->fields[f]->spec.kind;
    if (kind == KITH_POSITION) value[(size_t)i * NDIM + axis] = sign * value[(size_t)i * NDIM + axis] + shift;
    if (kind == KITH_VECTOR) value[(size_t)i * NDIM + axis] *= sign;
    if (kind == KITH_VELOCITY)
      value[(size_t)i * NDIM + axis] = sign * value[(size_t)i * NDIM + axis] + (sign < 0 ? 2 * velocity : 0);
    if (kind == KITH_SYMMETRIC)
      for (int a = 0, c = 0; a < NDIM; ++a)
        for (int b = a; b < NDIM; ++b, ++c)
          if ((a == axis) != (b == axis)) value[(size_t)i * (NDIM * (NDIM + 1) / 2) + c] *= sign;
    if (kind == KITH_TENSOR)
      for (int b = 0; b < NDIM; ++b) {
        if (b == axis) continue;
        value[((size_t)i * NDIM + axis) * NDIM + b] *= sign;
        value[((size_t)i * NDIM + b) * NDIM + axis] *= sign;
      }
  }
}

static kith_status enforce(struct kith_boundary *boundary, struct kith_nodes *nodes, double *moved_by) {
  (void)moved_by; /* a mirrored node has moved with the flow */
  const double *x = nodes->position->f64 + boundary->axis;
  const double low = lowest(boundary), high = highest(boundary);
  const double velocity = kith_boundary_face_velocity(boundary->ops, boundary->settings);
  const double far = KITH_MOST_IMAGES * fabs(boundary->upper - boundary->lower);
  kith_index lost = INT32_MAX;
  bool any = false;
#pragma omp parallel for schedule(static) reduction(min : lost) reduction(|| : any)
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    const double xi = x[(size_t)i * NDIM];
    if (xi >= low && xi <= high) continue;
    if (!(xi >= low - far && xi <= high + far)) {
      lost = KITH_MIN(lost, i);
      continue;
    }
    double sign, shift;
    fold(xi, low, high, &sign, &shift);
    mirror(nodes, i, boundary->axis, sign, shift, velocity);
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
    .has_faces = true,
    .mirrors = true,
    .keeps_lists = true,
};

struct piston {
  double velocity;
};
static const struct kith_param piston_params[] = {
    {"velocity", KITH_PARAM_NUMBER, NULL, "", "of the face, along its axis",
     KITH_INTO(struct piston, velocity), .unit = "velocity"},
    {0}};

static double face_velocity(const void *settings) {
  return settings == NULL ? 0 : ((const struct piston *)settings)->velocity;
}

static void move(struct kith_boundary *boundary, double time) {
  *(boundary->at_lower ? &boundary->lower : &boundary->upper) =
      boundary->start + face_velocity(boundary->settings) * time;
}

const struct kith_boundary_ops kith_boundary_piston = {
    .name = "piston",
    .doc =
        "a mirror that moves with a constant velocity: {kind: piston, velocity: u} on one side, open on the "
        "other",
    KITH_SETTINGS(piston_params, piston),
    .ghosts = ghosts,
    .violated = violated,
    .enforce = enforce,
    .move = move,
    .face_velocity = face_velocity,
    .has_faces = true,
    .one_side = true,
    .keeps_lists = true,
};
