/* The list of boundaries of a run. */
#include "boundaries/boundary.h"

#include <math.h>

#include "lib/core/family.h"

#define X(name) &kith_boundary_##name,
KITH_FAMILY(kith_boundary, KITH_BOUNDARY_LIST(X))
#undef X

/* Can both act? On one axis only if they are on opposite sides and gas passes one of the faces: images of
 * images are missing there, and the zone behind such a face needs none. */
static bool can_coexist(const struct kith_boundary *a, const struct kith_boundary *b) {
  const bool passes = kith_boundary_passes(a->ops) || kith_boundary_passes(b->ops);
  return a->axis != b->axis || (passes && !(a->at_lower && b->at_lower) && !(a->at_upper && b->at_upper));
}

static kith_status check_faces(const struct kith_boundaries *boundaries, const struct kith_boundary *wanted) {
  const bool both = wanted->at_lower && wanted->at_upper, any = wanted->at_lower || wanted->at_upper;
  bool good = wanted->axis >= 0 && wanted->axis < NDIM && wanted->lower < wanted->upper &&
              wanted->upper - wanted->lower < INFINITY && any && (both || !wanted->ops->wraps) &&
              !(both && (wanted->ops->one_side || kith_boundary_passes(wanted->ops)));
  for (int b = 0; b < boundaries->n; ++b)
    good = good && (!boundaries->boundary[b]->ops->has_faces || can_coexist(boundaries->boundary[b], wanted));
  if (good) return KITH_OK;
  KITH_FAIL(BAD_INPUT, "no %s boundary can act on axis %d from %g to %g, or on these sides of it",
            wanted->ops->name, wanted->axis, wanted->lower, wanted->upper);
}

kith_status kith_boundaries_add(struct kith_boundaries *boundaries, const struct kith_boundary_ops *ops,
                                int axis, double lower, double upper, bool at_lower, bool at_upper) {
  if (boundaries->n == KITH_MAX_BOUNDARIES)
    KITH_FAIL(BAD_INPUT, "more than %d boundaries", KITH_MAX_BOUNDARIES);
  const struct kith_boundary wanted = {.ops = ops,
                                       .index = boundaries->n,
                                       .axis = axis,
                                       .lower = lower,
                                       .upper = upper,
                                       .at_lower = at_lower,
                                       .at_upper = at_upper,
                                       .start = at_lower ? lower : upper};
  if (ops->has_faces) KITH_TRY(check_faces(boundaries, &wanted));
  struct kith_boundary *boundary = NULL;
  KITH_TRY(kith_resize(&boundary, 0, 1, sizeof *boundary));
  *boundary = wanted;
  boundaries->boundary[boundaries->n++] = boundary;
  return KITH_OK;
}

void kith_boundaries_clear(struct kith_boundaries *boundaries) {
  for (int b = 0; b < boundaries->n; ++b) {
    kith_nodes_destroy(&boundaries->boundary[b]->held);
    kith_free(&boundaries->boundary[b]);
  }
  boundaries->n = 0;
}

void kith_boundaries_measure(struct kith_boundaries *boundaries, const struct kith_nodes *nodes,
                             double radius_factor) {
  for (int b = 0; b < boundaries->n; ++b)
    if (boundaries->boundary[b]->ops->measure != NULL)
      boundaries->boundary[b]->ops->measure(boundaries->boundary[b], nodes, radius_factor);
}

int kith_boundaries_share(struct kith_boundaries *boundaries, struct kith_shared *parts) {
  int n = 0;
  for (int b = 0; b < boundaries->n; ++b)
    if (boundaries->boundary[b]->ops->measure != NULL)
      parts[n++] = (struct kith_shared){KITH_SHARE_MAX, KITH_BOUNDARY_MAXIMA, boundaries->boundary[b]->most};
  return n;
}

kith_status kith_boundaries_make_ghosts(struct kith_boundaries *boundaries, struct kith_nodes *nodes,
                                        double radius_factor, struct kith_profile *profile,
                                        kith_status status) {
  kith_nodes_drop_ghosts(nodes);
  for (int b = 0; b < boundaries->n; ++b) {
    struct kith_boundary *boundary = boundaries->boundary[b];
    const kith_index before = nodes->n_ghost;
    kith_profile_begin(profile, boundary->ops->name);
    if (status == KITH_OK && boundary->ops->ghosts != NULL)
      status = boundary->ops->ghosts(boundary, nodes, radius_factor);
    else if (status != KITH_OK && boundary->ops->abstain != NULL)
      boundary->ops->abstain(boundary, nodes);
    boundary->made = nodes->n_ghost - before;
    kith_profile_count(profile, "ghosts", boundary->made);
    kith_profile_end(profile);
  }
  return status;
}

kith_status kith_boundaries_ghosts(struct kith_boundaries *boundaries, struct kith_nodes *nodes,
                                   double radius_factor, struct kith_profile *profile) {
  struct kith_shared parts[KITH_MAX_BOUNDARIES];
  kith_boundaries_measure(boundaries, nodes, radius_factor);
  KITH_TRY(kith_ranks_agree(nodes->ranks, KITH_OK, kith_boundaries_share(boundaries, parts), parts));
  return kith_ranks_allreduce_status(
      nodes->ranks, kith_boundaries_make_ghosts(boundaries, nodes, radius_factor, profile, KITH_OK));
}

/* An image by a mirror is nearer than its node only to nodes beyond the face, or if its own node is beyond
 * it. Images that continue a zone lie the depth of the zone away from their nodes. */
double kith_boundaries_gain(const struct kith_boundaries *boundaries) {
  double gain = 0;
  for (int n = 0; n < boundaries->n; ++n) {
    const struct kith_boundary *b = boundaries->boundary[n];
    if (b->ops->image_of != NULL && !b->ops->wraps)
      gain += 4 * KITH_MAX(b->most[KITH_IMAGES_OUT], b->most[KITH_IMAGES_OUT + 1]);
    if (b->ops->enters) gain += kith_norm(b->zone);
  }
  return gain;
}

/* A node at depth D inside a face interacts with the image of a node at depth d if D + d <= R of either. So D
 * is at most its own R, or the largest distance by which a support reaches out of the box. */
bool kith_boundaries_reach(const struct kith_boundaries *boundaries, const struct kith_box *inside,
                           const struct kith_box *reach, const struct kith_box *all) {
  for (int n = 0; n < boundaries->n; ++n) {
    const struct kith_boundary *b = boundaries->boundary[n];
    if (!b->ops->has_faces || b->ops->face_velocity != NULL) return true;
    const int a = b->axis;
    const double out = KITH_MAX(b->lower - all->lower[a], all->upper[a] - b->upper);
    if (b->at_lower && !(reach->lower[a] > b->lower && inside->lower[a] > b->lower + out)) return true;
    if (b->at_upper && !(reach->upper[a] < b->upper && inside->upper[a] < b->upper - out)) return true;
  }
  return false;
}

const struct kith_nodes *kith_boundaries_held(const struct kith_boundaries *boundaries) {
  for (int b = 0; b < boundaries->n; ++b)
    if (boundaries->boundary[b]->held != NULL) return boundaries->boundary[b]->held;
  return NULL;
}

void kith_boundaries_move(struct kith_boundaries *boundaries, double time) {
  for (int k = 0; k < boundaries->n; ++k) {
    struct kith_boundary *b = boundaries->boundary[k];
    if (b->ops->face_velocity != NULL)
      *(b->at_lower ? &b->lower : &b->upper) = b->start + b->ops->face_velocity(b->settings) * time;
  }
}

/* Enforces the boundaries that wrap, or those that mirror. */
static kith_status enforce(struct kith_boundaries *boundaries, struct kith_nodes *nodes, bool wraps) {
  for (int b = 0; b < boundaries->n; ++b) {
    struct kith_boundary *boundary = boundaries->boundary[b];
    if (boundary->ops->enforce != NULL && boundary->ops->wraps == wraps)
      KITH_TRY(boundary->ops->enforce(boundary, nodes));
  }
  return KITH_OK;
}

kith_status kith_boundaries_mirror(struct kith_boundaries *boundaries, struct kith_nodes *nodes) {
  return enforce(boundaries, nodes, false);
}

kith_status kith_boundaries_wrap(struct kith_boundaries *boundaries, struct kith_nodes *nodes) {
  return enforce(boundaries, nodes, true);
}
