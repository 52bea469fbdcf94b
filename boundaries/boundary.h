/* boundary.h - boundary conditions by ghosts, one family. Members whose ghosts are images mirror or shift
 * positions and vectors along one axis.
 *
 * A boundary acts on one axis (both of its sides, or one), or on a set of nodes (constant). In the order of
 * the list each creates its ghosts from nodes and from earlier ghosts, so edges and corners are filled
 * without special cases.
 *
 * Image n of a node across an axis [a, b], L = b - a (the axis unfolded):
 *   periodic                    x + n L
 *   reflecting on both sides    n even: x + n L;  n odd: a + b - x + n L
 *   reflecting on one side      its mirror image only: 2 a - x or 2 b - x
 *   piston                      one side only, mirrored at the face a + u t; images have velocity 2 u - v
 *
 * A ghost is created where an internal node may interact with it: at depth d outside of the face, if
 *   d <= f R_ghost   or   d <= max over internal nodes i of (f R_i - depth of i inside the face),
 * R is the search radius; f is the longest half axis of supports (nodes.h), 1 for spheres, times 2 where
 * ghosts need neighbors of their own (overlap, values of ghosts that are recomputed); the maximum is over all
 * ranks. As many images are created as that takes (above a thousand: DIVERGED). Nodes may lie outside of the
 * box: see images.h. Ghosts come image by image (n = -1, 1, -2, 2, ...), list by list, in the order of their
 * controls. Nodes on a reflecting face have a ghost at the same position: neighbors at distance 0.
 *
 * A periodic boundary may use shifts (lib/nodes/shifts.h) instead of ghosts. They apply to all nodes and
 * ghosts, also to ghosts of later boundaries, and neighbor lists say which image a neighbor is. */
#ifndef KITH_BOUNDARIES_BOUNDARY_H
#define KITH_BOUNDARIES_BOUNDARY_H

#include "lib/core/param.h"
#include "lib/core/profile.h"
#include "lib/core/vec.h"
#include "lib/nodes/nodes.h"

struct kith_boundary;

struct kith_boundary_ops {
  const char *name, *doc;
  const struct kith_param *params; /* its own parameters, NULL: none; without settings they are 0 */
  size_t settings_size;
  /* Measures the internal nodes before ghosts are made: fills boundary->range for this rank, and
   * boundary->most, of which the maxima over all ranks are taken. NULL: nothing to measure. */
  void (*measure)(struct kith_boundary *boundary, const struct kith_nodes *nodes, double radius_factor);
  /* Appends ghost blocks to the nodes; radius_factor is f. Works on this rank alone, or by messages between
   * neighbor ranks. NULL: it makes none. */
  kith_status (*ghosts)(struct kith_boundary *boundary, struct kith_nodes *nodes, double radius_factor);
  /* Called instead of `ghosts` on a rank that has failed, for members whose ranks wait for each other. NULL:
   * they do not wait. */
  void (*abstain)(struct kith_boundary *boundary, struct kith_nodes *nodes);
  /* Puts internal nodes back. A boundary that `wraps` moves them into [lower, upper), after which neighbor
   * lists have to be built again; the others mirror them into [lower, upper] with all fields of the node, and
   * lists stay valid. DIVERGED for a node that is not finite or more than a thousand lengths away; the others
   * are put back. NULL: nothing to do. */
  kith_status (*enforce)(struct kith_boundary *boundary, struct kith_nodes *nodes);
  /* For members whose ghosts are images across their faces (images.h): image n = -1, 1, -2, 2, ... is
   * x -> sign * x + shift (false: no such image); put_back returns internal node i from outside. */
  bool (*image_of)(const struct kith_boundary *boundary, int n, double *sign, double *shift);
  void (*put_back)(const struct kith_boundary *boundary, struct kith_nodes *nodes, kith_index i);
  /* Are its images shifts (lib/nodes/shifts.h) instead of ghosts? NULL: no. */
  bool (*shifts)(const void *settings);
  /* Returns the velocity of its face along the axis, which is constant. NULL: its faces are fixed. */
  double (*face_velocity)(const void *settings);
  /* Properties, so that callers need not test names. */
  bool has_faces; /* acts on sides of the domain; false: on nodes, wherever they are */
  bool mirrors;   /* an immovable mirror */
  bool wraps;     /* a node that leaves on one side comes back on the other: acts on both sides */
  bool one_side;  /* acts on one side, whose opposite side must be open */
  /* Gas passes the face, from or to a zone of nodes behind it (flow.h): the settings of such a member begin
   * with struct kith_flow_settings, which set up the zone. */
  bool enters, leaves;
};

/* Is an axis periodic if this boundary is on one of its sides? NULL: open. */
static inline bool kith_boundary_wraps(const struct kith_boundary_ops *ops) {
  return ops != NULL && ops->wraps;
}

/* Does gas pass a side with this boundary? False for NULL: an open side has no zone behind it. */
static inline bool kith_boundary_passes(const struct kith_boundary_ops *ops) {
  return ops != NULL && (ops->enters || ops->leaves);
}

/* Velocity of the face of this boundary along its axis; 0 for NULL. */
static inline double kith_boundary_face_velocity(const struct kith_boundary_ops *ops, const void *settings) {
  return ops != NULL && ops->face_velocity != NULL ? ops->face_velocity(settings) : 0;
}

/* Indices into boundary->most. Boundaries with images have the maxima of f R - depth (WANTED) and of -depth,
 * at least 0 (OUT), each for the lower, then the upper side. */
enum { KITH_BOUNDARY_MAXIMA = 4, KITH_IMAGES_WANTED = 0, KITH_IMAGES_OUT = 2 };
struct kith_boundary {
  const struct kith_boundary_ops *ops;
  int index;               /* in the list of boundaries */
  kith_index made;         /* ghosts that it made last time */
  int axis;                /* 0 .. NDIM - 1 */
  double lower, upper;     /* faces */
  bool at_lower, at_upper; /* which sides act (periodic: both) */
  double start;            /* position at time 0 of the face that acts (the lower one of two) */
  double zone[NDIM];       /* set by the caller: shift from a node of the zone to its continuation */
  const void *settings;    /* values of its own parameters; set by the caller, borrowed; NULL: none */
  double most[KITH_BOUNDARY_MAXIMA]; /* filled by `measure` */
  struct {
    double low, high, search_radius; /* of the nodes of this rank along the axis */
    bool finite;
  } range;
  struct kith_nodes *held; /* nodes that it has taken out of the run, same lists and fields; NULL: none */
  void *self;              /* for `distributed` the halo, set by the caller, borrowed */
};

#define KITH_BOUNDARY_LIST(X) \
  X(reflecting) X(piston) X(periodic) X(constant) X(inflow) X(outflow) X(distributed)
#define X(name) extern const struct kith_boundary_ops kith_boundary_##name;
KITH_BOUNDARY_LIST(X)
#undef X
KITH_FAMILY_FUNCTIONS(kith_boundary);

/* constant: removes the internal nodes with chosen[i] != 0, which return as frozen ghosts whenever ghosts are
 * created. Once per boundary, and the nodes must have ids: else INTERNAL. The search radius of a frozen ghost
 * is its support times the largest R / H (at least 1) of internal nodes; fields registered later are zero. */
kith_status kith_constant_take(struct kith_boundary *boundary, struct kith_nodes *nodes,
                               const uint8_t *chosen);

/* All boundaries of a run, in order. */
enum { KITH_MAX_BOUNDARIES = 2 * NDIM + 8 };
struct kith_boundaries {
  int n;
  struct kith_boundary *boundary[KITH_MAX_BOUNDARIES]; /* owned */
};
/* BAD_INPUT unless lower < upper, the axis exists, no other boundary acts on it (or one acts on the other
 * side and gas passes either face), and the member can act on these sides. Members without faces ignore all
 * of these. */
kith_status kith_boundaries_add(struct kith_boundaries *boundaries, const struct kith_boundary_ops *ops,
                                int axis, double lower, double upper, bool at_lower, bool at_upper);
void kith_boundaries_clear(struct kith_boundaries *boundaries);
/* Drops all ghosts, then creates those of every boundary in order. profile: a stage per boundary, with the
 * counter `ghosts`. Collective. */
kith_status kith_boundaries_ghosts(struct kith_boundaries *boundaries, struct kith_nodes *nodes,
                                   double radius_factor, struct kith_profile *profile);
/* kith_boundaries_ghosts in three parts, for callers that tell other ranks more in the same message: measure
 * this rank's internal nodes; list what ranks agree on (at most KITH_MAX_BOUNDARIES parts; returns their
 * number); make ghosts. `status` is that of this rank so far; returns its new one. */
void kith_boundaries_measure(struct kith_boundaries *boundaries, const struct kith_nodes *nodes,
                             double radius_factor);
int kith_boundaries_share(struct kith_boundaries *boundaries, struct kith_shared *parts);
kith_status kith_boundaries_make_ghosts(struct kith_boundaries *boundaries, struct kith_nodes *nodes,
                                        double radius_factor, struct kith_profile *profile,
                                        kith_status status);
/* Returns by how much an image may be nearer to a node of another rank than the node that it is an image of.
 * Call after `measure`. */
double kith_boundaries_gain(const struct kith_boundaries *boundaries);
/* May a node with position in box `inside` and a support in box `reach` interact with ghosts of any boundary?
 * The supports of all nodes of this rank lie in box `all`. Always true with members that act on nodes or
 * whose faces move. */
bool kith_boundaries_reach(const struct kith_boundaries *boundaries, const struct kith_box *inside,
                           const struct kith_box *reach, const struct kith_box *all);
/* Returns the nodes that a boundary holds (at most one does), borrowed; NULL: none. */
const struct kith_nodes *kith_boundaries_held(const struct kith_boundaries *boundaries);
/* Moves all faces to their positions at this time; existing ghosts do not follow. */
void kith_boundaries_move(struct kith_boundaries *boundaries, double time);
/* Put internal nodes back that have left the box: by mirrors and pistons, which may be done at any time as
 * neighbor lists stay valid; by boundaries that wrap, after which lists have to be built again. DIVERGED as
 * `enforce` of the ops. */
kith_status kith_boundaries_mirror(struct kith_boundaries *boundaries, struct kith_nodes *nodes);
kith_status kith_boundaries_wrap(struct kith_boundaries *boundaries, struct kith_nodes *nodes);

#endif
