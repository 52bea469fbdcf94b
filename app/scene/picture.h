/* picture.h - which pictures a run draws: the scene's keys output.plot and probes.N.plot. */
#ifndef KITH_APP_SCENE_PICTURE_H
#define KITH_APP_SCENE_PICTURE_H

#include "lib/core/base.h"

/* name, word, doc */
#define KITH_PICTURE_KINDS(X)                                                   \
  X(AUTO, auto, "what suits the scene")                                         \
  X(PROFILE, profile, "curves over x")                                          \
  X(RADIAL, radial, "curves over the distance from the center")                 \
  X(MAP, map, "colors over the plane; in 3-D the mean along the line of sight") \
  X(SLICE, slice, "colors over a plane of a 3-D scene")
/* name, word, label; DENSITY to ENERGY, which are drawn by default, and VELOCITY_X to VELOCITY_Z stay in this
 * order */
#define KITH_PICTURE_FIELDS(X)                  \
  X(DENSITY, density, "density")                \
  X(VELOCITY, velocity, "velocity")             \
  X(PRESSURE, pressure, "pressure")             \
  X(ENERGY, energy, "specific energy")          \
  X(VELOCITY_X, velocity_x, "velocity along x") \
  X(VELOCITY_Y, velocity_y, "velocity along y") \
  X(VELOCITY_Z, velocity_z, "velocity along z")
#define X(name, word, doc) KITH_PICTURE_##name,
enum kith_picture_kind { KITH_PICTURE_KINDS(X) };
enum kith_picture_field { KITH_PICTURE_FIELDS(X) };
#undef X

enum { KITH_PICTURE_PANELS = 8 };

struct kith_picture_fields {
  int n;
  struct {
    enum kith_picture_field field;
    bool error; /* its difference from the exact solution */
  } panel[KITH_PICTURE_PANELS];
};

struct kith_picture {
  int kind;                          /* enum kith_picture_kind */
  struct kith_picture_fields fields; /* none: what suits the kind */
  double plane[3]; /* where a slice cuts an axis, NaN: not across it; all NaN: z, at the center or middle */
  double range[2]; /* of the colors of the first map; NaN: that of its values */
  bool frames;     /* a picture of each snapshot too */
};

#endif
