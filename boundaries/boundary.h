/* boundary.h - boundary conditions by ghosts. One family: reflecting, piston, periodic, constant,
 * inflow, outflow, distributed.
 *
 * A boundary acts on one axis (both of its sides, or one), or on a set of nodes (constant). In the order of
 * the list each creates its ghosts from nodes and from earlier ghosts, so edges and corners are filled
 * without special cases.
 *
 * Image n of a node across an axis [a, b], L = b - a (the axis unfolded):
 *   periodic                    x + n L
 *   reflecting on both sides    n even: x + n L;  n odd: a + b - x + n L
 *   reflecting on one side      its mirror image only: 2 a - x or 2 b - x
 *   piston                      the same, one side only, the face at a + u t; images have velocity 2 u - v
 *
 * A ghost is created where an internal node may interact with it: at depth d outside of the face, if
 *   d <= f R_ghost   or   d <= max over internal nodes i of (f R_i - depth of i inside the face),
 * R the search radius, f = 1, or 2 when overlap is required (internal nodes of all ranks). As many images are
 * created as that takes (above a thousand: DIVERGED). Nodes may lie outside of the box: see images.h. Ghosts
 * come image by image (n = -1, 1, -2, 2, ...), list by list, in the order of their controls. Nodes on a
 * reflecting face have a ghost at the same position: neighbors at distance 0.
 *
 * Images of a periodic boundary may instead be shifts (lib/nodes/shifts.h) of all nodes and ghosts that there
 * are, also of those that later boundaries make: no ghosts, and lists say which image a neighbor is. */
#ifndef KITH_BOUNDARIES_BOUNDARY_H
#define KITH_BOUNDARIES_BOUNDARY_H

#include "lib/core/param.h"
#include "lib/core/profile.h"
#include "lib/core/vec.h"
#include "lib/nodes/nodes.h"

struct kith_boundary;

struct kith_boundary_ops {
  const char *name, *doc;
  const struct kith_param *params; /* its own parameters, NULL: none */
  size_t settings_size;
  /* Before: what it has to know of the internal nodes, of this rank (boundary->range) and of all, as maxima
   * (boundary->most). NULL: nothing. */
  void (*measure)(struct kith_boundary *boundary, const struct kith_nodes *nodes, double radius_factor);
  /* Appends ghost blocks to the nodes; radius_factor is f. Of this rank alone, or by messages between
   * neighbors. */
  kith_status (*ghosts)(struct kith_boundary *boundary, struct kith_nodes *nodes, double radius_factor);
  /* Instead, on a rank that has failed, for members whose ranks wait for each other; NULL: they do not. */
  void (*abstain)(struct kith_boundary *boundary, struct kith_nodes *nodes);
  /* Puts internal nodes back: wraps into [lower, upper), or mirrors into [lower, upper] with all fields of
   * the node. DIVERGED for a node that is not finite or more than a thousand lengths away; the others are put
   * back. NULL: nothing to do. */
  kith_status (*enforce)(struct kith_boundary *boundary, struct kith_nodes *nodes);
  /* For members whose ghosts are images across their faces (images.h): image n = -1, 1, -2, 2, ... is
   * x -> sign * x + shift, false: there is none; put_back moves internal node i, which is outside. */
  bool (*image_of)(const struct kith_boundary *boundary, int n, double *sign, double *shift);
  void (*put_back)(const struct kith_boundary *boundary, struct kith_nodes *nodes, kith_index i);
  void (*destroy)(struct kith_boundary *boundary); /* private state; NULL: none */
  /* Moves its faces to their positions at this time; existing ghosts do not follow. NULL: faces are fixed. */
  void (*move)(struct kith_boundary *boundary, double time);
  double (*face_velocity)(const void *settings); /* along the axis; NULL: 0 */
  /* The nodes that it holds, as nodes of their own with the same lists and fields; NULL: none. View. */
  const struct kith_nodes *(*held_nodes)(const struct kith_boundary *boundary);
  /* Properties that callers test, instead of names. */
  bool has_faces;      /* acts on sides of the domain; false: on nodes, wherever they are */
  bool mirrors;        /* an immovable mirror */
  bool wraps;          /* a node that leaves on one side comes back on the other: acts on both sides */
  bool one_side;       /* acts on one side, whose opposite side must be open */
  bool keeps_lists;    /* enforcing it leaves neighbor lists valid: after steps; else before rebuilds */
  bool keeps_ghosts;   /* its ghosts are never culled */
  bool enters, leaves; /* gas passes the face, from or to a zone of nodes behind it (flow.h) */
};

/* Is this axis periodic, if one of its sides has this boundary? NULL: open. */
static inline bool kith_boundary_wraps(const struct kith_boundary_ops *ops) {
  return ops != NULL && ops->wraps;
}

/* Does gas pass the side? NULL: open, which has no zone behind it. */
static inline bool kith_boundary_passes(const struct kith_boundary_ops *ops) {
  return ops != NULL && (ops->enters || ops->leaves);
}

/* Velocity of its face along the axis. */
static inline double kith_boundary_face_velocity(const struct kith_boundary_ops *ops, const void *settings) {
  return ops != NULL && ops->face_velocity != NULL ? ops->face_velocity(settings) : 0;
}

/* The internal nodes in shares of consecutive ones, which lie close together where nodes are in order. Found
 * in one pass over nodes, they save most nodes a look for each axis and image. */
enum { KITH_SHARES = 256 };
struct kith_extents {
  kith_index n;   /* nodes; share s: those from kith_part_start(n, s, KITH_SHARES) on */
  uint64_t order; /* generation of the nodes */
  struct kith_extent {
    struct kith_box box;
    double search_radius; /* the largest */
    bool finite;          /* positions and search radii, all of them */
  } share[KITH_SHARES];
};

/* What `measure` finds; of images the maxima are, for the lower and the upper side, of f R - depth, and of
 * -depth, at least 0. */
enum { KITH_BOUNDARY_MAXIMA = 4, KITH_IMAGES_WANTED = 0, KITH_IMAGES_OUT = 2 };
struct kith_boundary {
  const struct kith_boundary_ops *ops;
  int index;               /* in the list of boundaries */
  kith_index made;         /* ghosts, when it was asked last */
  int axis;                /* 0 .. NDIM - 1 */
  double lower, upper;     /* faces */
  bool at_lower, at_upper; /* which sides act (periodic: both) */
  double start;            /* where the face that acts (the lower one of two) is at time 0 */
  double zone[NDIM];       /* behind a face that gas passes: from it to what continues it; the caller's */
  const void *settings;    /* of its own parameters: the caller's to fill, borrowed; NULL: none */
  const struct kith_extents *extents; /* of the nodes that are measured; borrowed */
  double most[KITH_BOUNDARY_MAXIMA];  /* by `measure` */
  struct {
    double low, high, search_radius; /* along its axis */
    bool finite;
  } range;
  void *self; /* private; of distributed, the last boundary: the halo, set by the caller, borrowed */
};

#define KITH_BOUNDARY_LIST(X) \
  X(reflecting) X(piston) X(periodic) X(constant) X(inflow) X(outflow) X(distributed)
#define X(name) extern const struct kith_boundary_ops kith_boundary_##name;
KITH_BOUNDARY_LIST(X)
#undef X
KITH_FAMILY_FUNCTIONS(kith_boundary);

/* constant: removes the internal nodes with chosen[i] != 0, which return as frozen ghosts whenever ghosts are
 * created. Once per boundary, and the nodes must have ids: else INTERNAL. The search radius of a frozen ghost
 * is its support times the largest R / H of the internal nodes; fields registered later are zero. */
kith_status kith_constant_take(struct kith_boundary *boundary, struct kith_nodes *nodes,
                               const uint8_t *chosen);

/* All boundaries of a run, in order. */
enum { KITH_MAX_BOUNDARIES = 2 * NDIM + 8 };
struct kith_boundaries {
  int n;
  struct kith_boundary *boundary[KITH_MAX_BOUNDARIES]; /* owned */
  struct kith_extents extents;
};
/* BAD_INPUT unless lower < upper, the axis exists and has no boundary yet (or one on the other side, and gas
 * passes either), and the member can act on these sides. Members without faces ignore all of these. */
kith_status kith_boundaries_add(struct kith_boundaries *boundaries, const struct kith_boundary_ops *ops,
                                int axis, double lower, double upper, bool at_lower, bool at_upper);
void kith_boundaries_clear(struct kith_boundaries *boundaries);
/* Drops all ghosts, then creates those of every boundary in order. profile: a stage per boundary, with the
 * counter `ghosts`. Collective. */
kith_status kith_boundaries_ghosts(struct kith_boundaries *boundaries, struct kith_nodes *nodes,
                                   double radius_factor, struct kith_profile *profile);
/* The same in three parts, for callers that have more to tell the other ranks: what there is to know of this
 * rank's internal nodes; what ranks agree on (at most KITH_MAX_BOUNDARIES parts, their number is returned);
 * ghosts. `status`: of this rank so far; that of this rank is returned. */
void kith_boundaries_measure(struct kith_boundaries *boundaries, const struct kith_nodes *nodes,
                             double radius_factor);
int kith_boundaries_share(struct kith_boundaries *boundaries, struct kith_shared *parts);
kith_status kith_boundaries_make_ghosts(struct kith_boundaries *boundaries, struct kith_nodes *nodes,
                                        double radius_factor, struct kith_profile *profile,
                                        kith_status status);
/* How much nearer to a node of another rank an image may be than its node is, after `measure`. */
double kith_boundaries_gain(const struct kith_boundaries *boundaries);
/* May a node with position in box `inside` and a support in box `reach` have to do with any boundary, where
 * the supports of all nodes of this rank lie in box `all`? Members that act on nodes have, wherever they
 * are. */
bool kith_boundaries_reach(const struct kith_boundaries *boundaries, const struct kith_box *inside,
                           const struct kith_box *reach, const struct kith_box *all);
/* The nodes that a boundary of these holds (a run has one such boundary), NULL: none does. View. */
const struct kith_nodes *kith_boundaries_held(const struct kith_boundaries *boundaries);
/* Moves all faces to their positions at this time. */
void kith_boundaries_move(struct kith_boundaries *boundaries, double time);
/* Enforces boundaries: mirrors, which keep neighbor lists valid, and the others, which do not. */
kith_status kith_boundaries_enforce(struct kith_boundaries *boundaries, struct kith_nodes *nodes,
                                    bool mirrors, bool others);

#endif
