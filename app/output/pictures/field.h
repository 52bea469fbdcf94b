/* field.h - what of a state a picture shows, and how it is called there. */
#ifndef KITH_APP_OUTPUT_PICTURES_FIELD_H
#define KITH_APP_OUTPUT_PICTURES_FIELD_H

#include "app/scene/picture.h"
#include "validation/exact/exact.h"

/* What a picture shows as the velocity: its absolute value, or else its component away from the center or,
 * of a vortex, around it, both beyond its uniform velocity, or else that along x. */
struct kith_picture_axes {
  const struct kith_exact_ops *exact; /* NULL: none */
  const struct kith_exact_gas *about; /* NULL: no center */
  bool speed;                         /* the absolute value */
};

/* The value of a field of a state at x, and what the field is called. */
double kith_picture_value(const struct kith_picture_axes *axes, enum kith_picture_field field,
                          const double *x, double time, const struct kith_exact_state *state);
const char *kith_picture_label(const struct kith_picture_axes *axes, enum kith_picture_field field);

#endif
