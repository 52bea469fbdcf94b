/* boundary.h - where ghosts come from. One family: reflecting, piston, periodic, constant, distributed.
 *
 * One boundary acts on one axis (both of its sides, or one), or on a set of nodes (constant). In the order of the list
 * each creates its ghosts from nodes and earlier ghosts, so edges and corners are filled without special cases.
 *
 * Image n of a node across an axis [a, b], L = b - a (the unfolded line):
 *   periodic                    x + n L
 *   reflecting on both sides    n even: x + n L;  n odd: a + b - x + n L
 *   reflecting on one side      its mirror image only: 2 a - x or 2 b - x
 *   piston                      the same, one side only, the face at a + u t: velocities of images are 2 u - v
 *
 * A ghost is made where it may matter: at depth d outside of the face (along the axis), if
 *   d <= f R_ghost   or   d <= max over internal nodes i of (f R_i - depth of i inside the face),
 * f = 1, or 2 when overlap is required (internal nodes of all ranks). As many images as that takes: a box may be thinner than the reach
 * (but not a thousand times: DIVERGED). Nodes may lie outside of the box: see images.h.
 * Ghosts come image by image (n = -1, 1, -2, 2, ...), list by list, in the order of their controls.
 * Nodes exactly on a reflecting face have a ghost at the same place: coincident nodes are neighbors at distance 0. */
#ifndef KITH_BOUNDARIES_BOUNDARY_H
#define KITH_BOUNDARIES_BOUNDARY_H

#include "lib/core/profile.h"
#include "lib/core/vec.h"
#include "lib/nodes/nodes.h"

struct kith_boundary;

struct kith_boundary_ops {
  const char *name, *doc;
  /* Appends ghost blocks to the nodes. `reach_factor` f as above. */
  kith_status (*ghosts)(struct kith_boundary *boundary, struct kith_nodes *nodes, double reach_factor);
  /* Is any internal node where it must not be? NULL: never. */
  bool (*violated)(const struct kith_boundary *boundary, const struct kith_nodes *nodes);
  /* Puts internal nodes back: wraps into [lower, upper), or mirrors into [lower, upper] with all positions,
   * vectors and tensors of the node. DIVERGED for a node that is not finite or a thousand lengths away; the others are put back.
   * `moved_by` (NDIM per node, may be NULL) gets the shift added that a wrap applied, so that a displacement can
   * leave it out. NULL: nothing to do. */
  kith_status (*enforce)(struct kith_boundary *boundary, struct kith_nodes *nodes, double *moved_by);
  /* Culling: before, keep[ghost] is what this rank needs, and gets what others need; after, renumber[old index] is the new one or
   * -1. Collective. NULL: nothing to do. */
  kith_status (*trim)(struct kith_boundary *boundary, struct kith_nodes *nodes, uint8_t *keep);
  void (*renumbered)(struct kith_boundary *boundary, const kith_index *renumber);
  void (*destroy)(struct kith_boundary *boundary); /* private state; NULL: none */
  /* Moves its faces to where they are at this time. NULL: they stay. Ghosts that are there already do not follow. */
  void (*move)(struct kith_boundary *boundary, double time);
  bool
      keeps_lists; /* enforcing leaves lasting lists valid (reflecting); false: only when the lists are rebuilt (periodic) */
  bool keeps_ghosts; /* its ghosts are never culled */
};

struct kith_boundary {
  const struct kith_boundary_ops *ops;
  int index;               /* place in the list of boundaries */
  int axis;                /* 0 .. NDIM - 1 */
  double lower, upper;     /* faces */
  bool at_lower, at_upper; /* which sides act (periodic: both) */
  double velocity, start;  /* piston: along the axis, the caller's to fill; where the face is at time 0 */
  void *self;
};

#define KITH_BOUNDARY_LIST(X) X(reflecting) X(piston) X(periodic) X(constant) X(distributed)
#define X(name) extern const struct kith_boundary_ops kith_boundary_##name;
KITH_BOUNDARY_LIST(X)
#undef X
const struct kith_boundary_ops *kith_boundary_find(const char *name);
const struct kith_boundary_ops *const *kith_boundary_all(void);

/* constant: takes the internal nodes with chosen[i] != 0 (length n_internal) out of the nodes and keeps all their fields; they come
 * back as frozen ghosts at every creation. Once per boundary (INTERNAL), and with ids. Ghosts are dropped. The reach of
 * a frozen ghost is its support, widened by the largest R / H of the internal nodes; fields registered later are zero. */
kith_status kith_constant_take(struct kith_boundary *boundary, struct kith_nodes *nodes,
                               const uint8_t *chosen);
/* The nodes that it holds, as nodes of their own with the same lists and fields; NULL: none. View. A checkpoint
 * stores them like any nodes; a restart reads them into kith_nodes_create_like and hands them back. */
struct kith_nodes *kith_constant_nodes(const struct kith_boundary *boundary);
/* Replaces the nodes that it holds. *held is owned by the boundary from here on, and set to NULL. */
void kith_constant_hold(struct kith_boundary *boundary, struct kith_nodes **held);

/* All boundaries of a run, in order. */
struct kith_boundaries {
  int n;
  struct kith_boundary *boundary[2 * NDIM + 8]; /* owned */
};
/* axis, lower < upper and sides are checked, and that the axis has no boundary yet: BAD_INPUT. constant and distributed ignore them. */
kith_status kith_boundaries_add(struct kith_boundaries *boundaries, const struct kith_boundary_ops *ops,
                                int axis, double lower, double upper, bool at_lower, bool at_upper);
void kith_boundaries_clear(struct kith_boundaries *boundaries);
/* Drops all ghosts, then creates those of every boundary in order. profile: a stage per boundary, counter ghosts. Collective. */
kith_status kith_boundaries_ghosts(struct kith_boundaries *boundaries, struct kith_nodes *nodes,
                                   double reach_factor, struct kith_profile *profile);
/* All faces to where they are at this time. */
void kith_boundaries_move(struct kith_boundaries *boundaries, double time);
/* Enforces all (or only those that keep lasting lists). */
kith_status kith_boundaries_enforce(struct kith_boundaries *boundaries, struct kith_nodes *nodes,
                                    double *moved_by, bool only_keeping_lists);
/* Their `trim` and `renumbered`, around a cull. Collective. */
kith_status kith_boundaries_trim(struct kith_boundaries *boundaries, struct kith_nodes *nodes, uint8_t *keep);
void kith_boundaries_renumbered(struct kith_boundaries *boundaries, const kith_index *renumber);

#endif
