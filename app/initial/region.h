/* region.h - a region of a scene as geometry and as a state at a place. Messages name the region's line and
 * the place. */
#ifndef KITH_APP_INITIAL_REGION_H
#define KITH_APP_INITIAL_REGION_H

#include "app/scene/scene.h"

enum { KITH_POINT_TEXT = 96 };
/* "(0.5, 0.25)"; returns `text`. */
const char *kith_point_text(char text[KITH_POINT_TEXT], const double *x);

/* Returns BAD_INPUT with "file:line: " before the message, or "--set " for an override. */
#define KITH_FAIL_AT(place, ...) \
  return kith_config_fail(&(const struct kith_config_node){.location = *(place)}, NULL, __VA_ARGS__)

/* The region's box cut with the domain. BAD_INPUT if nothing is left, or it is not finite. */
kith_status kith_region_box(const struct kith_region *region, const struct kith_box *domain,
                            struct kith_box *box);
/* Is x in the region? All parts are half-open, so that a part and its complement share no point: boxes
 * [lower, upper), balls r < radius | r >= radius; a point on a half-space's plane belongs to the one whose
 * first nonzero normal component is positive. */
kith_status kith_region_holds(const struct kith_region *region, const double *x, bool *holds);
/* Mean density over the part of `box` that is in the region: the value if it is a constant, else over a grid
 * of samples (1-D 4096, 2-D 128^2, 3-D 32^3). BAD_INPUT if no sample is in the region. */
kith_status kith_region_mean_density(const struct kith_region *region, const struct kith_box *box,
                                     double *mean);

/* Moves x by the displacement of the region. *stretch: by what it enlarges a volume there, the determinant of
 * the derivatives of the new place, by differences over `step`. BAD_INPUT if the place leaves the domain, or
 * the stretch is not above 0. */
kith_status kith_region_displace(const struct kith_region *region, const struct kith_box *domain, double step,
                                 double *x, double *stretch);

struct kith_region_state {
  double density, pressure, energy, velocity[NDIM]; /* pressure: NaN where the energy is given */
};
/* Initial state at x; the energy follows from the pressure where that is given. BAD_INPUT: not finite,
 * density <= 0, pressure < 0, energy < 0 where the equation of state forbids it. */
kith_status kith_region_state_at(const struct kith_region *region, const struct kith_material *material,
                                 const double *x, struct kith_region_state *state);

#endif
