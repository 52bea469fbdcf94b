/* region.h - what the formulas of a region of the scene give at a point. Failures are BAD_INPUT, with the
 * line of the region and the place. */
#ifndef KITH_APP_INITIAL_REGION_H
#define KITH_APP_INITIAL_REGION_H

#include "app/scene/scene.h"

/* A place in a message: its format, its numbers. */
#define KITH_PLACE "(%.10g, %.10g, %.10g)"
#define KITH_COORDINATES(x) (x)[0], NDIM > 1 ? (x)[1 % NDIM] : 0.0, NDIM > 2 ? (x)[2 % NDIM] : 0.0

/* Finds the region's box, cut with the domain. */
kith_status kith_region_box(const struct kith_region *region, const struct kith_box *domain,
                            struct kith_box *box);
/* Is x in the region? Its extents are half-open, so that regions that touch share no point. */
kith_status kith_region_holds(const struct kith_region *region, const double *x, bool *holds);
/* Finds the mean density over the part of `box` in the region: a constant, or the mean of a grid of
 * samples. */
kith_status kith_region_mean_density(const struct kith_region *region, const struct kith_box *box,
                                     double *mean);
/* Moves x by the displacement of the region. *stretch: the factor by which this enlarges a volume at x, which
 * is the determinant of the derivatives of the new place, by differences over `step`. */
kith_status kith_region_displace(const struct kith_region *region, const struct kith_box *domain, double step,
                                 double *x, double *stretch);

struct kith_region_state {
  double density, pressure, energy, velocity[NDIM]; /* pressure: NaN where the energy is given */
};
/* Evaluates the state at x; the energy follows from the pressure where that is given. */
kith_status kith_region_state(const struct kith_region *region, const struct kith_material *material,
                              const double *x, struct kith_region_state *state);
/* Evaluates the part of heat and momentum that a node at x does not pass. */
kith_status kith_region_damage(const struct kith_region *region, const double *x, double *damage);
/* Evaluates the state at x by the formulas of an inflow. */
kith_status kith_region_inflow_state(const struct kith_flow_settings *flow,
                                     const struct kith_material *material,
                                     const struct kith_config_node *node, const double *x,
                                     struct kith_region_state *state);

#endif
