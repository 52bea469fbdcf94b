#include "boundaries/boundary.h"

#include "lib/core/family.h"

#define X(name) &kith_boundary_##name,
KITH_FAMILY(kith_boundary, KITH_BOUNDARY_LIST(X))
#undef X

static bool has_faces(const struct kith_boundary_ops *ops) {
  return ops != &kith_boundary_constant && ops != &kith_boundary_distributed;
}

/* Only boundaries with faces: two of them on one axis would miss the images of images. */
static kith_status check_faces(const struct kith_boundaries *boundaries, const struct kith_boundary *wanted) {
  const char *name = wanted->ops->name;
  if (wanted->axis < 0 || wanted->axis >= NDIM)
    KITH_FAIL(BAD_INPUT, "%s boundary on axis %d: there are axes 0 to %d", name, wanted->axis, NDIM - 1);
  if (!(wanted->lower < wanted->upper && wanted->upper - wanted->lower < INFINITY))
    KITH_FAIL(BAD_INPUT, "%s boundary from %g to %g: lower must be less than upper, and both finite", name,
              wanted->lower, wanted->upper);
  if (!wanted->at_lower && !wanted->at_upper) KITH_FAIL(BAD_INPUT, "%s boundary that acts on no side", name);
  if (wanted->ops == &kith_boundary_periodic && !(wanted->at_lower && wanted->at_upper))
    KITH_FAIL(BAD_INPUT, "a periodic boundary acts on both sides");
  if (wanted->ops == &kith_boundary_piston && wanted->at_lower && wanted->at_upper)
    KITH_FAIL(BAD_INPUT, "a piston acts on one side, not on both");
  for (int b = 0; b < boundaries->n; ++b)
    if (has_faces(boundaries->boundary[b]->ops) && boundaries->boundary[b]->axis == wanted->axis)
      KITH_FAIL(BAD_INPUT, "axis %d has a %s boundary already: one boundary acts on both sides", wanted->axis,
                boundaries->boundary[b]->ops->name);
  return KITH_OK;
}

kith_status kith_boundaries_add(struct kith_boundaries *boundaries, const struct kith_boundary_ops *ops,
                                int axis, double lower, double upper, bool at_lower, bool at_upper) {
  const int most = (int)(sizeof boundaries->boundary / sizeof boundaries->boundary[0]);
  if (boundaries->n == most) KITH_FAIL(BAD_INPUT, "more than %d boundaries", most);
  const struct kith_boundary wanted = {
      ops, boundaries->n, axis, lower, upper, at_lower, at_upper, 0, at_lower ? lower : upper, NULL};
  if (has_faces(ops)) KITH_TRY(check_faces(boundaries, &wanted));
  struct kith_boundary *boundary = NULL;
  KITH_TRY(kith_resize(&boundary, 0, 1, sizeof *boundary));
  *boundary = wanted;
  boundaries->boundary[boundaries->n++] = boundary;
  return KITH_OK;
}

void kith_boundaries_clear(struct kith_boundaries *boundaries) {
  for (int b = 0; b < boundaries->n; ++b) {
    if (boundaries->boundary[b]->ops->destroy != NULL)
      boundaries->boundary[b]->ops->destroy(boundaries->boundary[b]);
    kith_free(&boundaries->boundary[b]);
  }
  boundaries->n = 0;
}

kith_status kith_boundaries_ghosts(struct kith_boundaries *boundaries, struct kith_nodes *nodes,
                                   double reach_factor, struct kith_profile *profile) {
  kith_nodes_drop_ghosts(nodes);
  kith_status status = KITH_OK;
  for (int b = 0; b < boundaries->n && status == KITH_OK; ++b) {
    struct kith_boundary *boundary = boundaries->boundary[b];
    const kith_index before = nodes->n_ghost;
    kith_profile_begin(profile, boundary->ops->name);
    status = kith_ranks_agree(nodes->ranks, boundary->ops->ghosts(boundary, nodes, reach_factor));
    kith_profile_count(profile, "ghosts", nodes->n_ghost - before);
    kith_profile_end(profile);
  }
  return status;
}

void kith_boundaries_move(struct kith_boundaries *boundaries, double time) {
  for (int b = 0; b < boundaries->n; ++b)
    if (boundaries->boundary[b]->ops->move != NULL)
      boundaries->boundary[b]->ops->move(boundaries->boundary[b], time);
}

kith_status kith_boundaries_enforce(struct kith_boundaries *boundaries, struct kith_nodes *nodes,
                                    double *moved_by, bool only_keeping_lists) {
  for (int b = 0; b < boundaries->n; ++b) {
    struct kith_boundary *boundary = boundaries->boundary[b];
    if (boundary->ops->enforce == NULL || (only_keeping_lists && !boundary->ops->keeps_lists)) continue;
    KITH_TRY(boundary->ops->enforce(boundary, nodes, moved_by));
  }
  return KITH_OK;
}

kith_status kith_boundaries_trim(struct kith_boundaries *boundaries, struct kith_nodes *nodes,
                                 uint8_t *keep) {
  for (int b = 0; b < boundaries->n; ++b)
    if (boundaries->boundary[b]->ops->trim != NULL)
      KITH_TRY(boundaries->boundary[b]->ops->trim(boundaries->boundary[b], nodes, keep));
  return KITH_OK;
}

void kith_boundaries_renumbered(struct kith_boundaries *boundaries, const kith_index *renumber) {
  for (int b = 0; b < boundaries->n; ++b)
    if (boundaries->boundary[b]->ops->renumbered != NULL)
      boundaries->boundary[b]->ops->renumbered(boundaries->boundary[b], renumber);
}
