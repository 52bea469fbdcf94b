/* flow.h - inflow and outflow: faces that gas passes, and the zones of nodes behind them.
 *
 * Behind such a face stand nodes that carry the flag of that side (nodes.h) to a depth D. Neighbor lists,
 * packages and schemes see nothing but nodes; the integrator says how they move (integrator/flow.h).
 *
 *   inflow   A lattice that moves as a whole with the state at the face. A node that comes through the face
 *            is gas from then on, and another takes its place a depth D behind it (upstream, if it enters at
 *            an angle and not along a periodic axis): the lattice has no end, and whole layers enter. Ghosts
 *            continue it: images of the zone, shifted by that distance. DIVERGED if f times a search radius
 *            in the zone (f of boundary.h) is more than D.
 *   outflow  Gas that has left through the face goes on to the depth D, where it is deleted. The end is open:
 *            nodes there lack partners, but no gas is near enough to see that. */
#ifndef KITH_BOUNDARIES_FLOW_H
#define KITH_BOUNDARIES_FLOW_H

#include "boundaries/boundary.h"

struct kith_expression; /* of the scene */

struct kith_flow_settings {
  double depth;               /* minimum of D, in supports at the start */
  struct kith_expression *at; /* where the face crosses the axis, a constant; NULL: the side of the domain */
  double pressure_far;        /* outflow: the pressure far behind it; 0: no wave comes from there */
  /* Inflow: the state at the face, by density, velocity and either pressure or energy; all NULL: that of the
   * region there. */
  struct kith_expression *density, *pressure, *energy, *velocity[NDIM];
};

/* Flag of the nodes in the zone of b; depth of the zone; outward direction along the axis, 1 or -1. */
static inline uint8_t kith_flow_flag(const struct kith_boundary *b) {
  return (uint8_t)(KITH_ZONE + 2 * b->axis + b->at_upper);
}
static inline double kith_flow_deepest(const struct kith_boundary *b) {
  return fabs(b->zone[b->axis]);
}
static inline double kith_flow_outwards(const struct kith_boundary *b) {
  return b->at_upper ? 1 : -1;
}

#endif
