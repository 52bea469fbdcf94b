/* Reflecting: mirror images across one face, or unfolded across both: image n is x + n L (even) or mirrored
 * (odd). Piston: a mirror on one side, whose face moves. */
#include "boundaries/images.h"

/* Computes odd images from the nearest face, so that a node on the face has its nearest image exactly
 * there. */
static bool image_of(const struct kith_boundary *boundary, int n, double *sign, double *shift) {
  const double lower = boundary->lower, upper = boundary->upper, length = upper - lower;
  if (!(boundary->at_lower && boundary->at_upper) && n != (boundary->at_lower ? -1 : 1)) return false;
  *sign = n % 2 == 0 ? 1 : -1;
  *shift = n % 2 == 0 ? n * length : n > 0 ? 2 * upper + (n - 1) * length : 2 * lower + (n + 1) * length;
  return true;
}

/* Reflects the node until it is between the faces, and maps all its fields at once, also positions and
 * velocities that schemes keep from the start of a step. */
static void put_back(const struct kith_boundary *boundary, struct kith_nodes *nodes, kith_index i) {
  const int axis = boundary->axis;
  struct kith_image image = {.velocity = {0}};
  double x = nodes->position->f64[(size_t)i * NDIM + axis], sign = 1, shift = 0;
  for (bool below;
       (below = boundary->at_lower && x < boundary->lower) || (boundary->at_upper && x > boundary->upper);) {
    const double face = below ? boundary->lower : boundary->upper;
    x = 2 * face - x;
    sign = -sign;
    shift = 2 * face - shift;
  }
  for (int a = 0; a < NDIM; ++a) image.sign[a] = a == axis ? sign : 1;
  image.shift[axis] = shift;
  if (sign < 0) image.velocity[axis] = 2 * kith_boundary_face_velocity(boundary->ops, boundary->settings);
  kith_nodes_map(nodes, i, &image);
}

const struct kith_boundary_ops kith_boundary_reflecting = {
    .name = "reflecting",
    .doc = "a mirror: no flow through the face",
    KITH_IMAGES,
    .has_faces = true,
    .mirrors = true,
};

struct piston {
  double velocity;
};
static const struct kith_param piston_params[] = {
    {"velocity", KITH_PARAM_NUMBER, NULL, "", "velocity of the face along its axis",
     KITH_INTO(struct piston, velocity)},
    {0}};

static double face_velocity(const void *settings) {
  return settings == NULL ? 0 : ((const struct piston *)settings)->velocity;
}

const struct kith_boundary_ops kith_boundary_piston = {
    .name = "piston",
    .doc =
        "a mirror that moves with a constant velocity: {kind: piston, velocity: u} on one side, open on the "
        "other",
    KITH_SETTINGS(piston_params, piston),
    KITH_IMAGES,
    .face_velocity = face_velocity,
    .has_faces = true,
    .one_side = true,
};
